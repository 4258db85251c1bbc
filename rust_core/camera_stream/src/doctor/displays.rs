//! Checks of the config and of each display, with the statuses of `check --live`.

use rcs_displays::{Level, Status, Statuses};
use rcs_node_support::near::near;
use rcs_ros::Publications;
use rcs_rviz_config::Config;

use super::finding::Finding;
use super::look::Look;
use crate::check::live::summary;
use crate::check::problems;
use crate::scene::status_tree::{StatusEntry, FIXED_FRAME, NO_PUBLISHERS, PUBLISHER};
use crate::scene::visibility::VISIBILITY;

/// Problems of a display that are listed. One with many markers has a status for each.
const MOST_PROBLEMS: usize = 3;

/// The config's problems, and each display.
pub(super) fn all(look: &Look<'_>, config: &Config) -> Vec<Finding> {
    let mut entries = look.session.display_entries(look.scene, look.options);
    look.session.add_graph(&mut entries);
    let display = |entry| not_published(look.publications.as_deref(), entry).unwrap_or_else(|| display(entry));
    of_config(config).into_iter().chain(entries.iter().map(display)).collect()
}

/// One finding for each problem of the config; none if it has only notes.
pub(super) fn of_config(config: &Config) -> Vec<Finding> {
    let wrong = problems(config).into_iter().filter(|(_, is_note)| !is_note);
    wrong.map(|(problem, _)| Finding::bad("config", format!("{}: {problem}", config.source), "")).collect()
}

/// A display whose topic nobody publishes: unknown, because what publishes it may start later, as for the topics that
/// `setup` adds unseen. `None` for other displays.
fn not_published(publications: Option<&Publications>, entry: &StatusEntry<'_>) -> Option<Finding> {
    let status = entry.statuses.get(PUBLISHER).filter(|_| entry.level() == Level::Warn)?;
    let (topic, kind) = entry.subscriptions.first().filter(|_| status.text.starts_with(NO_PUBLISHERS))?;
    let alike = publications.into_iter().flatten().filter(|(_, publication)| publication.has_type(kind.ros_type()));
    let near = near(topic, alike.map(|(name, _)| name.as_str()));
    let hint = near.first().map(|near| format!(": did you mean {near}?")).unwrap_or_default();
    Some(Finding::unknown(
        format!("display {}", entry.path),
        format!("nobody publishes {topic} yet"),
        format!("start its publisher, or correct the topic in the config{hint}"),
    ))
}

/// A display, by its worst statuses.
fn display(entry: &StatusEntry<'_>) -> Finding {
    let name = format!("display {}", entry.path);
    let text = |(name, status): (&str, &Status)| format!("{name}: {}", status.one_line());
    if entry.level() == Level::Ok {
        return Finding::good(name, summary(entry.statuses.iter().map(text)));
    }
    let mut wrong: Vec<_> = entry.statuses.iter().filter(|(_, status)| status.level > Level::Ok).collect();
    wrong.sort_by_key(|(_, status)| std::cmp::Reverse(status.level));
    let advice = advice_for(entry).unwrap_or_default();
    let more = wrong.len().saturating_sub(MOST_PROBLEMS);
    let more = if more > 0 { format!(", and {more} more") } else { String::new() };
    let texts: Vec<String> = wrong.into_iter().take(MOST_PROBLEMS).map(text).collect();
    Finding::bad(name, texts.join(", ") + &more, advice)
}

