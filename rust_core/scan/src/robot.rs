//! The robot of a scan: the frames above the camera, by TF and the robot's description.

use nalgebra::Isometry3;
use rcs_files::capture::{CapturedFrame, CapturedRobot, FrameMotion};
use rcs_files::projector::StaticFrame;
use rcs_robot::{JointKind, Robot};
use rcs_transforms::{Time, TransformTree};

/// The robot as TF shows it now: the frames from the camera's optical frame up to TF's root, and how they move.
///
/// A frame moves as its joint of the description (URDF) does. One that the description does not have is fixed if it was
/// published on `/tf_static`.
pub fn captured_robot(tree: &TransformTree, camera_frame: &str, description: Option<&str>) -> CapturedRobot {
    let robot = description.and_then(|urdf| Robot::parse(urdf).ok()).unwrap_or_default();
    let mut frames = Vec::new();
    let mut child = camera_frame.trim_start_matches('/').to_owned();
    // A loop in TF has no root.
    for _ in 0..tree.frames().count() {
        let Some(parent) = tree.parent_of(&child, Time::ZERO).map(str::to_owned) else { break };
        let Ok(parent_from_child) = tree.lookup(&parent, &child, Time::ZERO) else { break };
        let is_static = tree.newest_stamp_of(&child).is_some_and(Time::is_zero);
        frames.push(captured_frame(&robot, &parent, &child, &parent_from_child, is_static));
        child = parent;
    }
    CapturedRobot { description: description.map(str::to_owned), frames }
}

fn captured_frame(
    robot: &Robot,
    parent: &str,
    child: &str,
    parent_from_child: &Isometry3<f64>,
    is_static: bool,
) -> CapturedFrame {
    let is_joint = |(_, joint): &(_, &rcs_robot::Joint)| joint.parent_link == parent && joint.child_link == child;
    let joint = robot.joints.iter().find(is_joint);
    let motion = match joint {
        Some((_, joint)) => match joint.kind {
            JointKind::Fixed => FrameMotion::Fixed,
            JointKind::Revolute => FrameMotion::Revolute,
            JointKind::Continuous => FrameMotion::Continuous,
            JointKind::Prismatic => FrameMotion::Prismatic,
            JointKind::Floating => FrameMotion::Floating,
            JointKind::Planar => FrameMotion::Planar,
        },
        None if is_static => FrameMotion::Fixed,
        None => FrameMotion::Moving,
    };
    let frame = StaticFrame {
        parent: parent.to_owned(),
        child: child.to_owned(),
        translation_m: parent_from_child.translation.vector.into(),
        rotation: parent_from_child.rotation,
    };
    CapturedFrame { frame, motion, joint: joint.map(|(name, _)| name.clone()) }
}

#[cfg(test)]
mod tests {
    use rcs_transforms::RawTransform;

    use super::*;

    const URDF: &str = "<robot name='r'><link name='base'/><link name='head'/><link name='camera'/>
        <joint name='pan' type='continuous'><parent link='base'/><child link='head'/><axis xyz='0 0 1'/></joint>
        <joint name='mount' type='fixed'><parent link='head'/><child link='camera'/></joint></robot>";

    fn tree() -> TransformTree {
        let mut tree = TransformTree::new();
        for (parent, child, is_static, x) in [
            ("odom", "base", false, 1.0),
            ("base", "head", false, 2.0),
            ("head", "camera", false, 3.0),
            ("camera", "optical", true, 4.0),
        ] {
            let transform = RawTransform {
                parent,
                child,
                stamp: Time::from_secs_nanos(5, 0),
                translation: [x, 0.0, 0.0],
                rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
            };
            tree.insert(&transform, is_static, "/a").unwrap();
        }
        tree
    }

    fn motions(robot: &CapturedRobot) -> Vec<(&str, FrameMotion, Option<&str>)> {
        robot.frames.iter().map(|frame| (&*frame.frame.child, frame.motion, frame.joint.as_deref())).collect()
    }

    #[test]
    fn frames_move_as_their_joints_and_those_without_a_joint_by_their_topic() {
        let robot = captured_robot(&tree(), "/optical", Some(URDF));
        let expected = [
            ("optical", FrameMotion::Fixed, None),
            ("camera", FrameMotion::Fixed, Some("mount")),
            ("head", FrameMotion::Continuous, Some("pan")),
            ("base", FrameMotion::Moving, None),
        ];
        assert_eq!(motions(&robot), expected);
        assert_eq!(
            robot.frames.iter().map(|frame| frame.frame.translation_m[0]).collect::<Vec<_>>(),
            [4.0, 3.0, 2.0, 1.0]
        );
        assert_eq!(robot.description.as_deref(), Some(URDF));
    }

    #[test]
    fn without_a_readable_description_what_is_on_tf_moves() {
        for description in [None, Some("no XML")] {
            let robot = captured_robot(&tree(), "optical", description);
            let moving = robot.frames.iter().filter(|frame| frame.motion == FrameMotion::Moving).count();
            assert_eq!((robot.frames.len(), moving), (4, 3));
        }
        assert!(captured_robot(&tree(), "elsewhere", None).frames.is_empty());
    }
}
