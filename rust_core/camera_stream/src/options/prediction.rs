//! Prediction of moving frames: an image shows where things are when its light leaves the projector.
//!
//! Drawing, publishing and the screen take time, in which a projector on a robot moves on. So the camera, and displays
//! that follow frames, are extrapolated by that much; see [`rcs_transforms::Prediction`]. What a message places at its
//! stamp is not predicted.

use std::time::Duration;

use clap::Args;
use rcs_transforms::{Prediction, Time};

use rcs_node_support::node_options::within;

/// Prediction horizon of moving frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lead {
    /// None: frames are where the latest transforms place them.
    #[default]
    Off,
    /// The measured time from lookup to publishing, plus the [screen's delay](PredictionSettings::screen_delay).
    Auto,
    /// A fixed time.
    Fixed(Duration),
}

/// Prediction of moving frames.
#[derive(Args, Clone, Copy, Debug, PartialEq, Eq)]
pub struct PredictionSettings {
    /// Draw moving frames this many seconds ahead (0 to 1), or as far as the image is late (auto), or not (none)
    #[arg(long = "predict", value_name = "SECS|auto|none", default_value = "none", value_parser = lead)]
    pub lead: Lead,
    /// Longest time after a frame's newest transform that it is predicted for, 0 to 1 seconds
    #[arg(long = "predict-limit", value_name = "SECS", default_value = "0.1", value_parser = up_to_a_second)]
    pub limit: Duration,
    /// With --predict auto: the time from publishing an image to its light, 0 to 1 seconds
    #[arg(long, value_name = "SECS", default_value = "0.02", value_parser = up_to_a_second)]
    pub screen_delay: Duration,
}

impl PredictionSettings {
    /// The prediction at a time; `lookup_to_publish` is the measured time from lookup to publishing, if there is one.
    pub(crate) fn prediction(&self, now: Time, lookup_to_publish: Option<Duration>) -> Option<Prediction> {
        let lead = match self.lead {
            Lead::Off => return None,
            Lead::Auto => lookup_to_publish.unwrap_or_default() + self.screen_delay,
            Lead::Fixed(lead) => lead,
        };
        Some(Prediction { now, lead, limit: self.limit })
    }
}

/// Reads `none`, `auto` or seconds; 0 seconds are none.
fn lead(text: &str) -> Result<Lead, String> {
    match text {
        "none" => Ok(Lead::Off),
        "auto" => Ok(Lead::Auto),
        _ => match up_to_a_second(text).map_err(|_| "not seconds from 0 to 1, auto or none")? {
            Duration::ZERO => Ok(Lead::Off),
            lead => Ok(Lead::Fixed(lead)),
        },
    }
}

/// Reads seconds from 0 to 1.
fn up_to_a_second(text: &str) -> Result<Duration, String> {
    within(0.0, 1.0)(text).map(Duration::from_secs_f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lead_is_seconds_auto_or_none() {
        for (text, expected) in [
            ("0.05", Ok(Lead::Fixed(Duration::from_millis(50)))),
            ("0", Ok(Lead::Off)),
            ("0.0", Ok(Lead::Off)),
            ("none", Ok(Lead::Off)),
            ("auto", Ok(Lead::Auto)),
        ] {
            assert_eq!(lead(text), expected);
        }
        for text in ["-0.1", "1.1", "nan", "soon", ""] {
            assert!(lead(text).unwrap_err().contains("from 0 to 1, auto or none"), "{text}");
        }
    }

    #[test]
    fn auto_adds_the_screens_delay_to_the_measured_time() {
        let now = Time::from_secs_nanos(100, 0);
        let (limit, screen_delay) = (Duration::from_millis(100), Duration::from_millis(20));
        let auto = PredictionSettings { lead: Lead::Auto, limit, screen_delay };
        let lead = |millis: Option<u64>| auto.prediction(now, millis.map(Duration::from_millis)).unwrap().lead;
        assert_eq!([lead(None), lead(Some(12))], [20, 32].map(Duration::from_millis));
        assert_eq!(PredictionSettings { lead: Lead::Off, ..auto }.prediction(now, None), None);
    }
}
