//! `projector_calibrate manual`: intrinsics from a tape measure, see [`rcs_calibration::manual`].

mod questions;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use rcs_calibration::manual::{compare_matrices, solve, ManualLens, ManualMeasures, ManualWarning, WallMeasures};
use rcs_files::projector::ProjectorFile;

use super::arguments::{length_m, size_px, two_lengths_m};
use super::Failure;

/// Intrinsics from a tape measure; asks for what to measure if no measure is given
///
/// The projector stands still and throws its image onto a flat wall at right angles to its optical axis. A second
/// distance makes the result independent of where in the projector the light comes from. Lengths are metres, or have a
/// unit (90cm, 900mm).
///
/// fx = w Z/W, fy = h Z/H, cx = w X/W, cy = h Y/H; with two distances fx = w (Z2 - Z1)/(W2 - W1).
#[derive(Debug, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate manual
  projector_calibrate manual --size 1280x800 --distance 1.2 \\
      --projected 0.9x0.56 --axis 0.45,0.6 -o projector.yaml")]
#[command(after_help = "\
Exit codes: 0 written; 1 refused, nothing written (--check alone: the file has faults); 2 invalid arguments or an \
unreadable file")]
pub(super) struct ManualArguments {
    /// Width and height of the image in pixels, w and h
    #[arg(long, value_name = "WxH", value_parser = size_px)]
    size: Option<[u32; 2]>,
    /// Distance from the lens to the wall, Z
    #[arg(long, value_name = "Z", value_parser = length_m, allow_hyphen_values = true)]
    distance: Option<f64>,
    /// Width and height of the image on the wall, W and H
    #[arg(long, value_name = "WxH", value_parser = two_lengths_m, allow_hyphen_values = true)]
    projected: Option<[f64; 2]>,
    /// Where the optical axis meets the wall, from the image's top left corner: X to the right, Y down; it may lie
    /// outside of the image
    #[arg(long, value_name = "X,Y", value_parser = two_lengths_m, allow_hyphen_values = true)]
    axis: Option<[f64; 2]>,
    /// Distance from the lens to the wall in a second place
    #[arg(long, value_name = "Z", value_parser = length_m, allow_hyphen_values = true, requires = "projected2")]
    distance2: Option<f64>,
    /// Width and height of the image at the second distance
    #[arg(long, value_name = "WxH", value_parser = two_lengths_m, allow_hyphen_values = true, requires = "distance2")]
    projected2: Option<[f64; 2]>,
    /// Where the optical axis meets the wall at the second distance; --axis or --axis2 is needed, both are better
    #[arg(long, value_name = "X,Y", value_parser = two_lengths_m, allow_hyphen_values = true, requires = "distance2")]
    axis2: Option<[f64; 2]>,
    /// Error of a length read from the tape, in metres [default: 0.002]
    #[arg(long, value_name = "LENGTH", value_parser = length_m, allow_hyphen_values = true)]
    tape_error: Option<f64>,
    /// A projector file whose K and P to compare; may be given without measures
    #[arg(long, value_name = "FILE")]
    check: Option<PathBuf>,
    /// The file to write [default: standard output, or the file that is asked for]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl ManualArguments {
    /// The measures; `None` without any.
    fn measures(&self) -> Result<Option<ManualMeasures>, Failure> {
        let has_any = self.size.is_some()
            || self.distance.or(self.distance2).is_some()
            || self.projected.or(self.projected2).or(self.axis).or(self.axis2).is_some();
        if !has_any {
            return Ok(None);
        }
        let missing = |name: &str| {
            Failure::Unreadable(anyhow!("{name} is missing (without any measure, manual asks for each of them)"))
        };
        let image_m = self.projected.ok_or_else(|| missing("--projected"))?;
        let distance_m = self.distance.ok_or_else(|| missing("--distance"))?;
        let first = WallMeasures { distance_m, image_m, axis_m: self.axis };
        let second = self.distance2.zip(self.projected2);
        let second = second.map(|(distance_m, image_m)| WallMeasures { distance_m, image_m, axis_m: self.axis2 });
        if self.axis.or(self.axis2).is_none() {
            return Err(missing("--axis"));
        }
        let size_px = self.size.ok_or_else(|| missing("--size"))?;
        Ok(Some(ManualMeasures { size_px, first, second, tape_error_m: self.tape_error_m() }))
    }

