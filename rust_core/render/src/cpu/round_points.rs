//! `Style: Points`: round spots of a fixed size on the picture.
//!
//! A pixel belongs to the spot where its centre lies less than half the size from the point's place, so that a spot of
//! 1 px can miss every pixel centre. A point whose place is outside of the picture is not drawn at all, however far
//! its spot would reach inside.

use rcs_scene::PointStyle;

use super::band::{meet, Band};
use super::bins::Rows;
use super::points::{Block, Cloud, BLOCK};
use super::screen::Screen;

/// The largest spot, in pixels, as on Mesa's software rasteriser.
const LARGEST_PX: f32 = 255.0;

/// A spot.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoundPoint {
    x: f32,
    y: f32,
    depth: u32,
    color: [u8; 4],
    y0: u16,
    y1: u16,
}

impl Rows for RoundPoint {
    #[inline]
    fn rows(&self) -> (i32, i32) {
        (i32::from(self.y0), i32::from(self.y1))
    }
}

/// The spots' diameter in pixels; none where they cannot be seen.
fn diameter_px(cloud: &Cloud<'_>) -> Option<f32> {
    match cloud.points.style {
        PointStyle::Points { diameter_px } if diameter_px > 0.0 => Some(diameter_px.min(LARGEST_PX)),
        _ => None,
    }
}

/// The pixels, first and after the last, whose centres lie within `radius_px` of a window coordinate.
#[inline]
fn extent(center: f32, radius_px: f32) -> (i32, i32) {
    ((center - radius_px - 0.5).ceil() as i32, (center + radius_px - 0.5).floor() as i32 + 1)
}

/// The spots of the points in `range`, in their order, appended to `out`.
pub(super) fn project(
    cloud: &Cloud<'_>,
    screen: &Screen,
    range: std::ops::Range<usize>,
    block: &mut Block,
    out: &mut Vec<RoundPoint>,
) {
    let Some(diameter_px) = diameter_px(cloud) else { return };
    let radius_px = diameter_px * 0.5;
    let height = screen.height_px as i32;
    let positions = cloud.buffer().positions.get(range.clone()).unwrap_or(&[]);
    for (b, positions) in positions.chunks(BLOCK).enumerate() {
        block.project(cloud, screen, positions, 1.0);
        for i in 0..positions.len() {
            if !block.inside[i] {
                continue;
            }
            let (x, y) = (block.x[i], block.y[i]);
            let (y0, y1) = extent(y, radius_px);
            let (y0, y1) = (y0.max(0), y1.min(height));
            if y0 >= y1 {
                continue;
            }
            let Some(color) = cloud.color(range.start + b * BLOCK + i) else { continue };
            out.push(RoundPoint { x, y, depth: block.depth[i], color, y0: y0 as u16, y1: y1 as u16 });
        }
    }
}

/// Draws the rows of a band.
pub(super) fn draw(cloud: &Cloud<'_>, points: &[RoundPoint], band: &mut Band<'_>) {
    let Some(diameter_px) = diameter_px(cloud) else { return };
    let per_px = 1.0 / diameter_px;
    for point in points {
        let (x0, x1) = extent(point.x, diameter_px * 0.5);
        for y in band.rows(i32::from(point.y0), i32::from(point.y1)) {
            let dy = (y as f32 + 0.5 - point.y) * per_px;
            let (first, colors, depths) = band.span(y, x0, x1);
            for ((color, depth), x) in colors.iter_mut().zip(depths).zip(first..) {
                let dx = (x as f32 + 0.5 - point.x) * per_px;
                if dx * dx + dy * dy < 0.25 {
                    meet(color, depth, point.depth, point.color, cloud.mode);
                }
            }
        }
    }
}
