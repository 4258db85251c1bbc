//! `projector_calibrate`: from an unboxed projector to light on the thing: a projector's intrinsics and pose, measured
//! and checked. One file or folder for each command.
#![forbid(unsafe_code)]

mod arguments;
mod clicks;
mod decode;
mod failure;
mod input;
mod manual;
mod patterns;
mod placing;
mod refine;
mod scan;
mod show;
mod solve;
mod steer;
mod verify;

use std::path::Path;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use rcs_calibration::Lens;
use rcs_files::projector::ProjectorFile;

pub use failure::Failure;

use rcs_node_support::lifecycle::{self, own_arguments};

/// Calibrates a projector: writes the file that the program projector publishes.
#[derive(Debug, Parser)]
#[command(
    name = "projector_calibrate",
    display_name = "rviz_camera_stream",
    version,
    after_help = "Exit codes: 0 written or shown; 1 refused, nothing written; 2 invalid arguments or unreadable files"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Manual(manual::ManualArguments),
    Patterns(patterns::PatternsArguments),
    Show(show::ShowArguments),
    Scan(scan::ScanArguments),
    Decode(decode::DecodeArguments),
    Solve(solve::SolveArguments),
    Refine(refine::RefineArguments),
    Verify(verify::VerifyArguments),
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse_from(own_arguments());
    rcs_logging::start(false);
    rcs_scene::name_threads();
    let result = match &arguments.command {
        Command::Manual(arguments) => manual::run(arguments),
        Command::Patterns(arguments) => patterns::run(arguments),
        Command::Show(arguments) => show::run(arguments),
        Command::Scan(arguments) => scan::run(arguments),
        Command::Decode(arguments) => decode::run(arguments),
        Command::Solve(arguments) => solve::run(arguments),
        Command::Refine(arguments) => refine::run(arguments),
        Command::Verify(arguments) => verify::run(arguments),
    };
    let status = match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    };
    // Ends a node that a command left on its way out.
    lifecycle::finish(&Ok(()));
    status
}

/// The lens of a projector's file; what the file warns of is logged.
fn read_lens(path: &Path) -> Result<Lens, Failure> {
    let file = ProjectorFile::read(path).map_err(Failure::unreadable)?;
    for warning in file.warnings() {
        log::warn!("{}: {warning}", path.display());
    }
    file.lens().map_err(|problem| Failure::Unreadable(anyhow::anyhow!("{}: {problem}", path.display())))
}
