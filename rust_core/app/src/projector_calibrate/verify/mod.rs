//! `projector_calibrate verify`: how far light lands from where it should.

use std::path::PathBuf;

use clap::Args;
use rcs_calibration::Landed;
use rcs_files::projector::ProjectorFile;

use super::{input, placing, Failure};

/// Measures how far the light of a calibrated projector lands from where it should
///
/// Compares points of a scan (files of points or capture folders) with the projector's file: which pixel lights each
/// point, and which should. The file must place the projector in the camera's optical frame.
#[derive(Debug, Args)]
#[command(after_help = "\
Exit codes: 0 within the limit; 1 beyond it; 2 invalid arguments or unreadable files

Example: projector_calibrate verify capture --projector projector.yaml --limit 2")]
pub(super) struct VerifyArguments {
    /// Files of points, or capture folders
    #[arg(value_name = "FILE", required = true)]
    points: Vec<PathBuf>,
    /// The projector's file
    #[arg(long, value_name = "FILE")]
    projector: PathBuf,
    /// The limit of the RMS, pixels of the projector
    #[arg(long, value_name = "PIXELS", default_value_t = 2.0)]
    limit: f64,
}

/// Runs the command.
pub(super) fn run(arguments: &VerifyArguments) -> Result<(), Failure> {
    let VerifyArguments { points, projector, limit } = arguments;
    if !limit.is_finite() || *limit <= 0.0 {
        return Err(Failure::Unreadable(anyhow::anyhow!("--limit {limit} is not a positive number")));
    }
    let file = ProjectorFile::read(projector).map_err(Failure::unreadable)?;
    let lens = super::read_lens(projector)?;
    let input = input::read(points)?;
    let pose = placing::pose_in_file(&file, input.camera_frame.as_deref()).ok_or_else(|| {
        let camera = input.camera_frame.as_deref().unwrap_or("the camera's optical frame");
        Failure::Unreadable(anyhow::anyhow!(
            "{}: does not place {} in {camera}: solve or refine without --parent writes such a file",
            projector.display(),
            file.camera_info.header.frame_id
        ))
    })?;
    let landed = Landed::measure(&input.samples, &lens, &pose);
    println!(
        "light lands {:.2} px ({:.2} mm) RMS from where it should, {:.2} px for the middle one, {:.1} px at most for 99 % of {} points",
        landed.rms_px,
        1000.0 * landed.rms_m,
        landed.median_px,
        landed.most_px,
        landed.count
    );
    if landed.count == 0 {
        return Err(Failure::Refused(anyhow::anyhow!("no point is in front of the projector")));
    }
    if landed.rms_px > *limit {
        return Err(Failure::Refused(anyhow::anyhow!("beyond the limit of {limit} px")));
    }
    Ok(())
}
