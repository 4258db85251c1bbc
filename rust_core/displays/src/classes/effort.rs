//! `rviz/Effort`: an open circle around each joint, the larger the nearer its effort is to the joint's limit, with an
//! arrow's head that shows the direction.
//!
//! Only revolute joints are shown. A message is shown where the joints were when it came, and stays there. The oldest
//! of the shown messages is not replaced but overwritten: a joint that the new message does not name keeps the circle
//! that it has there. The display's opacity has no effect.

use std::collections::{BTreeMap, VecDeque};
use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use rcs_messages::sensor_msgs::JointState;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_rviz_config::EffortSettings;
use rcs_scene::{rainbow, Blending, DisplayId, Drawable, Geometry, Material, RibbonElement, Ribbons};
use rcs_transforms::Time;

use crate::framework::display::{Display, TopicRequest};
use crate::framework::world::all_finite;
use crate::parts::robot_description::{link_frame, RobotDescription, StatusTexts};
use crate::parts::solids::{arrow, arrow_pose, drawable, ArrowSize};
use crate::{Level, StatusText, Statuses, World};
use rcs_robot::JointKind;

const STATUS_TEXTS: StatusTexts =
    StatusTexts { good: "Robot model parsed Ok", bad: "Unable to parse robot model description!" };
/// Points of a circle, of 32: a gap shows where it begins.
const CIRCLE_POINTS: u32 = 30;
/// Minimum of a circle's radius (metres) and value.
const SMALLEST: f64 = 0.05;

#[derive(Debug)]
struct ShownJoint {
    frame: String,
    /// Rotation of the circle's z to the joint's axis, as in rviz.
    link_from_circle: UnitQuaternion<f64>,
    /// 0 where the description has none.
    max_effort: f64,
    enabled: bool,
}

#[derive(Debug)]
pub(crate) struct EffortDisplay {
    display: DisplayId,
    settings: EffortSettings,
    description: RobotDescription,
    /// Joints by name; `None` before the description is known.
    joints: Option<BTreeMap<String, ShownJoint>>,
    received: u64,
    /// Drawables of each joint, of the latest messages, the oldest first.
    shown: VecDeque<BTreeMap<String, Vec<Drawable>>>,
    drawables: Vec<Drawable>,
    changed: bool,
    statuses: Statuses,
}

pub(crate) fn create(display: DisplayId, settings: &EffortSettings) -> EffortDisplay {
    let mut statuses = Statuses::default();
    EffortDisplay {
        display,
        description: RobotDescription::new(&settings.robot_description, &mut statuses),
        settings: settings.clone(),
        joints: None,
        received: 0,
        shown: VecDeque::new(),
        drawables: Vec::new(),
        changed: false,
        statuses,
    }
}

impl EffortDisplay {
    fn show(&mut self, message: &JointState, world: &World<'_>) {
        let Some(joints) = &self.joints else { return };
        if message.name.len() != message.effort.len() {
            let text = "Received a joint state msg with different joint names and efforts size!";
            self.statuses.set(Level::Error, Statuses::TOPIC, text);
            return;
        }
        let is_full = self.shown.len() >= self.settings.history_length as usize;
        let mut visual = if is_full { self.shown.pop_front().unwrap_or_default() } else { BTreeMap::new() };
        for (name, &effort) in message.name.iter().zip(&message.effort) {
            let Some(joint) = joints.get(name) else { continue };
            let Ok(fixed_from_link) = world.fixed_from(&joint.frame, Time::ZERO) else {
                let text = format!("Error transforming from frame '{}' to frame '{}'", joint.frame, world.fixed_frame);
                self.statuses.set(Level::Error, name, StatusText::about_frame(text));
                continue;
            };
            let is_finite = all_finite(&[effort]);
            if is_finite {
                self.statuses.set(Level::Ok, name, "");
            } else {
                self.statuses.set(Level::Error, name, format!("Invalid effort: {effort}"));
            }
            if joint.enabled && is_finite {
                let fixed_from_circle = fixed_from_link * joint.link_from_circle;
                visual.insert(name.clone(), circle(self.display, &self.settings, joint, effort, &fixed_from_circle));
            } else {
                visual.remove(name);
            }
        }
        self.shown.push_back(visual);
        self.changed = true;
    }
}

