//! The received inputs of an aim, and which of them is missing.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_messages::sensor_msgs::{CameraInfo, JointState};
use rcs_messages::AnyMessage;
use rcs_robot::{Beam, PanTilt, Robot};
use rcs_transforms::{Time, TransformTree};

use super::arguments::TurretArguments;
use super::beam::{beam, AimPixel};
use super::unit::Unit;
use crate::target::Target;

/// Age at which joint states expire.
const JOINTS_TIMEOUT: Duration = Duration::from_secs(1);

/// The inputs of an aim.
#[derive(Clone, Debug)]
pub(super) struct Posture<'a> {
    pub(super) unit: &'a Unit,
    pub(super) pan_tilt: PanTilt,
    pub(super) beam: Beam,
    /// In the unit's base frame, metres.
    pub(super) target: Point3<f64>,
    /// Joint positions, radians.
    pub(super) present: [f64; 2],
}

/// Why there is no aim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum MissingInput {
    /// An input was not received, or has expired.
    Awaited(String),
    /// An input is invalid.
    Invalid(String),
}

/// Received inputs.
pub(super) struct TurretInputs {
    description: String,
    pixel: AimPixel,
    lens_frame: Option<String>,
    joint_names: [Option<String>; 2],
    info_topic: String,
    states_topic: String,
    robot: Option<Result<Robot, String>>,
    info: Option<Arc<CameraInfo>>,
    /// The lens frame and the unit made for it.
    unit: Option<(String, Result<Unit, String>)>,
    positions: BTreeMap<String, (f64, Instant)>,
}

impl TurretInputs {
    pub(super) fn new(arguments: &TurretArguments) -> Self {
        Self {
            description: arguments.robot_description.clone(),
            pixel: arguments.pixel,
            lens_frame: arguments.lens_frame.clone(),
            joint_names: [arguments.pan_joint.clone(), arguments.tilt_joint.clone()],
            info_topic: String::new(),
            states_topic: String::new(),
            robot: None,
            info: None,
            unit: None,
            positions: BTreeMap::new(),
        }
    }

    /// Sets the resolved names of the topics.
    pub(super) fn name_topics(&mut self, info: &str, states: &str) {
        (self.info_topic, self.states_topic) = (info.to_owned(), states.to_owned());
    }

    /// Sets the robot description; `None` while the parameter is not set.
    pub(super) fn take_description(&mut self, text: Option<&str>) {
        self.unit = None;
        self.robot = text.map(|text| {
            let robot = Robot::parse(text).map_err(|error| format!("parameter {}: {error}", self.description))?;
            robot.left_out.iter().for_each(|fault| log::warn!("parameter {}: {fault}", self.description));
            Ok(robot)
        });
    }

    /// Handles a message of one of the topics.
    pub(super) fn take(&mut self, topic: &str, message: &AnyMessage, received: Instant) {
        match message {
            AnyMessage::CameraInfo(info) if topic == self.info_topic => self.info = Some(Arc::clone(info)),
            AnyMessage::JointState(state) if topic == self.states_topic => self.take_positions(state, received),
            _ => {}
        }
    }

    fn take_positions(&mut self, state: &JointState, received: Instant) {
        let Some((_, Ok(unit))) = &self.unit else { return };
        for (name, position) in state.name.iter().zip(&state.position) {
            if position.is_finite() && unit.joints().iter().any(|joint| joint.name == *name) {
                self.positions.insert(name.clone(), (*position, received));
            }
        }
    }

    /// The inputs of an aim now.
    ///
    /// # Errors
    /// The first missing one.
    pub(super) fn posture(
        &mut self,
        tree: &TransformTree,
        target: &mut Target,
        now: Time,
    ) -> Result<Posture<'_>, MissingInput> {
        let info = self
            .info
            .clone()
            .ok_or_else(|| MissingInput::Awaited(format!("no CameraInfo yet on {}", self.info_topic)))?;
        let lens_frame = self.lens_frame.clone().unwrap_or_else(|| info.header.frame_id.clone());
        let beam = beam(&info, self.pixel)
            .map_err(|reason| MissingInput::Invalid(format!("the CameraInfo on {}: {reason}", self.info_topic)))?;
        self.make_unit(&lens_frame);
        // First, so that targets that wait for their transforms are handled whatever else is missing.
        let fixed = target.position(tree, now).map_err(|error| MissingInput::Awaited(error.to_string()));
        let unit = self.unit()?;
        let mut present = [0.0; 2];
        for (position, joint) in present.iter_mut().zip(unit.joints()) {
            *position = self.position(&joint.name)?;
        }
        let fixed = fixed?;
        let pan_tilt = unit.pan_tilt(tree, &lens_frame).map_err(MissingInput::Awaited)?;
        let base_from_fixed = unit.base_from(tree, target.fixed_frame()).map_err(MissingInput::Awaited)?;
        Ok(Posture { unit, pan_tilt, beam, target: base_from_fixed * fixed, present })
    }

    /// Makes the unit once the description is known, and again for another lens frame.
    fn make_unit(&mut self, lens_frame: &str) {
        let Some(robot) = &self.robot else { return };
        if self.unit.as_ref().is_none_or(|(frame, _)| frame != lens_frame) {
            let names = self.joint_names.each_ref().map(Option::as_deref);
            let made = |robot: &Robot| Unit::of(robot.clone(), names, lens_frame).map_err(|error| error.to_string());
            self.unit = Some((lens_frame.to_owned(), robot.as_ref().map_err(String::clone).and_then(made)));
        }
    }

    fn unit(&self) -> Result<&Unit, MissingInput> {
        match &self.unit {
            None => Err(MissingInput::Awaited(format!("parameter {} is not set", self.description))),
            Some((_, unit)) => unit.as_ref().map_err(|error| MissingInput::Invalid(error.clone())),
        }
    }

    fn position(&self, joint: &str) -> Result<f64, MissingInput> {
        let topic = &self.states_topic;
        match self.positions.get(joint) {
            Some((position, at)) if at.elapsed() <= JOINTS_TIMEOUT => Ok(*position),
            Some(_) => Err(MissingInput::Awaited(format!("the position of joint {joint} on {topic} has expired"))),
            None => Err(MissingInput::Awaited(format!("no position of joint {joint} yet on {topic}"))),
        }
    }
}
