//! `projector_calibrate decode`: from a capture folder to correspondences.

use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::Point2;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{decode, points, Decoded, Images, Sample, ScanProblem};
use rcs_files::capture::{read_patterns, Capture, CAPTURE_FILE};
use rcs_files::correspondences::{write_pixels, write_points, PointColumns};

use super::Failure;

/// Decodes a capture folder: which projector pixel lights which point
///
/// Writes points.csv (u_px, v_px: the projector's pixel, an integer is its centre; x_m, y_m, z_m: the point in the
/// camera's optical frame), and on request the projector's pixel for every decoded pixel of the camera, which needs no
/// depth.
#[derive(Debug, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate decode capture -o points.csv --pixels pixels.csv")]
#[command(after_help = "\
Exit codes: 0 written; 1 refused, nothing written; 2 invalid arguments or unreadable folder")]
pub(super) struct DecodeArguments {
    /// The capture folder, with capture.yaml
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Where to write the points; needs a depth image in the folder
    #[arg(short, long, value_name = "FILE", required_unless_present = "pixels")]
    output: Option<PathBuf>,
    /// Where to write the decoded pixels: cam_u_px, cam_v_px, u_px, v_px
    #[arg(long, value_name = "FILE")]
    pixels: Option<PathBuf>,
    /// Write each point's standard deviations, too (sigma_px, sigma_m), as weights for solve
    #[arg(long)]
    sigmas: bool,
}

/// Runs the command.
pub(super) fn run(arguments: &DecodeArguments) -> Result<(), Failure> {
    let capture = read(&arguments.folder)?;
    let decoded = decode_capture(&arguments.folder, &capture)?;
    let points = arguments.output.as_ref().map(|_| points_of(&arguments.folder, &capture, &decoded)).transpose()?;
    if let Some(path) = &arguments.pixels {
        write_pixels(path, camera_pixels(&decoded)).map_err(Failure::refused)?;
    }
    let mut depths = String::new();
    if let (Some(path), Some(points)) = (&arguments.output, &points) {
        let columns = if arguments.sigmas { PointColumns::WithSigmas } else { PointColumns::Plain };
        write_points(path, points, columns).map_err(Failure::refused)?;
        depths = format!(", {} points with depth", points.len());
    }
    let (count, percent) = (decoded.count(), 100.0 * decoded.share());
    eprintln!("decoded: {count} of {} lit pixels ({percent:.1} %){depths}", decoded.lit);
    Ok(())
}

/// Reads a capture folder and logs its warnings.
pub(super) fn read(folder: &Path) -> Result<Capture, Failure> {
    let capture = Capture::read(folder).map_err(Failure::unreadable)?;
    for warning in &capture.warnings {
        log::warn!("{warning}");
    }
    Ok(capture)
}

/// Decodes a capture; its problems are logged or, if the result would be wrong, refused.
pub(super) fn decode_capture(folder: &Path, capture: &Capture) -> Result<Decoded, Failure> {
    let images = capture.images.iter().map(|image| (image.pattern, image.grey.as_slice()));
    let (patterns, levels): (Vec<Pattern>, Vec<&[u8]>) = images.unzip();
    let images = Images { size_px: capture.image_size_px(), patterns: &patterns, levels };
    let decoded = decode(&images, capture.projector_size_px)
        .map_err(|error| Failure::Unreadable(anyhow::anyhow!("{}: {error}", folder.display())))?;
    for problem in decoded.quality.problems() {
        if problem.is_fatal() {
            return Err(Failure::Refused(anyhow::anyhow!("{}: {}", folder.display(), describe(folder, &problem))));
        }
        log::warn!("{}: {problem}", folder.display());
    }
    if decoded.count() == 0 {
        let reason = "no pixel could be decoded: the camera does not see the projector's light, the stripes are too \
                      fine for it (a larger --step mends that), or the pictures are not in the patterns' order";
        return Err(Failure::Refused(anyhow::anyhow!("{}: {reason}", folder.display())));
    }
    Ok(decoded)
}

/// A problem in words, with the names of the images' files.
fn describe(folder: &Path, problem: &ScanProblem) -> String {
    let ScanProblem::WrongImage(misplaced) = problem else { return problem.to_string() };
    let files = read_patterns(&folder.join(CAPTURE_FILE)).map(|list| list.patterns).unwrap_or_default();
    misplaced.describe(|index| match files.get(index) {
        Some((file, _)) => file.strip_prefix(folder).unwrap_or(file).display().to_string(),
        None => format!("picture {}", index + 1),
    })
}

/// The decoded points of a capture with a depth.
pub(super) fn points_of(folder: &Path, capture: &Capture, decoded: &Decoded) -> Result<Vec<Sample>, Failure> {
    let refused = |reason: &str| Failure::Refused(anyhow::anyhow!("{}: {reason}", folder.display()));
    let depth_m = capture.depth_m.as_ref().ok_or_else(|| {
        refused("there is no depth image, which points need (--pixels FILE writes the decoded pixels without)")
    })?;
    if !capture.is_camera_calibrated {
        return Err(refused("the camera has no CameraInfo, which points need"));
    }
    let samples = points(decoded, depth_m, &capture.camera).map_err(Failure::unreadable)?;
    if samples.is_empty() {
        return Err(refused("no decoded pixel has a usable depth"));
    }
    Ok(samples)
}

/// The decoded pixels of the camera, each with the projector's pixel that lights it.
fn camera_pixels(decoded: &Decoded) -> impl Iterator<Item = ([u32; 2], Point2<f64>)> + '_ {
    let width = decoded.size_px[0];
    (0_u32..)
        .zip(&decoded.pixels)
        .filter(|(_, pixel)| pixel.is_decoded())
        .map(move |(index, pixel)| ([index % width, index / width], Point2::from(pixel.at.map(f64::from))))
}
