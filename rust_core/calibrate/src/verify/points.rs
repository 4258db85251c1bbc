//! A projector's file compared with the points of a scan: which pixel lights each of them, and which should.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use rcs_calibration::ReprojectionError;
use rcs_files::projector::ProjectorFile;

use super::judge;
use crate::{input, placing, read_lens, Failure};

/// Compares and judges.
pub(super) fn run(points: &[PathBuf], projector: &Path, limit: f64) -> Result<(), Failure> {
    let file = ProjectorFile::read(projector).map_err(Failure::unreadable)?;
    let lens = read_lens(projector)?;
    let input = input::read(points)?;
    let pose = placing::pose_in_file(&file, input.camera_frame.as_deref()).ok_or_else(|| {
        let camera = input.camera_frame.as_deref().unwrap_or("the camera's optical frame");
        Failure::Unreadable(anyhow!(
            "{}: does not place {} in {camera}: solve or refine without --parent writes such a file",
            projector.display(),
            file.camera_info.header.frame_id
        ))
    })?;
    let error = ReprojectionError::measure(&input.samples, &lens, &pose);
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
