//! The frames between the camera and the robot's base during a scan, as its capture has them.

use anyhow::anyhow;
use nalgebra::Isometry3;
use rcs_files::capture::{CapturedFrame, CapturedRobot, FrameMotion};
use rcs_robot::Robot;

use super::Failure;

/// The frames above a camera, from it upwards.
pub(super) struct CameraChain<'a> {
    camera: &'a str,
    frames: &'a [CapturedFrame],
    /// Without links if the capture has no readable description.
    robot: Robot,
}

impl<'a> CameraChain<'a> {
    /// The chain of a capture; `None` if that has no frames above the camera.
    pub(super) fn new(captured: &'a CapturedRobot, camera: &str) -> Option<Self> {
        let camera = camera.trim_start_matches('/');
        let start = captured.frames.iter().position(|above| above.frame.child == camera)?;
        let frames = &captured.frames[start..];
        let robot = captured.description.as_deref().and_then(|urdf| Robot::parse(urdf).ok()).unwrap_or_default();
        Some(Self { camera: &frames.first()?.frame.child, frames, robot })
    }

    /// Names of the camera's frame and those above it.
    fn names(&self) -> impl Iterator<Item = &str> {
        std::iter::once(self.camera).chain(self.frames.iter().map(|above| &*above.frame.parent))
    }

    /// The frames up to the robot's base: the description's root, or TF's.
    fn up_to_base(&self) -> &[CapturedFrame] {
        let root = self.robot.root();
        let below_root = self.frames.iter().position(|above| Some(&*above.frame.parent) == root);
        below_root.map_or(self.frames, |last| &self.frames[..=last])
    }

    /// Checks that no joint moves between the camera and the robot's base.
    ///
    /// # Errors
    /// [`Failure::Refused`] with the joints and the choices.
    pub(super) fn check_rigid(&self) -> Result<(), Failure> {
        let frames = self.up_to_base();
        let moving = || frames.iter().rev().filter(|above| above.motion != FrameMotion::Fixed);
        let base = frames.last().map_or(self.camera, |last| &last.frame.parent);
        let mounts: Vec<&str> = std::iter::once(base).chain(moving().map(|above| &*above.frame.child)).collect();
        let names = |is_joint: bool| -> Vec<String> {
            moving()
                .filter(|above| above.joint.is_some() == is_joint)
                .map(|above| {
                    above.joint.clone().unwrap_or_else(|| format!("{} in {}", above.frame.child, above.frame.parent))
                })
                .collect()
        };
        let (joints, others) = (names(true), names(false));
        let what = match (joints.is_empty(), others.is_empty()) {
            (true, true) => return Ok(()),
            (false, true) => format!("the joints {}", joints.join(", ")),
            (true, false) => format!("the frames {} (on /tf and in no robot description)", others.join(", ")),
            (false, false) => format!(
                "the joints {} and the frames {} (on /tf and not in the robot's description)",
                joints.join(", "),
                others.join(", ")
            ),
        };
        Err(Failure::Refused(anyhow!(
            "{what} move between {} and {base}: choose --parent FRAME (where the projector is mounted: {}) or \
             --in-camera-frame (it moves with the camera)",
            self.camera,
            mounts.join(", ")
        )))
    }

