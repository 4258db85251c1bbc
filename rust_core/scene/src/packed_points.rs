//! Points in the bytes of the message that they came in, and rviz's rules of their colours.
//!
//! A renderer on a GPU takes the bytes as its vertex buffer, and the GPU decodes positions and colours, so that a cloud
//! of millions of points is copied once. Another renderer asks for the same points [decoded](PackedPoints::points).

use std::fmt;
use std::sync::{Arc, OnceLock};

use nalgebra::{Isometry3, Point3};
use rayon::prelude::*;

use crate::point_bytes::{bytes_at, has_finite_position, PointBytes, PositionLayout, POINTS_PER_SHARE};
use crate::{Aabb, PointBuffer, PointColors, PointLook, Points, Rgba};

/// An owner of bytes, such as a message.
pub type SharedBytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// Largest stride of a vertex buffer in WebGL 2, bytes.
const MAX_STRIDE: usize = 255;

/// Rule of the colours of packed points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PackedColors {
    /// One colour, red first, for all points.
    Uniform([u8; 4]),
    /// Blue, green and red as bytes at an offset; opaque.
    Rgb {
        /// Offset in a point.
        offset: usize,
    },
    /// rviz's rainbow along an axis.
    Axis(AxisRainbow),
}

/// Colours by a coordinate: red at the lowest, magenta at the highest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisRainbow {
    /// 0, 1 or 2 for x, y or z.
    pub axis: usize,
    /// Pose of the frame of the coordinate if it is not the object's.
    pub fixed_from_object: Option<Isometry3<f32>>,
    /// The lowest coordinate, metres.
    pub min_m: f32,
    /// The highest coordinate less the lowest, metres.
    pub range_m: f32,
}

impl AxisRainbow {
    /// Along an axis of the object, or of the fixed frame where its pose is given; the bounds follow.
    pub fn new(axis: usize, fixed_from_object: Option<Isometry3<f32>>) -> Self {
        Self { axis, fixed_from_object, min_m: 0.0, range_m: 1.0 }
    }

    /// The rainbow from a lowest to a highest coordinate, metres.
    #[must_use]
    pub fn between(self, min_m: f32, max_m: f32) -> Self {
        Self { min_m, range_m: if max_m == min_m { 0.001 } else { max_m - min_m }, ..self }
    }

    /// The coordinate of a position in the object's frame, metres.
    #[inline(always)]
    pub fn coordinate_m(&self, position: &[f32; 3]) -> f32 {
        match self.fixed_from_object {
            Some(fixed_from_object) => (fixed_from_object * Point3::from(*position))[self.axis],
            None => position[self.axis],
        }
    }

    /// The colour of a position in the object's frame, red first.
    #[inline(always)]
    pub fn color(&self, position: &[f32; 3]) -> [u8; 4] {
        let share = (self.coordinate_m(position) - self.min_m) / self.range_m;
        rainbow((1.0 - f64::from(share)) as f32).to_rgba8()
    }
}

/// Colours of rviz's rainbow at equal distances from 0 to 1; each differs from the next in one channel.
const RAINBOW: [[f32; 3]; 6] =
    [[1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]];

/// rviz's rainbow: magenta at 0 over blue, cyan, green and yellow to red at 1.
#[inline]
pub fn rainbow(share: f32) -> Rgba {
    let share = if share.is_nan() { share } else { share.clamp(0.0, 1.0) };
    // rviz counts the colours from one, in single precision, and the last level shows how that rounds.
    let place = share * (RAINBOW.len() - 1) as f32 + 1.0;
    // A NaN becomes 0.
    let number = (place as usize).max(1);
    let (from, to) = (RAINBOW[number - 1], RAINBOW[number.min(RAINBOW.len() - 1)]);
    let falling = 1.0 - (place - place.trunc());
    let rising = 1.0 - falling;
    let channel = |i: usize| match to[i] - from[i] {
        change if change < 0.0 => falling,
        change if change > 0.0 => rising,
        _ => to[i],
    };
    Rgba::new(channel(0), channel(1), channel(2), 1.0)
}

/// The opaque colour of blue, green and red at an offset in a point. rviz's way over floats ends at the same bytes.
#[inline(always)]
pub fn rgb_at(point: &[u8], offset: usize) -> [u8; 4] {
    let [b, g, r, _] = bytes_at(point, offset);
    [r, g, b, 255]
}

