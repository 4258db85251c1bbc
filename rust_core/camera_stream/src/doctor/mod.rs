//! `camera_stream doctor`: goes down the chain from the master to the light, and says what is wrong and what to do.
//!
//! ```text
//!  graph: master, clocks ─► camera: CameraInfo, transform ─► displays ─► limits ─► screen ─► image ─► exposure
//! ```
//!
//! It listens as `check --live` does and to the images as well, then each file makes one group of
//! checks. A check gives [`finding::Finding`]s, which are printed here and nowhere else. It needs no graphical session.

mod camera;
mod displays;
mod exposure;
pub(crate) mod finding;
mod graph;
mod image;
pub(crate) mod launch;
mod limits;
mod look;
mod screen;
pub(crate) mod viewer;
mod windows;

use std::ffi::OsString;
use std::io::Write;
use std::time::Instant;

use anyhow::{Error, Result};
use rcs_rviz_config::Config;

pub(crate) use self::displays::advice_for;
use self::finding::{Finding, Mark};
use self::look::Look;
use self::windows::Windows;
use crate::check::live::is_closed_pipe;
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

/// Makes all checks and prints a line for each finding. `options` are those of the command line.
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
    let (findings, has_master) = match Session::connect() {
        Ok(session) => {
            let findings = examine(&session, config, words, args);
            session.end();
            (findings?, true)
        }
        Err(error) => (without_master(&error, config, args, options), false),
    };
    let printed = findings.iter().try_for_each(|finding| writeln!(out, "{finding}")).map_err(Error::from);
    // A closed pipe, as of `head`, is no error.
    printed.or_else(|error| if is_closed_pipe(&error) { Ok(()) } else { Err(error) })?;
    let is_faulty = findings.iter().any(|finding| finding.mark == Mark::Bad);
    Ok(match (has_master, is_faulty) {
        (false, _) => Verdict::NoMaster,
        (true, true) => Verdict::Faulty,
        (true, false) => Verdict::Well,
    })
}

/// The findings of a running ROS.
fn examine(session: &Session, config: &Config, words: &[OsString], args: &DoctorArgs) -> Result<Vec<Finding>> {
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
    Ok(chain(&look, config, &windows))
}

/// All checks, in the order of the chain.
fn chain(look: &Look<'_>, config: &Config, windows: &Windows) -> Vec<Finding> {
    let cameras = look.scene.cameras();
    let mut findings = vec![graph::master(look)];
    findings.extend(graph::clocks(look));
    findings.extend(cameras.iter().flat_map(|camera| [camera::info(look, camera), camera::transform(look, camera)]));
    findings.extend(displays::all(look, config));
    findings.extend(limits::all(look));
    findings.extend(screen::all(windows, image_px(look)));
    findings.extend(cameras.iter().map(|camera| image::rate(look, camera)));
    findings.extend(exposure::all(look));
    findings
}

/// Size of the images, if the config has one camera.
fn image_px(look: &Look<'_>) -> Option<[u32; 2]> {
    let [camera] = look.scene.cameras() else { return None };
    let info = look.scene.camera_info(camera)?;
    let orientation = of_camera(&look.options.light.orientations, &camera.name).copied().unwrap_or_default();
    Some(orientation.size_px([info.width, info.height]))
}

/// The findings where no master answers.
fn without_master(error: &Error, config: &Config, args: &DoctorArgs, options: &Options) -> Vec<Finding> {
    let unknown = |name: &&str| Finding::unknown(*name, "unknown without a master", "");
    let mut findings = vec![graph::no_master(error)];
    findings.extend(["clocks", "camera_info", "transform"].iter().map(unknown));
    findings.extend(displays::of_config(config));
    findings.extend(["displays", "limits"].iter().map(unknown));
    findings.extend(screen::all(&Windows::of(args.viewer, args.monitor.as_ref(), options, None), None));
    findings.extend(["image", "exposure"].iter().map(unknown));
    findings
}
