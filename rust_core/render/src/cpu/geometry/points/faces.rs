//! Placing one point's face: `Style: Squares`, `Flat Squares`, `Spheres` and `Boxes`, and tiles.
//!
//! Squares and discs face the eye (they are not parallel to the image plane) and stand upright to the y axis of the
//! cloud's own frame: with `at` the direction to the eye, their sides run along `right = y × at` and `up = at × right`.
//! So they are seen from their front, turned as the cloud's frame is, and their depth changes over the face; where the
//! line of sight runs along that y axis there is no such direction and nothing is drawn. A tile is a rectangle of a
//! fixed orientation, seen from both sides. A box has its edges along the axes of the cloud's frame.
//!
//! ```text
//!         up
//!   2 ────┼──── 3        a face's corners, in units of its half sides;
//!   │     │     │        a place (u, v) on it is measured from its middle in whole
//!   ┼──── · ────┼ right  sides, so that it reaches from −0.5 to 0.5
//!   │     │     │
//!   0 ────┼──── 1
//! ```

use rcs_scene::{CullMode, PointStyle, Points};

use super::{is_visible, Cloud};
use crate::cpu::paint::{DepthBias, Paint, Surface};
use crate::cpu::raster::clip::ClipVertex;
use crate::cpu::tile::band::Mode;
use crate::shading::{drawn_point_size_px, Number, BOX_SIDES_AGAINST, BOX_SIDES_ALONG};

/// The surface of all of a cloud's faces.
pub(super) fn surface(points: &Points) -> Surface {
    let (paint, cull) = match points.style {
        PointStyle::Squares { .. } => (Paint::Edged, CullMode::Back),
        PointStyle::Spheres { .. } => (Paint::Disc, CullMode::Back),
        PointStyle::Boxes { .. } => (Paint::BoxSide, CullMode::Back),
        PointStyle::Tiles { .. } => (Paint::Edged, CullMode::None),
        PointStyle::FlatSquares { .. } | PointStyle::Points { .. } => (Paint::Color, CullMode::Back),
    };
    Surface { paint, mode: Mode::new(points.blended), cull, depth_bias: DepthBias::NONE }
}

impl Cloud<'_> {
    /// Half of a tile's sides, to the right and up, in the cloud's frame; none where the faces are no tiles.
    pub(super) fn tile_sides(&self) -> Option<[[f32; 3]; 2]> {
        let PointStyle::Tiles { size_m, normal, up } = self.points.style else { return None };
        Some([cross(up, normal).map(|c| c * size_m[0] * 0.5), up.map(|c| c * size_m[1] * 0.5)])
    }

    /// The farthest that a face reaches from its point, in clip coordinates and for a size factor of 1.
    pub(super) fn clip_extent(&self) -> [f32; 4] {
        let length = |v: &[f32]| v.iter().fold(0.0, |sum: f32, c| sum.hypot(*c));
        let reach_m = match self.points.style {
            PointStyle::Tiles { size_m, normal, up } => {
                let right = cross(up, normal);
                (length(&right) * size_m[0].abs() + length(&up) * size_m[1].abs()) * 0.5
            }
            PointStyle::Boxes { size_m } => length(&size_m) * 0.5,
            style => length(&size_m(style)) * 0.5,
        };
        self.transform.clip_from_object.map(|row| length(&row[..3]) * reach_m)
    }

    /// Makes the triangles of a point's faces.
    pub(super) fn triangles(&self, index: usize, mut out: impl FnMut([&ClipVertex; 3])) {
        let Some(&position) = self.points.buffer.positions.get(index) else { return };
        let [r, g, b, a] = self.points.buffer.colors.get(index).map(|c| f32::from(c) / 255.0);
        let alpha = a * self.points.alpha;
        let color = |brightness: f32| [r * brightness, g * brightness, b * brightness, alpha.clamp(0.0, 1.0)];
        let factor = if self.points.auto_size { position[2] } else { 1.0 };
        let center = self.transform.clip(position);
        let along = |[x, y, z]: [f32; 3], length: f32| {
            self.transform.clip_from_object.map(|row| (row[0] * x + row[1] * y + row[2] * z) * length)
        };
        let mut face = |middle: [f32; 4], right: [f32; 4], up: [f32; 4], color: [f32; 4]| {
            let corner = |u: f32, v: f32| ClipVertex {
                position: [0, 1, 2, 3].map(|i| middle[i] + u * right[i] + v * up[i]),
                color,
                uv: [u * 0.5, v * 0.5],
            };
            let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)];
            out([&corners[2], &corners[0], &corners[3]]);
            out([&corners[3], &corners[0], &corners[1]]);
        };
        match self.points.style {
            PointStyle::Squares { .. } | PointStyle::FlatSquares { .. } | PointStyle::Spheres { .. }
                if is_visible(alpha) =>
            {
                let half = size_m(self.points.style).map(|length| length * factor * 0.5);
                let towards_eye = [0, 1, 2].map(|i| self.eye[i] - position[i]);
                let ([right_x, right_z], up) = upright(towards_eye, half);
                face(center, along([right_x, 0.0, right_z], 1.0), along(up, 1.0), color(1.0));
            }
            PointStyle::Tiles { size_m, normal, up } if is_visible(alpha) => {
                let right = cross(up, normal);
                face(center, along(right, size_m[0] * 0.5), along(up, size_m[1] * 0.5), color(1.0));
            }
            PointStyle::Boxes { size_m } => {
                let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                let axes = [0, 1, 2].map(|axis: usize| along(axes[axis], size_m[axis] * factor * 0.5));
                for axis in [2, 0, 1] {
                    let (normal, u, v) = (axes[axis], axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
                    let middle = |sign: f32| [0, 1, 2, 3].map(|i| center[i] + sign * normal[i]);
                    face(middle(1.0), u, v, color(BOX_SIDES_ALONG[axis]));
                    face(middle(-1.0), v, u, color(BOX_SIDES_AGAINST[axis]));
                }
            }
            _ => {}
        }
    }
}

