//! Where the light of a projector on a moving robot lands, with and without prediction: a simulation without a clock.
//!
//! A base drives at 0.5 m/s and turns at 0.5 rad/s, a turret on it turns at 1 rad/s, both publish 50 transforms a
//! second, and 30 images a second become light 45 ms after their frames were looked up. The light of a point 1.5 m
//! before the lens lands where the projector as it stands then throws it. `--nocapture` prints the table of
//! docs/how-to/turret-and-moving-frames.md.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

use std::sync::Arc;
use std::time::Duration;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rcs_camera::Projection;
use rcs_camera_stream::scene::{self, SceneState};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{geometry_msgs, AnyMessage};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_transforms::{Prediction, Time};

const CONFIG: &str = "
Visualization Manager:
  Global Options: {Fixed Frame: map}
  Displays:
  - {Class: rviz/Axes, Name: hand, Enabled: true, Reference Frame: turret}
  - {Class: rviz/Pose, Name: goal, Enabled: true, Topic: /goal, Shape: Axes}
  - {Class: rviz_camera_stream/CameraPub, Name: projector, Enabled: true, Image Topic: /image,
     Camera Info Topic: /camera_info}
";
const PERIOD_SECS: f64 = 0.02;
/// Between a transform's stamp and its arrival.
const DELAY_SECS: f64 = 0.003;
const IMAGE_SECS: f64 = 1.0 / 30.0;
/// From looking up frames until the image is light.
const WAY: Duration = Duration::from_millis(45);
const DISTANCE_M: f64 = 1.5;

fn time(secs: f64) -> Time {
    Time::from_secs_f64(1000.0 + secs)
}

/// How the robot moves: how far along its way it is after some seconds of simulation, in seconds of steady motion.
type Progress = Box<dyn Fn(f64) -> f64>;

fn steady(secs: f64) -> f64 {
    secs
}

/// Speeds up and slows down as a sine, between standing and twice the speed, with a period of 4 s.
fn swinging(secs: f64) -> f64 {
    let pulse = std::f64::consts::TAU / 4.0;
    secs - (pulse * secs).sin() / pulse
}

fn base(progress: f64) -> Isometry3<f64> {
    let (angle, radius) = (0.5 * progress, 1.0);
    let place = Translation3::new(radius * angle.sin(), radius * (1.0 - angle.cos()), 0.0);
    Isometry3::from_parts(place, UnitQuaternion::from_scaled_axis(Vector3::z() * angle))
}

fn turret(progress: f64) -> Isometry3<f64> {
    let place = Translation3::new(0.1, 0.0, 1.0);
    Isometry3::from_parts(place, UnitQuaternion::from_scaled_axis(Vector3::z() * progress))
}

/// The optical frame: z forward, x right, y down, a little before the turret's axis.
fn turret_from_optical() -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_euler_angles(-std::f64::consts::FRAC_PI_2, 0.0, -std::f64::consts::FRAC_PI_2);
    Isometry3::from_parts(Translation3::new(0.05, 0.0, 0.1), rotation)
}

/// A small generator of noise between −1 and 1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next())
    }
}

struct Simulation {
    stage: SceneState,
    progress: Progress,
    /// Of each coordinate, metres and radians.
    noise_m: f64,
    noise: Noise,
}

