//! Calibration of a projector and a camera without depth, by a printed chessboard (Moreno and Taubin, "Simple,
//! accurate, and robust projector-camera calibration", 2012).
//!
//! Camera and projector are rigid, the board moves. `detect` finds the board's corners in the image of each pose, and
//! `lit` the projector's pixel of each corner by the decoded pixels around it. `camera` solves for the camera's lens
//! and the boards' poses in its frame (`zhang` starts, `bundle` adjusts), which makes the corners points of one scan in
//! space; from there on everything is [`crate::solve`]: lens and pose of the projector, refusals and report. Then
//! `bundle` adjusts all of it together, since the projector's pixels tell the boards' poses, too.

mod bundle;
mod camera;
mod detect;
mod grid;
mod guide;
mod homography;
mod lit;
mod response;
mod solve;
mod subpixel;
#[cfg(test)]
mod tests;
mod zhang;

pub use camera::board_pose;
pub use detect::find_chessboard;
pub use guide::{advice, BoardAdvice};
pub use lit::lit_corners;
pub use solve::{solve_boards, BoardSolution, BoardSolveOptions};

use nalgebra::{Isometry3, Point2, Point3};

use crate::Refusal;

/// Minimum number of poses that determine a camera's and a projector's lens.
pub const LEAST_POSES: usize = 3;

/// A printed chessboard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chessboard {
    /// Number of inner corners, where four squares meet, along both sides.
    pub corners: [u32; 2],
    /// Length of a square's side, metres.
    pub square_m: f64,
}

impl Chessboard {
    /// Number of inner corners.
    pub const fn count(&self) -> usize {
        self.corners[0] as usize * self.corners[1] as usize
    }
}

/// An inner corner of the board in a camera image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardCorner {
    /// Column and row on the board, from any of its corners: the board's own frame is not of interest.
    pub place: [i32; 2],
    /// Pixel in the camera's image.
    pub pixel: Point2<f64>,
    /// Projector pixel that lights it.
    pub lit_by: Option<LitPixel>,
}

/// Projector pixel with its deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LitPixel {
    /// Projector pixel.
    pub pixel: Point2<f64>,
    /// Standard deviation of each coordinate, pixels.
    pub sigma_px: f64,
}

impl BoardCorner {
    /// Point in the board's frame: x along columns, y along rows, z away from the camera; metres.
    pub(crate) fn point(&self, square_m: f64) -> Point3<f64> {
        Point3::new(f64::from(self.place[0]) * square_m, f64::from(self.place[1]) * square_m, 0.0)
    }
}

/// The board in one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardView {
    /// Name in messages, such as that of its folder.
    pub name: String,
    /// The corners that were found.
    pub corners: Vec<BoardCorner>,
}

/// Pose of the board, with its errors.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardPose {
    /// Name of the view.
    pub name: String,
    /// Pose, from the board's frame to the camera's optical frame.
    pub camera_from_board: Isometry3<f64>,
    /// RMS reprojection error in the camera's image, pixels.
    pub camera_rms_px: f64,
    /// RMS reprojection error in the projector's image, pixels.
    pub projector_rms_px: f64,
    /// RMS error in the projector's image of a calibration without this pose, pixels. `None` if the other poses do not
    /// suffice for one.
    pub left_out_px: Option<f64>,
}

/// Reason why board poses do not allow a calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BoardRefusal {
    /// No board in a camera image.
    #[error(
        "{found} of {needed} corners of a board with {}x{} inner corners are seen: light all of it, keep hands off the \
         squares, avoid reflections, and check --board",
        board[0], board[1]
    )]
    NoBoard {
        /// Number of corners of the largest grid.
        found: usize,
        /// Minimum number.
        needed: usize,
        /// Inner corners.
        board: [u32; 2],
    },
    /// A larger grid than the board's, such as a tiled floor, and no board.
    #[error(
        "a checkered surface with {corners} inner corners is seen, more than a board with {}x{} has: cover it, and check \
         --board",
        board[0], board[1]
    )]
    LargerGrid {
        /// Number of corners of the grid.
        corners: usize,
        /// Inner corners of the board.
        board: [u32; 2],
    },
    /// Too few corners whose projector pixel is known, of the view with this name.
    #[error(
        "{name}: the projector's pixel is known at {corners} corners only: let the projector light the whole board"
    )]
    Unlit {
        /// Name of the view.
        name: String,
        /// Number of corners.
        corners: usize,
    },
    /// Too few poses.
    #[error("{poses} poses of the board are too few: at least {LEAST_POSES} are needed, five are better")]
    TooFew {
        /// Number of poses.
        poses: usize,
    },
    /// The poses do not determine the camera's lens.
    #[error(
        "the poses do not determine the camera's lens: its focal length is uncertain by {percent:.1} %; tilt the board by \
         30 degrees to each side"
    )]
    CameraUndetermined {
        /// Standard deviation of the focal length, percent.
        percent: f64,
    },
    /// The camera's focal lengths differ.
    #[error(
        "by this board, the camera's fx and fy differ by {percent:.1} %, but a camera's pixels are square: measure the \
         squares along both sides, and print the board at 100 %; a camera whose pixels are not square needs a \
         CameraInfo"
    )]
    NotSquare {
        /// Difference, percent.
        percent: f64,
    },
    /// No camera fits the corners.
    #[error(
        "the corners do not fit a camera's lens, the RMS error is {rms_px:.2} px: use a flat board, keep it at rest, and \
         keep the camera's focus and zoom fixed"
    )]
    CameraInconsistent {
        /// RMS error, pixels.
        rms_px: f64,
    },
    /// The given camera lens is another one's.
    #[error(
        "the camera's CameraInfo does not fit: the board's corners are {given_px:.2} px off with it and {solved_px:.2} px \
         with a lens that is solved for; calibrate the camera, or ignore its CameraInfo with --solve-camera"
    )]
    WrongCameraInfo {
        /// RMS error with the given lens, pixels.
        given_px: f64,
        /// RMS error with a lens that is solved for, pixels.
        solved_px: f64,
    },
    /// The projector cannot be solved for.
    #[error(transparent)]
    Projector(#[from] Refusal),
}
