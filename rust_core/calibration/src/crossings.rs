//! Points where edges of coarse stripes cross: few, but known long before a scan is over.
//!
//! Of a pair of stripes and their inverse, the difference changes its sign at each edge, and the Gray code of the other
//! stripes says which edge it is. Where in a square of four camera pixels an edge of a column and one of a row are
//! seen, both differences are interpolated between the pixels, and the place where both vanish is the place of the
//! projector's corner.

use nalgebra::{Matrix2, Point2, Point3, Vector2};
use rayon::prelude::*;

use crate::decode::channels::{Channel, Channels};
use crate::decode::response::Response;
use crate::points::{inverse_depths, Window};
use crate::{DecodeError, Lens, Pictures, Sample};

/// White is so many levels brighter than black where something is looked at.
const LIT_LEVELS: u8 = 12;
/// Other stripes differ from their inverse by at least this share of white and black, on all four pixels.
const CLEAR: f32 = 0.3;
/// How far off a crossing is, roughly, projector pixels.
const SIGMA_PX: f64 = 0.5;
/// Inverse depths err by at least this, 1/m.
const LEAST_NOISE: f32 = 1e-4;
/// Steps of Newton's method.
const STEPS: usize = 4;

/// The crossings that are seen at points with a depth. `depth_m` is as for [`crate::points`]. Their deviations are
/// rough.
///
/// # Errors
/// [`DecodeError`]: pictures are missing.
///
/// Nothing is found where depth image, camera and pictures differ in size.
pub(crate) fn crossings(pictures: &Pictures<'_>, depth_m: &[f32], camera: &Lens) -> Result<Vec<Sample>, DecodeError> {
    let channels = Channels::new(pictures.patterns)?;
    let [width, height] = pictures.size_px.map(|side| side as usize);
    let count = width * height;
    if depth_m.len() != count || camera.size_px != pictures.size_px || pictures.levels.iter().any(|l| l.len() != count)
    {
        return Ok(Vec::new());
    }
    let response = Response::find(pictures, &channels);
    let seen = Seen { pictures, channels: &channels, response: &response, width };
    let inverse = inverse_depths(depth_m);
    let row = |y: usize| -> Vec<Sample> {
        let crossing = |x: usize| {
            let (at, pixel) = seen.crossing(x, y)?;
            let (near_x, near_y) = (at.x.round() as usize, at.y.round() as usize);
            let window = Window::new(&inverse, width, near_x, near_y)?;
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

/// The pictures in linear light.
struct Seen<'a> {
    pictures: &'a Pictures<'a>,
    channels: &'a Channels,
    response: &'a Response,
    width: usize,
}

/// An edge of a column or row: where it lies in the projector's picture, pixels, and the differences of its stripes at
/// the four camera pixels.
struct Edge {
    place_px: f64,
    differences: [f32; 4],
}

impl Seen<'_> {
    /// The crossing between the camera pixels from (x, y) to the next ones to the right and below: where it is in the
    /// camera's picture and in the projector's.
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

    /// The light of white less that of black at four pixels; none where one is hardly lit.
    fn contrast(&self, square: [usize; 4]) -> Option<[f32; 4]> {
        let (white, black) = (self.pictures.levels[self.channels.white], self.pictures.levels[self.channels.black]);
        let is_lit = |pixel: &usize| white[*pixel].saturating_sub(black[*pixel]) >= LIT_LEVELS;
        let contrast = |pixel: usize| self.response.light(white[pixel]) - self.response.light(black[pixel]);
        square.iter().all(is_lit).then(|| square.map(contrast))
    }

    /// The edge of an axis's stripes that runs between four pixels: one pair of stripes changes its sign there, all
    /// others are clear.
    fn edge(&self, axis: usize, square: [usize; 4], contrast: [f32; 4]) -> Option<Edge> {
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
        (high == low + 1).then_some(Edge { place_px, differences })
    }

    fn differences(&self, channel: &Channel, square: [usize; 4], contrast: [f32; 4]) -> [f32; 4] {
        let light = |picture: usize, pixel: usize| self.response.light(self.pictures.levels[picture][pixel]);
        std::array::from_fn(|i| (light(channel.lit, square[i]) - light(channel.inverse, square[i])) / contrast[i])
    }
}

/// What four values at the corners of a unit square are at a place between them, and the gradient there.
fn interpolated([a, b, c, d]: &[f32; 4], at: Vector2<f64>) -> (f64, Vector2<f64>) {
    let [a, b, c, d] = [a, b, c, d].map(|value| f64::from(*value));
    let (above, below) = (a + (b - a) * at.x, c + (d - c) * at.x);
    let along = (b - a) * (1.0 - at.y) + (d - c) * at.y;
    (above + (below - above) * at.y, Vector2::new(along, below - above))
}