impl Simulation {
    fn new(progress: impl Fn(f64) -> f64 + 'static, noise_m: f64) -> Self {
        let config = rcs_rviz_config::parse(CONFIG, "simulation").unwrap();
        let mut stage = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])));
        let mut info = CameraInfo { width: 1280, height: 800, ..CameraInfo::default() };
        info.P = [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 400.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        info.header.frame_id = "lens".to_owned();
        stage.take("/camera_info", &AnyMessage::CameraInfo(Arc::new(info)), time(0.0));
        let progress = Box::new(progress);
        let mut simulation = Self { stage, progress, noise_m, noise: Noise(1) };
        simulation.send("turret", "lens", 0.0, &turret_from_optical(), true);
        simulation.send("map", "odom", 0.0, &Isometry3::identity(), true);
        simulation
    }

    fn send(&mut self, parent: &str, child: &str, secs: f64, pose: &Isometry3<f64>, is_static: bool) {
        let mut transform = geometry_msgs::TransformStamped::default();
        let (sec, nsec) = time(secs).as_secs_nanos();
        transform.header.stamp = rcs_messages::Time { sec, nsec };
        (transform.header.frame_id, transform.child_frame_id) = (parent.to_owned(), child.to_owned());
        let (place, turn) = (&mut transform.transform.translation, &mut transform.transform.rotation);
        [place.x, place.y, place.z] = pose.translation.vector.into();
        [turn.x, turn.y, turn.z, turn.w] = pose.rotation.coords.into();
        self.stage.take_transforms(&TFMessage { transforms: vec![transform] }, is_static, "/simulation");
    }

    /// The transforms of a moment, measured with noise.
    fn measure(&mut self, parent: &str, child: &str, secs: f64, pose: Isometry3<f64>) {
        let (shift, turn) = (self.noise.vector() * self.noise_m, self.noise.vector() * self.noise_m);
        let noise = Isometry3::from_parts(Translation3::from(shift), UnitQuaternion::from_scaled_axis(turn));
        self.send(parent, child, secs, &(pose * noise), false);
    }

    fn map_from_turret(&self, secs: f64) -> Isometry3<f64> {
        let progress = (self.progress)(secs);
        base(progress) * turret(progress)
    }

    /// Sends what arrives until then, from the newest transforms sent before. Those of the turret are stamped 7 ms
    /// later.
    fn send_until(&mut self, secs: f64, sent: &mut [u32; 2]) {
        for (link, offset_secs) in [(0, 0.0), (1, 0.007)] {
            loop {
                let stamp = f64::from(sent[link]) * PERIOD_SECS + offset_secs;
                if stamp + DELAY_SECS > secs {
                    break;
                }
                let progress = (self.progress)(stamp);
                match link {
                    0 => self.measure("odom", "base", stamp, base(progress)),
                    _ => self.measure("base", "turret", stamp, turret(progress)),
                }
                sent[link] += 1;
            }
        }
    }

    /// How far each image's light lands from the point that it is for, with the time when it is light.
    fn errors(mut self, is_predicted: bool) -> Vec<(f64, f64)> {
        let mut sent = [0, 0];
        let mut errors = Vec::new();
        for image in 10..120 {
            let now = f64::from(image) * IMAGE_SECS;
            self.send_until(now, &mut sent);
            let prediction = Prediction { now: time(now), lead: WAY, limit: Duration::from_millis(100) };
            self.stage.predict(is_predicted.then_some(prediction));
            self.stage.update(time(now));
            let camera = scene::camera(&self.stage, &self.stage.cameras()[0], Projection::Exact).unwrap();

            let light_secs = now + WAY.as_secs_f64();
            let map_from_optical = self.map_from_turret(light_secs) * turret_from_optical();
            let point = map_from_optical * Point3::new(0.1, -0.05, DISTANCE_M);
            // What the image has at the point's pixel leaves the lens into that direction of where it is then.
            let view_from_optical = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            let in_drawn_view = camera.fixed_from_view().inverse() * point;
            let direction = map_from_optical.rotation * view_from_optical * in_drawn_view.coords.normalize();
            let to_point = point.coords - map_from_optical.translation.vector;
            errors.push((light_secs, to_point.cross(&direction).norm()));
        }
        errors
    }
}

/// The mean and the largest error in millimetres, without and with prediction.
fn compare(title: &str, progress: fn(f64) -> f64, noise_m: f64) -> [[f64; 2]; 2] {
    let figures = [false, true].map(|is_predicted| {
        let errors: Vec<f64> =
            Simulation::new(progress, noise_m).errors(is_predicted).iter().map(|(_, error)| error * 1e3).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        [mean, errors.iter().copied().fold(0.0, f64::max)]
    });
    let [without, with] = figures;
    println!("| {title} | {:.1} / {:.1} | {:.1} / {:.1} |", without[0], without[1], with[0], with[1]);
    figures
}

