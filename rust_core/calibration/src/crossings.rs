//! Samples at the crossings of coarse stripes' edges: few, but available early in a scan.
//!
//! The difference of stripes and their inverse changes its sign at each edge, and the other stripes' Gray code
//! identifies the edge. Where a column's and a row's edge both pass between four camera pixels, both differences are
//! interpolated, and the place where both vanish sees the corner between the projector pixels.

use nalgebra::{Matrix2, Point2, Point3, Vector2};
use rayon::prelude::*;

use crate::decode::channels::{Channels, StripeChannel};
use crate::decode::response::Response;
use crate::points::{inverse_depths, DepthWindow};
use crate::{DecodeError, Images, Lens, Sample};

/// Minimum difference of white and black, levels.
const LIT_LEVELS: u8 = 12;
/// Minimum contrast of the other stripes at all four pixels, as a share of white minus black.
const CLEAR: f32 = 0.3;
/// Rough deviation of a crossing, projector pixels.
const SIGMA_PX: f64 = 0.5;
/// Minimum noise of inverse depths, 1/m.
const LEAST_NOISE: f32 = 1e-4;
/// Steps of Newton's method.
const STEPS: usize = 4;

/// Crossings at points with a depth, with rough deviations; `depth_m` as for [`crate::points`]. Empty if depth image,
/// camera and images differ in size.
///
/// # Errors
/// [`DecodeError`]: images are missing.
pub(crate) fn crossings(images: &Images<'_>, depth_m: &[f32], camera: &Lens) -> Result<Vec<Sample>, DecodeError> {
    let channels = Channels::new(images.patterns)?;
    let [width, height] = images.size_px.map(|side| side as usize);
    let count = width * height;
    if depth_m.len() != count || camera.size_px != images.size_px || images.levels.iter().any(|l| l.len() != count) {
        return Ok(Vec::new());
    }
    let response = Response::find(images, &channels);
    let finder = CrossingFinder { images, channels: &channels, response: &response, width };
    let inverse = inverse_depths(depth_m);
    let row = |y: usize| -> Vec<Sample> {
        let crossing = |x: usize| {
            let (at, pixel) = finder.crossing(x, y)?;
            let (near_x, near_y) = (at.x.round() as usize, at.y.round() as usize);
            let window = DepthWindow::new(&inverse, width, near_x, near_y)?;
            let off = [at.x - near_x as f64, at.y - near_y as f64];
            let inverse =
                f64::from(window.inverse) + f64::from(window.by_px[0]) * off[0] + f64::from(window.by_px[1]) * off[1];
            let depth_m = 1.0 / inverse;
            Some(Sample {
                pixel,
                point: Point3::from(camera.ray(at)? * depth_m),
                scan: 0,
                sigma_px: SIGMA_PX,
                sigma_m: window.sigma_m(LEAST_NOISE, depth_m),
            })
        };
        (0..width.saturating_sub(1)).filter_map(crossing).collect()
    };
    Ok((0..height.saturating_sub(1)).into_par_iter().flat_map_iter(row).collect())
}

/// Images in linear light, searched for crossings.
struct CrossingFinder<'a> {
    images: &'a Images<'a>,
    channels: &'a Channels,
    response: &'a Response,
    width: usize,
}

/// Stripe edge between four camera pixels.
struct StripeEdge {
    /// Column or row of the edge in the projector's image, pixels.
    place_px: f64,
    /// Normalised differences of stripes and inverse at the four pixels.
    differences: [f32; 4],
}

impl CrossingFinder<'_> {
    /// Crossing between the camera pixels (x, y) and (x + 1, y + 1), in camera and in projector pixels.
    fn crossing(&self, x: usize, y: usize) -> Option<(Point2<f64>, Point2<f64>)> {
        let first = y * self.width + x;
        let square = [first, first + 1, first + self.width, first + self.width + 1];
        let contrast = self.contrast(square)?;
        let edges = [self.edge(0, square, contrast)?, self.edge(1, square, contrast)?];
        let mut at = Vector2::repeat(0.5);
        for _ in 0..STEPS {
            let [one, other] = edges.each_ref().map(|edge| interpolated(&edge.differences, at));
            let slopes = Matrix2::new(one.1.x, one.1.y, other.1.x, other.1.y);
            at -= slopes.try_inverse()? * Vector2::new(one.0, other.0);
        }
        let is_inside = at.iter().all(|share| (0.0..1.0).contains(share));
        let camera = Point2::new(x as f64 + at.x, y as f64 + at.y);
        is_inside.then(|| (camera, Point2::new(edges[0].place_px, edges[1].place_px)))
    }

    /// White minus black at four pixels, in linear light; `None` if one is hardly lit.
    fn contrast(&self, square: [usize; 4]) -> Option<[f32; 4]> {
        let (white, black) = (self.images.levels[self.channels.white], self.images.levels[self.channels.black]);
        let is_lit = |pixel: &usize| white[*pixel].saturating_sub(black[*pixel]) >= LIT_LEVELS;
        let contrast = |pixel: usize| self.response.light(white[pixel]) - self.response.light(black[pixel]);
        square.iter().all(is_lit).then(|| square.map(contrast))
    }

    /// Edge of an axis's stripes between four pixels: exactly one pair changes its sign, all others are clear.
    fn edge(&self, axis: usize, square: [usize; 4], contrast: [f32; 4]) -> Option<StripeEdge> {
        let axis = &self.channels.axes[axis];
        let code_bits = &axis.all[..axis.code_bits];
        let mut found = None;
        let mut codes = [0_u32; 2];
        for channel in code_bits {
            let differences = self.differences(channel, square, contrast);
            let lit = differences.iter().filter(|difference| **difference > 0.0).count();
            let bits = if (1..4).contains(&lit) {
                if found.replace(differences).is_some() {
                    return None;
                }
                [0, 1]
            } else if differences.iter().all(|difference| difference.abs() > CLEAR) {
                [u32::from(lit == 4); 2]
            } else {
                return None;
            };
            // From the Gray code's bits to the code, on both sides of the edge.
            codes = [0, 1].map(|side| 2 * codes[side] + ((codes[side] & 1) ^ bits[side]));
        }
        let stripes = &code_bits.first()?.stripes;
        let width_px = f64::from(stripes.step) * 2.0_f64.powi((stripes.bits as i32) - (axis.code_bits as i32));
        let differences = found?;
        let [low, high] = [codes[0].min(codes[1]), codes[0].max(codes[1])];
        // An integer is a pixel's centre, and an edge lies between two.
        let place_px = f64::from(high) * width_px - f64::from(stripes.offset) - 0.5;
        (high == low + 1).then_some(StripeEdge { place_px, differences })
    }

    fn differences(&self, channel: &StripeChannel, square: [usize; 4], contrast: [f32; 4]) -> [f32; 4] {
        let light = |image: usize, pixel: usize| self.response.light(self.images.levels[image][pixel]);
        std::array::from_fn(|i| (light(channel.lit, square[i]) - light(channel.inverse, square[i])) / contrast[i])
    }
}

/// Bilinear interpolation of the corners of a unit square, with its gradient.
fn interpolated([a, b, c, d]: &[f32; 4], at: Vector2<f64>) -> (f64, Vector2<f64>) {
    let [a, b, c, d] = [a, b, c, d].map(|value| f64::from(*value));
    let (above, below) = (a + (b - a) * at.x, c + (d - c) * at.x);
    let along = (b - a) * (1.0 - at.y) + (d - c) * at.y;
    (above + (below - above) * at.y, Vector2::new(along, below - above))
}