fn circle(
    display: DisplayId,
    settings: &EffortSettings,
    joint: &ShownJoint,
    effort: f64,
    fixed_from_circle: &Isometry3<f64>,
) -> Vec<Drawable> {
    let share = if joint.max_effort == 0.0 { effort.abs() } else { (effort.abs() / joint.max_effort).min(1.0) };
    let value = share + SMALLEST;
    let radius_m = SMALLEST + value * f64::from(settings.scale) * 0.5;
    let color = rainbow(value as f32);
    let side = if effort < 0.0 { -1.0 } else { 1.0 };
    let element = |i: u32| {
        let (sin, cos) = (f64::from(i) * TAU / 32.0).sin_cos();
        let point = fixed_from_circle.rotation * (Vector3::new(side * sin, cos, 0.0) * radius_m);
        RibbonElement { position: point.cast::<f32>().into(), color: color.to_rgba8() }
    };
    let ribbons = Ribbons {
        chains: vec![(0..CIRCLE_POINTS).map(element).collect()],
        width_m: settings.width_m,
        blending: Blending::Replace,
    };
    let fixed_from_middle = Translation3::from(fixed_from_circle.translation.vector).to_homogeneous();
    let mut drawables = vec![drawable(display, fixed_from_middle, Geometry::Ribbons(Arc::new(ribbons)))];
    let direction = if effort > 0.0 { -Vector3::x() } else { Vector3::x() };
    let position = fixed_from_circle * nalgebra::Point3::new(0.0, radius_m, 0.0);
    let width_m = f64::from(settings.width_m);
    let size = ArrowSize {
        shaft_length_m: 0.0,
        shaft_diameter_m: width_m * 2.0,
        head_length_m: width_m * 2.0,
        head_diameter_m: width_m * 4.0,
    };
    let fixed_from_arrow = arrow_pose(position.coords, &(fixed_from_circle.rotation * direction));
    let material = Arc::new(Material::lit(color));
    drawables.extend(arrow(display, &fixed_from_arrow, &size, &material, &material));
    drawables
}

/// Shortest rotation of the axis to z; the identity for an axis along z or of no length.
fn axis_turn(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    let z = Vector3::z();
    Unit::try_new(axis.cross(&z), 0.0)
        .map_or_else(UnitQuaternion::identity, |around| UnitQuaternion::from_axis_angle(&around, axis.angle(&z)))
}

