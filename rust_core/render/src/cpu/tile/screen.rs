//! The image's pixels in window coordinates, and the way there from an object's frame.
//!
//! Window coordinates are pixels, x to the right and y down, (0, 0) the upper left corner of the upper left pixel, so
//! that row 0 is the image's top. Places are snapped to 1/256 pixel before anything is decided about coverage, as
//! Mesa's rasteriser does; a snapped place is measured from the centre of the first pixel, so that pixel (i, j) is
//! covered where (256 i, 256 j) is. Depth is 0 at the near plane and [`FARTHEST`] at the far one; the nearer *or equal*
//! wins.

use fearless_simd::Level;
use nalgebra::{Matrix3, Matrix4, Vector3};
use rcs_scene::{Camera, DirectionalLight};
use wide::{f32x4, i32x4};

use super::lanes::LANES;
use crate::shading::{normalizes_normals, to_light, view_from_normal};

/// Snapped places to a pixel.
pub(in crate::cpu) const SUBPIXELS: i32 = 256;

/// The depth of the far plane, which the image is cleared to.
///
/// Depths are kept as `f32`. From half of this depth on, which is 2 cm before a camera that sees from 1 cm to 100 m, an
/// `f32` has no fraction, so that depths are rounded to whole steps just as in a depth buffer of 24 bits.
pub(in crate::cpu) const FARTHEST: f32 = crate::depths::FARTHEST;

/// Side of a tile in pixels: a window's.
pub(in crate::cpu) const TILE_PX: i32 = LANES as i32;

/// Pixels from left to before right and from top to before bottom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::cpu) struct Area {
    /// The first column.
    pub left: i32,
    /// The column after the last.
    pub right: i32,
    /// The first row.
    pub top: i32,
    /// The row after the last.
    pub bottom: i32,
}

impl Area {
    /// True if it has no pixels.
    #[inline(always)]
    pub(in crate::cpu) fn is_empty(&self) -> bool {
        self.left >= self.right || self.top >= self.bottom
    }

    /// The least area with the columns and rows of both.
    #[inline(always)]
    pub(in crate::cpu) fn around(&self, other: &Self) -> Self {
        Self {
            left: self.left.min(other.left),
            right: self.right.max(other.right),
            top: self.top.min(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }
}

/// The depths of a face's fragments: `at` at pixel (x, y) and its change to the right and down; each may be off by
/// `noise`.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct DepthPlane {
    /// The depth at the place.
    pub at: f32,
    pub dx: f32,
    pub dy: f32,
    pub x: f32,
    pub y: f32,
    pub noise: f32,
    /// No fragment is nearer than this, wherever the plane leads outside of the face; may be infinitely negative.
    pub least: f32,
}

impl DepthPlane {
    /// One depth everywhere.
    pub(in crate::cpu) fn level(at: f32) -> Self {
        Self { at, dx: 0.0, dy: 0.0, x: 0.0, y: 0.0, noise: 0.0, least: at }
    }

    /// At a place, exactly.
    pub(in crate::cpu) fn value(&self, x: f64, y: f64) -> f64 {
        f64::from(self.at) + f64::from(self.dx) * (x - f64::from(self.x)) + f64::from(self.dy) * (y - f64::from(self.y))
    }
}

/// The most that a sum or product of at most this magnitude is rounded by.
#[inline(always)]
pub(in crate::cpu) fn rounding(magnitude: f32) -> f32 {
    // Half of the place value of the last of 24 bits.
    const HALF_LAST_BIT: f32 = 1.0 / (1 << 24) as f32;
    f32::from_bits(magnitude.abs().to_bits() & 0x7f80_0000) * HALF_LAST_BIT
}

/// Size of the image and how it is cut into bands of rows.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Screen {
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    band_rows: u32,
    /// The instruction set that loops over points and pixels use.
    pub simd_level: Level,
    half_width: f32,
    half_height: f32,
}

