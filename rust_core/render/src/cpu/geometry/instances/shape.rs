//! Meshes as many solids use them: their vertices side by side, for several lanes at once.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::Matrix3;
use rcs_scene::{Aabb, Mesh};

use crate::cache::Derived;
use crate::cpu::tile::lanes::{LANES, WIDE};

/// A mesh as solids use it.
#[derive(Debug)]
pub(in crate::cpu) struct Shape {
    /// The coordinates of the places of vertices, each place once, filled up to a whole number of lanes.
    pub(in crate::cpu) coordinates: [Vec<f32>; 3],
    /// The corners of each triangle, which all exist.
    pub(in crate::cpu) triangles: Vec<[u32; 3]>,
    /// The places of each triangle's corners.
    pub(in crate::cpu) places: Vec<[u32; 3]>,
    /// Of so many triangles side by side the [`minors`] of their corners: the planes that they lie in.
    pub(in crate::cpu) planes: Vec<[[f32; WIDE]; 4]>,
    /// The most that a triangle reaches along one of the axes, over what the box does.
    pub(in crate::cpu) longest: f32,
    /// The box around the vertices; `None` where one is not finite.
    pub(in crate::cpu) bounds: Option<Aabb>,
}

impl Shape {
    pub(in crate::cpu) fn new(mesh: &Mesh) -> Self {
        let (coordinates, place_of_vertex) = each_once(mesh.vertices.iter().map(|vertex| vertex.position));
        let corners = mesh.indices.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]);
        let of = |corners: [u32; 3], all: &[u32]| {
            let [a, b, c] = corners.map(|corner| all.get(corner as usize).copied());
            Some([a?, b?, c?])
        };
        let triangles: Vec<[u32; 3]> = corners.filter(|&corners| of(corners, &place_of_vertex).is_some()).collect();
        let places: Vec<_> = triangles.iter().filter_map(|&corners| of(corners, &place_of_vertex)).collect();
        let positions = || mesh.vertices.iter().map(|vertex| vertex.position);
        let is_finite = positions().flatten().all(f32::is_finite);
        let bounds = Aabb::around(positions()).filter(|_| is_finite);
        let planes = planes(&coordinates, &places);
        let longest = longest(&coordinates, &places);
        Self { coordinates, triangles, places, planes, longest, bounds }
    }
}

/// Places, each of them once and the axes by themselves, filled up to a whole number of lanes; and for each
/// that was given which one it is.
fn each_once(all: impl Iterator<Item = [f32; 3]>) -> ([Vec<f32>; 3], Vec<u32>) {
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    let mut once: [Vec<f32>; 3] = Default::default();
    let which = all
        .map(|values| {
            *numbers.entry(values.map(f32::to_bits)).or_insert_with(|| {
                once.iter_mut().zip(values).for_each(|(axis, value)| axis.push(value));
                once[0].len() as u32 - 1
            })
        })
        .collect();
    once.iter_mut().for_each(|axis| axis.resize(axis.len().next_multiple_of(LANES), 0.0));
    (once, which)
}

/// The corners of each triangle, given the coordinates of the places and its own places.
fn corners<'a>(coordinates: &'a [Vec<f32>; 3], places: &'a [[u32; 3]]) -> impl Iterator<Item = [[f32; 3]; 3]> + 'a {
    let coordinate = |axis: usize, place: u32| coordinates[axis].get(place as usize).copied().unwrap_or_default();
    places.iter().map(move |places| places.map(|place| [0, 1, 2].map(|axis| coordinate(axis, place))))
}

/// As [`Shape::planes`].
fn planes(coordinates: &[Vec<f32>; 3], places: &[[u32; 3]]) -> Vec<[[f32; WIDE]; 4]> {
    let of_several = |places| {
        let mut planes = [[0.0; WIDE]; 4];
        for (lane, corners) in corners(coordinates, places).enumerate() {
            let plane = minors(corners.map(|[x, y, z]| [x, y, z, 1.0].map(f64::from)));
            planes.iter_mut().zip(plane).for_each(|(all, number)| all[lane] = number as f32);
        }
        planes
    };
    places.chunks(WIDE).map(of_several).collect()
}

/// As [`Shape::longest`].
fn longest(coordinates: &[Vec<f32>; 3], places: &[[u32; 3]]) -> f32 {
    let between = |values: [f32; 3]| {
        let [least, most] = [f32::min, f32::max].map(|choose| values.into_iter().reduce(choose).unwrap_or_default());
        most - least
    };
    let (mut low, mut high, mut longest) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3], [0.0_f32; 3]);
    for [a, b, c] in corners(coordinates, places) {
        for axis in 0..3 {
            let values = [a[axis], b[axis], c[axis]];
            low[axis] = values.into_iter().fold(low[axis], f32::min);
            high[axis] = values.into_iter().fold(high[axis], f32::max);
            longest[axis] = longest[axis].max(between(values));
        }
    }
    let share = |axis: usize| if longest[axis] > 0.0 { longest[axis] / (high[axis] - low[axis]) } else { 0.0 };
    [0, 1, 2].map(share).into_iter().fold(0.0, f32::max)
}

/// Of three rows of four numbers the determinants of what is left without the first column, without the second one, and
/// so on.
pub(in crate::cpu) fn minors(rows: [[f64; 4]; 3]) -> [f64; 4] {
    [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]
        .map(|columns| Matrix3::from_fn(|row, column| rows[row][columns[column]]).determinant())
}

/// The shapes of the meshes that are alive.
pub(in crate::cpu) type Shapes = Derived<Mesh, Arc<Shape>>;

/// The shape of a mesh out of the cache, made now if there is none.
pub(in crate::cpu) fn shape_of(mesh: &Arc<Mesh>, shapes: &mut Shapes) -> Arc<Shape> {
    shapes.get(mesh, |mesh| Arc::new(Shape::new(mesh))).clone()
}

#[cfg(test)]
mod tests {
    use rcs_scene::Vertex;

    use super::*;

    #[test]
    fn a_place_is_there_once_and_triangles_have_corners_that_exist() {
        let vertex = |x: f32, y: f32| Vertex::new([x, y, 0.0], [0.0, 0.0, 1.0]);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (5.0, 5.0)];
        let vertices = corners.map(|(x, y)| vertex(x, y)).to_vec();
        let mesh = Mesh { vertices, indices: vec![0, 1, 2, 3, 4, 5, 6, 6, 6, 0, 1, 9, 0, 1, 2, 6, 0, 1] };
        let shape = Shape::new(&mesh);
        assert_eq!(shape.coordinates[0], [0.0, 1.0, 0.0, 1.0, 5.0, 0.0, 0.0, 0.0]);
        assert_eq!(shape.triangles, [[0, 1, 2], [3, 4, 5], [6, 6, 6], [0, 1, 2], [6, 0, 1]]);
        assert_eq!(shape.places, [[0, 1, 2], [2, 1, 3], [4, 4, 4], [0, 1, 2], [4, 0, 1]]);
        // The triangle that is a point has no plane, and the others lie in z = 0; the last one is the largest.
        assert_eq!(shape.planes.len(), 1);
        assert_eq!(shape.planes[0][2][..6], [1.0, 1.0, 0.0, 1.0, 5.0, 0.0]);
        assert_eq!(shape.longest, 1.0);
    }
}
