//! Says in the log what rviz would show beside a display in its tree: what is missing or wrong with it.
//!
//! Each problem is said once. Frames are often a little late, so that one that is missing is said when it has been
//! missing for a while; a message that is wrong is said at once, as the next may be right.

use std::collections::{HashMap, HashSet};

use rcs_displays::{DisplaySet, Level};
use rcs_transforms::Time;

/// How long a frame may be missing before that is said.
const FRAME_PATIENCE_SECS: f64 = 2.0;
/// How often the displays are looked at.
const LOOK_PERIOD_SECS: f64 = 0.5;
/// The status of a display that tells about frames.
const FRAMES: &str = "Transform";
/// Statuses can name any number of markers, and nobody reads that many lines.
const MOST_SAID: usize = 500;

/// What was said already.
#[derive(Debug, Default)]
pub(crate) struct StatusLog {
    said: HashSet<String>,
    /// Since when each problem that is not said yet is there.
    since: HashMap<String, Time>,
    looked: Option<Time>,
}

/// What makes two texts the same problem: all but their numbers, which are times and positions.
fn without_numbers(text: &str) -> String {
    text.chars().filter(|letter| !letter.is_ascii_digit()).collect()
}

impl StatusLog {
    /// Looks at the displays, if it is time to.
    pub(crate) fn look(&mut self, displays: &DisplaySet, now: Time) {
        let passed = |looked: Time| looked > now || now.secs_since(looked) >= LOOK_PERIOD_SECS;
        if self.looked.is_none_or(passed) {
            self.looked = Some(now);
            self.say(displays, now, false);
        }
    }

    /// Says what is wrong now, whether or not it may still come right.
    pub(crate) fn conclude(&mut self, displays: &DisplaySet, now: Time) {
        self.say(displays, now, true);
    }

    fn say(&mut self, displays: &DisplaySet, now: Time, is_end: bool) {
        let mut since = HashMap::new();
        for (display, statuses) in displays.statuses() {
            for (name, status) in statuses.iter().filter(|(_, status)| status.level > Level::Ok) {
                let path = display.path.join(" / ");
                let key = format!("{path}: {name}: {}", without_numbers(&status.text));
                if self.said.contains(&key) || self.said.len() >= MOST_SAID {
                    continue;
                }
                let first = self.since.get(&key).copied().unwrap_or(now);
                if name == FRAMES && !is_end && now.secs_since(first) < FRAME_PATIENCE_SECS {
                    since.insert(key, first);
                    continue;
                }
                let text = status.text.replace(" \n", "; ").replace('\n', "; ");
                match status.level {
                    Level::Error if name != FRAMES => log::error!("display {path}: {name}: {text}"),
                    _ => log::warn!("display {path}: {name}: {text}"),
                }
                self.said.insert(key);
            }
        }
        self.since = since;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rcs_displays::World;
    use rcs_resources::{MeshStore, PackageIndex};
    use rcs_transforms::TransformTree;

    fn at(secs: f64) -> Time {
        Time::from_secs_f64(secs)
    }

    #[test]
    fn a_frame_is_missed_after_a_while_and_each_problem_is_said_once() {
        let text =
            "Visualization Manager:\n  Displays:\n  - {Class: rviz/Grid, Name: g, Enabled: true, Reference Frame: x}\n";
        let config = rcs_rviz_config::parse(text, "test").unwrap();
        let mut displays = DisplaySet::new(&config);
        let (transforms, meshes) = (TransformTree::new(), MeshStore::new(PackageIndex::new([])));
        let mut log = StatusLog::default();
        for (secs, said) in [(1.0, 0), (2.0, 0), (2.9, 0), (3.5, 1), (9.0, 1)] {
            let world = World { transforms: &transforms, fixed_frame: "map", now: at(secs), meshes: &meshes };
            displays.update(&world);
            log.look(&displays, at(secs));
            assert_eq!(log.said.len(), said, "at {secs}: {:?}", log.said);
        }
        let mut other = StatusLog::default();
        other.conclude(&displays, at(9.0));
        assert_eq!(other.said.len(), 1);
    }
}