    fn tape_error_m(&self) -> f64 {
        self.tape_error.unwrap_or(ManualMeasures::TAPE_ERROR_M)
    }
}

/// Runs the command.
pub(super) fn run(arguments: &ManualArguments) -> Result<(), Failure> {
    let checked = arguments.check.as_deref().map(check_file).transpose()?;
    let (measures, output) = match (arguments.measures()?, checked) {
        (Some(measures), _) => (measures, arguments.output.clone()),
        (None, Some(faults)) => return report_check(faults, arguments),
        (None, None) => {
            let (measures, output) = questions::ask_user(arguments.tape_error_m(), arguments.output.as_deref())?;
            (measures, Some(output))
        }
    };
    let found = solve(&measures).map_err(Failure::refused)?;
    eprintln!("{}", summary(&found));
    for warning in &found.warnings {
        log::warn!("{warning}");
    }
    let file = ProjectorFile::from_lens(&found.lens, ProjectorFile::FRAME_ID);
    match output {
        Some(path) => {
            file.write(&path).map_err(Failure::refused)?;
            eprintln!("written: {}", path.display());
        }
        None => {
            let text = file.to_yaml(Path::new("standard output")).map_err(Failure::refused)?;
            let mut stdout = std::io::stdout().lock();
            stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).map_err(Failure::refused)?;
        }
    }
    Ok(())
}

/// Reads a projector's file, warns of its faults and returns their number.
fn check_file(path: &Path) -> Result<usize, Failure> {
    let file = ProjectorFile::read(path).map_err(Failure::unreadable)?;
    let info = &file.camera_info;
    let mut faults = file.warnings();
    let difference = compare_matrices([info.width, info.height], &info.K, &info.P);
    faults.extend(difference.map(|difference| ManualWarning::MatricesDiffer(difference).to_string()));
    if let Err(problem) = file.lens() {
        faults.push(problem.to_string());
    }
    for fault in &faults {
        log::warn!("{}: {fault}", path.display());
    }
    Ok(faults.len())
}

/// The result of a check without measures.
fn report_check(faults: usize, arguments: &ManualArguments) -> Result<(), Failure> {
    if arguments.output.is_some() {
        return Err(Failure::Unreadable(anyhow!("--output needs measures; --check alone writes nothing")));
    }
    let name = arguments.check.as_deref().unwrap_or(Path::new("")).display();
    match faults {
        0 => {
            println!("{name}: K and P agree");
            Ok(())
        }
        1 => Err(Failure::Refused(anyhow!("{name}: the fault above"))),
        _ => Err(Failure::Refused(anyhow!("{name}: the {faults} faults above"))),
    }
}

/// The lens and its accuracy in words.
fn summary(found: &ManualLens) -> String {
    let (f, c, accuracy) = (found.lens.focal_px, found.lens.center_px, &found.accuracy);
    let percent = 100.0 * accuracy.focal_share;
    let mut lines = vec![
        format!("fx {:.1} ± {:.2} %, fy {:.1} ± {:.2} % (pixels)", f.x, percent.x, f.y, percent.y),
        format!("cx {:.1} ± {:.1}, cy {:.1} ± {:.1} (pixels)", c.x, accuracy.center_px.x, c.y, accuracy.center_px.y),
        format!("error by the tape alone: up to {:.1} mm at a metre", 1e3 * accuracy.light_m),
    ];
    if let Some([x, y]) = found.lens_place_m {
        let behind_m = 0.5 * (x + y);
        let side = if behind_m < 0.0 { "nearer to" } else { "farther from" };
        lines.push(format!(
            "the center of projection is {:.0} mm {side} the wall than where distances were measured from",
            1e3 * behind_m.abs()
        ));
    }
    if let Some(by_place) = accuracy.focal_share_by_place {
        lines.push(format!(
            "f is off by {by_place:.1} % more for each 10 mm between the center of projection and where distances were \
             measured from; a second distance (--distance2, --projected2) cancels that"
        ));
    }
    lines.join("\n")
}