/// What to do about a display's worst status for which something is known.
pub(crate) fn advice_for(entry: &StatusEntry<'_>) -> Option<&'static str> {
    let mut wrong: Vec<_> = entry.statuses.iter().filter(|(_, status)| status.level > Level::Ok).collect();
    wrong.sort_by_key(|(_, status)| std::cmp::Reverse(status.level));
    wrong.into_iter().find_map(|(name, status)| advice(name, &status.text))
}

/// What to do about a status.
fn advice(name: &str, text: &str) -> Option<&'static str> {
    Some(match name {
        PUBLISHER if text.contains(" is published as ") => "choose a display of that type, or correct the topic",
        PUBLISHER if text.contains("Failed to contact") => {
            "end what the dead node left (rosnode cleanup), and set ROS_IP on its computer"
        }
        PUBLISHER => "start the publisher, or correct the topic in the config",
        FIXED_FRAME if text.contains("No TF data") => "start what publishes TF (robot_state_publisher, projector)",
        FIXED_FRAME => "set fixed_frame to a frame of TF (rosrun tf tf_monitor lists them)",
        VISIBILITY => "aim the projector at it: it lies outside the image",
        Statuses::TRANSFORM => "publish that frame, or correct its name in the message",
        _ if text.contains("For frame [") => "publish that frame, or correct its name in the message",
        _ if text.contains("No messages received") => "see whether its publisher sends (rostopic hz)",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use rcs_messages::MessageKind;
    use rcs_ros::Publication;

    use super::*;

    #[test]
    fn a_display_is_a_line_with_its_problems_the_worst_first() {
        let line = |list: &[(Level, &str, &str)]| {
            let mut statuses = Statuses::default();
            list.iter().for_each(|(level, name, text)| statuses.set(*level, name, *text));
            let entry = StatusEntry {
                path: "group / cloud".to_owned(),
                class: "rviz/PointCloud2".to_owned(),
                topic: "/cloud".to_owned(),
                statuses: Cow::Owned(statuses),
                ..StatusEntry::default()
            };
            display(&entry).to_string()
        };
        assert_eq!(line(&[(Level::Ok, "Topic", "3 messages")]), "✓ display group / cloud: Topic: 3 messages");
        let wrong = line(&[
            (Level::Warn, "Topic", "No messages received"),
            (Level::Ok, "Points", "Showing 3 points"),
            (Level::Error, Statuses::TRANSFORM, "For frame [x]: no such frame"),
        ]);
        let expected =
            "✗ display group / cloud: Transform: For frame [x]: no such frame, Topic: No messages received; \
                        publish that frame, or correct its name in the message";
        assert_eq!(wrong, expected);
    }

    #[test]
    fn a_topic_that_nobody_publishes_is_unknown_in_one_line() {
        let publication =
            |ros_type: &str| Publication { nodes: vec!["/detector".to_owned()], ros_type: ros_type.to_owned() };
        let publications: Publications = [
            ("/detector/clusters", publication("sensor_msgs/PointCloud2")),
            ("/clutsers", publication("sensor_msgs/Image")),
        ]
        .map(|(topic, publication)| (topic.to_owned(), publication))
        .into();
        let line = |topic: &str, level: Level, text: &str| {
            let mut statuses = Statuses::default();
            statuses.set(Level::Warn, "Topic", "No messages received");
            statuses.set(level, PUBLISHER, text);
            let entry = StatusEntry {
                path: "cloud".to_owned(),
                subscriptions: vec![(topic.to_owned(), MessageKind::PointCloud2)],
                statuses: Cow::Owned(statuses),
                ..StatusEntry::default()
            };
            not_published(Some(&publications), &entry).map(|finding| finding.to_string())
        };
        let nobody = "No publishers on [/clusters].  Topic may not exist.";
        let unknown =
            "? display cloud: nobody publishes /clusters yet; start its publisher, or correct the topic in the \
                       config: did you mean /detector/clusters?";
        assert_eq!(line("/clusters", Level::Warn, nobody).as_deref(), Some(unknown));
        let without_hint = line("/scan", Level::Warn, nobody).unwrap();
        assert!(without_hint.ends_with("correct the topic in the config"), "{without_hint}");
        assert_eq!(line("/clusters", Level::Error, "[/clusters] is published as std_msgs/Int8"), None);
        assert_eq!(line("/clusters", Level::Warn, "Failed to contact publisher [/a]"), None);
    }
}
