//! Finds a chessboard in a camera image: candidates (`response`), the grid among them (`grid`), and their exact places
//! (`subpixel`).
//!
//! A board may be cut off or covered in part: its grid needs no particular corner, since each pose has its own frame.

use nalgebra::Point2;

use super::grid::Grid;
use super::response::{candidates, Grey};
use super::subpixel::refined;
use super::{BoardCorner, BoardRefusal, Chessboard};

/// Minimum share of the board's corners.
const LEAST_SHARE: f64 = 0.5;
/// Radius of the first refinement, pixels.
const FIRST_RADIUS_PX: f64 = 3.0;
/// Radius of the last refinement as a share of the distance to the nearest corner, and its bounds, pixels.
const RADIUS_SHARE: f64 = 0.4;
const RADIUS_PX: [f64; 2] = [3.0, 12.0];

/// Finds the board's corners in an image: grey levels, row by row.
///
/// # Errors
/// [`BoardRefusal::NoBoard`]: less than half of it is seen. [`BoardRefusal::LargerGrid`]: another checkered surface is.
pub fn find_chessboard(grey: &[u8], size_px: [u32; 2], board: &Chessboard) -> Result<Vec<BoardCorner>, BoardRefusal> {
    let needed = (LEAST_SHARE * board.count() as f64).ceil() as usize;
    let refusal = |found| BoardRefusal::NoBoard { found, needed, board: board.corners };
    if grey.len() != size_px[0] as usize * size_px[1] as usize {
        return Err(refusal(0));
    }
    let grey = Grey::new(grey, size_px);
    let refine = |rough: Point2<f64>| refined(&grey, rough, FIRST_RADIUS_PX).unwrap_or(rough);
    let points: Vec<Point2<f64>> = candidates(&grey).into_iter().map(refine).collect();
    let grid = Grid::largest(&grey, &points, board.corners);
    let corners: Vec<BoardCorner> = (grid.places.iter())
        .filter_map(|(place, index)| {
            let radius_px = (RADIUS_SHARE * grid.spacing_px(&points, *place)).clamp(RADIUS_PX[0], RADIUS_PX[1]);
            let pixel = refined(&grey, points[*index], radius_px)?;
            Some(BoardCorner { place: *place, pixel, lit_by: None })
        })
        .collect();
    if corners.len() < needed && grid.larger > 0 {
        return Err(BoardRefusal::LargerGrid { corners: grid.larger, board: board.corners });
    }
    if corners.len() < needed {
        return Err(refusal(corners.len()));
    }
    Ok(corners)
}
