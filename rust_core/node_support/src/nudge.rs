//! A nudge: a correction by hand of where a projector is, which the node `projector` offers by dynamic_reconfigure.
//!
//! `x`, `y`, `z` move the frame that the projector's file places along its own axes; `roll`, `pitch` and `yaw` turn it
//! about its x, y and z axes: `parent_from_child = (that of the file) · nudge`.

use std::fmt;
use std::time::Duration;

use anyhow::{anyhow, bail};
use nalgebra::{Isometry3, UnitQuaternion};
use rcs_messages::dynamic_reconfigure::{Config, DoubleParameter, Reconfigure};
use rcs_messages::std_srvs::{Trigger, TriggerReq, TriggerRes};
use rcs_ros::settings::{Setting, SettingGroup};
use rcs_ros::{NodeError, ParameterValue, RosNode};

/// Names and descriptions of the parameters.
const PARAMETERS: [(&str, &str); 6] = [
    ("x", "Move along the frame's x axis [m]"),
    ("y", "Move along the frame's y axis [m]"),
    ("z", "Move along the frame's z axis [m]"),
    ("roll", "Turn about the frame's x axis [rad]"),
    ("pitch", "Turn about the frame's y axis [rad]"),
    ("yaw", "Turn about the frame's z axis [rad]"),
];
/// Largest value of a parameter, metres or radians; the smallest is its negative.
const LARGEST: f64 = 0.5;
/// Difference of values that are the same.
const ROUNDING: f64 = 1e-12;
/// Time that each call to the node may take.
const CALL_TIMEOUT: Duration = Duration::from_secs(2);

/// A correction of a frame's pose: x, y, z in metres, then roll, pitch, yaw in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Nudge(pub [f64; 6]);

impl Nudge {
    /// The values of a dynamic_reconfigure server; `None` if it has other parameters.
    pub fn of_config(config: &Config) -> Option<Self> {
        let mut nudge = Self::default();
        for (value, (name, _)) in nudge.0.iter_mut().zip(PARAMETERS) {
            *value = config.doubles.iter().find(|parameter| parameter.name == name)?.value;
        }
        Some(nudge)
    }

    /// The nudge of a transform.
    pub fn of_isometry(isometry: &Isometry3<f64>) -> Self {
        let ([x, y, z], (roll, pitch, yaw)) = (isometry.translation.vector.into(), isometry.rotation.euler_angles());
        // Not minus zero.
        Self([x, y, z, roll, pitch, yaw].map(|value| value + 0.0))
    }

    /// The transform, which takes points of the nudged frame to the frame as it is in the file.
    pub fn isometry(&self) -> Isometry3<f64> {
        let [x, y, z, roll, pitch, yaw] = self.0;
        Isometry3::from_parts([x, y, z].into(), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
    }

    /// Takes values that the table below has accepted.
    pub fn take(&mut self, values: &[(String, ParameterValue)]) {
        for (own, (name, _)) in self.0.iter_mut().zip(PARAMETERS) {
            if let Some((_, ParameterValue::Double(value))) = values.iter().find(|(known, _)| known == name) {
                *own = *value;
            }
        }
    }

    /// The values, as a request to the node.
    pub fn config(&self) -> Config {
        let parameter = |((name, _), value): ((&str, &str), f64)| DoubleParameter { name: name.to_owned(), value };
        Config { doubles: PARAMETERS.into_iter().zip(self.0).map(parameter).collect(), ..Config::default() }
    }

    /// The table of the parameters.
    pub fn groups(&self) -> Vec<SettingGroup> {
        let setting = |((name, description), value)| Setting::new(name, description, [value, 0.0], [-LARGEST, LARGEST]);
        vec![("Default", PARAMETERS.into_iter().zip(self.0).map(setting).collect())]
    }

    /// `true` if all values are those of another one, except for rounding.
    fn is_close_to(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(one, other)| (one - other).abs() < ROUNDING)
    }

    /// `true` if all values are within the bounds.
    fn is_within_bounds(&self) -> bool {
        self.0.iter().all(|value| value.abs() <= LARGEST)
    }
}

impl fmt::Display for Nudge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let isometry = self.isometry();
        let (moved_mm, turned_deg) = (isometry.translation.vector.norm() * 1e3, isometry.rotation.angle().to_degrees());
        write!(f, "{moved_mm:.1} mm and {turned_deg:.2} degrees")
    }
}

