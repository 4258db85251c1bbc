//! Cutting triangles and lines at the view's sides, in clip coordinates.
//!
//! Everything is cut at the near and the far plane. Triangles are cut at the image's sides only where they reach far
//! outside, so that their window coordinates stay small; lines are cut there exactly, as Mesa cuts them. A cut between
//! two vertices is always computed from the inner one, so that two triangles that share an edge share the cut too, and
//! the pixels along it are drawn once.

use wide::f32x4;

/// A vertex on its way to the image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::cpu) struct ClipVertex {
    /// Clip coordinates.
    pub position: [f32; 4],
    /// Red, green, blue, alpha, each 0 to 1.
    pub color: [f32; 4],
    /// Texture coordinates.
    pub uv: [f32; 2],
}

impl ClipVertex {
    /// True if all coordinates are finite.
    pub(in crate::cpu) fn is_finite(&self) -> bool {
        self.position.iter().all(|c| c.is_finite())
    }

    fn towards(&self, other: &Self, t: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * t;
        Self {
            position: [0, 1, 2, 3].map(|i| mix(self.position[i], other.position[i])),
            color: [0, 1, 2, 3].map(|i| mix(self.color[i], other.color[i])),
            uv: [0, 1].map(|i| mix(self.uv[i], other.uv[i])),
        }
    }
}

/// Triangles may reach this far outside of the image, in w.
pub(in crate::cpu) const GUARD: f32 = 4.0;

/// The bits of the view's sides, in the order in which things are cut: near, far, left, right, bottom, top.
const SIDES: [u32; 6] = [2, 6, 0, 4, 1, 5];

/// How far a place is inside of a side; it is outside where this is negative.
fn distance(side: u32, position: [f32; 4], guard: f32) -> f32 {
    let (axis, w) = (side as usize % 4, position[3]);
    let size = if axis == 2 { w } else { guard * w };
    if side < 4 {
        size + position[axis]
    } else {
        size - position[axis]
    }
}

/// On which sides a place is outside: of the view, and of the wider one that triangles are cut at.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cpu) struct Outside {
    /// One bit for each side.
    pub view: u32,
    /// One bit for each side; a non-finite position is outside of none, and has one bit more.
    pub guard: u32,
}

impl Outside {
    /// Of clip coordinates.
    #[inline]
    pub(in crate::cpu) fn new(position: [f32; 4]) -> Self {
        const NOT_FINITE: u32 = 1 << 8;
        let [x, y, z, w] = position;
        let place = f32x4::new([x, y, z, 0.0]);
        let beyond = |size: f32x4| {
            (size + place).simd_lt(f32x4::ZERO).to_bitmask() | (size - place).simd_lt(f32x4::ZERO).to_bitmask() << 4
        };
        // Infinite or NaN.
        if (f32x4::new(position) * f32x4::ZERO).simd_ne(f32x4::ZERO).any() {
            return Self { view: 0, guard: NOT_FINITE };
        }
        let view = beyond(f32x4::splat(w));
        // Outside of the wide view is outside of the narrow one, too.
        let guard = if view == 0 { 0 } else { beyond(f32x4::new([GUARD * w, GUARD * w, w, w])) };
        Self { view, guard }
    }
}

/// A triangle that was cut.
#[derive(Debug)]
pub(in crate::cpu) struct Polygon {
    vertices: [ClipVertex; 3 + SIDES.len() + 1],
    len: usize,
}

impl Polygon {
    /// The part of a triangle inside of the view; `None` where nothing is left, or where a coordinate is not finite.
    #[inline]
    pub(in crate::cpu) fn clip(triangle: [&ClipVertex; 3]) -> Option<Self> {
        if triangle.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let outside = triangle.map(|vertex| Outside::new(vertex.position));
        if outside.iter().fold(!0, |all, outside| all & outside.view) != 0 {
            return None;
        }
        let mut polygon = Self { vertices: [ClipVertex::default(); 3 + SIDES.len() + 1], len: 3 };
        for (to, from) in polygon.vertices.iter_mut().zip(triangle) {
            *to = *from;
        }
        let crossed = outside.iter().fold(0, |any, outside| any | outside.guard);
        for side in SIDES.into_iter().filter(|side| crossed & 1 << side != 0) {
            polygon.cut(side);
        }
        (polygon.len >= 3).then_some(polygon)
    }

