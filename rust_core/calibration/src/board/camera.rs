//! The camera's lens, unless its CameraInfo is known and fits, and the boards' poses in its frame.

use nalgebra::Isometry3;

use super::bundle::{Adjusted, Bundle, Rig};
use super::zhang::{first_lens, first_pose};
use super::{BoardCorner, BoardRefusal, Chessboard};
use crate::keystone::SQUARE_PIXELS;
use crate::statistics::root_mean_square;
use crate::Lens;

/// Maximum RMS error of a camera's corners: a share of the image's width.
const MOST_RMS: f64 = 0.002;
/// Maximum relative deviation of the focal length.
const MOST_FOCAL_SIGMA: f64 = 0.03;
/// A given lens fits if its RMS error is at most this multiple of that of a lens that is solved for, plus pixels.
const GIVEN_FITS: (f64, f64) = (2.0, 0.2);
/// Minimum poses for this comparison.
const COMPARED_POSES: usize = 3;

/// A camera with the poses of the boards before it.
pub(super) struct SolvedCamera {
    pub(super) rig: Rig,
    /// Standard deviations of the camera's lens parameters; 0 if they are given.
    pub(super) sigmas: [f64; 9],
    /// RMS error, pixels.
    pub(super) rms_px: f64,
}

/// Solves for a camera or checks a given one.
pub(super) fn solve_camera(
    views: &[&[BoardCorner]],
    board: Chessboard,
    size_px: [u32; 2],
    given: Option<&Lens>,
) -> Result<SolvedCamera, BoardRefusal> {
    let Some(given) = given else {
        let free = camera(views, board, &first_lens(views, size_px), true)?;
        free.check()?;
        free.check_squares()?;
        return Ok(free);
    };
    let known = camera(views, board, given, false)?;
    if views.len() >= COMPARED_POSES {
        // The corners may not determine a lens, which is no fault of the given one.
        let free = camera(views, board, &first_lens(views, size_px), true);
        let (factor, more_px) = GIVEN_FITS;
        if let Some(free) = free.ok().filter(|free| known.rms_px > factor * free.rms_px + more_px) {
            free.check_squares()?;
            return Err(BoardRefusal::WrongCameraInfo { given_px: known.rms_px, solved_px: free.rms_px });
        }
    }
    known.check()?;
    Ok(known)
}

/// Poses of boards before a camera, whose lens is solved for from a first one, or known.
pub(super) fn camera(
    views: &[&[BoardCorner]],
    board: Chessboard,
    lens: &Lens,
    is_free: bool,
) -> Result<SolvedCamera, BoardRefusal> {
    let inconsistent = BoardRefusal::CameraInconsistent { rms_px: f64::INFINITY };
    let first = |corners: &&[BoardCorner]| first_pose(corners, lens, board.square_m);
    let boards = views.iter().map(first).collect::<Option<Vec<_>>>().ok_or(inconsistent.clone())?;
    let bundle = Bundle { board, views: views.to_vec(), is_camera_free: is_free, projector_terms: Vec::new() };
    let adjusted = bundle.adjusted(Rig { camera: *lens, projector: None, boards });
    let Adjusted { rig, camera_sigmas } = adjusted.ok_or(inconsistent)?;
    let rms_px = root_mean_square((0..views.len()).map(|view| bundle.camera_rms_px(&rig, view)));
    Ok(SolvedCamera { rig, sigmas: camera_sigmas, rms_px })
}

/// Pose `camera_from_board` of a board before a camera with a known lens; `None` if the corners do not tell.
pub fn board_pose(corners: &[BoardCorner], board: Chessboard, lens: &Lens) -> Option<Isometry3<f64>> {
    camera(&[corners], board, lens, false).ok()?.rig.boards.first().copied()
}

impl SolvedCamera {
    /// Refuses a lens that was solved for and has no square pixels: it is the board's squares that are not square.
    fn check_squares(&self) -> Result<(), BoardRefusal> {
        let focal_px = self.rig.camera.focal_px;
        let differ = (focal_px.x / focal_px.y - 1.0).abs();
        if differ > SQUARE_PIXELS {
            return Err(BoardRefusal::NotSquare { percent: 100.0 * differ });
        }
        Ok(())
    }

    /// Refuses an uncertain lens and one that does not fit.
    fn check(&self) -> Result<(), BoardRefusal> {
        let lens = &self.rig.camera;
        if self.rms_px.is_nan() || self.rms_px > MOST_RMS * f64::from(lens.size_px[0].max(lens.size_px[1])) {
            return Err(BoardRefusal::CameraInconsistent { rms_px: self.rms_px });
        }
        let uncertain = (self.sigmas[0] / lens.focal_px.x).max(self.sigmas[1] / lens.focal_px.y);
        if uncertain > MOST_FOCAL_SIGMA {
            return Err(BoardRefusal::CameraUndetermined { percent: 100.0 * uncertain });
        }
        Ok(())
    }
}