impl Screen {
    /// An image of this size for a number of workers. How it is cut into bands changes none of its pixels.
    ///
    /// One band's colours and depths stay in a core's cache; what lies across several bands is looked at in each, so
    /// that high ones are better as long as there are two for each worker. Of few bands there is an even number of the
    /// same height: else one of two workers waits while the other one draws a last one.
    pub(in crate::cpu) fn new(width_px: u32, height_px: u32, workers: usize) -> Self {
        const BAND_PX: u32 = 40_960;
        const FEW: u32 = 12;
        let low = 1 << (BAND_PX / width_px.max(1)).clamp(4, 64).ilog2();
        let (high, workers) = (2 * low, u32::try_from(workers).unwrap_or(u32::MAX));
        let bands_of = |rows: u32| height_px.div_ceil(rows);
        let bands = bands_of(low).min(workers.saturating_mul(2)).max(bands_of(high));
        let as_high = [high, low].into_iter().find(|rows| bands > FEW && bands_of(*rows) == bands);
        let band_rows = as_high.unwrap_or_else(|| height_px.div_ceil(bands.next_multiple_of(2).max(2)));
        Self {
            width_px,
            height_px,
            band_rows: band_rows.max(1),
            simd_level: Level::new(),
            half_width: width_px as f32 * 0.5,
            half_height: height_px as f32 * 0.5,
        }
    }

    /// Rows of a band; the last one may have fewer.
    pub(in crate::cpu) fn band_rows(&self) -> usize {
        self.band_rows as usize
    }

    /// The number of bands.
    pub(in crate::cpu) fn bands(&self) -> usize {
        (self.height_px as usize).div_ceil(self.band_rows())
    }

    /// Window x of a clip x that is already divided by w.
    #[inline]
    pub(in crate::cpu) fn x(&self, ndc: f32) -> f32 {
        ndc * self.half_width + self.half_width
    }

    /// Window y of a clip y that is already divided by w.
    #[inline]
    pub(in crate::cpu) fn y(&self, ndc: f32) -> f32 {
        self.half_height - ndc * self.half_height
    }

    /// Window x and y, and depth from 0 to 1, of clip coordinates that are already divided by w; the last lane has no
    /// meaning.
    #[inline]
    pub(in crate::cpu) fn window(&self, ndc: f32x4) -> f32x4 {
        ndc * f32x4::new([self.half_width, -self.half_height, 0.5, 0.0])
            + f32x4::new([self.half_width, self.half_height, 0.5, 0.0])
    }

    /// Half of the image's width and height in pixels.
    #[inline]
    pub(in crate::cpu) fn half_size(&self) -> (f32, f32) {
        (self.half_width, self.half_height)
    }
}

/// A window coordinate in 1/256 pixel from the first pixel's centre, to the nearest. Kept within ±2^24.
#[inline]
pub(in crate::cpu) fn snap(window: f32) -> i32 {
    snap_lanes(f32x4::splat(window)).to_array()[0]
}

/// Window coordinates in 1/256 pixel from the first pixel's centre, to the nearest. Kept within ±2^24.
#[inline]
pub(in crate::cpu) fn snap_lanes(window: f32x4) -> i32x4 {
    let limit = f32x4::splat((1 << 24) as f32);
    let scaled = (window - f32x4::splat(0.5)) * f32x4::splat(SUBPIXELS as f32);
    let half = f32x4::splat(0.5) | (scaled & f32x4::splat(-0.0));
    // A half away from zero before the fraction is cut off. NaN ends at a limit.
    (scaled + half).fast_min(limit).fast_max(-limit).fast_trunc_int()
}

/// The first pixel whose centre is not before a snapped place.
#[inline]
pub(in crate::cpu) fn first_pixel(snapped: i32) -> i32 {
    (snapped + SUBPIXELS - 1) >> SUBPIXELS.ilog2()
}

/// A vertex's position on the image.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cpu) struct ScreenPosition {
    /// Snapped window coordinates.
    pub x: i32,
    pub y: i32,
    /// 0 to [`FARTHEST`].
    pub depth: f32,
    /// One over the clip coordinate.
    pub inverse_w: f32,
}

impl ScreenPosition {
    /// The position of clip coordinates in front of the near plane.
    #[inline]
    pub(in crate::cpu) fn new(position: [f32; 4], screen: &Screen) -> Self {
        let inverse_w = 1.0 / position[3];
        // Window x and y, and the depth from 0 to 1.
        let window = screen.window(f32x4::new(position) * f32x4::splat(inverse_w));
        let [x, y, ..] = snap_lanes(window).to_array();
        let [_, _, depth, _] = window.to_array();
        Self { x, y, depth: depth * FARTHEST, inverse_w }
    }
}

