//! How far a box reaches into the view: the first sieve of many small things.

use nalgebra::Vector3;

use super::super::screen::{Screen, FARTHEST, SUBPIXELS};

/// A box: its middle and half its size.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShapeBounds {
    middle: Vector3<f32>,
    half: Vector3<f32>,
}

impl ShapeBounds {
    /// From its lowest to its highest corner.
    pub(super) fn new(low: Vector3<f32>, high: Vector3<f32>) -> Self {
        Self { middle: (low + high) * 0.5, half: (high - low) * 0.5 }
    }
}

/// What a box may be on the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reach {
    /// Nothing in it is seen.
    Unseen,
    /// All in it is in the view.
    Inside(Footprint),
    /// Anything else.
    Crossing,
}

/// Where a box in the view is on the picture, or a little more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footprint {
    /// The first column of pixels and the one after the last.
    pub columns: [i32; 2],
    /// The same of rows.
    pub rows: [i32; 2],
    /// Not more than the depth of any fragment of a solid in the box, see [`FARTHEST`].
    pub least_depth: f32,
    /// Between which values w is.
    pub w: [f32; 2],
    /// How far a snapped place may be from the exact one, in pixels to each side.
    pub error_px: f32,
}

impl Footprint {
    /// Its width and height in pixels, together.
    pub(super) fn width_and_height_px(&self) -> f32 {
        [self.columns, self.rows].iter().map(|[first, after]| (after - first) as f32).sum()
    }

    /// Whether it is as small as the least depth holds for, and as a crowd's solids are.
    pub(super) fn is_small(&self) -> bool {
        const MAX_PX: i32 = 64;
        [self.columns, self.rows].iter().all(|[first, after]| after - first <= MAX_PX)
    }
}

/// The least depth of a solid's fragments, given that of its box and the greatest.
///
/// Depths are interpolated with rounded slopes. Those of a sliver of no width to speak of may miss its corners' depths,
/// by no more than a few times their range where it is some dozen pixels long.
fn least_depth([near, far]: [f32; 2]) -> f32 {
    const STEPS: f32 = 16.0;
    const RANGES: f32 = 4.0;
    (near - (far - near) * RANGES - STEPS).max(0.0)
}

/// How far a box reaches into the view. Errs towards `Crossing`.
pub(super) fn reach(bounds: &ShapeBounds, rows: &[[f32; 4]; 4], screen: &Screen) -> Reach {
    // Far more than what rounding does to a sum of four products.
    const SLACK: f32 = 1e-5;
    // What it does to such a sum, to its quotient with another one, and to what is made of that.
    const ROUNDING: f32 = 2e-6;
    // Snapping moves a vertex by half of a subpixel.
    const SNAP_PX: f32 = 1.0 / SUBPIXELS as f32;
    let (middle, half) = (bounds.middle, bounds.half);
    let dot = |[a, b, c, d]: [f32; 4]| a * middle.x + b * middle.y + c * middle.z + d;
    let extent = |[a, b, c, _]: [f32; 4]| a.abs() * half.x + b.abs() * half.y + c.abs() * half.z;
    let size = |row: [f32; 4]| {
        let [a, b, c, d] = row.map(f32::abs);
        a * middle.x.abs() + b * middle.y.abs() + c * middle.z.abs() + d + extent(row)
    };
    let w = rows[3];
    let w_slack = size(w) * SLACK;
    let mut is_inside = true;
    for axis in [rows[0], rows[1], rows[2]] {
        let slack = size(axis) * SLACK + w_slack;
        for sign in [1.0, -1.0] {
            let plane = [0, 1, 2, 3].map(|i| w[i] + sign * axis[i]);
            let (at, extent) = (dot(plane), extent(plane) + slack);
            if at < -extent {
                return Reach::Unseen;
            }
            is_inside &= at > extent;
        }
    }
    let (at_w, w_extent) = (dot(w), extent(w) + w_slack);
    let (least_w, most_w) = (at_w - w_extent, at_w + w_extent);
    if !is_inside || least_w <= 0.0 || most_w.is_nan() {
        return Reach::Crossing;
    }
    // Between which coordinates it lies.
    let between = |axis: [f32; 4]| {
        let (at, extent) = (dot(axis), extent(axis) + size(axis) * SLACK);
        let [low, high] = [at - extent, at + extent];
        let low = if low < 0.0 { low / least_w } else { low / most_w };
        let high = if high < 0.0 { high / most_w } else { high / least_w };
        [low, high]
    };
    // The pixels whose centres may be among them.
    let pixels = |axis: [f32; 4], window: &dyn Fn(f32) -> f32| {
        let [a, b] = between(axis).map(window);
        let slack = (a.abs() + b.abs()) * SLACK + SNAP_PX;
        let (low, high) = (a.min(b) - slack - 0.5, a.max(b) + slack - 0.5);
        [low.ceil() as i32, high.floor() as i32 + 1]
    };
    let columns = pixels(rows[0], &|x| screen.x(x));
    let rows_of_pixels = pixels(rows[1], &|y| screen.y(y));
    if columns[0] >= columns[1] || rows_of_pixels[0] >= rows_of_pixels[1] {
        return Reach::Unseen;
    }
    // Depth is z over w, which grow together: how far the middle's share of w leaves z in the box.
    let share = dot(rows[2]) / at_w;
    let rest = [0, 1, 2, 3].map(|i| rows[2][i] - share * w[i]);
    let reach = (extent(rest) + (size(rows[2]) + size(w)) * SLACK) / least_w;
    let depths = [share - reach, share + reach].map(|depth| (depth * 0.5 + 0.5) * FARTHEST);
    let (half_width, half_height) = screen.half_size();
    let rounding = ((size(rows[0]) + size(w)) * half_width).max((size(rows[1]) + size(w)) * half_height) / least_w;
    Reach::Inside(Footprint {
        columns,
        rows: rows_of_pixels,
        least_depth: least_depth(depths),
        w: [least_w, most_w],
        error_px: SNAP_PX + rounding * ROUNDING,
    })
}
