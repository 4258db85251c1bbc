//! `simulate_scan`: a projector, a depth camera and things to light that do not exist, to rehearse a calibration.
//!
//! Writes capture folders as a scan leaves them, the projector's true file, and one as a tape measure yields it; and
//! draws onto the camera's image where the light of a projector's file lands. Or is camera and projector live, on ROS
//! topics.

mod live;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{bail, Context, Result};
use clap::{CommandFactory, Parser, Subcommand, ValueEnum};
use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion, Vector3};
use rcs_calibration::board::Chessboard;
use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::Lens;
use rcs_files::canvas::Canvas;
use rcs_files::capture::{Capture, CapturedRobot, PatternImage};
use rcs_files::image_file;
use rcs_files::projector::ProjectorFile;
use rcs_node_support::lifecycle;
use rcs_node_support::ros_names::{publishes, serves, subscribes, RosName};
use rcs_scan_simulator::{Conditions, DepthCamera, Random, Rig, Room, Scan, View};
use rcs_scene::Image;

const PROJECTOR_PX: [u32; 2] = [1280, 800];
const CAMERA_FRAME: &str = "head_camera_rgb_optical_frame";
const BOARD: Chessboard = Chessboard { corners: [8, 6], square_m: 0.045 };
/// Tilts of the board about x and y, radians; and places right of and below the middle, and depths, metres.
const BOARD_POSES: [([f64; 2], [f64; 3]); 5] = [
    ([0.1, 0.1], [0.0, 0.0, 1.2]),
    ([0.0, 0.5], [-0.16, -0.09, 1.1]),
    ([-0.1, -0.5], [0.16, 0.09, 1.15]),
    ([0.5, 0.0], [0.18, -0.1, 1.4]),
    ([-0.5, 0.1], [-0.18, 0.1, 1.3]),
];

/// Topics and services of the subcommand `robot`.
pub const ROS_NAMES: &[RosName] = &[
    publishes("CAMERA/rgb/image_raw", "sensor_msgs/Image", "the camera's image; with CAMERA/rgb/camera_info"),
    publishes("CAMERA/depth_registered/image_raw", "sensor_msgs/Image", "its depth"),
    subscribes("/projector/patterns", "sensor_msgs/Image", "the projector's image; not with --screen"),
    serves("~next_view", "std_srvs/Trigger", "holds the board in its next pose"),
];

/// Simulates a projector, a depth camera, and things to calibrate them on
#[derive(Debug, Parser)]
#[command(
    name = "simulate_scan",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  simulate_scan --seed 1 robot rehearsal --scene table --screen auto
  simulate_scan scan captures --places 5"
)]
struct Arguments {
    /// Everything follows from it: room, projector, camera, light, noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(subcommand)]
    command: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Writes capture_0, capture_1 and so on, truth.yaml and tape.yaml
    #[command(before_help = "Examples:\n  simulate_scan scan captures --places 5")]
    Scan {
        /// The folder to write to
        folder: PathBuf,
        /// How many places the camera scans from
        #[arg(long, default_value_t = 1)]
        places: u32,
    },
    /// Is a depth camera and a projector: publishes what the camera sees of the projector's light
    #[command(before_help = "\
Examples:
  simulate_scan --seed 1 robot rehearsal --scene table --screen auto
  simulate_scan robot rehearsal --camera camera")]
    Robot {
        /// A folder to write truth.yaml and tape.yaml to
        folder: PathBuf,
        /// Scene before the projector
        #[arg(long, value_enum, default_value = "room")]
        scene: Scene,
        /// The camera's name: before its topics and its frame, CAMERA_rgb_optical_frame
        #[arg(long, value_name = "CAMERA", default_value = "head_camera")]
        camera: String,
        /// The projector shows what this monitor shows, by name or number, or auto; else /projector/patterns
        #[arg(long, value_name = "MONITOR")]
        screen: Option<String>,
        /// Camera and projector have a quarter of the pixels: 320×240 and 640×400
        #[arg(long)]
        small: bool,
    },
    /// Draws where the light of a projector's file lands: green crosses are what is to be lit, orange dots the light
    #[command(before_help = "Examples:\n  simulate_scan light projector.yaml -o light.png")]
    Light {
        /// The projector's file
        projector: PathBuf,
        /// The PNG file to write
        #[arg(short, long)]
        output: PathBuf,
    },
}

/// Scene before the projector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Scene {
    /// A cluttered room.
    Room,
    /// A table with boxes, seen from above at a slope.
    Table,
    /// A printed chessboard:8x6:45mm before a wall, in another pose after each call of ~next_view.
    Board,
}

impl Scene {
    /// The rooms, which the service `~next_view` goes through.
    fn rooms(self, seed: u64, rig: &Rig) -> Vec<Room> {
        match self {
            Self::Room => vec![Room::cluttered(seed)],
            Self::Table => vec![Room::table(seed)],
            Self::Board => with_board(rig),
        }
    }
}

/// The command line.
pub fn command() -> clap::Command {
    Arguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    rcs_process::name_threads();
    lifecycle::run_main(|arguments: Arguments| run(&arguments))
}

