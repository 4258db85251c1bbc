//! `projector_calibrate patterns`: the images that a scan shows, as files.

use std::path::PathBuf;

use clap::{value_parser, Args};
use rcs_files::capture::{write_patterns, PATTERNS_FILE};
use rcs_scan::patterns;

use super::arguments::size_px;
use super::Failure;

/// Writes the patterns of a scan: p000.png and so on, and patterns.yaml
///
/// White, black, and stripes in Gray code, each with its inverse. With a step, the finest stripes are twice as many
/// pixels wide and are shown shifted by each pixel instead: for cameras that cannot see finer ones.
#[derive(Debug, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate patterns --size 1280x800 --step 4 -o patterns")]
#[command(after_help = "\
Exit codes: 0 written; 1 not written; 2 invalid arguments")]
pub(super) struct PatternsArguments {
    /// Width and height of the projector's image, pixels
    #[arg(long, value_name = "WxH", value_parser = size_px)]
    size: [u32; 2],
    /// Pixels that share a code, 1 to 64
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u32).range(1..=64))]
    step: u32,
    /// The folder to write to; made if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs the command.
pub(super) fn run(arguments: &PatternsArguments) -> Result<(), Failure> {
    let PatternsArguments { size, step, output } = arguments;
    let patterns = patterns(*size, *step);
    write_patterns(output, *size, &patterns).map_err(Failure::refused)?;
    eprintln!("written: {} pictures and {}", patterns.len(), output.join(PATTERNS_FILE).display());
    Ok(())
}