/// The node that publishes a CameraInfo, and its nudge.
#[derive(Clone, Debug, PartialEq)]
pub struct NudgedProjector {
    /// Whole name of the node.
    pub node: String,
    /// Values that apply.
    pub nudge: Nudge,
}

impl NudgedProjector {
    /// The node `projector` that publishes a CameraInfo on a topic, by its whole name; `None` if there is none.
    ///
    /// # Errors
    /// [`NodeError`]: it does not answer.
    pub fn find(ros: &RosNode, topic: &str) -> Result<Option<Self>, NodeError> {
        let publications = ros.publications().or_else(|| ros.query_publications()).unwrap_or_default();
        let nodes = publications.get(topic).map(|publication| publication.nodes.as_slice()).unwrap_or_default();
        for node in nodes {
            // Calls only those that have a dynamic_reconfigure server of their own.
            if publications.contains_key(&format!("{node}/parameter_updates")) {
                // A request without values returns those that apply.
                if let Some(nudge) = set(ros, node, &Config::default())? {
                    return Ok(Some(Self { node: node.clone(), nudge }));
                }
            }
        }
        Ok(None)
    }

    /// Sets the values.
    ///
    /// # Errors
    /// They are out of bounds, or the node does not answer or refuses them.
    pub fn set(&mut self, ros: &RosNode, wanted: Nudge) -> anyhow::Result<()> {
        if !wanted.is_within_bounds() {
            bail!("{} can be nudged by at most {LARGEST} m and rad; save the nudge, or calibrate again", self.node);
        }
        self.nudge = set(ros, &self.node, &wanted.config())?.unwrap_or_default();
        if self.nudge.is_close_to(&wanted) {
            return Ok(());
        }
        // It has nothing to revert, and its answer says why.
        let reason = self.trigger(ros, "revert")?;
        Err(anyhow!("{}: {reason}", self.node))
    }

    /// Calls `save` or `revert`. Returns what the node says.
    ///
    /// # Errors
    /// It does not answer, or refuses.
    pub fn trigger(&self, ros: &RosNode, service: &str) -> anyhow::Result<String> {
        let service = format!("{}/{service}", self.node);
        match ros.call::<Trigger>(&service, &TriggerReq {}, CALL_TIMEOUT)? {
            TriggerRes { success: true, message } => Ok(message),
            TriggerRes { message, .. } => Err(anyhow!("{}: {message}", self.node)),
        }
    }
}

fn set(ros: &RosNode, node: &str, values: &Config) -> Result<Option<Nudge>, NodeError> {
    let values = ros.call::<Reconfigure>(&format!("{node}/set_parameters"), values, CALL_TIMEOUT)?;
    Ok(Nudge::of_config(&values))
}

#[cfg(test)]
mod tests {
    use rcs_ros::settings::accepted;

    use super::*;

    fn request(values: &[(&str, f64)]) -> Config {
        let parameter = |(name, value): &(&str, f64)| DoubleParameter { name: (*name).to_owned(), value: *value };
        Config { doubles: values.iter().map(parameter).collect(), ..Config::default() }
    }

    #[test]
    fn values_are_taken_by_name_and_clamped() {
        let mut nudge = Nudge([0.1; 6]);
        let values = [("x", 7.0), ("roll", -0.2), ("yaw", f64::NEG_INFINITY), ("y", f64::NAN), ("other", 1.0)];
        let values = values.map(|(name, value)| (name.to_owned(), ParameterValue::Double(value)));
        nudge.take(&accepted(&nudge.groups(), &values));
        assert_eq!(nudge, Nudge([0.5, 0.1, 0.1, -0.2, 0.1, -0.5]));
        assert_eq!(Nudge::of_config(&nudge.config()), Some(nudge));
        assert_eq!(Nudge::of_config(&request(&[("x", 0.1)])), None);
    }

    #[test]
    fn a_nudge_is_a_transform_and_back() {
        let nudge = Nudge([0.1, -0.2, 0.3, 0.4, -0.5, 0.25]);
        for (value, expected) in Nudge::of_isometry(&nudge.isometry()).0.iter().zip(nudge.0) {
            assert!((value - expected).abs() < 1e-15, "{value} {expected}");
        }
        assert_eq!(Nudge([0.003, 0.004, 0.0, 0.0, 0.0, 0.01]).to_string(), "5.0 mm and 0.57 degrees");
    }
}