fn run(arguments: &Arguments) -> Result<()> {
    let (room, rig) = (Room::cluttered(arguments.seed), Rig::random(arguments.seed));
    match &arguments.command {
        Task::Scan { folder, places } => {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
            for place in 0..*places {
                let capture = scan(&room, &rig.at_place(place), arguments.seed);
                capture.write(&folder.join(format!("capture_{place}")))?;
            }
            write_projectors(folder, &rig, arguments.seed, CAMERA_FRAME)
        }
        Task::Robot { folder, scene, camera, screen, small } => {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
            let rig = if *small { live::small(&rig) } else { rig };
            write_projectors(folder, &rig, arguments.seed, &live::camera_frame(camera))?;
            let views: Vec<View> = scene.rooms(arguments.seed, &rig).iter().map(|room| View::new(room, &rig)).collect();
            live::run(&views, arguments.seed, camera, screen.as_deref())
        }
        Task::Light { projector, output } => {
            let file = ProjectorFile::read(projector)?;
            let lens = file.lens().context("the projector's lens")?;
            let Some(frame) = file.frames.first() else { bail!("{}: no frames", projector.display()) };
            let pose = frame.parent_from_child().inverse();
            let image = light(&View::new(&room, &rig), &lens, &pose, arguments.seed);
            Ok(image_file::write(output, &image)?)
        }
    }
}

/// A room for each of [`BOARD_POSES`].
fn with_board(rig: &Rig) -> Vec<Room> {
    let room = |([about_x, about_y], [right_m, down_m, depth_m]): ([f64; 2], [f64; 3])| {
        let place = rig.target.coords * (depth_m / rig.target.z) + Vector3::new(right_m, down_m, 0.0);
        Room::wall(1.9, [0.1, 0.1]).with_board(BOARD, &Isometry3::new(place, Vector3::new(about_x, about_y, 0.05)))
    };
    BOARD_POSES.into_iter().map(room).collect()
}

/// Capture of a scan from this place.
fn scan(room: &Room, rig: &Rig, seed: u64) -> Capture {
    let view = View::new(room, rig);
    let patterns = gray_code(PROJECTOR_PX);
    let greys = Scan::new(&view, Conditions::random(seed)).capture_all(&patterns);
    let images = patterns.iter().zip(greys).map(|(pattern, grey)| PatternImage { pattern: *pattern, grey });
    Capture {
        projector_size_px: PROJECTOR_PX,
        camera: rig.camera,
        is_camera_calibrated: true,
        camera_frame_id: CAMERA_FRAME.to_owned(),
        images: images.collect(),
        depth_m: Some(DepthCamera { frames: 10, ..DepthCamera::kinect(seed) }.capture(&view)),
        robot: CapturedRobot::default(),
        warnings: Vec::new(),
    }
}

/// Lens and pose as a careful person measures them with a tape: 1 % of the focal length, 8 pixels of the principal
/// point, half a centimetre and a third of a degree off, and no distortion.
fn by_tape(rig: &Rig, seed: u64) -> (Lens, Isometry3<f64>) {
    let random = &mut Random::new(&[seed, 0x5441_5045]);
    let mut error = |size: f64| if random.happens(0.5) { size } else { -size };
    let truth = &rig.projector;
    let focal = truth.focal_px * (1.0 + error(0.01));
    let center = [truth.center_px.x + error(8.0), truth.center_px.y + error(8.0)];
    let lens = Lens::pinhole(truth.size_px, [focal.x, focal.y], center);
    let moved = Translation3::new(error(0.005), error(0.005), error(0.005));
    let turned = UnitQuaternion::from_euler_angles(error(0.006), error(0.006), error(0.006));
    (lens, Isometry3::from_parts(moved, turned) * rig.projector_from_camera())
}

/// Writes truth.yaml and tape.yaml.
fn write_projectors(folder: &Path, rig: &Rig, seed: u64, camera_frame: &str) -> Result<()> {
    let truth = (rig.projector, rig.projector_from_camera());
    for (name, (lens, projector_from_camera)) in [("truth.yaml", truth), ("tape.yaml", by_tape(rig, seed))] {
        let file = ProjectorFile::calibrated(&lens, camera_frame, &projector_from_camera.inverse());
        file.write(&folder.join(name))?;
    }
    Ok(())
}

/// The camera's image with crosses on things and dots where light that is meant for them lands.
fn light(view: &View, lens: &Lens, projector_from_camera: &Isometry3<f64>, seed: u64) -> Image {
    let rig = view.rig();
    let grey = Scan::new(view, Conditions::random(seed)).capture(&Pattern::White, 0);
    let [width, height] = view.size_px();
    let mut canvas = Canvas::from_grey([width, height], grey.iter().map(|grey| grey / 2 + 20));
    for v in (20..height - 20).step_by(20) {
        for u in (20..width - 20).step_by(20) {
            let Some(sight) = view.sight(u, v).filter(|sight| sight.lit_by.is_some()) else { continue };
            let aim = Point2::new(f64::from(u), f64::from(v));
            canvas.cross(aim, [60, 230, 90]);
            let pixel = lens.project(&(projector_from_camera * Point3::from(sight.point.coords)));
            let Some(ray) = pixel.and_then(|pixel| rig.projector.ray(pixel)) else { continue };
            let origin = Point3::from(rig.room_from_projector.translation.vector);
            let Some(hit) = view.room().hit(&origin, &(rig.room_from_projector.rotation * ray)) else { continue };
            if let Some(landed) = rig.camera.project(&rig.room_from_camera.inverse_transform_point(&hit.point)) {
                canvas.line(aim, landed, [255, 150, 40]);
                canvas.dot(landed, [255, 150, 40]);
            }
        }
    }
    canvas.into_image()
}
