//! `projector_calibrate solve`: from correspondences to the projector's file.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::Args;
use nalgebra::{Isometry3, Point3, Vector3};
use rcs_calibration::board::Chessboard;
use rcs_calibration::{
    solve, DistortionTerms, FocalLengths, Parameter, Report, Sample, ScanPose, Solution, SolveOptions, Table, Verdict,
};
use rcs_files::calibration_report;
use rcs_files::projector::{ProjectorFile, StaticFrame, TABLE_FRAME};
use rcs_node_support::key_value;

use super::arguments::{chessboard, size_px};
use super::board::{self, BoardOutputs};
use super::correspondences::Correspondences;
use super::placing::{read_projector, CameraPose, PlacingArguments};
use super::Failure;

/// Solves for the projector's lens and pose, and writes the file that the program projector publishes
///
/// Takes files of points (u_px, v_px, x_m, y_m, z_m and optionally scan, which numbers the camera's poses), and capture
/// folders. Each further file or folder is another pose of the camera; the projector must not have moved in between.
/// The pose that is written belongs to the first of them.
///
/// A pose in the camera's frame would move with the camera: if joints move that, solve asks for --parent, the frame
/// that the projector is mounted on, or --in-camera-frame. The capture knows the joints, and where the camera was. For
/// points and photos, --camera-frame names its frame.
#[derive(Debug, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate solve capture --size 1280x800 -o projector.yaml \\
      --report report
  projector_calibrate solve boards --board chessboard:10x7:25mm \\
      --size 1280x800 -o projector.yaml --camera camera.yaml")]
#[command(after_help = "\
Exit codes: 0 written; 1 refused, nothing written but the report of a verdict \"again\"; 2 invalid arguments or \
unreadable files")]
#[command(override_usage = "projector_calibrate solve [OPTIONS] --size <WxH> -o <FILE> <FILE>...")]
pub(super) struct SolveArguments {
    /// Files of points, capture folders or, with --board, a folder of them
    #[arg(value_name = "FILE", required = true)]
    points: Vec<PathBuf>,
    /// Width and height of the projector's image, pixels
    #[arg(long, value_name = "WxH", value_parser = size_px)]
    size: [u32; 2],
    /// The projector's file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The printed board of `scan --board`
    #[arg(long, value_name = "chessboard:CxR:SIDE", value_parser = chessboard)]
    board: Option<Chessboard>,
    /// With --board: the camera's file to write
    #[arg(long, value_name = "FILE", requires = "board")]
    camera: Option<PathBuf>,
    /// With --board: ignore the camera's CameraInfo
    #[arg(long, requires = "board")]
    solve_camera: bool,
    /// A folder for report.yaml and report.html
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Distortion to solve for. auto: each term only if it lowers the held-out error
    #[arg(long, default_value = "auto", value_parser = distortion_parser())]
    distortion: DistortionTerms,
    /// Focal lengths to solve for: one for both axes, or two
    #[arg(long, default_value = "two", value_parser = focal_parser())]
    focal: FocalLengths,
    /// A parameter that is known: fx, fy, cx, cy, k1, k2, p1, p2, k3. Can be given several times
    #[arg(long, value_name = "NAME=VALUE", value_parser = fixed_parameter)]
    fix: Vec<(Parameter, f64)>,
    /// Also write the frame `table`: on the plane that most points of the first scan lie on, z up, x to the right in
    /// the camera's image, its origin where the camera looks
    #[arg(long, conflicts_with = "board")]
    table: bool,
    /// A projector's file to start from
    #[arg(long, value_name = "FILE")]
    initial: Option<PathBuf>,
    #[command(flatten)]
    placing: PlacingArguments,
}

fn distortion_parser() -> impl TypedValueParser<Value = DistortionTerms> {
    PossibleValuesParser::new(["auto", "none", "k1", "k1k2", "plumb_bob"]).map(|name| match &*name {
        "none" => DistortionTerms::None,
        "k1" => DistortionTerms::K1,
        "k1k2" => DistortionTerms::K1K2,
        "plumb_bob" => DistortionTerms::PlumbBob,
        _ => DistortionTerms::Auto,
    })
}

fn focal_parser() -> impl TypedValueParser<Value = FocalLengths> {
    PossibleValuesParser::new(["one", "two"])
        .map(|name| if name == "one" { FocalLengths::One } else { FocalLengths::Two })
}

/// Parses `NAME=VALUE`.
fn fixed_parameter(text: &str) -> Result<(Parameter, f64), String> {
    let (name, value) = key_value::split(text).ok_or("not NAME=VALUE")?;
    let parameter = Parameter::from_name(name)
        .ok_or_else(|| format!("there is no parameter '{name}': {}", Parameter::ALL.map(Parameter::name).join(", ")))?;
    match value.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((parameter, value)),
        _ => Err(format!("'{value}' is not a finite number")),
    }
}

