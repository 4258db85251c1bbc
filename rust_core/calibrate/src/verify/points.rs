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
    let landed = ReprojectionError::measure(&input.samples, &lens, &pose);
    println!(
        "light lands {:.2} px ({:.2} mm) RMS from where it should, {:.2} px for the middle one, {:.1} px at most for 99 % of {} points",
        landed.rms_px,
        1000.0 * landed.rms_m,
        landed.median_px,
        landed.most_px,
        landed.count
    );
    if landed.count == 0 {
        return Err(Failure::Refused(anyhow!("no point is in front of the projector")));
    }
    judge(landed.rms_px, limit)
}
