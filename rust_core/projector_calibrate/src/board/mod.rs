//! A printed chessboard in place of a depth camera: `print` draws it, `scan` takes its poses, `solve` calibrates with
//! them, and `poses` are the corners of all of them.

mod pdf;
mod poses;
mod print;
mod scan;
mod solve;

pub(super) use print::{run, BoardArguments};
pub(super) use scan::BoardScan;
pub(super) use solve::{solve_and_write, BoardOutputs};
