//! `simulate_scan`: a robot, a projector and a cluttered table that do not exist, for `./demo --calibrate` and to try
//! `projector_calibrate` on.
//!
//! Writes capture folders as a scan leaves them, the projector's true file, and one as a tape measure yields it; and
//! draws onto the camera's image where the light of a projector's file lands. Or is that robot live, on ROS topics.

mod robot;

use std::path::{Path, PathBuf};

use anyhow::{bail, Context, Result};
use clap::{Parser, Subcommand};
use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion, Vector3};
use rcs_calibration::board::Chessboard;
use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::Lens;
use rcs_files::canvas::Canvas;
use rcs_files::capture::{Capture, CapturedRobot, PatternImage};
use rcs_files::image_file;
use rcs_files::projector::ProjectorFile;
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

/// Simulates a scan of a cluttered table by a projector and an RGB-D camera
#[derive(Debug, Parser)]
#[command(name = "simulate_scan")]
struct Arguments {
    /// Everything follows from it: room, projector, camera, light, noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Writes capture_0, capture_1 and so on, truth.yaml and tape.yaml
    Scan {
        /// The folder to write to
        folder: PathBuf,
        /// How many places the camera scans from
        #[arg(long, default_value_t = 1)]
        places: u32,
    },
    /// Is the robot: its projector shows what arrives on /projector/patterns, and its head camera publishes what it
    /// sees of that, on the topics of Fetch's
    Robot {
        /// A folder to write truth.yaml and tape.yaml to
        folder: PathBuf,
        /// Camera and projector have a quarter of the pixels: 320×240 and 640×400
        #[arg(long)]
        small: bool,
        /// A printed chessboard:8x6:45mm is held before a wall, in another pose after each call of
        /// /simulated_robot/next_view
        #[arg(long)]
        board: bool,
    },
    /// Draws where the light of a projector's file lands: green crosses are what is to be lit, orange dots the light
    Light {
        /// The projector's file
        projector: PathBuf,
        /// The PNG file to write
        #[arg(short, long)]
        output: PathBuf,
    },
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    rcs_process::name_threads();
    let (room, rig) = (Room::cluttered(arguments.seed), Rig::random(arguments.seed));
    match &arguments.command {
        Command::Scan { folder, places } => {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
            for place in 0..*places {
                let capture = scan(&room, &rig.at_place(place), arguments.seed);
                capture.write(&folder.join(format!("capture_{place}")))?;
            }
            write_projectors(folder, &rig, arguments.seed)
        }
        Command::Robot { folder, small, board } => {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
            let rig = if *small { robot::small(&rig) } else { rig };
            write_projectors(folder, &rig, arguments.seed)?;
            let rooms = if *board { with_board(&rig) } else { vec![room] };
            let views: Vec<View> = rooms.iter().map(|room| View::new(room, &rig)).collect();
            robot::run(&views, arguments.seed)
        }
        Command::Light { projector, output } => {
            let file = ProjectorFile::read(projector)?;
            let lens = file.lens().context("the projector's lens")?;
            let Some(frame) = file.frames.first() else { bail!("{}: no frames", projector.display()) };
            let translation = Translation3::from(Vector3::from(frame.translation_m));
            let pose = Isometry3::from_parts(translation, frame.rotation).inverse();
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

/// What a scan from this place leaves behind.
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

/// What a careful person with a tape measure finds: 1 % of the focal length, 8 pixels of the principal point, half a
/// centimetre and a third of a degree off, and no distortion.
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
fn write_projectors(folder: &Path, rig: &Rig, seed: u64) -> Result<()> {
    write_projector(&folder.join("truth.yaml"), &rig.projector, &rig.projector_from_camera())?;
    let (lens, pose) = by_tape(rig, seed);
    write_projector(&folder.join("tape.yaml"), &lens, &pose)
}

fn write_projector(path: &Path, lens: &Lens, projector_from_camera: &Isometry3<f64>) -> Result<()> {
    Ok(ProjectorFile::calibrated(lens, CAMERA_FRAME, &projector_from_camera.inverse()).write(path)?)
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
