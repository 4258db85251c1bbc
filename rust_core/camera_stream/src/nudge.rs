//! Nudging a projector from its image: steps along the image's axes become values of the node `projector` that
//! publishes the camera's CameraInfo.
//!
//! That node moves the frame of the CameraInfo, the optical frame: `parent_from_optical = (that of its file) · nudge`.
//! A step moves the optical frame as it is now, so the new nudge is `nudge · step`. The image's axes are those of the
//! optical frame, turned and mirrored like the image.

use std::sync::{Arc, Mutex};

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rcs_camera::QuarterTurns;
use rcs_messages::std_srvs::TriggerRes;
use rcs_node_support::nudge::{Nudge, LARGEST};
pub use rcs_node_support::nudged_projector::NudgedProjector;
use rcs_render::Orientation;
use rcs_ros::{NodeError, RosNode};
use rcs_scene::lock;

/// A step of the projector's frame along and about the image's axes: x right, y down, z forward.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// To the right, metres.
    pub right_m: f64,
    /// Down, metres.
    pub down_m: f64,
    /// Along the view, metres.
    pub forward_m: f64,
    /// About the axis to the right, radians; positive turns the view up.
    pub pitch_rad: f64,
    /// About the axis down, radians; positive turns the view to the right.
    pub yaw_rad: f64,
    /// About the view, radians; positive turns the projector clockwise, seen from behind.
    pub roll_rad: f64,
}

/// A camera whose projector is nudged.
#[derive(Clone, Debug)]
pub struct NudgeTarget {
    /// Topic of the CameraInfo that the camera reads.
    pub camera_info_topic: String,
    /// Orientation of the camera's image.
    pub orientation: Orientation,
}

/// Errors of nudging.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NudgeError {
    /// No node that can be nudged publishes the CameraInfo.
    #[error(
        "{topic} is not published by a node projector, which alone can be nudged; start it with the projector's file"
    )]
    NoProjector {
        /// Topic of the CameraInfo.
        topic: String,
    },
    /// The node cannot be called.
    #[error(transparent)]
    Call(#[from] NodeError),
    /// The sum of all steps is too large.
    #[error("{node} can be nudged by at most {LARGEST} m and rad; save the nudge, or calibrate again")]
    TooFar {
        /// Name of the node.
        node: String,
    },
    /// The node refuses, with its reason.
    #[error("{node}: {reason}")]
    Refused {
        /// Name of the node.
        node: String,
        /// Reason.
        reason: String,
    },
}

/// Nudges projectors. Its methods wait for other nodes, some seconds at most.
pub struct Nudger {
    ros: Arc<RosNode>,
    /// Held from reading the values to writing them, so that all steps count.
    stepping: Mutex<()>,
}

impl Nudger {
    /// Nudges through the services of projectors' nodes.
    pub fn new(ros: Arc<RosNode>) -> Self {
        Self { ros, stepping: Mutex::default() }
    }

    /// The node that publishes a camera's CameraInfo, and its values.
    ///
    /// # Errors
    /// [`NudgeError::NoProjector`] or [`NudgeError::Call`].
    pub fn values(&self, target: &NudgeTarget) -> Result<NudgedProjector, NudgeError> {
        let topic = self.ros.resolve(&target.camera_info_topic)?;
        NudgedProjector::find(&self.ros, &topic)?.ok_or(NudgeError::NoProjector { topic })
    }

    /// Moves the projector by a step. Returns the values that apply then.
    ///
    /// # Errors
    /// [`NudgeError`].
    pub fn nudge(&self, target: &NudgeTarget, step: &Step) -> Result<NudgedProjector, NudgeError> {
        let _stepping = lock(&self.stepping);
        let known = self.values(target)?;
        let wanted = Nudge::of_isometry(&(known.nudge.isometry() * step.in_optical_frame(target.orientation)));
        if !wanted.is_within_bounds() {
            return Err(NudgeError::TooFar { node: known.node });
        }
        let set = known.set(&self.ros, &wanted)?;
        if set.nudge.is_close_to(&wanted) {
            return Ok(set);
        }
        // It has nothing to revert, and its answer says why.
        let reason = known.trigger(&self.ros, "revert")?.message;
        Err(NudgeError::Refused { node: known.node, reason })
    }

    /// Writes the nudged pose into the projector's file. Returns what the node says.
    ///
    /// # Errors
    /// [`NudgeError`].
    pub fn save(&self, target: &NudgeTarget) -> Result<String, NudgeError> {
        self.finish(target, "save")
    }

    /// Takes the nudge back. Returns what the node says.
    ///
    /// # Errors
    /// [`NudgeError`].
    pub fn revert(&self, target: &NudgeTarget) -> Result<String, NudgeError> {
        self.finish(target, "revert")
    }

