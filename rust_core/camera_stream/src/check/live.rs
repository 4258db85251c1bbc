//! `camera_stream check --live`: a config against a running ROS. Subscribes for a few seconds as the node would, and
//! prints the status of each display and camera.

use std::ffi::OsString;
use std::io::{self, Write};
use std::time::Duration;

use anyhow::{Error, Result};
use rcs_displays::{Level, Status};
use rcs_rviz_config::Config;

use crate::check::session::Session;
use crate::check::table;
use crate::scene::status_tree::{self, StatusEntry};
use crate::scene::visibility::VISIBILITY;

const HEAD: [&str; 5] = ["DISPLAY", "CLASS", "TOPIC", "STATUS", "TEXT"];

/// Subscribes for a while and prints the table and what is wrong with meshes. Returns `true` if every status is Ok,
/// each mesh is whole and the whole config is understood.
///
/// # Errors
/// No master, an invalid parameter, or an output that cannot be written.
pub(crate) fn run(config: &Config, words: &[OsString], listen: Duration, out: &mut dyn Write) -> Result<bool> {
    let session = Session::connect()?;
    let result = check(config, &session, words, listen, out);
    session.end();
    match result {
        // A closed pipe, as of `head`, is no error.
        Err(error) if is_closed_pipe(&error) => Ok(true),
        result => result,
    }
}

fn check(
    config: &Config,
    session: &Session,
    words: &[OsString],
    listen: Duration,
    out: &mut dyn Write,
) -> Result<bool> {
    let options = session.options(words, config)?;
    let mut scene = session.scene(config, &options);
    // Kept because they know their publishers.
    let _subscriptions = session.listen(&mut scene, listen)?;
    session.ros.query_publications();
    let mut entries = session.display_entries(&scene, &options);
    entries.extend(scene.cameras().iter().map(|view| status_tree::camera(&scene, view, options.model)));
    session.add_graph(&mut entries);
    print(&entries, out)?;
    let warnings = scene.mesh_warnings();
    for warning in &warnings {
        writeln!(out, "{warning}")?;
    }
    let is_understood = super::print_findings(config, out)?;
    let is_ok = entries.iter().all(|entry| entry.level() == Level::Ok);
    Ok(is_ok && warnings.is_empty() && is_understood)
}

pub(crate) fn is_closed_pipe(error: &Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// One row for each status that is not Ok, and for the Visibility, the worst first; an entry whose statuses are all Ok
/// has one row with their texts.
fn rows(entry: &StatusEntry<'_>) -> Vec<[String; 5]> {
    let columns = [&entry.path, &entry.class, &entry.topic].map(|text| (!text.is_empty()).then_some(text.as_str()));
    let columns = columns.map(|text| text.unwrap_or("-").to_owned());
    let row = |level: Level, text: String| {
        let [path, class, topic] = columns.clone();
        [path, class, topic, format!("{level:?}"), text]
    };
    let text = |(name, status): (&str, &Status)| format!("{name}: {}", status.one_line());
    if entry.level() == Level::Ok {
        return vec![row(Level::Ok, summary(entry.statuses.iter().map(text)))];
    }
    let is_listed = |(name, status): &(&str, &Status)| status.level > Level::Ok || *name == VISIBILITY;
    let mut listed: Vec<_> = entry.statuses.iter().filter(is_listed).collect();
    listed.sort_by_key(|(_, status)| std::cmp::Reverse(status.level));
    listed.into_iter().map(|(name, status)| row(status.level, text((name, status)))).collect()
}

/// Longest list of statuses in one row, in characters. TF has a status for each frame.
const MAX_SUMMARY_CHARS: usize = 100;

/// The texts in one line, or the first of them and their number.
pub(crate) fn summary(texts: impl Iterator<Item = String>) -> String {
    let texts: Vec<String> = texts.collect();
    let mut line = String::new();
    for (index, text) in texts.iter().enumerate() {
        let comma = if index == 0 { "" } else { ", " };
        if index > 0 && line.chars().count() + comma.len() + text.chars().count() > MAX_SUMMARY_CHARS {
            return format!("{line}, … ({} statuses, all Ok)", texts.len());
        }
        line += &format!("{comma}{text}");
    }
    line
}

fn print(entries: &[StatusEntry<'_>], out: &mut dyn Write) -> io::Result<()> {
    let rows: Vec<[String; 5]> =
        std::iter::once(HEAD.map(str::to_owned)).chain(entries.iter().flat_map(rows)).collect();
    table::print(&rows, "", out)
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use rcs_displays::Statuses;

    use super::*;

    #[test]
    fn many_statuses_are_a_line_with_their_number() {
        let text = |index| format!("frame_{index}: Transform OK");
        assert_eq!(summary((0..2).map(text)), "frame_0: Transform OK, frame_1: Transform OK");
        let many = summary((0..60).map(text));
        assert!(many.starts_with("frame_0: Transform OK, ") && many.ends_with(", … (60 statuses, all Ok)"), "{many}");
        assert!(many.chars().count() < MAX_SUMMARY_CHARS + 40, "{many}");
        assert_eq!(summary(std::iter::once("x".repeat(300))).len(), 300, "one is whole");
    }

    #[test]
    fn the_table_has_a_row_for_each_problem_and_one_for_an_ok_entry() {
        let entry = |path: &str, statuses: &[(Level, &str, &str)]| {
            let mut set = Statuses::default();
            for (level, name, text) in statuses {
                set.set(*level, name, *text);
            }
            StatusEntry {
                path: path.to_owned(),
                class: "rviz/Path".to_owned(),
                topic: String::new(),
                statuses: Cow::Owned(set),
                ..StatusEntry::default()
            }
        };
        let ok = entry("é", &[(Level::Ok, "Topic", "3 messages received"), (Level::Ok, "Transform", "OK")]);
        let bad =
            entry("long name", &[(Level::Warn, "A", "odd"), (Level::Error, "B", "bro\nken"), (Level::Ok, "C", "")]);
        let hidden =
            [(Level::Ok, VISIBILITY, "hidden in camera X"), (Level::Warn, "Topic", "none"), (Level::Ok, "C", "")];
        let hidden = entry("hidden", &hidden);
        let mut out = Vec::new();
        print(&[ok, bad, hidden], &mut out).unwrap();
        let expected = "\
DISPLAY    CLASS      TOPIC  STATUS  TEXT
é          rviz/Path  -      Ok      Topic: 3 messages received, Transform: OK
long name  rviz/Path  -      Error   B: bro; ken
long name  rviz/Path  -      Warn    A: odd
hidden     rviz/Path  -      Warn    Topic: none
hidden     rviz/Path  -      Ok      Visibility: hidden in camera X
";
        assert_eq!(String::from_utf8(out).unwrap(), expected);
    }
}
