//! `camera_stream check --live`: a config against a running ROS. Listens for a few seconds as the node would, and prints
//! how each display and camera did.

use std::collections::HashMap;
use std::io::{self, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_displays::Level;
use rcs_messages::{stamp_nanos, MessageKind};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::{NodeError, NodeEvent, RosNode};
use rcs_rviz_config::Config;
use rcs_transforms::Time;

use crate::camera_stream::camera_pose::Projection;
use crate::camera_stream::report::{self, Subject};
use crate::camera_stream::stage::Stage;
use crate::small_node::EndRequest;

/// How long it sleeps at most while nothing is received.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);
/// The columns of the table.
const HEAD: [&str; 5] = ["DISPLAY", "CLASS", "TOPIC", "STATUS", "TEXT"];

/// Why the check could not be made.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// The ROS there is cannot be used.
    #[error(transparent)]
    Ros(#[from] NodeError),
    /// Signals cannot be taken, or the output cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Listens for that long and prints the table. Returns whether all is well.
///
/// # Errors
/// See [`LiveError`]; no master is one of them.
pub fn run(config: &Config, listen: Duration, projection: Projection, out: &mut dyn Write) -> Result<bool, LiveError> {
    let end = EndRequest::watch_signals()?;
    // Not the node's own name: the master would end the node that has it.
    let ros = RosNode::connect_now(&format!("camera_stream_check_{}", std::process::id()))?;
    let result = check(config, listen, projection, &ros, &end, out);
    ros.shutdown();
    result
}

fn check(
    config: &Config,
    listen: Duration,
    projection: Projection,
    ros: &RosNode,
    end: &EndRequest,
    out: &mut dyn Write,
) -> Result<bool, LiveError> {
    let mut stage = Stage::new(config, None, MeshStore::new(PackageIndex::from_env(&[])));
    hear(&mut stage, listen, ros, end)?;
    ros.query_publications();
    let mut subjects = stage.subjects(Time::from_nanos(stamp_nanos(ros.now())));
    subjects.extend(stage.cameras().iter().map(|view| report::camera(&stage, view, projection)));
    report::add_surroundings(&mut subjects, ros);
    print(&subjects, out)?;
    for finding in &config.findings {
        writeln!(out, "{}: {finding}", config.source)?;
    }
    let is_well = subjects.iter().all(|subject| subject.level() == Level::Ok);
    Ok(is_well && config.findings.is_empty())
}

/// Plays what comes onto the stage.
fn hear(stage: &mut Stage, listen: Duration, ros: &RosNode, end: &EndRequest) -> Result<(), LiveError> {
    ros.subscribe_transforms()?;
    let mut names: HashMap<(Arc<str>, MessageKind), Vec<String>> = HashMap::new();
    let mut subscriptions = Vec::new();
    for request in stage.topics() {
        match ros.subscribe(&request.topic, request.kind, request.queue_size) {
            Ok(subscription) => {
                names.entry((subscription.topic().clone(), request.kind)).or_default().push(request.topic);
                subscriptions.push(subscription);
            }
            Err(error) => log::error!("{error}"),
        }
    }
    ros.follow_parameters(stage.parameters());
    let now = || Time::from_nanos(stamp_nanos(ros.now()));
    let started = Instant::now();
    loop {
        let left = listen.saturating_sub(started.elapsed());
        for event in ros.events().wait(left.min(LONGEST_SLEEP)) {
            match event {
                NodeEvent::Message { topic, message, .. } => {
                    for name in names.get(&(topic, message.kind())).into_iter().flatten() {
                        stage.take(name, &message, now());
                    }
                }
                NodeEvent::Transforms { message, is_static, authority, .. } => {
                    stage.take_transforms(&message, is_static, &authority);
                }
                NodeEvent::Parameter { name, text } => stage.take_parameter(&name, text.as_ref(), now()),
                NodeEvent::TimeJumpedBack { .. } => stage.reset(),
                _ => {}
            }
        }
        stage.update(now());
        if left.is_zero() || end.is_requested() || ros.is_asked_to_end() {
            return Ok(());
        }
    }
}

/// One row for each status that is not well; what is all well has one row with its texts.
fn rows(subject: &Subject<'_>) -> Vec<[String; 5]> {
    let who = [&subject.path, &subject.class, &subject.topic].map(|text| (!text.is_empty()).then_some(text.as_str()));
    let who = who.map(|text| text.unwrap_or("-").to_owned());
    let row = |level: Level, text: String| {
        let [path, class, topic] = who.clone();
        [path, class, topic, format!("{level:?}"), text.replace(" \n", "; ").replace('\n', "; ")]
    };
    if subject.level() == Level::Ok {
        let texts: Vec<String> =
            subject.statuses.iter().map(|(name, status)| format!("{name}: {}", status.text)).collect();
        return vec![row(Level::Ok, texts.join(", "))];
    }
    let mut bad: Vec<_> = subject.statuses.iter().filter(|(_, status)| status.level > Level::Ok).collect();
    bad.sort_by_key(|(_, status)| std::cmp::Reverse(status.level));
    bad.into_iter().map(|(name, status)| row(status.level, format!("{name}: {}", status.text))).collect()
}

/// Prints the table with columns as wide as what is in them.
fn print(subjects: &[Subject<'_>], out: &mut dyn Write) -> io::Result<()> {
    let rows: Vec<[String; 5]> =
        std::iter::once(HEAD.map(str::to_owned)).chain(subjects.iter().flat_map(rows)).collect();
    let width = |column: usize| {
        let widths = rows.iter().filter_map(|row| row.get(column)).map(|text| text.chars().count());
        widths.max().unwrap_or(0)
    };
    let (path_width, class_width, topic_width, status_width) = (width(0), width(1), width(2), width(3));
    for [path, class, topic, status, text] in &rows {
        let line =
            format!("{path:path_width$}  {class:class_width$}  {topic:topic_width$}  {status:status_width$}  {text}");
        writeln!(out, "{}", line.trim_end())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use rcs_displays::Statuses;

    use super::*;
    use crate::camera_stream::report::Kind;

    #[test]
    fn the_table_has_a_row_for_each_problem_and_one_for_what_is_well() {
        let subject = |path: &str, statuses: &[(Level, &str, &str)]| {
            let mut set = Statuses::default();
            for (level, name, text) in statuses {
                set.set(*level, name, *text);
            }
            Subject {
                kind: Kind::Display,
                path: path.to_owned(),
                class: "rviz/Path".to_owned(),
                topic: String::new(),
                listens: Vec::new(),
                has_heard: true,
                statuses: Cow::Owned(set),
                values: Vec::new(),
            }
        };
        let well = subject("é", &[(Level::Ok, "Topic", "3 messages received"), (Level::Ok, "Transform", "OK")]);
        let ill =
            subject("long name", &[(Level::Warn, "A", "odd"), (Level::Error, "B", "bro\nken"), (Level::Ok, "C", "")]);
        let mut out = Vec::new();
        print(&[well, ill], &mut out).unwrap();
        let expected = "\
DISPLAY    CLASS      TOPIC  STATUS  TEXT
é          rviz/Path  -      Ok      Topic: 3 messages received, Transform: OK
long name  rviz/Path  -      Error   B: bro; ken
long name  rviz/Path  -      Warn    A: odd
";
        assert_eq!(String::from_utf8(out).unwrap(), expected);
    }
}
