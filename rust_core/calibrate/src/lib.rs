//! `projector_calibrate`: a projector's intrinsics and pose, measured and checked. One file or folder for each command.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod arguments;
mod camera_chain;
mod clicks;
mod correspondences;
mod crosshair;
mod decode;
mod failure;
mod live;
mod manual;
mod patterns;
mod placing;
mod refine;
mod scan;
mod show;
mod solve;
mod verify;
mod window_support;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use failure::Failure;
use rcs_node_support::lifecycle::{self, own_arguments};

/// Calibrates a projector: writes the file that the program projector publishes.
#[derive(Debug, Parser)]
#[command(
    name = "projector_calibrate",
    display_name = "rviz_camera_stream",
    version,
    after_help = "Exit codes: 0 written or shown; 1 refused, nothing written; 2 invalid arguments or unreadable files"
)]
struct CalibrateArguments {
    #[command(subcommand)]
    command: CalibrateCommand,
}

#[derive(Debug, Subcommand)]
enum CalibrateCommand {
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
    let arguments = CalibrateArguments::parse_from(own_arguments());
    rcs_logging::start(false);
    rcs_scene::name_threads();
    let result = match &arguments.command {
        CalibrateCommand::Manual(arguments) => manual::run(arguments),
        CalibrateCommand::Patterns(arguments) => patterns::run(arguments),
        CalibrateCommand::Show(arguments) => show::run(arguments),
        CalibrateCommand::Scan(arguments) => scan::run(arguments),
        CalibrateCommand::Decode(arguments) => decode::run(arguments),
        CalibrateCommand::Solve(arguments) => solve::run(arguments),
        CalibrateCommand::Refine(arguments) => refine::run(arguments),
        CalibrateCommand::Verify(arguments) => verify::run(arguments),
    };
    let status = match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    };
    // Ends the node after an error of a command.
    lifecycle::finish(&Ok(()));
    status
}
