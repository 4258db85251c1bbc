//! The pan-tilt unit: two joints of the robot description and the lens above them.
//!
//! Transforms between links with only fixed joints between them come from the description, all others from TF: a lift
//! in between, or a lens that the description lacks.

use nalgebra::Isometry3;
use rcs_robot::{ChainError, Hinge, PanTilt, Robot};
use rcs_transforms::{Time, TransformTree};

/// A pan-tilt unit.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    robot: Robot,
    joints: [NamedJoint; 2],
}

/// A joint of the unit.
#[derive(Clone, Debug)]
pub(super) struct NamedJoint {
    pub(super) name: String,
    hinge: Hinge,
    parent_link: String,
    child_link: String,
    parent_from_child_at_zero: Isometry3<f64>,
    /// Radians per second.
    pub(super) greatest_speed: Option<f64>,
}

impl NamedJoint {
    fn of(robot: &Robot, name: &str) -> Result<Self, ChainError> {
        let joint = robot.turning_joint(name)?;
        Ok(Self {
            name: name.to_owned(),
            hinge: Hinge::of(name, joint)?,
            parent_link: joint.parent_link.clone(),
            child_link: joint.child_link.clone(),
            parent_from_child_at_zero: joint.parent_from_child_at_zero,
            greatest_speed: joint.limits.map(|limits| limits.velocity).filter(|speed| *speed > 0.0),
        })
    }

    /// The limit at a position, radians, if it is at one.
    pub(super) fn limit_at(&self, position: f64) -> Option<f64> {
        let travel = self.hinge.travel;
        [travel.lower, travel.upper].into_iter().find(|limit| (position - limit).abs() < 1e-6)
    }
}

impl Unit {
    /// The unit of the named joints, or of the two revolute joints above the lens.
    ///
    /// # Errors
    /// [`ChainError`].
    pub(super) fn of(robot: Robot, given: [Option<&str>; 2], lens_frame: &str) -> Result<Self, ChainError> {
        let names = match given {
            [Some(pan), Some(tilt)] => [pan.to_owned(), tilt.to_owned()],
            _ => robot.two_turning_joints(lens_frame)?,
        };
        robot.check_order(&names[0], &names[1]).or_else(|error| {
            // An unknown name is the better error.
            robot.turning_joint(&names[0]).and(robot.turning_joint(&names[1])).and(Err(error))
        })?;
        let [first, second] = &names;
        let joints = [NamedJoint::of(&robot, first)?, NamedJoint::of(&robot, second)?];
        Ok(Self { robot, joints })
    }

    /// The joints, the one nearer to the base first.
    pub(super) fn joints(&self) -> &[NamedJoint; 2] {
        &self.joints
    }

    /// The kinematics of both joints and the lens.
    ///
    /// # Errors
    /// The missing frame.
    pub(super) fn pan_tilt(&self, tree: &TransformTree, lens_frame: &str) -> Result<PanTilt, String> {
        let [first, second] = &self.joints;
        let between = self.transform(tree, &first.child_link, &second.parent_link)?;
        Ok(PanTilt {
            hinges: [first.hinge, second.hinge],
            first_from_second: between * second.parent_from_child_at_zero,
            second_from_lens: self.transform(tree, &second.child_link, lens_frame)?,
        })
    }

    /// Transform from a frame to the base of the unit, which is the first joint's frame at zero.
    ///
    /// # Errors
    /// The missing frame.
    pub(super) fn base_from(&self, tree: &TransformTree, frame: &str) -> Result<Isometry3<f64>, String> {
        let first = &self.joints[0];
        let parent_from_frame = self.transform(tree, &first.parent_link, frame)?;
        Ok(first.parent_from_child_at_zero.inverse() * parent_from_frame)
    }

