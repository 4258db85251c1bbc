//! Says in the log what rviz would show beside a display in its tree: what is missing or wrong with it, and that it is
//! well again.
//!
//! Each change is said once. Frames are often a little late and publishers start in any order, so that what may still
//! come is said when it has been missing for a while; a message that is wrong is said at once, as the next may be right.
//! What comes and goes is said less and less often.

use std::collections::HashMap;

use rcs_displays::{Level, StatusCause, Statuses};
use rcs_transforms::Time;

use crate::camera_stream::report::{Kind, Subject, FIXED_FRAME, PUBLISHER};

/// How long a frame may be missing before that is said.
const FRAME_PATIENCE_SECS: f64 = 2.0;
/// How long a topic may be silent before that is said.
const TOPIC_PATIENCE_SECS: f64 = 5.0;
/// How long something must be well before that is said.
const WELL_PATIENCE_SECS: f64 = 2.0;
/// How long the same status is not spoken of after a problem was said; each time twice as long.
const FIRST_SILENCE_SECS: f64 = 10.0;
/// The longest such silence.
const LONGEST_SILENCE_SECS: f64 = 320.0;
/// What was not spoken of for that long is as new.
const FORGOTTEN_AFTER_SECS: f64 = 900.0;
/// How often the displays are looked at.
const LOOK_PERIOD_SECS: f64 = 0.5;
/// Statuses can name any number of markers, and nobody reads that many lines.
const MOST_STATUSES: usize = 500;

/// What was said already.
#[derive(Debug, Default)]
pub(crate) struct StatusLog {
    /// By who it is and the status's name.
    tales: HashMap<(String, String), Tale>,
    looked: Option<Time>,
}

/// What is known of one status.
#[derive(Debug)]
struct Tale {
    /// Whether it is a problem, and since when it is one or none.
    is_bad: bool,
    since: Time,
    /// The problem that was said last, unless its end was said too.
    said: Option<String>,
    /// When a problem was said last.
    said_at: Option<Time>,
    silence_secs: f64,
}

/// What makes two texts the same problem: all but their numbers, which are times and positions.
fn without_numbers(text: &str) -> String {
    text.chars().filter(|letter| !letter.is_ascii_digit()).collect()
}

fn patience_secs(status_name: &str, level: Level, cause: StatusCause) -> f64 {
    match status_name {
        Statuses::TRANSFORM | FIXED_FRAME => FRAME_PATIENCE_SECS,
        // An error of a topic is a message that is wrong, or a name.
        Statuses::TOPIC if level == Level::Warn => TOPIC_PATIENCE_SECS,
        PUBLISHER => TOPIC_PATIENCE_SECS,
        // Markers, robots' links and frames have statuses of their own names.
        _ if cause == StatusCause::Frame => FRAME_PATIENCE_SECS,
        _ => 0.0,
    }
}

/// Whether a status is spoken of here: cameras speak for themselves, what is not drawn was said when the config was read,
/// and of a topic it is enough that it is silent.
fn is_told(subject: &Subject<'_>, status_name: &str, level: Level) -> bool {
    match (status_name, subject.kind) {
        (PUBLISHER, _) => level == Level::Error,
        (Statuses::CLASS, _) | (_, Kind::Camera) => false,
        (_, Kind::Global | Kind::Display) => true,
    }
}

impl StatusLog {
    /// Whether it is time to look again.
    pub(crate) fn is_due(&self, now: Time) -> bool {
        self.looked.is_none_or(|looked| looked > now || now.secs_since(looked) >= LOOK_PERIOD_SECS)
    }

