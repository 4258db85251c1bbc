//! Plots of a report, one file each.

mod axes;
mod depth_coverage;
mod histogram;
mod places;
mod residual_map;

pub(super) use depth_coverage::depth_coverage;
pub(super) use histogram::histogram;
pub(super) use places::places;
pub(super) use residual_map::residual_map;

/// Text colour.
const INK: &str = "#1b2129";
/// Colour of secondary text and axes.
const GREY: &str = "#5a6572";
/// Style of grid lines.
const GRID: &str = "stroke=\"#e2e6eb\" stroke-width=\"1\"";
/// Colour map of errors.
const WARM: [[u8; 3]; 5] = [[255, 247, 236], [253, 212, 158], [252, 141, 89], [215, 48, 31], [127, 0, 0]];
/// Colour map of point counts.
const COLD: [[u8; 3]; 5] = [[222, 235, 247], [158, 202, 225], [66, 146, 198], [8, 81, 156], [8, 48, 107]];
/// Colours of scans, repeated.
const SCANS: [&str; 6] = ["#1f77b4", "#e07b00", "#2a9d4b", "#9467bd", "#c2417c", "#7a5c3e"];
