//! `camera_stream`: the virtual cameras of a `.rviz` config, as a ROS node or over a bag.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod camera;
mod check;
pub mod cli;
mod control;
mod doctor;
mod new_camera;
pub mod nudge;
pub mod offline;
mod options;
pub mod outputs;
mod page;
mod projection_warning;
mod runtime;
mod safety;
pub mod scene;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{anyhow, Context, Result};
use clap::FromArgMatches as _;
use rcs_node_support::lifecycle::{self, own_arguments};
use rcs_node_support::user_file;
use rcs_resources::{MeshStore, PackageIndex};
use rcs_rviz_config::{Config, DisplaySettings, Finding, PlacedDisplay};
use rcs_setup::SetupError;

use crate::cli::{CheckArgs, Cli, Command, DoctorArgs, RenderArgs};
use crate::doctor::launch::{node_arguments, restart};
use crate::doctor::Verdict;
use crate::offline::{BagSection, RenderJob, RenderTarget};
use crate::options::config_file::find_config;
use crate::options::{rviz_arguments, Options};
use crate::safety::names::{ConfigNames, ForCamera};
use crate::scene::SceneState;

pub use safety::light_mask;

/// Default name of the node.
const NODE_NAME: &str = "camera_stream";
/// Exit status for invalid arguments and an unreadable config.
const INVALID: u8 = 2;

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    if let Some(status) = rcs_window::run_black_window() {
        return status;
    }
    let (words, of_qt) = rviz_arguments::understood(own_arguments());
    let parsed = cli::command().try_get_matches_from(&words).and_then(|matches| Cli::from_arg_matches(&matches));
    let mut cli = match parsed {
        Ok(cli) => cli,
        Err(error) => {
            let error = cli::with_hints(error);
            // Help and version are no errors; clap prints each to the right stream. A closed pipe is ignored.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { INVALID } else { 0 });
        }
    };
    if cli.may_use_gpu() {
        quiet_graphics_libraries();
    }
    let is_node = cli.command.is_none();
    if is_node {
        rcs_process::keep_one_heap();
    }
    let flush = is_node.then(|| rcs_logging::start_node(cli.is_debug()));
    if flush.is_none() {
        rcs_logging::start(cli.is_debug());
    }
    if !of_qt.is_empty() {
        log::warn!("Qt's arguments have no effect, as there is no window of Qt: {}", of_qt.join(" "));
    }
    let is_node = cli.command.is_none();
    run(&words, &mut cli).unwrap_or_else(|error| {
        print_error(&error.to_string(), is_node);
        ExitCode::from(INVALID)
    })
}

/// Runs the node or a command.
///
/// # Errors
/// Invalid arguments, or a config that cannot be read.
fn run(words: &[OsString], cli: &mut Cli) -> Result<ExitCode> {
    if let Some(Command::Doctor(args)) = &cli.command {
        let arguments = std::env::args_os().skip(1);
        if let Some(arguments) = node_arguments(arguments, args)? {
            return Err(restart(arguments).into());
        }
    }
    find_config(cli)?;
    if let Some(Command::NewCamera(args)) = &cli.command {
        return Ok(finished(new_camera::run(args)));
    }
    if let Some(Command::Setup(args)) = &cli.command {
        return match rcs_setup::run(args) {
            Ok(()) => Ok(ExitCode::SUCCESS),
            Err(SetupError::Refused(error)) => Ok(finished(Err(error))),
            Err(SetupError::Invalid(error)) => Err(anyhow!(rcs_logging::one_line(&error))),
        };
    }
    let file = cli.config_mut().cloned().context("no config: name one with -d FILE.rviz (see --help)")?;
    user_file::check(&file)?;
    let config = rcs_rviz_config::load(&file)?;
    let options = Options::of_command_line(cli, &config_names(&config))?;
    let result = match &cli.command {
        Some(Command::Check(args)) if args.live => return check_live(words, args, &config),
        Some(Command::Doctor(args)) => return examine(words, args, &config, &options),
        Some(Command::Check(_)) => check::print(&config, options.fixed_frame.as_deref(), &mut std::io::stdout().lock())
            .map(|understood| if understood { ExitCode::SUCCESS } else { ExitCode::FAILURE })
            .map_err(|error| anyhow!("standard output: {error}")),
        Some(Command::Render(args)) => render(cli, args, &config).map(|()| ExitCode::SUCCESS),
        None => return Ok(lifecycle::finish(&runtime::run(words, &file, &config))),
        Some(Command::NewCamera(_) | Command::Setup(_)) => Ok(ExitCode::SUCCESS),
    };
    Ok(finished(result))
}

