//! Statuses and age of a display, for consumers outside of this crate.
//!
//! rviz's status of every display with a topic before the first message is added here for all of them.

use std::borrow::Cow;

use rcs_scene::DisplayId;

use crate::framework::lookups::FollowedFrames;
use crate::{Level, ShownMessage, Statuses, TopicRequest};

/// A display of a config, drawn or not.
#[derive(Clone, Debug)]
pub struct ListedDisplay {
    /// The names of the groups around it and its own.
    pub path: Vec<String>,
    /// Such as `rviz/Grid`.
    pub class: String,
    /// Topic in the config, which may be empty; `None` for a class without topic.
    pub topic: Option<String>,
}

/// Age of a display: its newest message and the frames that it follows. The caller decides which age is too old.
#[derive(Clone, Debug)]
pub struct DisplayAge<'a> {
    /// Number of the display.
    pub id: DisplayId,
    /// The names of the groups around it and its own.
    pub path: &'a [String],
    /// Topics that it subscribes to, by the names in the config.
    pub topics: &'a [TopicRequest],
    /// Newest message that the drawables stand for; `None` before the first, and for a display without topics. Refused,
    /// dropped and waiting messages do not count; one that repeats its predecessor does. Its stamp is no newer than the
    /// transforms that placed it.
    pub current: Option<ShownMessage>,
    /// Frames that the drawables follow.
    pub follows: &'a FollowedFrames,
    /// `true` if it has no drawables.
    pub is_empty: bool,
}

/// A display and its statuses.
#[derive(Clone, Debug)]
pub struct DisplayReport<'a> {
    /// Number in [`rcs_scene::DisplayMask`] and [`crate::SceneState::in_view`].
    pub id: DisplayId,
    /// The display.
    pub listed: &'a ListedDisplay,
    /// Topics that it subscribes to.
    pub topics: &'a [TopicRequest],
    /// Messages taken since the start or the last jump in time.
    pub received: u64,
    /// Newest message that it shows.
    pub shown: Option<ShownMessage>,
    /// Statuses, including its topic's.
    pub statuses: Cow<'a, Statuses>,
}

/// Status of a display's topic, unless the display itself has one.
pub(crate) fn topic_status(
    listed: &ListedDisplay,
    topics: &[TopicRequest],
    received: u64,
    own: &Statuses,
) -> Option<(Level, String)> {
    if topics.is_empty() {
        // Without a topic nothing is subscribed to; that is wrong only for a class that has a topic.
        let has_no_topic = listed.topic.as_ref().is_some_and(String::is_empty) && own.get(Statuses::CLASS).is_none();
        return has_no_topic.then(|| (Level::Error, "Error subscribing: Empty topic name".to_owned()));
    }
    if received == 0 {
        return Some((Level::Warn, "No messages received".to_owned()));
    }
    own.get(Statuses::TOPIC).is_none().then(|| (Level::Ok, format!("{received} messages received")))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rcs_messages::{nav_msgs, AnyMessage};
    use rcs_resources::{MeshStore, PackageIndex};
    use rcs_transforms::Time;

    use super::*;
    use crate::SceneState;

    const CONFIG: &str = "
Visualization Manager:
  Displays:
  - {Class: rviz/Path, Name: path, Enabled: true, Topic: /path}
  - {Class: rviz/Path, Name: none, Enabled: true, Topic: ''}
  - {Class: rviz/Path, Name: off, Enabled: false, Topic: /path}
  - {Class: rviz/Grid, Name: grid, Enabled: true}
  - Class: rviz/Group
    Name: group
    Enabled: true
    Displays:
    - {Class: fancy/Hologram, Name: ghost, Enabled: true, Topic: /x}
";

    fn worst_statuses(displays: &SceneState) -> Vec<String> {
        let line = |report: DisplayReport<'_>| {
            let (name, status) = report.statuses.worst().unwrap();
            format!("{} | {name} | {:?} | {}", report.listed.path.join("/"), status.level, status.text)
        };
        displays.reports().map(line).collect()
    }

    #[test]
    fn every_display_with_a_topic_reports_whether_it_received_something() {
        let config = rcs_rviz_config::parse(CONFIG, "test").unwrap();
        let mut displays = SceneState::new(&config, Some("map"), MeshStore::new(PackageIndex::new([])));
        displays.update(Time::ZERO);
        let silent = "path | Topic | Warn | No messages received";
        let rest = [
            "none | Topic | Error | Error subscribing: Empty topic name",
            "grid | Transform | Ok | Transform OK",
            "group/ghost | Class | Error | The class required for this display could not be loaded.",
        ];
        assert_eq!(worst_statuses(&displays), [&[silent], &rest[..]].concat());

        let mut path = nav_msgs::Path::default();
        path.header.frame_id = "arm".to_owned();
        let path = AnyMessage::Path(Arc::new(path));
        displays.take("/path", &path, Time::ZERO);
        displays.update(Time::ZERO);
        let waits = "path | Transform | Warn | For frame [arm]: Fixed Frame [map] does not exist";
        assert_eq!(worst_statuses(&displays), [&[waits], &rest[..]].concat());
        let report = displays.reports().next().unwrap();
        assert_eq!(report.statuses.get(Statuses::TOPIC).unwrap().text, "1 messages received");

        displays.reset();
        assert_eq!(worst_statuses(&displays)[0], silent);
    }
}
