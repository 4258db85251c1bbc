//! A projector's file compared with where its light lands now.

use std::path::Path;

use rcs_calibration::ErrorStatistics;
use rcs_files::picture_file::{self, PictureFormat};
use rcs_files::verification;

use super::{check_folder, judge, VerifyArguments};
use crate::scan::{verify_live, LiveOptions};
use crate::Failure;
use rcs_scan::Verification;

/// Measures, writes and judges.
pub(super) fn run(arguments: &VerifyArguments, projector: &Path) -> Result<(), Failure> {
    if let Some(path) = &arguments.picture {
        PictureFormat::of(path).map_err(Failure::unreadable)?;
    }
    [&arguments.picture, &arguments.report].into_iter().flatten().try_for_each(|path| check_folder(path))?;
    let options = LiveOptions {
        projector: projector.to_owned(),
        monitor: arguments.monitor.clone(),
        show_on: arguments.show_on.clone(),
        camera: arguments.camera.clone(),
        frames: usize::from(arguments.frames),
        hold: arguments.hold,
    };
    let output = Output {
        projector: projector.display().to_string(),
        limit: arguments.limit,
        report: arguments.report.clone(),
        picture: arguments.picture.clone(),
    };
    verify_live(&options, move |verification| output.finish(verification))
}

/// What becomes of the distances.
struct Output {
    projector: String,
    limit: f64,
    report: Option<std::path::PathBuf>,
    picture: Option<std::path::PathBuf>,
}

impl Output {
    fn finish(&self, verification: &Verification) -> Result<(), Failure> {
        let verified = &verification.verified;
        println!("{}", line("light", &verified.all()));
        for (name, misses, shown) in
            [("spots", &verified.spots, verified.spots_shown), ("edges", &verified.edges, verified.edges_shown)]
        {
            let figures = ErrorStatistics::of(misses);
            if figures.count > 0 {
                println!("  {}; {} of {shown} seen", line(name, &figures), figures.count);
            } else {
                println!("  {name}: none of {shown} seen");
            }
        }
        if let Some(path) = &self.report {
            verification::write(path, &self.projector, self.limit, verified).map_err(Failure::refused)?;
        }
        if let Some(path) = &self.picture {
            let (picture, factor) = verification::picture(&verification.white, verification.camera_px, verified);
            picture_file::write(path, &picture).map_err(Failure::refused)?;
            log::info!("{}: arrows are {factor:.0} times as long as the distances", path.display());
        }
        judge(verified.all().rms[0], self.limit)
    }
}

/// Distances in a line.
fn line(name: &str, figures: &ErrorStatistics) -> String {
    let both = |[px, m]: [f64; 2]| format!("{px:.2} px ({:.2} mm)", 1000.0 * m);
    let ErrorStatistics { median, rms, worst, .. } = figures;
    format!("{name}: {} RMS error, median {}, worst {}", both(*rms), both(*median), both(*worst))
}