/// Runs the command.
pub(super) fn run(arguments: &SolveArguments) -> Result<(), Failure> {
    let initial = arguments.initial.as_deref().map(read_projector).transpose()?.map(|(_, lens)| lens);
    let options = SolveOptions {
        distortion: arguments.distortion,
        focal: arguments.focal,
        fixed: arguments.fix.clone(),
        initial,
        ..SolveOptions::new(arguments.size)
    };
    if let Some(board) = arguments.board {
        let (camera, report) = (arguments.camera.as_deref(), arguments.report.as_deref());
        let outputs = BoardOutputs { projector: &arguments.output, camera, report };
        let (points, placing) = (&arguments.points, &arguments.placing);
        return board::solve_and_write(points, board, arguments.solve_camera, options, placing, &outputs);
    }
    let points = Correspondences::read(&arguments.points)?;
    let place = arguments.placing.camera_pose(points.camera_frame.as_deref(), &points.robot, None)?;
    let solved = Solved::new(&points.samples, &options, arguments.report.as_deref())?;
    let (lens, pose) = (&solved.report.solution.lens, solved.parent_from_projector(&place));
    let mut file = ProjectorFile::calibrated(lens, &place.parent, &pose);
    if arguments.table {
        file.frames.push(table(&points.samples, &place)?);
    }
    file.write(&arguments.output).map_err(Failure::refused)?;
    solved.summarise();
    place.tell_written(&arguments.output);
    Ok(())
}

/// The frame of the table that the first scan saw.
fn table(samples: &[Sample], place: &CameraPose) -> Result<StaticFrame, Failure> {
    let of_first = samples.iter().filter(|sample| sample.scan == samples[0].scan);
    let points: Vec<Point3<f64>> = of_first.map(|sample| sample.point).collect();
    let Table { camera_from_table, share } = Table::find(&points).map_err(Failure::refused)?;
    let tilt = (camera_from_table.rotation * Vector3::z()).angle(&-Vector3::z());
    eprintln!(
        "table: {:.0} % of the points, {:.2} m before the camera, tilted by {:.0} degrees",
        100.0 * share,
        camera_from_table.translation.vector.z,
        tilt.to_degrees()
    );
    let pose = place.parent_from_camera * camera_from_table;
    Ok(StaticFrame::new(&place.parent, TABLE_FRAME, &pose))
}

/// A solution that may be used.
pub(super) struct Solved {
    /// Its report, with a verdict that is not "again".
    pub(super) report: Report,
    /// Pose of the first scan.
    pose: ScanPose,
}

impl Solved {
    /// Solves, and writes the report.
    pub(super) fn new(
        samples: &[Sample],
        options: &SolveOptions,
        report_folder: Option<&Path>,
    ) -> Result<Self, Failure> {
        Self::judged(samples, solve(samples, options).map_err(Failure::refused)?, report_folder)
    }

    /// Judges a solution, and writes the report.
    pub(super) fn judged(
        samples: &[Sample],
        solution: Solution,
        report_folder: Option<&Path>,
    ) -> Result<Self, Failure> {
        let pose = solution.poses.first().copied();
        let pose = pose.ok_or_else(|| Failure::Refused(anyhow::anyhow!("no pose was found")))?;
        let report = Report::new(samples, solution);
        if let Some(folder) = report_folder {
            calibration_report::write(folder, &report, samples).map_err(Failure::refused)?;
        }
        if report.verdict == Verdict::Again {
            let reasons = report.reasons.join("; ");
            return Err(Failure::Refused(anyhow::anyhow!("not to be used, scan again: {reasons}")));
        }
        Ok(Self { report, pose })
    }

    /// The projector's pose in the frame that it is written in.
    pub(super) fn parent_from_projector(&self, place: &CameraPose) -> Isometry3<f64> {
        place.parent_from_camera * self.pose.projector_from_camera.inverse()
    }

    /// Largest standard deviations of the pose: metres and radians.
    pub(super) fn sigmas(&self) -> [f64; 2] {
        let ScanPose { position_sigma_m, orientation_sigma_rad, .. } = self.pose;
        [position_sigma_m, orientation_sigma_rad].map(|sigmas| sigmas.into_iter().fold(0.0, f64::max))
    }

    /// Prints verdict and errors.
    pub(super) fn summarise(&self) {
        summarise(&self.report);
    }
}

/// Prints verdict and errors.
fn summarise(report: &Report) {
    let solution = &report.solution;
    eprintln!(
        "verdict: {}. RMS error {:.2} px, held out {:.2} px, {:.2} mm; {} of {} points are inliers",
        report.verdict.name(),
        solution.rms_px,
        solution.held_out_rms_px,
        1000.0 * report.rms_m,
        solution.inliers,
        report.points,
    );
    report.reasons.iter().for_each(|reason| eprintln!("  {reason}"));
}
