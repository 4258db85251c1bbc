//! `simulate_scan`: a robot, a projector and a cluttered table that do not exist, for `./demo --calibrate` and to try
//! `projector_calibrate` on.
//!
//! Writes capture folders as a scan leaves them, the projector's true file, and one as a tape measure yields it; and
//! draws onto the camera's picture where the light of a projector's file lands.

use std::path::{Path, PathBuf};

use anyhow::{bail, Context, Result};
use clap::{Parser, Subcommand};
use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion, Vector3};
use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::Lens;
use rcs_files::capture::{Capture, PatternPicture};
use rcs_files::picture_file;
use rcs_files::projector::ProjectorFile;
use rcs_scan_simulator::{Conditions, DepthCamera, Random, Rig, Room, Scan, View};
use rcs_scene::{Encoding, Picture};

const PROJECTOR_PX: [u32; 2] = [1280, 800];
const CAMERA_FRAME: &str = "head_camera_rgb_optical_frame";

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
    let (room, rig) = (Room::cluttered(arguments.seed), Rig::random(arguments.seed));
    match &arguments.command {
        Command::Scan { folder, places } => {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
            for place in 0..*places {
                let capture = scan(&room, &rig.at_place(place), arguments.seed);
                capture.write(&folder.join(format!("capture_{place}")))?;
            }
            let truth = rig.projector_from_camera();
            write_projector(&folder.join("truth.yaml"), &rig.projector, &truth)?;
            let (lens, pose) = by_tape(&rig, arguments.seed);
            write_projector(&folder.join("tape.yaml"), &lens, &pose)
        }
        Command::Light { projector, output } => {
            let file = ProjectorFile::read(projector)?;
            let lens = file.lens().context("the projector's lens")?;
            let Some(frame) = file.frames.first() else { bail!("{}: no frames", projector.display()) };
            let translation = Translation3::from(Vector3::from(frame.translation_m));
            let pose = Isometry3::from_parts(translation, frame.rotation).inverse();
            let picture = light(&View::new(&room, &rig), &lens, &pose, arguments.seed);
            Ok(picture_file::write(output, &picture)?)
        }
    }
}

/// What a scan from this place leaves behind.
fn scan(room: &Room, rig: &Rig, seed: u64) -> Capture {
    let view = View::new(room, rig);
    let patterns = gray_code(PROJECTOR_PX);
    let greys = Scan::new(&view, Conditions::random(seed)).capture_all(&patterns);
    let pictures = patterns.iter().zip(greys).map(|(pattern, grey)| PatternPicture { pattern: *pattern, grey });
    let depth = DepthCamera { frames: 10, ..DepthCamera::kinect(seed) }.capture(&view);
    Capture {
        projector_size_px: PROJECTOR_PX,
        camera: rig.camera,
        camera_frame_id: CAMERA_FRAME.to_owned(),
        pictures: pictures.collect(),
        depth_m: Some(depth.into_iter().map(|depth| f32::from(depth) * 1e-4).collect()),
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

fn write_projector(path: &Path, lens: &Lens, projector_from_camera: &Isometry3<f64>) -> Result<()> {
    Ok(ProjectorFile::calibrated(lens, CAMERA_FRAME, &projector_from_camera.inverse()).write(path)?)
}

/// The camera's picture with crosses on things and dots where light that is meant for them lands.
fn light(view: &View, lens: &Lens, projector_from_camera: &Isometry3<f64>, seed: u64) -> Picture {
    let rig = view.rig();
    let grey = Scan::new(view, Conditions::random(seed)).capture(&Pattern::White, 0);
    let [width, height] = view.size_px();
    let mut canvas = Canvas { width, height, rgb: grey.iter().flat_map(|grey| [grey / 2 + 20; 3]).collect() };
    for v in (20..height - 20).step_by(20) {
        for u in (20..width - 20).step_by(20) {
            let Some(sight) = view.sight(u, v).filter(|sight| sight.lit_by.is_some()) else { continue };
            canvas.cross(Point2::new(f64::from(u), f64::from(v)), [60, 230, 90]);
            let pixel = lens.project(&(projector_from_camera * Point3::from(sight.point.coords)));
            let Some(ray) = pixel.and_then(|pixel| rig.projector.ray(pixel)) else { continue };
            let origin = Point3::from(rig.room_from_projector.translation.vector);
            let Some(hit) = view.room().hit(&origin, &(rig.room_from_projector.rotation * ray)) else { continue };
            if let Some(landed) = rig.camera.project(&rig.room_from_camera.inverse_transform_point(&hit.point)) {
                canvas.line(Point2::new(f64::from(u), f64::from(v)), landed, [255, 150, 40]);
                canvas.dot(landed, [255, 150, 40]);
            }
        }
    }
    canvas.picture()
}

/// A colour picture to draw on.
struct Canvas {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Canvas {
    fn set(&mut self, at: Point2<f64>, color: [u8; 3]) {
        let (x, y) = (at.x.round(), at.y.round());
        if x >= 0.0 && y >= 0.0 && x < f64::from(self.width) && y < f64::from(self.height) {
            let index = 3 * (y as usize * self.width as usize + x as usize);
            self.rgb[index..index + 3].copy_from_slice(&color);
        }
    }

    fn cross(&mut self, at: Point2<f64>, color: [u8; 3]) {
        for step in -3..=3 {
            let step = f64::from(step);
            self.set(Point2::new(at.x + step, at.y), color);
            self.set(Point2::new(at.x, at.y + step), color);
        }
    }

    fn dot(&mut self, at: Point2<f64>, color: [u8; 3]) {
        for y in -1..=1 {
            for x in -1..=1 {
                self.set(Point2::new(at.x + f64::from(x), at.y + f64::from(y)), color);
            }
        }
    }

    fn line(&mut self, from: Point2<f64>, to: Point2<f64>, color: [u8; 3]) {
        let steps = ((to - from).amax().ceil() as u32).min(2000);
        for step in 0..=steps {
            let share = f64::from(step) / f64::from(steps.max(1));
            self.set(from + (to - from) * share, color);
        }
    }

    fn picture(self) -> Picture {
        Picture { width_px: self.width, height_px: self.height, encoding: Encoding::Rgb8, data: self.rgb }
    }
}
