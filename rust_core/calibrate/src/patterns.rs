//! `projector_calibrate patterns`: the pictures that a scan shows, as files.

use std::path::PathBuf;

use clap::{value_parser, Args};
use rcs_calibration::patterns::{gray_code, shifted_gray_code};
use rcs_files::capture::{write_patterns, PATTERNS_FILE};

use super::arguments::{size, Size};
use super::Failure;

/// Writes the patterns of a scan: p000.png and so on, and patterns.yaml
///
/// White, black, and stripes in Gray code, each with its inverse. With a step, the finest stripes are twice as many
/// pixels wide and are shown shifted by each pixel instead: for cameras that cannot see finer ones.
#[derive(Debug, Args)]
#[command(after_help = "\
Exit codes: 0 written; 1 not written; 2 invalid arguments

Example: projector_calibrate patterns --size 1280x800 --step 4 -o patterns")]
pub(super) struct PatternsArguments {
    /// Width and height of the projector's picture, pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Size,
    /// How many pixels share a code, 1 to 64
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u32).range(1..=64))]
    step: u32,
    /// The folder to write to; made if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs the command.
pub(super) fn run(arguments: &PatternsArguments) -> Result<(), Failure> {
    let PatternsArguments { size: Size(size_px), step, output } = arguments;
    let patterns = if *step == 1 { gray_code(*size_px) } else { shifted_gray_code(*size_px, *step) };
    write_patterns(output, *size_px, &patterns).map_err(Failure::refused)?;
    eprintln!("written: {} pictures and {}", patterns.len(), output.join(PATTERNS_FILE).display());
    Ok(())
}