    fn transform(&self, tree: &TransformTree, target: &str, source: &str) -> Result<Isometry3<f64>, String> {
        let source = source.trim_start_matches('/');
        match self.robot.fixed_transform(target, source) {
            Some(fixed) => Ok(fixed),
            None => tree.lookup(target, source, Time::ZERO).map_err(|error| error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use rcs_transforms::RawTransform;

    use super::*;

    const TURRET: &str =
        "<robot name='r'><link name='torso'/><link name='yoke'/><link name='cradle'/><link name='lens'/>
        <joint name='pan' type='revolute'><parent link='torso'/><child link='yoke'/><origin xyz='1 0 0'/>
          <axis xyz='0 0 1'/><limit lower='-2' upper='2' effort='1' velocity='3'/></joint>
        <joint name='tilt' type='continuous'><parent link='yoke'/><child link='cradle'/><origin xyz='0 0 0.1'/>
          <axis xyz='0 1 0'/></joint>
        <joint name='optics' type='fixed'><parent link='cradle'/><child link='lens'/><origin xyz='0 0 0.05'/></joint>
        </robot>";

    #[test]
    fn the_description_is_enough_where_it_has_the_lens() {
        let unit = Unit::of(Robot::parse(TURRET).unwrap(), [None, None], "lens").unwrap();
        assert_eq!(unit.joints().each_ref().map(|joint| joint.name.as_str()), ["pan", "tilt"]);
        assert_eq!(unit.joints().each_ref().map(|joint| joint.greatest_speed), [Some(3.0), None]);
        let pan_tilt = unit.pan_tilt(&TransformTree::new(), "lens").unwrap();
        let lens = pan_tilt.base_from_lens([0.0, 0.0]) * Point3::origin();
        assert!((lens - Point3::new(0.0, 0.0, 0.15)).norm() < 1e-12);
        let base = unit.base_from(&TransformTree::new(), "torso").unwrap();
        assert!((base * Point3::new(1.0, 0.0, 0.0) - Point3::origin()).norm() < 1e-12);
        assert_eq!(unit.joints()[0].limit_at(2.0), Some(2.0));
    }

    /// The package's own robots: their turrets reach a table, with the lens beside both axes.
    #[test]
    fn the_turrets_of_the_package_light_a_table() {
        for text in [
            include_str!("../../../../ros_pkg/urdf/fetch_turret.urdf"),
            include_str!("../../../../ros_pkg/urdf/arm_turret.urdf"),
        ] {
            let robot = Robot::parse(text).unwrap();
            assert!(robot.left_out.is_empty(), "{:?}", robot.left_out);
            let unit = Unit::of(robot, [None, None], "proj_view").unwrap();
            let tree = TransformTree::new();
            let pan_tilt = unit.pan_tilt(&tree, "proj_view").unwrap();
            let beam = rcs_robot::Beam { origin: Point3::origin(), direction: nalgebra::Vector3::z_axis() };
            // Ahead of the turret and half a metre below it.
            let aim = pan_tilt.aim(&beam, Point3::new(0.9, 0.2, -0.5), [0.0, 0.0]).unwrap();
            assert!(aim.meets() && aim.positions[1] > 0.3, "{aim:?}");
        }
    }

    #[test]
    fn a_lens_that_is_only_a_frame_needs_the_names_of_the_joints() {
        let robot = Robot::parse(TURRET).unwrap();
        assert!(Unit::of(robot.clone(), [None, None], "proj_view").is_err());
        let unit = Unit::of(robot, [Some("pan"), Some("tilt")], "proj_view").unwrap();
        let mut tree = TransformTree::new();
        assert!(unit.pan_tilt(&tree, "proj_view").unwrap_err().contains("proj_view"));
        let mount = RawTransform {
            parent: "cradle",
            child: "proj_view",
            stamp: Time::ZERO,
            translation: [0.2, 0.0, 0.0],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
        };
        tree.insert(&mount, true, "projector").unwrap();
        let lens = unit.pan_tilt(&tree, "/proj_view").unwrap().second_from_lens;
        assert_eq!(lens.translation.vector.x, 0.2);
    }

    #[test]
    fn joints_that_are_not_there_or_in_the_wrong_order_are_named() {
        let error = |names: [&str; 2]| {
            Unit::of(Robot::parse(TURRET).unwrap(), names.map(Some), "lens").unwrap_err().to_string()
        };
        assert!(error(["tilt", "pan"]).contains("right order"));
        assert!(error(["head", "tilt"]).contains("no joint \"head\""));
    }
}
