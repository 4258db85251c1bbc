//! The parameter with a robot's description, with rviz's statuses for it.
//!
//! rviz polls the parameter when the display starts and once a second until it is set. After that it does not read it
//! again, so a robot does not change while the display lives.

use std::sync::Arc;

use crate::{Level, Statuses};
use rcs_robot::Robot;

pub(crate) const STATUS: &str = "URDF";

/// Status texts, which differ between two of rviz's displays.
pub(crate) struct StatusTexts {
    pub(crate) good: &'static str,
    pub(crate) bad: &'static str,
}

/// A robot's description: the name of a parameter, and whether it was read.
#[derive(Debug)]
pub(crate) struct RobotDescription {
    name: String,
    is_read: bool,
}

impl RobotDescription {
    pub(crate) fn new(name: &str, statuses: &mut Statuses) -> Self {
        if let Err(reason) = check_name(name) {
            statuses.set(Level::Error, STATUS, format!("Invalid parameter name: {name}.\n{reason}"));
        }
        Self { name: name.to_owned(), is_read: false }
    }

    pub(crate) fn parameters(&self) -> Vec<String> {
        check_name(&self.name).map(|()| self.name.clone()).into_iter().collect()
    }

    /// Parses a parameter's text; `None` where it is unset or invalid, with a status, or was read before.
    pub(crate) fn take(
        &mut self,
        text: Option<&Arc<str>>,
        words: &StatusTexts,
        statuses: &mut Statuses,
    ) -> Option<Robot> {
        if self.is_read {
            return None;
        }
        let name = &self.name;
        let Some(text) = text else {
            let text = format!("Parameter [{name}] does not exist, and was not found by searchParam()");
            statuses.set(Level::Error, STATUS, text);
            return None;
        };
        self.is_read = true;
        if text.is_empty() {
            statuses.set(Level::Error, STATUS, "URDF is empty");
            return None;
        }
        match Robot::parse(text) {
            Ok(robot) => {
                let passed_over = robot.passed_over.iter().map(|fault| format!("passed over: {fault}"));
                let faults: Vec<String> = robot.left_out.iter().map(ToString::to_string).chain(passed_over).collect();
                for fault in &faults {
                    log::warn!("parameter {name}: {fault}");
                }
                match faults.first() {
                    None => statuses.set(Level::Ok, STATUS, words.good),
                    Some(first) if faults.len() == 1 => statuses.set(Level::Warn, STATUS, first.clone()),
                    Some(first) => {
                        let text = format!("{first} (and {} more, in the log)", faults.len() - 1);
                        statuses.set(Level::Warn, STATUS, text);
                    }
                }
                Some(robot)
            }
            Err(error) => {
                statuses.set(Level::Error, STATUS, format!("{}: {name}, {error}", words.bad));
                None
            }
        }
    }
}

/// roscpp's rules for the name of a parameter.
fn check_name(name: &str) -> Result<(), String> {
    if name.starts_with('~') {
        return Err("Private names (~) cannot be used here".to_owned());
    }
    if let Some(first) = name.chars().next().filter(|first| !first.is_ascii_alphabetic() && *first != '/') {
        return Err(format!("A name begins with a letter or a slash, not with [{first}]"));
    }
    match name.chars().find(|letter| !letter.is_ascii_alphanumeric() && !matches!(letter, '/' | '_')) {
        Some(letter) => Err(format!("[{letter}] cannot be part of a name")),
        None => Ok(()),
    }
}

pub(crate) fn link_frame(tf_prefix: &str, link: &str) -> String {
    if tf_prefix.is_empty() {
        link.to_owned()
    } else {
        format!("{tf_prefix}/{link}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATUS_TEXTS: StatusTexts = StatusTexts { good: "fine", bad: "not good" };

    fn status(statuses: &Statuses) -> (Level, String) {
        let status = statuses.iter().find(|(name, _)| *name == STATUS).unwrap().1;
        (status.level, status.text.clone())
    }

    #[test]
    fn a_missing_description_is_an_error_and_one_that_is_set_is_read_once() {
        let mut statuses = Statuses::default();
        let mut description = RobotDescription::new("robot_description", &mut statuses);
        assert_eq!(description.parameters(), ["robot_description"]);
        assert_eq!(statuses, Statuses::default());
        assert!(description.take(None, &STATUS_TEXTS, &mut statuses).is_none());
        let missing = "Parameter [robot_description] does not exist, and was not found by searchParam()";
        assert_eq!(status(&statuses), (Level::Error, missing.to_owned()));
        let text: Arc<str> = "<robot name='r'><link name='a'/></robot>".into();
        assert!(description.take(Some(&text), &STATUS_TEXTS, &mut statuses).is_some());
        assert_eq!(status(&statuses), (Level::Ok, "fine".to_owned()));
        assert!(description.take(Some(&text), &STATUS_TEXTS, &mut statuses).is_none());
    }

    #[test]
    fn faults_of_a_description_that_is_read_are_a_warning() {
        let warning = |parts: &str| {
            let mut statuses = Statuses::default();
            let text = format!("<robot name='r'>\n<link name='a'/>{parts}</robot>").as_str().into();
            assert!(RobotDescription::new("d", &mut statuses)
                .take(Some(&text), &STATUS_TEXTS, &mut statuses)
                .is_some());
            status(&statuses)
        };
        let (level, one) = warning("<transmission>a & b</transmission>");
        assert!(level == Level::Warn && one.starts_with("passed over: line 2: "), "{one}");
        let sphere = "<link name='x'><visual><geometry><sphere radius='big'/></geometry></visual></link>\
                      <joint name='j' type='fixed'><parent link='a'/><child link='x'/></joint>";
        let (level, two) = warning(&format!("{sphere}<transmission>a & b</transmission>"));
        assert!(level == Level::Warn && two.starts_with("line 2: link \"x\": sphere: "), "{two}");
        assert!(two.ends_with(" (and 1 more, in the log)"), "{two}");
    }

    #[test]
    fn damaged_descriptions_and_names_are_statuses() {
        let take = |text: &str| {
            let mut statuses = Statuses::default();
            let mut description = RobotDescription::new("d", &mut statuses);
            assert!(description.take(Some(&text.into()), &STATUS_TEXTS, &mut statuses).is_none());
            status(&statuses).1
        };
        assert_eq!(take(""), "URDF is empty");
        assert_eq!(take("<robot\nname='r'/>"), "not good: d, line 1: robot \"r\": it has no links");
        for name in ["~x", "1x", "a b"] {
            let mut statuses = Statuses::default();
            assert!(RobotDescription::new(name, &mut statuses).parameters().is_empty());
            assert!(status(&statuses).1.starts_with("Invalid parameter name"));
        }
    }
}