/// Names of a config's cameras and displays, enabled or not.
fn config_names(config: &Config) -> ConfigNames {
    let placed = config.placed_displays();
    let is_camera = |placed: &&PlacedDisplay<'_>| matches!(placed.display.settings, DisplaySettings::CameraPub(_));
    let (cameras, displays): (Vec<_>, Vec<_>) = placed.iter().partition(is_camera);
    let names = |placed: Vec<&PlacedDisplay<'_>>| placed.iter().map(|placed| placed.display.name.clone()).collect();
    ConfigNames { cameras: names(cameras), displays: names(displays) }
}

/// The exit status of a result. An error is printed.
fn finished(result: Result<ExitCode>) -> ExitCode {
    result.unwrap_or_else(|error| {
        print_error(&rcs_logging::one_line(&error), false);
        ExitCode::FAILURE
    })
}

/// Without a session there is no XDG_RUNTIME_DIR, and then libwayland prints errors when a GL driver is probed,
/// although no window is opened. Where the variable names an existing folder, it finds no socket there and prints
/// nothing. To be called before a thread starts, because others may read the environment at the same time.
fn quiet_graphics_libraries() {
    const RUNTIME_FOLDER: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(RUNTIME_FOLDER).is_none() {
        std::env::set_var(RUNTIME_FOLDER, std::env::temp_dir());
    }
}

/// Logs the findings that were not known before; notes, which change no image, as debug messages.
fn log_findings(config: &Config, known: &[Finding]) {
    for finding in config.findings.iter().filter(|finding| !known.contains(finding)) {
        let level = if finding.is_note { log::Level::Debug } else { log::Level::Warn };
        log::log!(level, "{}: {finding}", config.source);
    }
}

/// Prints the error that ends the program in one line; a node logs it.
fn print_error(text: &str, is_node: bool) {
    if is_node {
        rcs_logging::log_last(&rcs_logging::flat(text));
    } else {
        rcs_logging::print_error(&format!("camera_stream: {}", rcs_logging::flat(text)));
    }
}

fn check_live(words: &[OsString], args: &CheckArgs, config: &Config) -> Result<ExitCode> {
    let is_ok = check::live::run(config, words, args.listen, &mut std::io::stdout().lock())?;
    Ok(if is_ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn examine(words: &[OsString], args: &DoctorArgs, config: &Config, options: &Options) -> Result<ExitCode> {
    Ok(match doctor::run(config, words, args, options, &mut std::io::stdout().lock())? {
        Verdict::Well => ExitCode::SUCCESS,
        Verdict::Faulty => ExitCode::FAILURE,
        Verdict::NoMaster => ExitCode::from(INVALID),
    })
}

fn render(cli: &Cli, args: &RenderArgs, config: &Config) -> Result<()> {
    log_findings(config, &[]);
    rcs_process::name_threads();
    let packages = PackageIndex::from_env(&args.package_path);
    // The user's own files may lie beside each other, in no package.
    let files: Vec<&Path> = std::iter::once(&args.display_config).chain(&args.bag).map(PathBuf::as_path).collect();
    let options = cli.drawing().resources.options_beside(&files);
    // Images must not depend on the speed of the disk: each mesh is loaded when it is first needed.
    let meshes = MeshStore::with_options(packages, options);
    let parameters = offline::read_parameters(&args.param, meshes.packages())?;
    let mut scene = SceneState::new(config, args.fixed_frame.as_deref(), meshes);
    offline::set_parameters(&mut scene, &parameters);
    let (rate_hz, overwrite) = (args.rate, args.overwrite);
    let target = match (&args.output, &args.sequence, &args.video) {
        (Some(file), ..) => RenderTarget::Image { file: file.clone() },
        (_, Some(folder), _) => RenderTarget::Sequence { folder: folder.clone(), rate_hz, overwrite },
        (.., Some(file)) => RenderTarget::Video { file: file.clone(), rate_hz },
        (None, None, None) => {
            return Err(anyhow!("no output: name one with -o FILE.png, --sequence DIR or --video FILE.mp4"))
        }
    };
    let job = RenderJob {
        bags: &args.bag,
        remappings: &offline::bag_names(&lifecycle::remappings())?,
        camera: args.camera.as_deref(),
        projector: args.projector.as_deref(),
        section: BagSection { at_secs: args.at, start_secs: args.start, end_secs: args.end },
        target: &target,
        model: args.drawing.model.model(),
        orientations: ForCamera::read_all("--orientation", &args.orientation, &config_names(config).cameras)?,
    };
    let mut renderer = rcs_render::create(args.drawing.renderer)?;
    offline::render(&mut scene, &job, renderer.as_mut())
}
