//! The plots of a report, one file each: what a person looks at to see why a calibration is good or not.

mod axes;
mod depth_coverage;
mod histogram;
mod places;
mod residual_map;

pub(super) use depth_coverage::depth_coverage;
pub(super) use histogram::histogram;
pub(super) use places::places;
pub(super) use residual_map::residual_map;

/// Text.
const INK: &str = "#1b2129";
/// Text of less weight, and axes.
const GREY: &str = "#5a6572";
/// Lines behind the data.
const GRID: &str = "stroke=\"#e2e6eb\" stroke-width=\"1\"";
/// From small to large errors.
const WARM: [[u8; 3]; 5] = [[255, 247, 236], [253, 212, 158], [252, 141, 89], [215, 48, 31], [127, 0, 0]];
/// From few to many points.
const COLD: [[u8; 3]; 5] = [[222, 235, 247], [158, 202, 225], [66, 146, 198], [8, 81, 156], [8, 48, 107]];
/// What tells scans apart; they repeat.
const SCANS: [&str; 6] = ["#1f77b4", "#e07b00", "#2a9d4b", "#9467bd", "#c2417c", "#7a5c3e"];
