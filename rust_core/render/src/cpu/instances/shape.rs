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
    /// The coordinates of the places of vertices, each place once, filled up to a whole number of lanes.
    pub(super) coordinates: [Vec<f32>; 3],
    /// The normals of the vertices, filled up to a whole number of lanes; none where one is not finite.
    pub(super) normals: [Vec<f32>; 3],
    /// The corners of each triangle, which all exist.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The places of each triangle's corners.
    pub(super) places: Vec<[u32; 3]>,
    /// All triangles in their order.
    pub(super) pairs: Vec<Pair>,
    /// The box around the vertices; `None` where one is not finite.
    pub(super) bounds: Option<ShapeBounds>,
}

/// A triangle and the next one, which shares a side with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// The first one's other place, the two that are shared, and the second one's other place.
    pub(super) places: [u32; 4],
    /// The numbers of both; the second one's is [`Self::NONE`] where there is none.
    pub(super) triangles: [u32; 2],
}

impl Pair {
    /// No triangle's number.
    pub(super) const NONE: u32 = u32::MAX;

    /// Of the first triangle, and of the second one if it shares a side.
    fn of(number: u32, first: [u32; 3], second: Option<[u32; 3]>) -> Self {
        let both = second.and_then(|second| {
            let other = |of: [u32; 3], than: [u32; 3]| of.into_iter().find(|place| !than.contains(place));
            let (a, d) = (other(first, second)?, other(second, first)?);
            let shared = |of: [u32; 3], without: u32| {
                let at = of.iter().position(|&place| place == without).unwrap_or(0);
                [of[(at + 1) % 3], of[(at + 2) % 3]]
            };
            let ([b, c], [e, f]) = (shared(first, a), shared(second, d));
            let is_side = (b != c) & ([b, c] == [e, f] || [b, c] == [f, e]);
            is_side.then_some(Self { places: [a, b, c, d], triangles: [number, number + 1] })
        });
        let [a, b, c] = first;
        both.unwrap_or(Self { places: [a, b, c, b], triangles: [number, Self::NONE] })
    }
}

impl Shape {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
        let mut coordinates: [Vec<f32>; 3] = Default::default();
        let place_of_vertex: Vec<u32> = mesh
            .vertices
            .iter()
            .map(|vertex| {
                *numbers.entry(vertex.position.map(f32::to_bits)).or_insert_with(|| {
                    coordinates.iter_mut().zip(vertex.position).for_each(|(all, coordinate)| all.push(coordinate));
                    coordinates[0].len() as u32 - 1
                })
            })
            .collect();
        coordinates.iter_mut().for_each(|all| all.resize(all.len().next_multiple_of(LANES), 0.0));
        let corners = mesh.indices.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]);
        let place = |corner: u32| place_of_vertex.get(corner as usize).copied();
        let (triangles, places): (Vec<_>, Vec<_>) = corners
            .filter_map(|corners| {
                let [Some(a), Some(b), Some(c)] = corners.map(place) else { return None };
                Some((corners, [a, b, c]))
            })
            .unzip();
        let positions = || mesh.vertices.iter().map(|vertex| Vector3::from(vertex.position));
        let is_finite = positions().all(|position| position.iter().all(|c| c.is_finite()));
        let low = positions().reduce(|low, position| low.inf(&position));
        let high = positions().reduce(|high, position| high.sup(&position));
        let bounds = low.zip(high).filter(|_| is_finite).map(|(low, high)| ShapeBounds::new(low, high));
        Self { coordinates, normals: normals(mesh), triangles, pairs: pairs(&places), places, bounds }
    }

    /// Whether the normals are there.
    pub(super) fn has_normals(&self) -> bool {
        !self.normals[0].is_empty()
    }
}

/// As [`Shape::normals`].
fn normals(mesh: &Mesh) -> [Vec<f32>; 3] {
    let mut normals: [Vec<f32>; 3] = Default::default();
    if mesh.vertices.iter().all(|vertex| vertex.normal.iter().all(|coordinate| coordinate.is_finite())) {
        for (all, i) in normals.iter_mut().zip(0..) {
            all.extend(mesh.vertices.iter().map(|vertex| vertex.normal[i]));
            all.resize(all.len().next_multiple_of(LANES), 0.0);
        }
    }
    normals
}

/// Pairs of neighbours with a common side, given the places of each triangle's corners.
fn pairs(places: &[[u32; 3]]) -> Vec<Pair> {
    let mut pairs = Vec::with_capacity(places.len().div_ceil(2));
    let mut next = 0;
    while let Some(&first) = places.get(next) {
        let pair = Pair::of(next as u32, first, places.get(next + 1).copied());
        next += if pair.triangles[1] == Pair::NONE { 1 } else { 2 };
        pairs.push(pair);
    }
    pairs
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

#[cfg(test)]
mod tests {
    use rcs_scene::Vertex;

    use super::*;

    #[test]
    fn a_place_is_there_once_and_neighbours_with_a_common_side_are_a_pair() {
        let vertex = |x: f32, y: f32| Vertex::new([x, y, 0.0], [0.0, 0.0, 1.0]);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (5.0, 5.0)];
        let vertices = corners.map(|(x, y)| vertex(x, y)).to_vec();
        let mesh = Mesh { vertices, indices: vec![0, 1, 2, 3, 4, 5, 6, 6, 6, 0, 1, 9, 0, 1, 2, 6, 0, 1] };
        let shape = Shape::new(&mesh);
        assert_eq!(shape.coordinates[0], [0.0, 1.0, 0.0, 1.0, 5.0, 0.0, 0.0, 0.0]);
        assert_eq!(shape.triangles, [[0, 1, 2], [3, 4, 5], [6, 6, 6], [0, 1, 2], [6, 0, 1]]);
        assert_eq!(shape.places, [[0, 1, 2], [2, 1, 3], [4, 4, 4], [0, 1, 2], [4, 0, 1]]);
        let pairs: Vec<_> = shape.pairs.iter().map(|pair| (pair.places, pair.triangles)).collect();
        let single = ([4, 4, 4, 4], [2, Pair::NONE]);
        assert_eq!(pairs, [([0, 1, 2, 3], [0, 1]), single, ([2, 0, 1, 4], [3, 4])]);
    }
}
