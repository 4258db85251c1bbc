//! Settings of the prediction of moving frames: a picture shows where things are when it has become light.
//!
//! What a camera looks up now is seen later, by the time that drawing, publishing and the screen take. A projector on a
//! robot has moved on by then, so the camera, and displays that follow frames, look ahead by that much; see
//! [`rcs_transforms::Prediction`]. What a message places at its stamp is not predicted.

use std::time::Duration;

use anyhow::Result;
use clap::Args;
use rcs_ros::RosNode;
use rcs_transforms::{Prediction, Time};

use crate::private_parameters::choose;

/// How far ahead of now moving frames are looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lead {
    /// They are not: frames are where the latest transforms place them.
    #[default]
    Off,
    /// By the measured time from looking up to publishing, and the [screen's delay](PredictionSettings::screen_delay).
    Auto,
    /// By this.
    Fixed(Duration),
}

/// Whether and how far moving frames are predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PredictionSettings {
    /// How far ahead of now.
    pub lead: Lead,
    /// How far ahead of a frame's newest transform at most.
    pub limit: Duration,
    /// With [`Lead::Auto`]: the time from publishing a picture until it is light.
    pub screen_delay: Duration,
}

impl Default for PredictionSettings {
    /// Off; 0.1 s at most. The delay is that of a window which shows the next refresh of 60 Hz, without the
    /// projector's.
    fn default() -> Self {
        Self { lead: Lead::Off, limit: Duration::from_millis(100), screen_delay: Duration::from_millis(20) }
    }
}

/// The node's arguments for these settings.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct PredictionArgs {
    /// Draw moving frames, the camera's among them, where they will be so many seconds from now (0 to 1), or when the
    /// picture is seen (auto: the measured time until publishing, and --screen-delay); or not (off)
    #[arg(long, value_name = "SECS|auto|off", value_parser = lead)]
    pub predict: Option<Lead>,
    /// Predict no frame further than this after its newest transform, 0 to 1 seconds [default: 0.1]
    #[arg(long, value_name = "SECS", value_parser = seconds)]
    pub predict_limit: Option<Duration>,
    /// With --predict auto: the time from publishing a picture to its light, window and projector included, 0 to 1
    /// seconds [default: 0.02]
    #[arg(long, value_name = "SECS", value_parser = seconds)]
    pub screen_delay: Option<Duration>,
}

impl PredictionSettings {
    /// The command line's, else those of the parameters `~predict`, `~predict_limit` and `~screen_delay`.
    ///
    /// # Errors
    /// When a parameter has no valid value; names the parameter.
    pub(crate) fn read(ros: &RosNode, given: &PredictionArgs) -> Result<Self> {
        let default = Self::default();
        let secs = |given, name: &str, default| {
            Ok::<_, anyhow::Error>(choose(ros, given, &[name], seconds)?.unwrap_or(default))
        };
        Ok(Self {
            lead: choose(ros, given.predict, &["~predict"], lead)?.unwrap_or_default(),
            limit: secs(given.predict_limit, "~predict_limit", default.limit)?,
            screen_delay: secs(given.screen_delay, "~screen_delay", default.screen_delay)?,
        })
    }

    /// What is predicted now. `way` is the measured time from looking up frames to publishing the picture, if there was
    /// one.
    pub(crate) fn prediction(&self, now: Time, way: Option<Duration>) -> Option<Prediction> {
        let lead = match self.lead {
            Lead::Off => return None,
            Lead::Auto => way.unwrap_or_default() + self.screen_delay,
            Lead::Fixed(lead) => lead,
        };
        Some(Prediction { now, lead, limit: self.limit })
    }
}

/// Off, auto, or seconds; no seconds are off.
fn lead(text: &str) -> Result<Lead, String> {
    match text.to_ascii_lowercase().as_str() {
        "off" | "false" => Ok(Lead::Off),
        "auto" => Ok(Lead::Auto),
        _ => match seconds(text).map_err(|error| format!("{error}, or auto, or off"))? {
            Duration::ZERO => Ok(Lead::Off),
            lead => Ok(Lead::Fixed(lead)),
        },
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let secs = text.parse::<f64>().ok().filter(|secs| (0.0..=1.0).contains(secs));
    secs.map(Duration::from_secs_f64).ok_or_else(|| format!("{text} is not a number of seconds from 0 to 1"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lead_is_seconds_auto_or_off() {
        for (text, expected) in [
            ("0.05", Ok(Lead::Fixed(Duration::from_millis(50)))),
            ("0", Ok(Lead::Off)),
            ("0.0", Ok(Lead::Off)),
            ("off", Ok(Lead::Off)),
            ("Auto", Ok(Lead::Auto)),
        ] {
            assert_eq!(lead(text), expected);
        }
        for text in ["-0.1", "1.1", "nan", "soon", ""] {
            assert!(lead(text).unwrap_err().contains("from 0 to 1, or auto"), "{text}");
        }
    }

    #[test]
    fn auto_adds_the_screens_delay_to_the_measured_way() {
        let now = Time::from_secs_nanos(100, 0);
        let auto = PredictionSettings { lead: Lead::Auto, ..PredictionSettings::default() };
        let lead = |way_millis: Option<u64>| auto.prediction(now, way_millis.map(Duration::from_millis)).unwrap().lead;
        assert_eq!([lead(None), lead(Some(12))], [20, 32].map(Duration::from_millis));
        assert_eq!(PredictionSettings::default().prediction(now, None), None);
    }
}
