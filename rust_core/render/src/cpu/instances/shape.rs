//! Meshes as many solids use them: their vertices side by side, for several lanes at once.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use nalgebra::Vector3;
use rcs_scene::Mesh;

use super::reach::ShapeBounds;
use crate::cpu::lanes::LANES;

/// A mesh as solids use it.
#[derive(Debug)]
pub(in crate::cpu) struct Shape {
    /// The coordinates of the vertices, each filled up to a whole number of lanes.
    pub(super) coordinates: [Vec<f32>; 3],
    /// The corners of each triangle, which all exist.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The box around the vertices; `None` where one is not finite.
    pub(super) bounds: Option<ShapeBounds>,
}

impl Shape {
    fn new(mesh: &Mesh) -> Self {
        let count = mesh.vertices.len();
        let coordinates = [0, 1, 2].map(|axis| {
            let mut values: Vec<f32> = mesh.vertices.iter().map(|vertex| vertex.position[axis]).collect();
            values.resize(count.next_multiple_of(LANES), 0.0);
            values
        });
        let corners = mesh.indices.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]);
        let triangles = corners.filter(|corners| corners.iter().all(|&corner| (corner as usize) < count)).collect();
        let positions = || mesh.vertices.iter().map(|vertex| Vector3::from(vertex.position));
        let is_finite = positions().all(|position| position.iter().all(|c| c.is_finite()));
        let low = positions().reduce(|low, position| low.inf(&position));
        let high = positions().reduce(|high, position| high.sup(&position));
        let bounds = low.zip(high).filter(|_| is_finite).map(|(low, high)| ShapeBounds::new(low, high));
        Self { coordinates, triangles, bounds }
    }
}

/// The shapes that are alive.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Shapes {
    by_address: HashMap<usize, (Weak<Mesh>, Arc<Shape>)>,
}

impl Shapes {
    /// The shape of a mesh, made now if it is new.
    pub(in crate::cpu) fn get(&mut self, mesh: &Arc<Mesh>) -> Arc<Shape> {
        let address = Arc::as_ptr(mesh) as usize;
        let make = || (Arc::downgrade(mesh), Arc::new(Shape::new(mesh)));
        self.by_address.entry(address).or_insert_with(make).1.clone()
    }

    /// Drops those whose meshes are gone.
    pub(in crate::cpu) fn forget_dead(&mut self) {
        self.by_address.retain(|_, (mesh, _)| mesh.strong_count() > 0);
    }
}
