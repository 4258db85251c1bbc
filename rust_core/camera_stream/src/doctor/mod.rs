//! `camera_stream doctor`: goes down the chain from ROS to the light, and says what is wrong and what to do.
//!
//! ```text
//!  distribution ─► master, clocks ─► CameraInfo, transform ─► displays ─► limits ─► screen ─► image ─► exposure
//! ```
//!
//! It listens as `check --live` does and to the images as well, then each file makes one group of
//! checks. A check gives [`finding::Finding`]s, which are printed here and nowhere else. It needs no graphical session.

mod camera;
mod displays;
mod distribution;
mod exposure;
pub(crate) mod finding;
mod graph;
mod image;
pub(crate) mod launch;
mod limits;
mod look;
mod running;
mod screen;
pub(crate) mod viewer;
mod windows;

use std::ffi::OsString;
use std::io::{IsTerminal as _, Write};
use std::path::Path;
use std::time::Instant;

use anyhow::{Error, Result};
use rcs_ros::ParameterValue;
use rcs_rviz_config::Config;

pub(crate) use self::displays::advice_for;
use self::finding::{Finding, Report};
use self::look::Look;
use self::windows::Windows;
use crate::check::session::Session;
use crate::cli::DoctorArgs;
use crate::options::Options;
use crate::safety::names::of_camera;
use crate::safety::read_rules::age_limits;

/// Result of all checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Nothing is wrong.
    Well,
    /// Something is.
    Faulty,
    /// There is no master, so little could be checked.
    NoMaster,
}

/// Makes all checks, prints a line for each finding, and at the end what to do first. `options` are those of the
/// command line.
///
/// # Errors
/// An invalid parameter, or an output that cannot be written.
pub(crate) fn run(
    config: &Config,
    words: &[OsString],
    args: &DoctorArgs,
    options: &Options,
    out: &mut dyn Write,
) -> Result<Verdict> {
    let mut report = Report { out, is_coloured: is_coloured(), findings: Vec::new(), error: None };
    report.add([distribution::distribution()]);
    let has_master = match Session::connect() {
        Ok(session) => {
            let examined = examine(&session, config, words, args, &mut report);
            session.end();
            examined?;
            true
        }
        Err(error) => {
            without_master(&error, config, args, options, &mut report);
            false
        }
    };
    let is_faulty = report.end()?;
    Ok(match (has_master, is_faulty) {
        (false, _) => Verdict::NoMaster,
        (true, true) => Verdict::Faulty,
        (true, false) => Verdict::Well,
    })
}

/// `true` if standard output is a terminal whose user wants colours.
fn is_coloured() -> bool {
    std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

/// The findings of a running ROS.
fn examine(
    session: &Session,
    config: &Config,
    words: &[OsString],
    args: &DoctorArgs,
    report: &mut Report<'_>,
) -> Result<()> {
    let options = session.options(words, config)?;
    let limits = age_limits(&session.ros, &options)?;
    let mut scene = session.scene(config, &options);
    let _images = image::subscribe(&session.ros, scene.cameras().iter());
    let started = Instant::now();
    let (subscriptions, observed) = session.listen(&mut scene, args.listen)?;
    let ended = Instant::now();
    let look = Look {
        session,
        options: &options,
        limits: &limits,
        scene: &scene,
        subscriptions: &subscriptions,
        observed: &observed,
        publications: session.ros.query_publications(),
        listened: ended.saturating_duration_since(started),
        ended,
    };
    let ros = Some((&session.ros, session.checked_name.as_str()));
    let windows = Windows::of(args.viewer, args.monitor.as_ref(), &options, ros);
    let parameter = || match session.ros.parameters_of("/projector").ok()?.remove("file")? {
        ParameterValue::String(file) => Some(file.into()),
        _ => None,
    };
    let projector_file = args.projector_file.clone().or_else(parameter);
    chain(&look, config, &windows, projector_file.as_deref(), report);
    Ok(())
}

/// All checks, in the order of the chain.
fn chain(look: &Look<'_>, config: &Config, windows: &Windows, projector_file: Option<&Path>, report: &mut Report<'_>) {
    let cameras = look.scene.cameras();
    report.add([graph::master(look)]);
    report.add(graph::clocks(look));
    report.add(projector_file.and_then(camera::missing_file));
    for camera in cameras {
        report.add([camera::info(look, camera), camera::transform(look, camera)]);
    }
    report.add(displays::all(look, config));
    report.add(limits::all(look));
    report.add(screen::all(windows, image_px(look)));
    report.add(cameras.iter().map(|camera| image::rate(look, camera)));
    report.add(exposure::all(look));
}

/// Size of the images, if the config has one camera.
fn image_px(look: &Look<'_>) -> Option<[u32; 2]> {
    let [camera] = look.scene.cameras() else { return None };
    let info = look.scene.camera_info(camera)?;
    let orientation = of_camera(&look.options.light.orientations, &camera.name).copied().unwrap_or_default();
    Some(orientation.size_px([info.width, info.height]))
}

/// The findings where no master answers.
fn without_master(error: &Error, config: &Config, args: &DoctorArgs, options: &Options, report: &mut Report<'_>) {
    let unknown = |name: &&str| Finding::unknown(*name, "unknown without a master", "");
    report.add([graph::no_master(error)]);
    report.add(args.projector_file.as_deref().and_then(camera::missing_file));
    report.add(["clocks", "camera_info", "transform"].iter().map(unknown));
    report.add(displays::of_config(config));
    report.add(["displays", "limits"].iter().map(unknown));
    report.add(screen::all(&Windows::of(args.viewer, args.monitor.as_ref(), options, None), None));
    report.add(["image", "exposure"].iter().map(unknown));
}
