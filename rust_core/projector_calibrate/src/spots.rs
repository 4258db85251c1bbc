//! `projector_calibrate refine --spots`: the pose of a bumped projector, by spots of light that a camera sees.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use nalgebra::Isometry3;
use rcs_calibration::{RefinedPose, Zoom};
use rcs_files::projector::StaticFrame;
use rcs_node_support::nudge::{Nudge, NudgedProjector};
use rcs_scan::{Refinement, ScanCamera, ScanEvent, ScanOptions, ScanSession};
use rcs_window::MonitorChoice;

use super::arguments::check_output;
use super::known_projector::KnownProjector;
use super::live::{CameraArguments, LiveSession, LiveSetup, PlacedProjector, Progress};
use super::placing::CameraPose;
use super::solve::Solved;
use super::Failure;

/// Default CameraInfo topic of a projector's file, as of the node `projector`.
const DEFAULT_TOPIC: &str = "/proj_view/camera_info";
/// Maximum difference of equal poses, metres and radians.
const SAME_POSE: f64 = 1e-6;

/// Arguments of `refine --spots`.
#[derive(Debug, Clone, Args)]
pub(super) struct SpotsArguments {
    /// Show spots and find them with the camera; nothing may move meanwhile. A running projector gets the pose and
    /// saves it, unless --output is given; without one, the file is written
    #[arg(long, conflicts_with_all = ["points", "things", "clicked", "camera_frame", "parent", "in_camera_frame"])]
    spots: bool,
    /// Publish the spots on this topic and open no window: ~patterns of the camera_stream that has the screen, or the
    /// topic of a projector_window elsewhere
    #[arg(long, value_name = "TOPIC", requires = "spots", conflicts_with = "monitor")]
    show_on: Option<String>,
    /// The camera.
    #[command(flatten)]
    camera: CameraArguments,
}

impl SpotsArguments {
    /// `true` for a refinement by spots.
    pub(super) fn is_chosen(&self) -> bool {
        self.spots
    }
}

/// Refines by spots, and writes `output` if that is given. `report` is the folder of the reports.
pub(super) fn run(
    spots: &SpotsArguments,
    monitor: MonitorChoice,
    projector: KnownProjector,
    output: Option<PathBuf>,
    report: Option<PathBuf>,
) -> Result<(), Failure> {
    projector.frame()?;
    [&output, &report].into_iter().flatten().try_for_each(|path| check_output(path))?;
    let setup = LiveSetup {
        name: "the refinement",
        monitor,
        topics: spots.camera.topics(),
        show_on: spots.show_on.clone(),
        projector_px: projector.lens.size_px,
        projector_frame: projector.child().to_owned(),
        needs_lens: true,
    };
    let frames = usize::from(spots.camera.frames);
    setup.run(move |session| {
        session.camera.follow_robot().map_err(Failure::unreadable)?;
        let placed = session.camera.place(&projector)?;
        let Refinement { refined, elapsed } = measure(session, frames, &projector, &placed)?;
        session.check_valid()?;
        let RefinedPose { samples, solution, shown, zoom } = refined;
        let solved = Solved::judged(&samples, solution, report.as_deref())?;
        let (parent, parent_from_camera) = (placed.frame.parent.clone(), placed.parent_from_camera);
        let place = CameraPose { parent, parent_from_camera, may_move: false };
        let pose = solved.parent_from_projector(&place);
        let change = Nudge::of_isometry(&(placed.frame.parent_from_child().inverse() * pose));
        let done = hand_over(session, &projector, &placed.frame, &pose, output.as_deref())?;
        solved.summarise();
        let [sigma_m, sigma_rad] = solved.sigmas();
        eprintln!(
            "{} of {shown} spots seen in {:.1} s; the projector has moved by {change}, \u{b1} {:.1} mm and {:.2} degrees",
            samples.len(),
            elapsed.as_secs_f64(),
            1000.0 * sigma_m,
            sigma_rad.to_degrees()
        );
        if let Zoom::Undecidable { variation } = zoom {
            log::warn!(
                "cannot tell whether the zoom has changed: depths vary by {:.0} % only, or too few spots are seen; if \
                 it has, the pose is right at this depth only",
                100.0 * variation
            );
        }
        eprintln!("{done}");
        Ok(())
    })
}

fn measure(
    session: &mut LiveSession<'_>,
    frames: usize,
    projector: &KnownProjector,
    placed: &PlacedProjector,
) -> Result<Refinement, Failure> {
    let (end, projector_px) = (session.end, projector.lens.size_px);
    let options = ScanOptions { projector_px, step: 1, frames, is_cancelled: &|| end.is_requested() };
    let camera_px = session.camera.lens().size_px;
    let mut progress = Progress::new("looking for the projector's light", None, camera_px, projector_px);
    let mut observe = |event: ScanEvent<'_>| progress.show(&event);
    let refinement = ScanSession::new(&mut *session.screen, &mut session.camera, &options, &mut observe)
        .refine(&projector.lens, &placed.projector_from_camera());
    progress.finish();
    Ok(refinement?)
}

/// Writes the pose into `output`, or lets the running projector save it, or writes it into the projector's file.
/// Returns what was done.
fn hand_over(
    session: &mut LiveSession<'_>,
    projector: &KnownProjector,
    frame: &StaticFrame,
    pose: &Isometry3<f64>,
    output: Option<&Path>,
) -> Result<String, Failure> {
    let topic = projector.file.camera_info_topic.as_deref().unwrap_or(DEFAULT_TOPIC);
    let topic = session.node.resolve(topic).map_err(Failure::unreadable)?;
    let running = match output {
        Some(_) => None,
        None => NudgedProjector::find(session.node, &topic).map_err(Failure::refused)?,
    };
    let Some(mut running) = running else {
        let output = output.unwrap_or(&projector.path);
        projector.write(output, &frame.parent, pose)?;
        return Ok(format!("written: {}", output.display()));
    };
    let file = frame.parent_from_child();
    let published = session.camera.look_up(&frame.parent, &frame.child)?;
    let difference = (file * running.nudge.isometry()).inverse() * published;
    if difference.translation.vector.norm() > SAME_POSE || difference.rotation.angle() > SAME_POSE {
        return Err(Failure::Refused(anyhow!(
            "{} has another pose of {} than {}: give the file that it runs with, or write one with --output",
            running.node,
            frame.child,
            projector.path.display()
        )));
    }
    let nudge = Nudge::of_isometry(&(file.inverse() * pose));
    let set = running.set(session.node, nudge).and_then(|()| running.trigger(session.node, "save"));
    let saved = set.map_err(|error| {
        Failure::Refused(error.context("the projector cannot save the pose (write a file with --output)"))
    })?;
    Ok(format!("saved by {}: {saved}", running.node))
}