    /// The corners, in their order.
    pub(in crate::cpu) fn vertices(&self) -> &[ClipVertex] {
        &self.vertices[..self.len]
    }

    fn cut(&mut self, side: u32) {
        let mut kept = [ClipVertex::default(); 3 + SIDES.len() + 1];
        let mut len = 0;
        let mut push = |vertex: ClipVertex| {
            if let Some(place) = kept.get_mut(len) {
                *place = vertex;
                len += 1;
            }
        };
        for i in 0..self.len {
            let (a, b) = (&self.vertices[i], &self.vertices[(i + 1) % self.len]);
            let (da, db) = (distance(side, a.position, GUARD), distance(side, b.position, GUARD));
            if da >= 0.0 {
                push(*a);
                if db < 0.0 {
                    push(a.towards(b, da / (da - db)));
                }
            } else if db >= 0.0 {
                push(b.towards(a, db / (db - da)));
            }
        }
        (self.vertices, self.len) = (kept, len);
    }
}

/// The part of a line inside of the view; `None` where nothing is left, or where a coordinate is not finite.
pub(in crate::cpu) fn clip_line(mut a: ClipVertex, mut b: ClipVertex) -> Option<(ClipVertex, ClipVertex)> {
    if !a.is_finite() || !b.is_finite() {
        return None;
    }
    let (out_a, out_b) = (Outside::new(a.position).view, Outside::new(b.position).view);
    if out_a & out_b != 0 {
        return None;
    }
    for side in SIDES.into_iter().filter(|side| (out_a | out_b) & 1 << side != 0) {
        let (da, db) = (distance(side, a.position, 1.0), distance(side, b.position, 1.0));
        match (da < 0.0, db < 0.0) {
            (true, true) => return None,
            (true, false) => a = b.towards(&a, db / (db - da)),
            (false, true) => b = a.towards(&b, da / (da - db)),
            (false, false) => {}
        }
    }
    Some((a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32, y: f32, z: f32, w: f32) -> ClipVertex {
        ClipVertex { position: [x, y, z, w], color: [x; 4], uv: [y; 2] }
    }

    #[test]
    fn inside_triangles_are_unchanged() {
        let triangle = [at(0.0, 0.0, 0.0, 1.0), at(0.5, 0.0, 0.0, 1.0), at(0.0, 3.5, 0.0, 1.0)];
        let polygon = Polygon::clip([&triangle[0], &triangle[1], &triangle[2]]).unwrap();
        assert_eq!(polygon.vertices(), triangle);
    }

    #[test]
    fn a_triangle_through_the_near_plane_becomes_a_quadrangle() {
        let triangle = [at(0.0, 0.0, -3.0, 1.0), at(0.5, 0.0, 0.0, 1.0), at(0.0, 0.5, 0.0, 1.0)];
        let polygon = Polygon::clip([&triangle[0], &triangle[1], &triangle[2]]).unwrap();
        assert_eq!(polygon.vertices().len(), 4);
        assert!(polygon.vertices().iter().all(|v| v.position[2] >= -v.position[3] - 1e-6));
    }

    #[test]
    fn outside_or_nonfinite_primitives_are_dropped() {
        let outside = [at(2.0, 0.0, 0.0, 1.0), at(3.0, 0.0, 0.0, 1.0), at(2.0, 9.0, 0.0, 1.0)];
        assert!(Polygon::clip([&outside[0], &outside[1], &outside[2]]).is_none());
        let broken = [at(f32::NAN, 0.0, 0.0, 1.0), at(0.0, 0.0, 0.0, 1.0), at(0.0, 1.0, 0.0, 1.0)];
        assert!(Polygon::clip([&broken[0], &broken[1], &broken[2]]).is_none());
        assert!(clip_line(broken[0], broken[1]).is_none());
        assert!(clip_line(at(2.0, 0.0, 0.0, 1.0), at(0.0, 20.0, 0.0, 1.0)).is_none());
    }

    #[test]
    fn lines_end_at_the_sides_with_their_colours_between() {
        let (a, b) = clip_line(at(-3.0, 0.0, 0.0, 1.0), at(5.0, 0.0, 0.0, 1.0)).unwrap();
        assert_eq!((a.position[0], b.position[0]), (-1.0, 1.0));
        assert_eq!((a.color[0], b.color[0]), (-1.0, 1.0));
    }
}