#[test]
fn light_of_a_constant_velocity_lands_where_it_should() {
    let [without, with] = compare("constant velocity", steady, 0.0);
    assert!(with[1] < 5.0, "at most {} mm", with[1]);
    assert!(without[0] > 5.0 * with[0] && without[1] > 5.0 * with[1], "{without:?} without, {with:?} with prediction");
}

#[test]
fn prediction_helps_with_noise_and_changing_speeds_as_well() {
    let [without, with] = compare("constant velocity, each coordinate ± 1 mm and ± 1 mrad", steady, 0.001);
    assert!(without[0] > 5.0 * with[0], "{without:?} without, {with:?} with prediction");
    let [without, with] = compare("speed as a sine from 0 to double, 4 s a period", swinging, 0.0);
    assert!(without[0] > 5.0 * with[0], "{without:?} without, {with:?} with prediction");
}

#[test]
fn light_overshoots_a_sudden_stop_once_and_is_back_with_the_first_transforms() {
    let (mut largest_mm, mut longest_ms) = (0.0, 0.0);
    // At all phases of transforms and images.
    for phase in 0..100 {
        let stop_secs = 1.0 + f64::from(phase) * 0.001;
        let errors = Simulation::new(move |secs| secs.min(stop_secs), 0.0).errors(true);
        for (secs, error) in errors.iter().filter(|(secs, _)| *secs > stop_secs) {
            largest_mm = f64::max(largest_mm, error * 1e3);
            if *error > 0.001 {
                longest_ms = f64::max(longest_ms, (secs - stop_secs) * 1e3);
            }
        }
    }
    println!(
        "| a sudden stop | 0 beyond it | {largest_mm:.0} beyond it, in pictures until {longest_ms:.0} ms after it |"
    );
    // The light goes on at its speed of 2.7 m/s for what the lead and the age of the transforms take.
    let (way_ms, age_ms) = (WAY.as_secs_f64() * 1e3, (PERIOD_SECS + DELAY_SECS) * 1e3);
    assert!(largest_mm < 2.75 * (way_ms + age_ms), "{largest_mm} mm");
    // The last wrong image was begun just before the first transforms that stand still arrived.
    assert!(longest_ms < way_ms + age_ms + PERIOD_SECS * 1e3, "{longest_ms} ms");
}

#[test]
fn what_follows_a_frame_is_predicted_and_what_a_message_placed_is_not() {
    let now = time(1.0);
    let shown = |prediction: Option<Prediction>| {
        let mut simulation = Simulation::new(steady, 0.0);
        simulation.send_until(1.0, &mut [0, 0]);
        let mut goal = geometry_msgs::PoseStamped::default();
        let (sec, nsec) = time(0.9).as_secs_nanos();
        goal.header.stamp = rcs_messages::Time { sec, nsec };
        goal.header.frame_id = "turret".to_owned();
        goal.pose.orientation.w = 1.0;
        simulation.stage.take("/goal", &AnyMessage::PoseStamped(Arc::new(goal)), now);
        simulation.stage.predict(prediction);
        simulation.stage.update(now);
        let drawables = simulation.stage.scene().drawables;
        let (hand, goal): (Vec<_>, Vec<_>) = drawables.into_iter().partition(|drawable| drawable.display == 0);
        assert!(hand.len() == 3 && goal.len() == 1, "{hand:?} {goal:?}");
        // The middle of the axis z, one metre long, and all of the goal.
        let turret_from_hand = simulation.map_from_turret(1.045).inverse() * hand[2].sort_point;
        (turret_from_hand.coords - Vector3::z() * 0.5, format!("{goal:?}"))
    };
    let (hand, goal) = shown(Some(Prediction { now, lead: WAY, limit: Duration::from_millis(100) }));
    let (hand_without, goal_without) = shown(None);
    assert!(hand.norm() < 0.001 && hand_without.norm() > 0.02, "{hand} {hand_without}");
    assert_eq!(goal, goal_without);
}
