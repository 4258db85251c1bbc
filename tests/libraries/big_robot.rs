//! A full-size robot on the CPU renderer: how long it takes to load, and an image of it while its joints move.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;
use std::time::{Duration, Instant};

use rcs_camera::Projection;
use rcs_camera_stream::scene::{self, SceneState};
use rcs_messages::geometry_msgs::{Quaternion, Transform, TransformStamped, Vector3};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_msgs::Header;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::AnyMessage;
use rcs_render::{CpuRenderer, Renderer, View};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_scene::{Encoding, Image};
use rcs_tests::big_robot::{self, BigJoint};
use rcs_transforms::Time;

const CONFIG: &str = "
Visualization Manager:
  Global Options: {Fixed Frame: base}
  Displays:
  - {Class: rviz/RobotModel, Name: robot, Enabled: true, Robot Description: robot_description}
  - {Class: rviz_camera_stream/CameraPub, Name: eye, Enabled: true, Image Topic: /image, Camera Info Topic: /info}
  Views: {Current: {Class: rviz/Orbit, Yaw: 0.5, Pitch: 0.4}}
";
/// From the joints' first message to the last, at 60 Hz.
const FRAMES: u32 = 60;

struct Bench {
    stage: SceneState,
    renderer: CpuRenderer,
    image: Image,
    joints: Vec<BigJoint>,
}

fn time(frame: u32) -> rcs_messages::Time {
    let nanos = u64::from(frame) * 1_000_000_000 / 60;
    rcs_messages::Time { sec: 100 + (nanos / 1_000_000_000) as u32, nsec: (nanos % 1_000_000_000) as u32 }
}

fn stamped(frame: u32, parent: &str, child: &str, xyz: [f64; 3], xyzw: [f64; 4]) -> TransformStamped {
    let header = Header { stamp: time(frame), frame_id: parent.to_owned(), ..Header::default() };
    let ([x, y, z], [qx, qy, qz, qw]) = (xyz, xyzw);
    let transform = Transform { translation: Vector3 { x, y, z }, rotation: Quaternion { x: qx, y: qy, z: qz, w: qw } };
    TransformStamped { header, child_frame_id: child.to_owned(), transform }
}

impl Bench {
    /// Loads the robot. Returns how long that took, its first image included, as well.
    fn load(folder: &Path, joints: Vec<BigJoint>) -> (Self, Duration) {
        let description = std::fs::read_to_string(folder.join("big_robot/robot.urdf")).unwrap();
        let config = rcs_rviz_config::parse(CONFIG, "big.rviz").unwrap();
        let begin = Instant::now();
        let stage = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([folder.to_owned()])));
        let mut bench = Self { stage, renderer: CpuRenderer::with_threads(2), image: Image::default(), joints };
        let mut info = CameraInfo { width: 1280, height: 800, ..CameraInfo::default() };
        info.header.frame_id = "eye".to_owned();
        info.P = [1000.0, 0.0, 640.0, 0.0, 0.0, 1000.0, 400.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        bench.stage.take("/info", &AnyMessage::CameraInfo(info.into()), Time::ZERO);
        bench.stage.take_parameter("robot_description", Some(&description.as_str().into()), Time::ZERO);
        // Before the robot, at half its height, looking at it.
        let eye = stamped(0, "base", "eye", [1.8, 0.0, 0.6], [-0.5, -0.5, 0.5, 0.5]);
        bench.stage.take_transforms(&TFMessage { transforms: vec![eye] }, true, "test");
        bench.draw(0);
        let took = begin.elapsed();
        (bench, took)
    }

    /// Takes a message with all joints and draws the robot.
    fn draw(&mut self, frame: u32) {
        let turn = 0.5 * (f64::from(frame) * 0.1).sin();
        let (sin, cos) = (turn / 2.0).sin_cos();
        let transform =
            |joint: &BigJoint| stamped(frame, &joint.parent, &joint.child, joint.origin_m, [0.0, 0.0, sin, cos]);
        let message = TFMessage { transforms: self.joints.iter().map(transform).collect() };
        self.stage.take_transforms(&message, false, "test");
        let now = time(frame);
        let now = Time::from_secs_nanos(now.sec, now.nsec);
        assert!(self.stage.update(now), "frame {frame}: nothing moved");
        let scene = self.stage.scene();
        let camera = self.stage.cameras()[0].clone();
        let eye = scene::camera(&self.stage, &camera, Projection::Rviz).unwrap();
        let view = View {
            scene: &scene,
            camera: &eye,
            visible: &camera.visible,
            background: [0; 3],
            encoding: Encoding::default(),
        };
        self.renderer.render(&view, &mut self.image).unwrap();
    }

    /// The share of the image that is not background.
    fn covered(&self) -> f64 {
        let pixels = self.image.data.chunks_exact(3);
        let count = pixels.len() as f64;
        pixels.filter(|pixel| pixel.iter().any(|level| *level > 0)).count() as f64 / count
    }
}

#[test]
fn a_full_size_robot_loads_and_moves() {
    let folder = tempfile::tempdir().unwrap();
    let joints = big_robot::write(folder.path()).unwrap();
    assert_eq!(joints.len(), 24);
    let (mut bench, load_time) = Bench::load(folder.path(), joints);
    let faults: Vec<String> = bench
        .stage
        .reports()
        .flat_map(|report| {
            let faults = report.statuses.iter().filter(|(_, status)| status.level > rcs_displays::Level::Ok);
            faults.map(|(name, status)| format!("{name}: {}", status.text)).collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(faults, [""; 0]);
    let first = bench.image.data.clone();
    assert!(bench.covered() > 0.1, "{}", bench.covered());
    let mut times: Vec<Duration> = (1..=FRAMES)
        .map(|frame| {
            let begin = Instant::now();
            bench.draw(frame);
            begin.elapsed()
        })
        .collect();
    times.sort();
    println!(
        "loaded and drawn once in {load_time:.0?}; then a message and its picture in {:.1?} (fastest), {:.1?} (median)",
        times[0],
        times[times.len() / 2]
    );
    assert_ne!(bench.image.data, first, "the robot moved");
}