/// The points' diameter on the image, in pixels; none where the cloud has another style.
pub(super) fn diameter_px(points: &Points) -> Option<f32> {
    match points.style {
        PointStyle::Points { diameter_px } => Some(drawn_point_size_px(diameter_px)),
        _ => None,
    }
}

/// Width and height of faces that face the eye.
#[inline]
pub(super) fn size_m(style: PointStyle) -> [f32; 2] {
    match style {
        PointStyle::Squares { size_m } | PointStyle::Spheres { size_m } => size_m,
        PointStyle::FlatSquares { side_m } => [side_m; 2],
        PointStyle::Points { .. } | PointStyle::Boxes { .. } | PointStyle::Tiles { .. } => [0.0; 2],
    }
}

pub(super) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Half sides to the right (its x and z; its y is 0) and up of a face that faces the eye, given the vector to the eye
/// and the half sides' lengths. NaN where the eye is straight above or below.
#[inline(always)]
pub(super) fn upright<T: Number>([x, y, z]: [T; 3], [half_width, half_height]: [T; 2]) -> ([T; 2], [T; 3]) {
    let level = x * x + z * z;
    let right = half_width / level.root();
    let up = half_height / (level * (level + y * y)).root();
    let (minus_x, minus_y) = (x * -1.0, y * -1.0);
    ([z * right, minus_x * right], [minus_x * y * up, level * up, minus_y * z * up])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn faces_turn_to_the_eye_and_stand_upright() {
        let towards_eye = [-2.0_f32, 6.0, -6.0];
        let ([right_x, right_z], up) = upright(towards_eye, [1.0, 1.0]);
        let at = Vector3::from(towards_eye).normalize();
        let (right, up) = (Vector3::new(right_x, 0.0, right_z), Vector3::from(up));
        assert!((right.cross(&up) - at).norm() < 1e-6);
        assert!((right.norm() - 1.0).abs() < 1e-6 && up.y > 0.0);
    }

    #[test]
    fn there_is_no_face_straight_below_the_eye() {
        let (right, up) = upright([0.0_f32, 4.0, 0.0], [1.0, 1.0]);
        assert!(right.iter().chain(&up).any(|c| c.is_nan()));
    }
}
