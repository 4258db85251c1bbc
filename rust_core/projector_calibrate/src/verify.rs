//! `projector_calibrate verify`: the reprojection error of a projector's file, on the surface that the camera sees now
//! or on the points of a scan.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::anyhow;
use clap::Args;
use nalgebra::Isometry3;
use rcs_calibration::{ErrorStatistics, ReprojectionError};
use rcs_files::image_file::{self, ImageFormat};
use rcs_files::projector::ProjectorFile;
use rcs_files::verification;
use rcs_scan::{ScanCamera, ScanEvent, ScanOptions, ScanSession, Verification};

use super::arguments::{check_output, seconds};
use super::camera_chain::CameraChain;
use super::correspondences::Correspondences;
use super::known_projector::KnownProjector;
use super::live::{DeviceArguments, LiveSession, LiveSetup, Progress};
use super::placing::{frame_in_file, pose_in_file, projector_from_parent, read_projector};
use super::Failure;

/// Measures the reprojection error of a calibrated projector
///
/// Lights spots, and outlines along depth edges, on the surface that the camera sees now, and finds their light in the
/// camera's images. Afterwards both stay shown for a while. Given files of points or capture folders beside
/// --projector, compares with these instead and shows nothing.
#[derive(Debug, Clone, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate verify projector.yaml --limit 2 --monitor HDMI-1
  projector_calibrate verify capture --projector projector.yaml --limit 2")]
#[command(after_help = "\
Topics subscribed to: --image (sensor_msgs/Image: mono8, rgb8, bgr8, rgba8, bgra8), --camera-info, and --depth (16UC1 \
in millimetres, 32FC1 in metres) or --cloud; the defaults are those of Fetch's head camera. /tf, if the file places \
the projector in another frame than the camera's
Exit codes: 0 within the limit; 1 beyond it, or too little light was found; 2 invalid arguments, unreadable files, or \
a topic that is silent or cannot be used")]
pub(super) struct VerifyArguments {
    /// The projector's file; with --projector, files of points or capture folders to compare it with
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// The projector's file
    #[arg(long, value_name = "FILE")]
    projector: Option<PathBuf>,
    /// The limit of the RMS error, pixels of the projector
    #[arg(long, value_name = "PIXELS", default_value_t = 2.0)]
    limit: f64,
    /// The devices.
    #[command(flatten)]
    devices: DeviceArguments,
    /// Publish the images on this topic, for a projector_window elsewhere, and open no window
    #[arg(long, value_name = "TOPIC", conflicts_with = "monitor")]
    show_on: Option<String>,
    /// Time to show spots and outlines afterwards; Ctrl-C, or Escape in the window, ends it
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    hold: Duration,
    /// Write all errors as YAML
    #[arg(long, value_name = "FILE.yaml")]
    report: Option<PathBuf>,
    /// Write the camera's image with arrows from the expected to the measured positions
    #[arg(long = "picture", value_name = "FILE.png")]
    arrows: Option<PathBuf>,
}

/// Runs the command.
pub(super) fn run(arguments: &VerifyArguments) -> Result<(), Failure> {
    let limit = arguments.limit;
    if !limit.is_finite() || limit <= 0.0 {
        return Err(Failure::Unreadable(anyhow!("--limit {limit} is not a positive number")));
    }
    match (&arguments.projector, &*arguments.files) {
        (Some(projector), []) | (None, [projector]) => verify_live(arguments, projector),
        (Some(projector), files) => {
            if arguments.report.is_some() || arguments.arrows.is_some() {
                let reason = "--report and --picture are of a live verification: give no files of points";
                return Err(Failure::Unreadable(anyhow!(reason)));
            }
            verify_points(files, projector, limit)
        }
        (None, _) => Err(Failure::Unreadable(anyhow!("which projector? Give its file, alone or as --projector"))),
    }
}

/// Compares a projector's file with the points of a scan: which pixel lights each of them, and which should.
fn verify_points(points: &[PathBuf], projector: &Path, limit: f64) -> Result<(), Failure> {
    let (file, lens) = read_projector(projector)?;
    let points = Correspondences::read(points)?;
    let pose = pose_in_file(&file, points.camera_frame.as_deref()).or_else(|| pose_by_chain(&file, &points));
    let pose = pose.ok_or_else(|| {
        let camera = points.camera_frame.as_deref().unwrap_or("the camera's optical frame");
        Failure::Unreadable(anyhow!(
            "{}: does not place {} in {camera} or in a frame of the scan's chain: solve or refine with \
             --in-camera-frame writes such a file",
            projector.display(),
            file.camera_info.header.frame_id
        ))
    })?;
    let error = ReprojectionError::measure(&points.samples, &lens, &pose);
    println!(
        "reprojection error: {:.2} px ({:.2} mm) RMS, median {:.2} px, 99th percentile {:.1} px; {} points",
        error.rms_px,
        1000.0 * error.rms_m,
        error.median_px,
        error.max_px,
        error.count
    );
    if error.count == 0 {
        return Err(Failure::Refused(anyhow!("no point is in front of the projector")));
    }
    judge(error.rms_px, limit)
}