/// A cloud in the bytes of its message, with the way it is drawn. Positions are 32-bit floats, little endian, in metres
/// in the object's frame; points whose position is not finite are not drawn.
pub struct PackedPoints {
    bytes: SharedBytes,
    stride: usize,
    positions: PositionLayout,
    colors: PackedColors,
    look: PointLook,
    /// Number of points with a finite position of each share.
    shown: Vec<usize>,
    bounds: Option<Aabb>,
    decoded: OnceLock<Points>,
}

impl PackedPoints {
    /// Points of `stride` bytes. `None` unless they can be a vertex buffer within WebGL 2's limits: x, y and z
    /// consecutive, the stride and all offsets multiples of four.
    pub fn new(
        bytes: SharedBytes,
        stride: usize,
        positions: PositionLayout,
        colors: PackedColors,
        look: PointLook,
    ) -> Option<Self> {
        let position_offset = positions.plain_offset()?;
        let color_offset = if let PackedColors::Rgb { offset } = colors { offset } else { position_offset };
        let fits = |offset: usize, len: usize| {
            offset.is_multiple_of(4) && offset.checked_add(len).is_some_and(|end| end <= stride)
        };
        let is_whole = stride > 0 && stride.is_multiple_of(4) && (*bytes).as_ref().len().is_multiple_of(stride);
        if stride > MAX_STRIDE || !is_whole || !fits(position_offset, 12) || !fits(color_offset, 4) {
            return None;
        }
        let survey = |share: &[u8]| {
            let mut count = 0;
            let share = share.chunks_exact(stride).map(|point| positions.in_point(point));
            let bounds = Aabb::around(share.inspect(|position| count += usize::from(has_finite_position(position))));
            (count, bounds)
        };
        let shares: Vec<_> = (*bytes).as_ref().par_chunks(POINTS_PER_SHARE * stride).map(survey).collect();
        let bounds = shares.iter().filter_map(|(_, bounds)| *bounds).reduce(Aabb::joined);
        let shown = shares.into_iter().map(|(count, _)| count).collect();
        Some(Self { bytes, stride, positions, colors, look, shown, bounds, decoded: OnceLock::new() })
    }

    /// All points, one after the other.
    pub fn bytes(&self) -> &[u8] {
        (*self.bytes).as_ref()
    }

    /// Bytes of a point: a multiple of four, not 0.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Offset of x in a point, which y and z follow: a multiple of four.
    pub fn position_offset(&self) -> usize {
        self.positions.plain_offset().unwrap_or_default()
    }

    /// The rule of their colours; offsets are multiples of four.
    pub fn colors(&self) -> &PackedColors {
        &self.colors
    }

    /// How they are drawn.
    pub fn look(&self) -> PointLook {
        self.look
    }

    /// Number of points, including those without a finite position.
    pub fn count(&self) -> usize {
        self.bytes().len() / self.stride
    }

    /// Number of points with a finite position.
    pub fn finite_count(&self) -> usize {
        self.shown.iter().sum()
    }

    /// The box around the finite positions in the object's frame.
    pub fn bounds(&self) -> Option<Aabb> {
        self.bounds
    }

    /// The points with a finite position, decoded on all cores by the first call and kept.
    pub fn points(&self) -> &Points {
        self.decoded.get_or_init(|| {
            let points = PointBytes {
                data: self.bytes(),
                point_step: self.stride,
                positions: self.positions,
                shown: &self.shown,
                is_all_shown: self.finite_count() == self.count(),
            };
            let positions = points.map(|point| self.positions.in_point(point));
            let colors = match &self.colors {
                PackedColors::Uniform(color) => PointColors::Uniform(*color),
                PackedColors::Rgb { offset } => PointColors::PerPoint(points.map(|point| rgb_at(point, *offset))),
                PackedColors::Axis(rainbow) => PointColors::PerPoint(
                    positions.par_iter().with_min_len(POINTS_PER_SHARE).map(|p| rainbow.color(p)).collect(),
                ),
            };
            self.look.of(Arc::new(PointBuffer { positions, colors }))
        })
    }
}