    /// Looks at how the displays do. `now` is of any clock that goes on.
    pub(crate) fn look(&mut self, subjects: &[Subject<'_>], now: Time) {
        self.looked = Some(now);
        self.say(subjects, now, false);
    }

    /// Says what is wrong now, whether or not it may still come right.
    pub(crate) fn conclude(&mut self, subjects: &[Subject<'_>], now: Time) {
        self.say(subjects, now, true);
    }

    fn say(&mut self, subjects: &[Subject<'_>], now: Time, is_end: bool) {
        let mut unseen: HashMap<(String, String), Tale> = std::mem::take(&mut self.tales);
        for subject in subjects {
            for (name, status) in subject.statuses.iter().filter(|(name, status)| is_told(subject, name, status.level))
            {
                let who = match subject.kind {
                    Kind::Global => subject.path.clone(),
                    Kind::Display => format!("display {}", subject.path),
                    Kind::Camera => format!("camera {}", subject.path),
                };
                let key = (who, name.to_owned());
                let mut tale = match (unseen.remove(&key), status.level) {
                    (Some(tale), _) => tale,
                    (None, Level::Ok) => continue,
                    (None, _) if self.tales.len() >= MOST_STATUSES => continue,
                    (None, _) => Tale::new(now),
                };
                let (who, text) = (&key.0, status.text.replace(" \n", "; ").replace('\n', "; "));
                let patience_secs = patience_secs(name, status.level, status.cause);
                if tale.is_news(patience_secs, status.level, &text, now, is_end) {
                    match status.level {
                        Level::Error if patience_secs == 0.0 => {
                            log::error!("{who}: {name}: {text}");
                        }
                        Level::Ok => log::info!("{who}: {name}: ok again: {text}"),
                        _ => log::warn!("{who}: {name}: {text}"),
                    }
                }
                self.tales.insert(key, tale);
            }
        }
        // A status that is not there any more is a problem that is over.
        for (key, mut tale) in unseen {
            if tale.is_news(0.0, Level::Ok, "", now, is_end) {
                log::info!("{}: {}: ok again", key.0, key.1);
            }
            self.tales.insert(key, tale);
        }
        self.tales.retain(|_, tale| !tale.is_over(now));
    }
}

impl Tale {
    fn new(now: Time) -> Self {
        Self { is_bad: false, since: now, said: None, said_at: None, silence_secs: FIRST_SILENCE_SECS }
    }

    /// Takes what the status is now, and tells whether that is to be said.
    fn is_news(&mut self, patience_secs: f64, level: Level, text: &str, now: Time, is_end: bool) -> bool {
        let is_bad = level > Level::Ok;
        if is_bad != self.is_bad || self.since > now {
            (self.is_bad, self.since) = (is_bad, now);
        }
        let lasted_secs = now.secs_since(self.since);
        if !is_bad {
            return self.said.is_some() && (is_end || lasted_secs >= WELL_PATIENCE_SECS) && self.said.take().is_some();
        }
        let problem = without_numbers(text);
        if self.said.as_ref() == Some(&problem) || (!is_end && lasted_secs < patience_secs) {
            return false;
        }
        if let Some(said_at) = self.said_at.filter(|said_at| *said_at <= now) {
            let quiet_secs = now.secs_since(said_at);
            if quiet_secs < self.silence_secs && !is_end {
                return false;
            }
            self.silence_secs = if quiet_secs < FORGOTTEN_AFTER_SECS {
                (self.silence_secs * 2.0).min(LONGEST_SILENCE_SECS)
            } else {
                FIRST_SILENCE_SECS
            };
        }
        (self.said, self.said_at) = (Some(problem), Some(now));
        true
    }

    /// Whether there is nothing left to remember.
    fn is_over(&self, now: Time) -> bool {
        let is_quiet = |said_at: Time| said_at > now || now.secs_since(said_at) >= FORGOTTEN_AFTER_SECS;
        !self.is_bad && self.said.is_none() && self.said_at.is_none_or(is_quiet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(secs: f64) -> Time {
        Time::from_secs_f64(secs)
    }

    /// When and what is said of a status that is looked at twice a second.
    fn said(name: &str, secs: f64, status: impl Fn(f64) -> (Level, &'static str)) -> Vec<(f64, &'static str)> {
        let mut tale = Tale::new(at(100.0));
        let mut said = Vec::new();
        for look in 0..(secs * 2.0) as u32 {
            let secs = f64::from(look) / 2.0;
            let (level, text) = status(secs);
            let patience_secs = patience_secs(name, level, StatusCause::Other);
            if tale.is_news(patience_secs, level, text, at(100.0 + secs), false) {
                said.push((secs, text));
            }
        }
        said
    }

    #[test]
    fn a_problem_is_said_once_and_its_end_too() {
        let frames = |secs| if secs < 5.0 { (Level::Error, "lost 1") } else { (Level::Ok, "found") };
        assert_eq!(said("Transform", 30.0, frames), [(2.0, "lost 1"), (7.0, "found")]);
        assert_eq!(said("Message", 30.0, frames), [(0.0, "lost 1"), (7.0, "found")]);
        let late = |secs| if secs < 1.5 { (Level::Error, "lost") } else { (Level::Ok, "found") };
        assert_eq!(said("Transform", 30.0, late), []);
        let numbers = |secs| (Level::Error, if secs < 5.0 { "at 17 s" } else { "at 18 s" });
        assert_eq!(said("Transform", 30.0, numbers), [(2.0, "at 17 s")]);
        let other = |secs| (Level::Error, if secs < 5.0 { "arm" } else { "leg" });
        assert_eq!(said("Transform", 30.0, other), [(2.0, "arm"), (12.0, "leg")]);
    }

    #[test]
    fn what_comes_and_goes_is_said_less_and_less_often() {
        let flutter = |secs: f64| if secs % 6.0 < 3.0 { (Level::Error, "bad") } else { (Level::Ok, "good") };
        let lines = said("Message", 3600.0, flutter);
        assert_eq!(lines[..4], [(0.0, "bad"), (5.0, "good"), (12.0, "bad"), (17.0, "good")]);
        assert!(lines.len() < 40, "{}", lines.len());
        let alternating = |secs: f64| (Level::Error, if secs % 1.0 < 0.5 { "a" } else { "b" });
        let lines = said("Transform", 3600.0, alternating);
        assert!(lines.len() > 2 && lines.len() < 20, "{}", lines.len());
    }
}