/// `projector_from_camera` by a projector's file with a pose in a frame of the scan's chain.
fn pose_by_chain(file: &ProjectorFile, points: &Correspondences) -> Option<Isometry3<f64>> {
    let chain = CameraChain::new(&points.robot, points.camera_frame.as_deref()?)?;
    let frame = frame_in_file(file, None)?;
    Some(projector_from_parent(frame) * chain.parent_from_camera(&frame.parent).ok()?)
}

/// Measures on the surface that the camera sees now, reports and judges.
fn verify_live(arguments: &VerifyArguments, path: &Path) -> Result<(), Failure> {
    if let Some(image) = &arguments.arrows {
        ImageFormat::of(image).map_err(Failure::unreadable)?;
    }
    [&arguments.arrows, &arguments.report].into_iter().flatten().try_for_each(|path| check_output(path))?;
    let projector = KnownProjector::read(path)?;
    let setup = LiveSetup {
        name: "the verification",
        monitor: arguments.devices.monitor.clone(),
        topics: arguments.devices.camera.topics(),
        show_on: arguments.show_on.clone(),
        projector_px: projector.lens.size_px,
        needs_lens: true,
        projector_frame: projector.child().to_owned(),
    };
    let arguments = arguments.clone();
    setup.run(move |session| {
        session.camera.follow_robot().map_err(Failure::unreadable)?;
        let verification = measure(session, usize::from(arguments.devices.camera.frames), &projector)?;
        session.check_valid()?;
        let judged = report(&arguments, &projector.path, &verification);
        if !arguments.hold.is_zero() {
            log::info!("spots and outlines are shown for {:.0} s, or until Ctrl-C", arguments.hold.as_secs_f64());
        }
        session.end.wait_for(arguments.hold);
        judged
    })
}

/// Verifies a projector with the devices of a session.
fn measure(session: &mut LiveSession<'_>, frames: usize, projector: &KnownProjector) -> Result<Verification, Failure> {
    let (end, projector_px) = (session.end, projector.lens.size_px);
    let pose = session.camera.place(projector)?.projector_from_camera();
    let options = ScanOptions { projector_px, step: 1, frames, is_cancelled: &|| end.is_requested() };
    let camera_px = session.camera.lens().size_px;
    let mut progress = Progress::new("looking for the projector's light", None, camera_px, projector_px);
    let mut observe = |event: ScanEvent<'_>| progress.show(&event);
    let verified = ScanSession::new(&mut *session.screen, &mut session.camera, &options, &mut observe)
        .verify(&projector.lens, &pose);
    progress.finish();
    Ok(verified?)
}

/// Prints and writes the errors, and judges them.
fn report(arguments: &VerifyArguments, projector: &Path, verification: &Verification) -> Result<(), Failure> {
    let (limit, result) = (arguments.limit, &verification.result);
    println!("{}", line("light", &result.all()));
    for (name, errors, shown) in
        [("spots", &result.spots, result.spots_shown), ("edges", &result.edges, result.edges_shown)]
    {
        let statistics = ErrorStatistics::of(errors);
        if statistics.count > 0 {
            println!("  {}; {} of {shown} seen", line(name, &statistics), statistics.count);
        } else {
            println!("  {name}: none of {shown} seen");
        }
    }
    if let Some(path) = &arguments.report {
        let projector = projector.display().to_string();
        verification::write(path, &projector, limit, result).map_err(Failure::refused)?;
    }
    if let Some(path) = &arguments.arrows {
        let (image, factor) = verification::image(&verification.white, verification.camera_px, result);
        image_file::write(path, &image).map_err(Failure::refused)?;
        log::info!("{}: arrows are {factor:.0} times as long as the errors", path.display());
    }
    judge(result.all().rms[0], limit)
}

/// The statistics in a line.
fn line(name: &str, statistics: &ErrorStatistics) -> String {
    let both = |[px, m]: [f64; 2]| format!("{px:.2} px ({:.2} mm)", 1000.0 * m);
    let ErrorStatistics { median, rms, worst, .. } = statistics;
    format!("{name}: {} RMS error, median {}, worst {}", both(*rms), both(*median), both(*worst))
}

/// Compares an RMS error with the limit.
fn judge(rms_px: f64, limit: f64) -> Result<(), Failure> {
    if rms_px > limit {
        return Err(Failure::Refused(anyhow!("{rms_px:.2} px RMS are beyond the limit of {limit} px")));
    }
    Ok(())
}
