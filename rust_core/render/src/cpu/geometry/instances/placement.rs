//! How far a box reaches into the view: the first test of many small things.

use nalgebra::Matrix4;
use rcs_scene::{Aabb, InFrustum};

use crate::cpu::tile::screen::{Screen, SUBPIXELS};

/// Position of a box on the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::cpu) enum Placement {
    /// Nothing in it is seen.
    Unseen,
    /// All in it is in the view.
    Inside,
    /// Anything else.
    Crossing,
}

/// Far more than the share by which rounding changes a sum of four products.
const SLACK: f64 = 1e-5;

/// Snapping moves a vertex by half of a subpixel.
const SNAP_PX: f64 = 1.0 / SUBPIXELS as f64;

/// Places a box, given the rows of its matrix to clip coordinates. Errs towards `Crossing`.
pub(in crate::cpu) fn place_box(bounds: &Aabb, rows: &[[f32; 4]; 4], screen: &Screen) -> Placement {
    let clip = Matrix4::from_fn(|row, column| f64::from(rows[row][column]));
    match bounds.in_frustum(&clip, SLACK) {
        InFrustum::Outside => return Placement::Unseen,
        InFrustum::Crossing => return Placement::Crossing,
        InFrustum::Inside => {}
    }
    // Between which values each coordinate is.
    let range = |row: usize| bounds.range(&clip.row(row).into_owned(), SLACK);
    let [least_w, most_w] = range(3);
    if least_w.is_nan() || least_w <= 0.0 {
        return Placement::Crossing;
    }
    // The pixels whose centres may be among them: the first one and the one after the last.
    let pixels = |axis: usize, window: &dyn Fn(f32) -> f32| {
        let [low, high] = range(axis);
        let low = if low < 0.0 { low / least_w } else { low / most_w };
        let high = if high < 0.0 { high / most_w } else { high / least_w };
        let [a, b] = [low, high].map(|ndc| f64::from(window(ndc as f32)));
        let slack = (a.abs() + b.abs()) * SLACK + SNAP_PX;
        let (low, high) = (a.min(b) - slack - 0.5, a.max(b) + slack - 0.5);
        [low.ceil() as i32, high.floor() as i32 + 1]
    };
    let [columns, rows] = [pixels(0, &|x| screen.x(x)), pixels(1, &|y| screen.y(y))];
    if columns[0] >= columns[1] || rows[0] >= rows[1] {
        return Placement::Unseen;
    }
    Placement::Inside
}