    /// The camera's pose in a frame of the chain, or in one that is fixed to it by the robot's description.
    ///
    /// # Errors
    /// [`Failure::Refused`] with all frames of the chain.
    pub(super) fn parent_from_camera(&self, parent: &str) -> Result<Isometry3<f64>, Failure> {
        let parent = parent.trim_start_matches('/');
        let mut poses = vec![(self.camera, Isometry3::identity())];
        for CapturedFrame { frame, .. } in self.frames {
            let (_, child_from_camera) = poses.last().copied().unwrap_or((self.camera, Isometry3::identity()));
            poses.push((&frame.parent, frame.parent_from_child() * child_from_camera));
        }
        let own = poses.iter().find(|(name, _)| *name == parent).map(|(_, pose)| *pose);
        let fixed =
            || poses.iter().find_map(|(name, pose)| Some(self.robot.fixed_transform(name, parent)?.inverse() * *pose));
        own.or_else(fixed).ok_or_else(|| {
            let names: Vec<&str> = self.names().collect();
            Failure::Refused(anyhow!(
                "--parent {parent}: neither a frame above the camera during the scan nor fixed to one; from the camera \
                 up, these are {}",
                names.join(", ")
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};
    use rcs_files::projector::StaticFrame;

    use super::*;

    /// Like Fetch's, with a mount on the torso that is not above the camera.
    const URDF: &str = "<robot name='fetch'><link name='base_link'/><link name='torso'/><link name='mount'/>
        <link name='pan'/><link name='tilt'/>
        <joint name='lift' type='prismatic'><parent link='base_link'/><child link='torso'/>
          <limit lower='0' upper='1' effort='1' velocity='1'/></joint>
        <joint name='bracket' type='fixed'><parent link='torso'/><child link='mount'/><origin xyz='0 0 0.5'/></joint>
        <joint name='pan_joint' type='continuous'><parent link='torso'/><child link='pan'/></joint>
        <joint name='tilt_joint' type='continuous'><parent link='pan'/><child link='tilt'/></joint></robot>";

    fn frame(child: &str, parent: &str, x: f64, motion: FrameMotion, joint: Option<&str>) -> CapturedFrame {
        let (parent, child, rotation) = (parent.to_owned(), child.to_owned(), UnitQuaternion::identity());
        let frame = StaticFrame { parent, child, translation_m: [x, 0.0, 0.0], rotation };
        CapturedFrame { frame, motion, joint: joint.map(str::to_owned) }
    }

    fn fetch() -> CapturedRobot {
        let mut robot = CapturedRobot {
            description: Some(URDF.to_owned()),
            frames: vec![
                frame("optical", "tilt", 1.0, FrameMotion::Fixed, None),
                frame("tilt", "pan", 2.0, FrameMotion::Continuous, Some("tilt_joint")),
                frame("pan", "torso", 4.0, FrameMotion::Continuous, Some("pan_joint")),
                frame("torso", "base_link", 8.0, FrameMotion::Prismatic, Some("lift")),
                frame("base_link", "odom", 16.0, FrameMotion::Moving, None),
            ],
        };
        // Looks back.
        robot.frames[2].frame.rotation = UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::PI);
        robot
    }

    fn refusal(result: Result<impl std::fmt::Debug, Failure>) -> String {
        match result {
            Err(Failure::Refused(error)) => error.to_string(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn moving_joints_up_to_the_robots_base_are_refused_with_both_choices() {
        let robot = fetch();
        let error = refusal(CameraChain::new(&robot, "/optical").unwrap().check_rigid());
        assert_eq!(
            error,
            "the joints lift, pan_joint, tilt_joint move between optical and base_link: choose --parent FRAME (where \
             the projector is mounted: base_link, torso, pan, tilt) or --in-camera-frame (it moves with the camera)"
        );
    }

    #[test]
    fn without_a_description_frames_of_tf_count_as_moving() {
        let mut robot = fetch();
        robot.description = None;
        for above in &mut robot.frames {
            above.joint = None;
        }
        let error = refusal(CameraChain::new(&robot, "optical").unwrap().check_rigid());
        assert!(
            error.contains("the frames base_link in odom, torso in base_link, pan in torso, tilt in pan (on /tf"),
            "{error}"
        );
        assert!(error.contains("between optical and odom: choose --parent FRAME"), "{error}");
    }

    #[test]
    fn a_chain_without_moving_joints_is_not_refused() {
        let mut robot = fetch();
        for above in &mut robot.frames[..4] {
            above.motion = FrameMotion::Fixed;
        }
        // The robot drives, but its base is the description's root.
        assert!(CameraChain::new(&robot, "optical").unwrap().check_rigid().is_ok());
        assert!(CameraChain::new(&robot, "other_camera").is_none());
        assert!(CameraChain::new(&CapturedRobot::default(), "optical").is_none());
    }

    #[test]
    fn the_stored_chain_and_the_description_place_the_camera() {
        let robot = fetch();
        let chain = CameraChain::new(&robot, "optical").unwrap();
        let place = |parent: &str| chain.parent_from_camera(parent).map(|pose| pose.translation.vector);
        let expected = [
            ("optical", [0.0, 0.0, 0.0]),
            ("pan", [3.0, 0.0, 0.0]),
            ("/torso", [1.0, 0.0, 0.0]),
            ("mount", [1.0, 0.0, -0.5]),
            ("odom", [25.0, 0.0, 0.0]),
        ];
        for (parent, at) in expected {
            assert!((place(parent).unwrap() - Vector3::from(at)).norm() < 1e-12, "{parent}");
        }
        assert_eq!(
            refusal(place("gripper")),
            "--parent gripper: neither a frame above the camera during the scan nor fixed to one; from the camera up, \
             these are optical, tilt, pan, torso, base_link, odom"
        );
    }
}