/// How an object's positions and normals come to the image.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct ObjectTransform {
    /// Rows of the matrix from the object's frame to clip coordinates.
    pub clip_from_object: [[f32; 4]; 4],
    /// From the object's normals to the view frame; see [`view_from_normal`].
    pub view_from_normal: Matrix3<f32>,
    /// Normals are brought to unit length; see [`normalizes_normals`].
    pub normalizes: bool,
    /// Unit vector to the light in the view frame, if there is light.
    pub to_light: Option<Vector3<f32>>,
}

impl ObjectTransform {
    /// From an object's matrix to the view frame, in `f64` so that far-away frames keep their precision.
    pub(in crate::cpu) fn new(
        camera: &Camera,
        view_from_object: &Matrix4<f64>,
        light: Option<&DirectionalLight>,
    ) -> Self {
        Self {
            clip_from_object: Self::clip_rows(camera, view_from_object),
            view_from_normal: view_from_normal(view_from_object),
            normalizes: normalizes_normals(&view_from_object.fixed_view::<3, 3>(0, 0).into_owned()),
            to_light: to_light(camera, light),
        }
    }

    /// Rows of the matrix from an object's frame to clip coordinates.
    pub(in crate::cpu) fn clip_rows(camera: &Camera, view_from_object: &Matrix4<f64>) -> [[f32; 4]; 4] {
        let clip: Matrix4<f32> = (camera.clip_from_view() * view_from_object).cast();
        [0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| clip[(r, c)]))
    }

    /// Clip coordinates of a position in the object's frame.
    #[inline]
    pub(in crate::cpu) fn clip(&self, [x, y, z]: [f32; 3]) -> [f32; 4] {
        let row = |r: &[f32; 4]| r[0] * x + r[1] * y + r[2] * z + r[3];
        let [a, b, c, d] = &self.clip_from_object;
        [row(a), row(b), row(c), row(d)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_snap_to_the_pixel_raster() {
        let limit = 1 << 24;
        let snap = |window| snap_lanes(f32x4::new(window)).to_array();
        assert_eq!(snap([0.5, 3.5, f32::INFINITY, -1e30]), [0, 3 * SUBPIXELS, limit, -limit]);
        // Halves go away from zero.
        assert_eq!(snap([0.5 + 1.5 / 256.0, 0.5 - 1.5 / 256.0, 0.5 + 1.4 / 256.0, 0.5]), [2, -2, 1, 0]);
        assert!(snap([f32::NAN; 4]).iter().all(|place| place.abs() == limit));
        assert_eq!((first_pixel(0), first_pixel(1), first_pixel(-255), first_pixel(-256)), (0, 1, 0, -1));
    }

    #[test]
    fn bands_cover_the_image() {
        for (width, height) in [(1, 1), (1280, 800), (16384, 16384), (16384, 1), (1, 16384), (333, 217)] {
            for workers in [1, 2, 4, 64] {
                let screen = Screen::new(width, height, workers);
                assert!(screen.bands() * screen.band_rows() >= height as usize);
                assert!((screen.bands() - 1) * screen.band_rows() < height as usize);
                assert!(screen.band_rows() <= 128);
            }
        }
    }

    #[test]
    fn bands_are_high_while_there_are_two_for_each_worker() {
        let bands = |width, height, workers| {
            let screen = Screen::new(width, height, workers);
            (screen.bands(), screen.band_rows())
        };
        assert_eq!([1, 2, 3, 16].map(|workers| bands(640, 480, workers)), [(4, 120), (4, 120), (6, 80), (8, 60)]);
        assert_eq!([2, 3].map(|workers| bands(640, 360, workers)), [(4, 90), (6, 60)]);
        assert_eq!([1, 2].map(|workers| bands(320, 200, workers)), [(2, 100), (4, 50)]);
        assert_eq!([1, 7, 16].map(|workers| bands(1280, 800, workers)), [(13, 64), (14, 58), (25, 32)]);
        assert_eq!(bands(16384, 1, 2), (1, 1));
    }
}