impl fmt::Debug for PackedPoints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PackedPoints({} of {} bytes, {:?}, {:?})", self.count(), self.stride, self.colors, self.look)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PointStyle;

    #[test]
    fn the_rainbow_runs_from_magenta_to_red() {
        assert_eq!(rainbow(0.0).to_rgba8(), [255, 0, 255, 255]);
        assert_eq!(rainbow(0.2).to_rgba8(), [0, 0, 255, 255]);
        assert_eq!(rainbow(0.4).to_rgba8(), [0, 255, 255, 255]);
        assert_eq!(rainbow(0.6).to_rgba8(), [0, 255, 0, 255]);
        assert_eq!(rainbow(0.75).to_rgba8(), [191, 255, 0, 255]);
        assert_eq!(rainbow(0.8).to_rgba8(), [255, 255, 0, 255]);
        assert_eq!(rainbow(1.0).to_rgba8(), [255, 0, 0, 255]);
        assert_eq!(rainbow(f32::NAN).to_rgba8(), [0, 0, 255, 255]);
        assert_eq!(rainbow(-7.0), rainbow(0.0));
        assert_eq!(rainbow(7.0), rainbow(1.0));
    }

    #[test]
    fn bytes_go_the_way_of_floats() {
        for byte in 0..=255 {
            let level = f32::from(byte) / 255.0;
            assert_eq!(Rgba::new(level, level, level, level).to_rgba8(), [byte; 4]);
        }
    }

    #[test]
    fn only_what_can_be_a_vertex_buffer_is_packed() {
        let style = PointStyle::Points { diameter_px: 1.0 };
        let look = PointLook { style, alpha: 1.0, blended: false, auto_size: false };
        let rgb = |offset| PackedColors::Rgb { offset };
        let is_packed = |len: usize, stride, offsets, colors| {
            let positions = PositionLayout::new(offsets);
            PackedPoints::new(Arc::new(vec![0; len]), stride, positions, colors, look).is_some()
        };
        assert!(is_packed(0, 16, [0, 4, 8], rgb(12)));
        assert!(is_packed(64, 32, [4, 8, 12], rgb(28)));
        assert!(is_packed(504, 252, [240, 244, 248], PackedColors::Uniform([9; 4])));
        assert!(!is_packed(64, 32, [0, 8, 4], rgb(12)), "z before y");
        assert!(!is_packed(44, 22, [0, 4, 8], rgb(12)), "the stride");
        assert!(!is_packed(64, 32, [2, 6, 10], rgb(16)), "the position's offset");
        assert!(!is_packed(64, 32, [0, 4, 8], rgb(13)), "the colour's offset");
        assert!(!is_packed(64, 32, [0, 4, 8], rgb(32)), "the colour is in the next point");
        assert!(!is_packed(512, 256, [0, 4, 8], rgb(12)), "too large for WebGL 2");
        assert!(!is_packed(65, 32, [0, 4, 8], rgb(12)), "half a point");
        assert!(!is_packed(0, 0, [0, 4, 8], rgb(12)));
    }

    #[test]
    fn points_without_a_finite_position_are_not_among_the_decoded_ones() {
        let positions = [[1.0, 2.0, 3.0], [f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0], [4.0, 5.0, -6.0_f32]];
        let point = |(i, position): (usize, &[f32; 3])| {
            let bytes: Vec<u8> =
                position.iter().flat_map(|value| value.to_le_bytes()).chain([i as u8, 2, 3, 4]).collect();
            bytes
        };
        let bytes: Vec<u8> = positions.iter().enumerate().flat_map(point).collect();
        let look =
            PointLook { style: PointStyle::FlatSquares { side_m: 0.1 }, alpha: 1.0, blended: false, auto_size: true };
        let layout = PositionLayout::new([0, 4, 8]);
        let packed = PackedPoints::new(Arc::new(bytes), 16, layout, PackedColors::Rgb { offset: 12 }, look).unwrap();
        assert_eq!((packed.count(), packed.finite_count()), (4, 2));
        assert_eq!(packed.bounds(), Some(Aabb::new([1.0, 2.0, -6.0].into(), [4.0, 5.0, 3.0].into())));
        let points = packed.points();
        assert_eq!((points.look(), &points.buffer.positions[..]), (look, &[positions[0], positions[3]][..]));
        assert_eq!(points.buffer.colors, PointColors::PerPoint(vec![[3, 2, 0, 255], [3, 2, 3, 255]]));
    }
}
