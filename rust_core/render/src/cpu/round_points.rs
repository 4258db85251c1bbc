//! `Style: Points`: round spots of a fixed size on the picture.
//!
//! A pixel belongs to the spot where its centre lies less than half the size from the point's place, so that a spot of
//! 1 px can miss every pixel centre. A point whose place is outside of the picture is not drawn at all, however far
//! its spot would reach inside. A spot has one depth, that of its place.

use rcs_scene::{PointStyle, Points};
use wide::{f32x4, u32x4};

use super::band::{pack, Band, LANE, LANES};
use super::points::{Cloud, Gathered, PointRef, BLOCK};
use super::screen::{Screen, FARTHEST};

/// The largest spot, in pixels, as on Mesa's software rasteriser.
const LARGEST_PX: f32 = 255.0;

/// The spots' diameter in pixels; none where the cloud has another style.
pub(super) fn diameter_px(points: &Points) -> Option<f32> {
    match points.style {
        PointStyle::Points { diameter_px } => Some(if diameter_px > 0.0 { diameter_px.min(LARGEST_PX) } else { 0.0 }),
        _ => None,
    }
}

/// Projected points.
struct Block {
    x: [f32; BLOCK],
    y: [f32; BLOCK],
    depth: [f32; BLOCK],
    inside: [bool; BLOCK],
}

impl Block {
    #[inline(always)]
    fn project(&mut self, cloud: &Cloud<'_>, screen: &Screen, places: &[[f32; BLOCK]; 3]) {
        let [xs, ys, zs] = places;
        let m = &cloud.placement.clip_from_object;
        for i in 0..BLOCK {
            let row = |r: [f32; 4]| r[0] * xs[i] + r[1] * ys[i] + r[2] * zs[i] + r[3];
            let (x, y, z, w) = (row(m[0]), row(m[1]), row(m[2]), row(m[3]));
            let inverse_w = 1.0 / w;
            self.x[i] = screen.x(x * inverse_w);
            self.y[i] = screen.y(y * inverse_w);
            self.depth[i] = (z * inverse_w) * (0.5 * FARTHEST) + 0.5 * FARTHEST;
            self.inside[i] = (w > 0.0) & (z >= -w) & (z <= w) & (x.abs() <= w) & (y.abs() <= w);
        }
    }
}

/// Draws the rows of a band.
pub(super) fn draw(cloud: &Cloud<'_>, refs: &[PointRef], screen: &Screen, points: &mut Gathered, band: &mut Band<'_>) {
    let Some(diameter_px) = diameter_px(cloud.points).filter(|&diameter_px| diameter_px > 0.0) else { return };
    let mode = cloud.surface.mode;
    let (radius_px, per_px) = (diameter_px * 0.5, 1.0 / diameter_px);
    let mut block = Block { x: [0.0; BLOCK], y: [0.0; BLOCK], depth: [0.0; BLOCK], inside: [false; BLOCK] };
    for refs in refs.chunks(BLOCK) {
        points.gather(cloud, refs);
        block.project(cloud, screen, &points.places);
        for i in 0..points.len {
            if !block.inside[i] {
                continue;
            }
            let (x, y) = (block.x[i], block.y[i]);
            let columns = ceil(x - radius_px - 0.5).max(0)..ceil(x + radius_px + 0.5).min(band.width);
            let depths = f32x4::splat(block.depth[i]);
            let colors = u32x4::splat(pack(points.colors[i]));
            let rows = band.rows(ceil(y - radius_px - 0.5), ceil(y + radius_px + 0.5));
            for begin in columns.step_by(LANES) {
                let from = f32x4::splat(begin as f32 + 0.5 - x) + f32x4::new(LANE);
                let dx = from * f32x4::splat(per_px);
                let dx_squared = dx * dx;
                let mut from = rows.start as f32 + 0.5 - y;
                for window in band.windows(rows.clone(), begin) {
                    let dy = f32x4::splat(from * per_px);
                    let mask = (dx_squared + dy * dy).simd_lt(f32x4::splat(0.25));
                    window.meet(mask, depths, colors, mode);
                    from += 1.0;
                }
            }
        }
    }
}

/// The whole number not below a window coordinate.
#[inline(always)]
fn ceil(value: f32) -> i32 {
    let whole = value as i32;
    whole + i32::from(value > whole as f32)
}
