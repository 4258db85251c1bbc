//! `camera_stream check --live`: a config against a running ROS. Subscribes for a few seconds as the node would, and
//! prints the status of each display and camera.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use rcs_displays::{time_from_stamp, Level, Status};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::{NodeError, RosNode};
use rcs_rviz_config::Config;
use rcs_transforms::Time;

use crate::check::node_name::NodeName;
use crate::check::table;
use crate::cli::{ModelArgs, ResourceArgs};
use crate::private_parameters;
use crate::scene::status_tree::{self, StatusEntry};
use crate::scene::subscriptions::Subscriptions;
use crate::scene::visibility::{self, PlacedCamera, VISIBILITY};
use crate::scene::SceneState;
use rcs_node_support::lifecycle::EndRequest;

/// How long it sleeps at most while nothing is received.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);
/// The columns of the table.
const HEAD: [&str; 5] = ["DISPLAY", "CLASS", "TOPIC", "STATUS", "TEXT"];

/// Why the check could not be made.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// No node can be started, or it cannot subscribe.
    #[error(transparent)]
    Ros(#[from] NodeError),
    /// Signals cannot be handled, or the output cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A private parameter has no valid value.
    #[error("{0}")]
    Parameter(String),
}

/// The arguments of the launch line that matter to the check.
#[derive(Clone, Debug)]
pub struct LiveArgs {
    /// How long to listen.
    pub listen: Duration,
    /// Overrides the config's.
    pub fixed_frame: Option<String>,
    /// Overrides the node's private parameters.
    pub model: ModelArgs,
    /// Which mesh files may be read, besides the private parameters.
    pub resources: ResourceArgs,
}

/// Subscribes for a while and prints the table. Returns whether every status is Ok and all of the config is understood.
///
/// # Errors
/// See [`LiveError`]; no master is one of them.
pub fn run(config: &Config, args: &LiveArgs, out: &mut dyn Write) -> Result<bool, LiveError> {
    // The master would end the running node if this one took its name.
    let name = NodeName::of_this_process()?;
    let end = EndRequest::watch_signals()?;
    rcs_scene::name_threads();
    let ros = RosNode::connect_now(&name.own, &|| end.is_requested())?;
    let result = check(config, args, &name, &ros, &end, out);
    ros.shutdown();
    match result {
        // One that is closed, as by `head`, has been read as far as it is wanted.
        Err(LiveError::Io(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(true),
        result => result,
    }
}

fn check(
    config: &Config,
    args: &LiveArgs,
    name: &NodeName,
    ros: &RosNode,
    end: &EndRequest,
    out: &mut dyn Write,
) -> Result<bool, LiveError> {
    // `_projection:=` of the command line, or what the node's own launch file set.
    let model = private_parameters::camera_model(ros, &args.model, Some(&name.diagnosed))
        .map_err(|error| LiveError::Parameter(error.to_string()))?;
    let resources =
        private_parameters::resources(ros, &args.resources).map_err(|error| LiveError::Parameter(error.to_string()))?;
    let events = ros.events().clone();
    let meshes = MeshStore::in_background(PackageIndex::from_env(&[]), resources, move || events.wake());
    let mut stage = SceneState::new(config, args.fixed_frame.as_deref(), meshes);
    // Kept for what is known of their publishers.
    let _subscriptions = receive(&mut stage, args.listen, ros, end)?;
    ros.query_publications();
    let mut entries = stage.status_entries(ros_time(ros));
    let place = |view| PlacedCamera { view, camera: stage.camera(view, model).ok() };
    let placed: Vec<_> = stage.cameras().iter().map(place).collect();
    visibility::add(&mut entries, stage.displays(), &placed);
    entries.extend(stage.cameras().iter().map(|view| status_tree::camera(&stage, view, model)));
    status_tree::add_ros_graph(&mut entries, ros);
    status_tree::add_unreachable_publishers(&mut entries, ros);
    print(&entries, out)?;
    let is_understood = super::print_findings(config, out)?;
    let is_ok = entries.iter().all(|entry| entry.level() == Level::Ok);
    Ok(is_ok && is_understood)
}

fn ros_time(ros: &RosNode) -> Time {
    time_from_stamp(ros.now())
}

/// Applies what is received to the stage. Returns the subscriptions.
fn receive(
    stage: &mut SceneState,
    listen: Duration,
    ros: &RosNode,
    end: &EndRequest,
) -> Result<Subscriptions, LiveError> {
    ros.subscribe_transforms()?;
    let mut subscriptions = Subscriptions::default();
    subscriptions.update(ros, stage.topics());
    ros.follow_parameters(stage.parameters());
    let started = Instant::now();
    loop {
        let left = listen.saturating_sub(started.elapsed());
        for event in ros.events().wait(left.min(LONGEST_SLEEP)) {
            subscriptions.apply(event, stage, ros_time(ros));
        }
        stage.update(ros_time(ros));
        if left.is_zero() || end.is_requested() {
            return Ok(subscriptions);
        }
    }
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

/// The longest list of statuses in one row, in characters. TF has a status for each frame.
const MAX_SUMMARY_CHARS: usize = 100;

/// The texts in one line, and how many there are if that would be too long.
fn summary(texts: impl Iterator<Item = String>) -> String {
    let texts: Vec<String> = texts.collect();
    let mut shown = String::new();
    for (index, text) in texts.iter().enumerate() {
        let comma = if index == 0 { "" } else { ", " };
        if index > 0 && shown.chars().count() + comma.len() + text.chars().count() > MAX_SUMMARY_CHARS {
            return format!("{shown}, … ({} statuses, all Ok)", texts.len());
        }
        shown += &format!("{comma}{text}");
    }
    shown
}

/// Prints the table.
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
    use crate::scene::status_tree::EntryKind;

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
                kind: EntryKind::Display,
                display: Some(0),
                path: path.to_owned(),
                class: "rviz/Path".to_owned(),
                topic: String::new(),
                subscriptions: Vec::new(),
                has_received: true,
                statuses: Cow::Owned(set),
                values: Vec::new(),
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
