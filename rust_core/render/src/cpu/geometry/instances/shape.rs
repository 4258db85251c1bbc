//! Meshes as many solids use them: their vertices side by side, for several lanes at once.

use std::collections::HashMap;
use std::sync::Arc;

use rcs_scene::{Aabb, Mesh};

use crate::cache::Derived;
use crate::cpu::tile::lanes::LANES;

/// A mesh as solids use it.
#[derive(Debug)]
pub(in crate::cpu) struct Shape {
    /// The coordinates of the places of vertices, each place once, filled up to a whole number of lanes.
    pub(in crate::cpu) coordinates: [Vec<f32>; 3],
    /// The corners of each triangle, which all exist.
    pub(in crate::cpu) triangles: Vec<[u32; 3]>,
    /// The places of each triangle's corners.
    pub(in crate::cpu) places: Vec<[u32; 3]>,
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
        Self { coordinates, triangles, places, bounds }
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
    }
}
