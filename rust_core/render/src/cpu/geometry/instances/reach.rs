//! How far a box reaches into the view: the first sieve of many small things.

use nalgebra::Matrix4;
use rcs_scene::{Aabb, InFrustum};

use crate::cpu::tile::screen::{Screen, SUBPIXELS};

/// Position of a box on the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::cpu) enum Placement {
    /// Nothing in it is seen.
    Unseen,
    /// All in it is in the view.
    Inside(Footprint),
    /// Anything else.
    Crossing,
}

/// A box in the view on the picture, or a little more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::cpu) struct Footprint {
    /// Its width and height in pixels, together.
    pub width_and_height_px: f32,
    /// Between which values w is.
    pub w: [f32; 2],
    /// How far a snapped place may be from the exact one, in pixels to each side.
    pub error_px: f32,
}

/// Far more than the share by which rounding changes a sum of four products.
const SLACK: f64 = 1e-5;

/// Such a share itself, with that of a quotient of two sums and of what is made of it.
const ROUNDING: f64 = 2e-6;

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
    let ([least_w, most_w], magnitudes) =
        (range(3), [0, 1, 3].map(|row| bounds.magnitude(&clip.row(row).into_owned())));
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
    let (half_width, half_height) = screen.half_size();
    let [x, y, w] = magnitudes;
    let rounding = ((x + w) * f64::from(half_width)).max((y + w) * f64::from(half_height)) / least_w;
    Placement::Inside(Footprint {
        width_and_height_px: (columns[1] - columns[0] + rows[1] - rows[0]) as f32,
        w: [least_w as f32, most_w as f32],
        error_px: (SNAP_PX + rounding * ROUNDING) as f32,
    })
}