    fn finish(&self, target: &NudgeTarget, service: &str) -> Result<String, NudgeError> {
        let _stepping = lock(&self.stepping);
        let known = self.values(target)?;
        match known.trigger(&self.ros, service)? {
            TriggerRes { success: true, message } => Ok(message),
            TriggerRes { message: reason, .. } => Err(NudgeError::Refused { node: known.node, reason }),
        }
    }
}

impl Step {
    /// The step in the axes of the camera's optical frame.
    fn in_optical_frame(&self, orientation: Orientation) -> Isometry3<f64> {
        let optical_from_image = optical_from_image(orientation);
        let translation = optical_from_image * Vector3::new(self.right_m, self.down_m, self.forward_m);
        // In a mirror, a turn to the right is one to the left.
        let turn = optical_from_image.determinant().signum() * optical_from_image;
        let rotation = turn * Vector3::new(self.pitch_rad, self.yaw_rad, self.roll_rad);
        Isometry3::from_parts(translation.into(), UnitQuaternion::from_scaled_axis(rotation))
    }
}

/// The axes of an oriented image in the camera's optical frame.
fn optical_from_image(orientation: Orientation) -> Matrix3<f64> {
    let turns = QuarterTurns { is_mirrored: orientation.is_mirrored, quarters: orientation.degrees() / 90 };
    let own_from_turned = turns.turned_from_optical().inverse().into_inner();
    // Mirrored first, then turned.
    let mirrored = if orientation.is_mirrored { -1.0 } else { 1.0 };
    Matrix3::from_diagonal(&Vector3::new(mirrored, 1.0, 1.0)) * own_from_turned
}

#[cfg(test)]
mod tests {
    use super::*;

    const MM: f64 = 0.001;

    fn step(orientation: &str, step: Step) -> Isometry3<f64> {
        step.in_optical_frame(orientation.parse().unwrap())
    }

    #[test]
    fn a_step_follows_the_axes_of_a_turned_or_mirrored_image() {
        // What points up in the lens points right after a quarter to the right, and left when mirrored before.
        for (orientation, expected) in [
            ("0", [MM, 0.0, 0.0]),
            ("90", [0.0, -MM, 0.0]),
            ("180", [-MM, 0.0, 0.0]),
            ("270", [0.0, MM, 0.0]),
            ("mirrored", [-MM, 0.0, 0.0]),
            ("mirrored-90", [0.0, -MM, 0.0]),
        ] {
            let moved = step(orientation, Step { right_m: MM, ..Step::default() });
            assert_eq!(moved.translation.vector, Vector3::from(expected), "{orientation}");
            assert_eq!(moved.rotation, UnitQuaternion::identity(), "{orientation}");
        }
        assert_eq!(step("90", Step { down_m: MM, ..Step::default() }).translation.vector, Vector3::new(MM, 0.0, 0.0));
        for orientation in ["0", "90", "180", "270", "mirrored", "mirrored-270"] {
            let forward = step(orientation, Step { forward_m: MM, ..Step::default() });
            assert_eq!(forward.translation.vector, Vector3::new(0.0, 0.0, MM), "{orientation}");
            // The view turns where the image's right is.
            let right = step(orientation, Step { right_m: 1.0, ..Step::default() }).translation.vector;
            let view = step(orientation, Step { yaw_rad: 0.1, ..Step::default() }) * Vector3::z();
            assert!((view.dot(&right) - 0.1_f64.sin()).abs() < 1e-15, "{orientation}: {view}");
            let up = -step(orientation, Step { down_m: 1.0, ..Step::default() }).translation.vector;
            let view = step(orientation, Step { pitch_rad: 0.1, ..Step::default() }) * Vector3::z();
            assert!((view.dot(&up) - 0.1_f64.sin()).abs() < 1e-15, "{orientation}: {view}");
        }
    }

    /// `parent_from_optical` moves by the step, whatever the nudge was.
    #[test]
    fn a_step_moves_the_optical_frame_by_itself() {
        let in_file = Isometry3::from_parts([1.0, 2.0, 3.0].into(), UnitQuaternion::from_euler_angles(-1.57, 0.2, 0.4));
        let before = Nudge([0.01, -0.02, 0.03, 0.1, -0.2, 0.3]);
        for orientation in ["0", "90", "mirrored-180"] {
            let step = step(orientation, Step { right_m: MM, yaw_rad: 0.002, ..Step::default() });
            let after = Nudge::of_isometry(&(before.isometry() * step));
            let moved = (in_file * before.isometry()).inverse() * (in_file * after.isometry());
            assert!((moved.translation.vector - step.translation.vector).norm() < 1e-14, "{orientation}: {moved}");
            assert!(moved.rotation.angle_to(&step.rotation) < 1e-14, "{orientation}: {moved}");
        }
    }
}
