//! Nudging a projector from its image: steps along the image's axes become values of the node `projector` that
//! publishes the camera's CameraInfo.
//!
//! That node moves the frame of the CameraInfo, the optical frame: `parent_from_optical = (that of its file) · nudge`.
//! A step moves the optical frame as it is now, so the new nudge is `nudge · step`. The image's axes are those of the
//! optical frame, turned and mirrored like the image.

use anyhow::{Context, Result};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rcs_camera::QuarterTurns;
use rcs_node_support::nudge::{Nudge, NudgedProjector};
use rcs_render::Orientation;
use rcs_ros::RosNode;

/// A step of the projector's frame: to the right, down and forward along the image's axes in metres, then about these
/// axes in radians. Positive pitch (about right) turns the view up, yaw (about down) to the right, and roll (about
/// forward) the projector clockwise, seen from behind.
pub type Step = [f64; 6];

/// The node `projector` that publishes the CameraInfo on a topic.
///
/// # Errors
/// There is none, or it does not answer.
pub fn projector(ros: &RosNode, camera_info_topic: &str) -> Result<NudgedProjector> {
    let topic = ros.resolve(camera_info_topic)?;
    NudgedProjector::find(ros, &topic)?.with_context(|| {
        format!(
            "{topic} is not published by a node projector, which alone can be nudged; start it with the projector's \
             file"
        )
    })
}

/// Moves a projector by a step along the axes of its image.
///
/// # Errors
/// The sum of all steps is too large, or the node does not answer or refuses it.
pub fn nudge(ros: &RosNode, projector: &mut NudgedProjector, orientation: Orientation, step: &Step) -> Result<()> {
    projector.set(ros, Nudge::of_isometry(&(projector.nudge.isometry() * in_optical_frame(step, orientation))))
}

/// The step in the axes of the camera's optical frame.
fn in_optical_frame(step: &Step, orientation: Orientation) -> Isometry3<f64> {
    let [right, down, forward, pitch, yaw, roll] = *step;
    let optical_from_image = optical_from_image(orientation);
    let translation = optical_from_image * Vector3::new(right, down, forward);
    // In a mirror, a turn to the right is one to the left.
    let turn = optical_from_image.determinant().signum() * optical_from_image;
    Isometry3::from_parts(translation.into(), UnitQuaternion::from_scaled_axis(turn * Vector3::new(pitch, yaw, roll)))
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
        in_optical_frame(&step, orientation.parse().unwrap())
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
            let moved = step(orientation, [MM, 0.0, 0.0, 0.0, 0.0, 0.0]);
            assert_eq!(moved.translation.vector, Vector3::from(expected), "{orientation}");
            assert_eq!(moved.rotation, UnitQuaternion::identity(), "{orientation}");
        }
        assert_eq!(step("90", [0.0, MM, 0.0, 0.0, 0.0, 0.0]).translation.vector, Vector3::new(MM, 0.0, 0.0));
        for orientation in ["0", "90", "180", "270", "mirrored", "mirrored-270"] {
            let forward = step(orientation, [0.0, 0.0, MM, 0.0, 0.0, 0.0]);
            assert_eq!(forward.translation.vector, Vector3::new(0.0, 0.0, MM), "{orientation}");
            // The view turns where the image's right is.
            let right = step(orientation, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]).translation.vector;
            let view = step(orientation, [0.0, 0.0, 0.0, 0.0, 0.1, 0.0]) * Vector3::z();
            assert!((view.dot(&right) - 0.1_f64.sin()).abs() < 1e-15, "{orientation}: {view}");
            let up = -step(orientation, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]).translation.vector;
            let view = step(orientation, [0.0, 0.0, 0.0, 0.1, 0.0, 0.0]) * Vector3::z();
            assert!((view.dot(&up) - 0.1_f64.sin()).abs() < 1e-15, "{orientation}: {view}");
        }
    }

    /// `parent_from_optical` moves by the step, whatever the nudge was.
    #[test]
    fn a_step_moves_the_optical_frame_by_itself() {
        let in_file = Isometry3::from_parts([1.0, 2.0, 3.0].into(), UnitQuaternion::from_euler_angles(-1.57, 0.2, 0.4));
        let before = Nudge([0.01, -0.02, 0.03, 0.1, -0.2, 0.3]);
        for orientation in ["0", "90", "mirrored-180"] {
            let step = step(orientation, [MM, 0.0, 0.0, 0.0, 0.002, 0.0]);
            let after = Nudge::of_isometry(&(before.isometry() * step));
            let moved = (in_file * before.isometry()).inverse() * (in_file * after.isometry());
            assert!((moved.translation.vector - step.translation.vector).norm() < 1e-14, "{orientation}: {moved}");
            assert!(moved.rotation.angle_to(&step.rotation) < 1e-14, "{orientation}: {moved}");
        }
    }
}