impl Display for EffortDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        TopicRequest::new(&self.settings.topic, MessageKind::JointState, self.settings.queue_size).into_iter().collect()
    }

    fn take(&mut self, message: &AnyMessage, world: &World<'_>) {
        if let AnyMessage::JointState(message) = message {
            self.received += 1;
            self.statuses.set(Level::Ok, Statuses::TOPIC, format!("{} messages received", self.received));
            self.show(message, world);
        }
    }

    fn parameters(&self) -> Vec<String> {
        self.description.parameters()
    }

    fn take_parameter(&mut self, _name: &str, text: Option<&Arc<str>>, _world: &World<'_>) {
        let Some(robot) = self.description.take(text, &STATUS_TEXTS, &mut self.statuses) else { return };
        let revolute = robot.joints.into_iter().filter(|(_, joint)| joint.kind == JointKind::Revolute);
        let shown = revolute.map(|(name, joint)| {
            let shown = ShownJoint {
                frame: link_frame(&self.settings.tf_prefix, &joint.child_link),
                link_from_circle: axis_turn(&joint.axis),
                max_effort: joint.max_effort.unwrap_or_default(),
                enabled: self.settings.joints.get(&name).copied().unwrap_or(true),
            };
            (name, shown)
        });
        self.joints = Some(shown.collect());
    }

    fn update(&mut self, _world: &World<'_>) -> bool {
        let changed = std::mem::take(&mut self.changed);
        if changed {
            self.drawables = self.shown.iter().flat_map(BTreeMap::values).flatten().cloned().collect();
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn reset(&mut self) {
        self.shown.clear();
        self.drawables.clear();
        self.received = 0;
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framework::test_world::TestWorld;

    const ROBOT: &str = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>
        <joint name='j' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 1 0'/>
        <limit effort='10' velocity='1'/></joint>
        <joint name='k' type='continuous'><parent link='b'/><child link='c'/></joint></robot>";

    struct Bench {
        display: EffortDisplay,
        world: TestWorld,
    }

    impl Bench {
        fn new(settings: &EffortSettings) -> Self {
            let mut world = TestWorld::at(Time::ZERO);
            world.place_static("b", [1.0, 2.0, 3.0]);
            Self { display: create(0, settings), world }
        }

        fn describe(&mut self) {
            self.display.take_parameter("robot_description", Some(&ROBOT.into()), &self.world.get());
        }

        /// Sends efforts by the joints' names; returns how many things are shown.
        fn send(&mut self, names: &[&str], efforts: &[f64]) -> usize {
            let name = names.iter().map(|name| (*name).to_owned()).collect();
            let message = JointState { name, effort: efforts.to_vec(), ..JointState::default() };
            self.display.take(&AnyMessage::JointState(Arc::new(message)), &self.world.get());
            self.display.update(&self.world.get());
            self.display.drawables().len()
        }

        fn status(&self, name: &str) -> Option<(Level, &str)> {
            let status = self.display.statuses.iter().find(|(key, _)| *key == name)?.1;
            Some((status.level, &status.text))
        }
    }

    /// A circle, and a shaft and a head of its arrow.
    const ONE: usize = 3;

    #[test]
    fn only_revolute_joints_of_a_known_robot_are_shown() {
        let mut bench = Bench::new(&EffortSettings::default());
        assert_eq!(bench.send(&["j"], &[1.0]), 0, "no robot yet");
        bench.describe();
        assert_eq!(bench.send(&["j", "k", "other"], &[1.0, 1.0, 1.0]), ONE);
        assert_eq!(bench.status("j"), Some((Level::Ok, "")));
        assert_eq!(bench.status("k"), None);
    }

    #[test]
    fn the_oldest_message_is_overwritten_joint_by_joint() {
        let mut bench = Bench::new(&EffortSettings { history_length: 2, ..EffortSettings::default() });
        bench.describe();
        assert_eq!(bench.send(&["j"], &[1.0]), ONE);
        assert_eq!(bench.send(&["j"], &[2.0]), 2 * ONE);
        assert_eq!(bench.send(&[], &[]), 2 * ONE, "the oldest goes on without a change");
        assert_eq!(bench.send(&["j"], &[f64::NAN]), ONE);
        assert_eq!(bench.status("j"), Some((Level::Error, "Invalid effort: NaN")));
    }

    #[test]
    fn bad_efforts_are_reported_and_not_shown() {
        let mut bench = Bench::new(&EffortSettings::default());
        bench.describe();
        assert_eq!(bench.send(&["j", "k"], &[1.0]), 0);
        assert_eq!(bench.status(Statuses::TOPIC).unwrap().0, Level::Error);
        let mut bench = Bench::new(&EffortSettings { tf_prefix: "other".to_owned(), ..EffortSettings::default() });
        bench.describe();
        assert_eq!(bench.send(&["j"], &[1.0]), 0);
        let text = "Error transforming from frame 'other/b' to frame 'map'";
        assert_eq!(bench.status("j"), Some((Level::Error, text)));
        let joints = BTreeMap::from([("j".to_owned(), false)]);
        let mut bench = Bench::new(&EffortSettings { joints, ..EffortSettings::default() });
        bench.describe();
        assert_eq!(bench.send(&["j"], &[1.0]), 0, "switched off");
    }
}
