//! Wide lines: flat ribbons that turn towards the eye, with a width in metres.
//!
//! Reproduces `rviz::BillboardLine` on Ogre's `BillboardChain`: at each element the ribbon spreads by half its width to
//! both sides, perpendicular to the line's tangent there (towards the next element at the first, from the previous at
//! the last, from previous to next between) and to the direction to the eye. A line is drawn from its last element to
//! its first, which shows where a translucent one crosses itself.

use nalgebra::{Point3, Vector3};

use crate::{Blending, Mesh, Vertex};

/// A corner of a wide line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RibbonElement {
    /// Metres in the object's frame.
    pub position: [f32; 3],
    /// Red first, interpolated along the line.
    pub color: [u8; 4],
}

/// Wide lines of one width.
#[derive(Clone, Debug, PartialEq)]
pub struct Ribbons {
    /// Each a line through its elements; those of fewer than two elements are not drawn.
    pub chains: Vec<Vec<RibbonElement>>,
    /// Width in metres.
    pub width_m: f32,
    /// Combination with the pixels behind them.
    pub blending: Blending,
}

impl Ribbons {
    /// The ribbons as triangles in the object's frame, turned to an eye given in the object's frame.
    pub fn to_mesh(&self, eye: Point3<f32>) -> Mesh {
        let mut mesh = Mesh::default();
        self.write_to(&mut mesh, eye);
        mesh
    }

    /// Like [`Self::to_mesh`], into the memory of a mesh, whose content is replaced.
    pub fn write_to(&self, mesh: &mut Mesh, eye: Point3<f32>) {
        let elements: usize = self.chains.iter().map(Vec::len).sum();
        mesh.vertices.clear();
        mesh.vertices.reserve(elements * 2);
        mesh.indices.clear();
        mesh.indices.reserve(elements * 6);
        for chain in self.chains.iter().filter(|chain| chain.len() > 1) {
            let base = mesh.vertices.len() as u32;
            for (i, element) in chain.iter().enumerate() {
                let at = |i: usize| Vector3::from(chain[i].position);
                let here = at(i);
                let tangent = at((i + 1).min(chain.len() - 1)) - at(i.saturating_sub(1));
                let side = tangent
                    .cross(&(eye.coords - here))
                    .try_normalize(1e-12)
                    .map_or_else(Vector3::zeros, |side| side * (self.width_m * 0.5));
                for position in [here - side, here + side] {
                    mesh.vertices.push(Vertex { color: element.color, ..Vertex::new(position.into(), [0.0; 3]) });
                }
            }
            for i in (0..chain.len() as u32 - 1).rev() {
                let a = base + 2 * i;
                mesh.indices.extend([a, a + 1, a + 2, a + 1, a + 3, a + 2]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_drawn_from_its_end_to_its_beginning_and_faces_the_eye() {
        let element = |x: f32, color| RibbonElement { position: [x, 0.0, 0.0], color };
        let ends = [element(0.0, [1; 4]), element(1.0, [2; 4]), element(3.0, [3; 4])];
        let ribbons = Ribbons { chains: vec![ends.to_vec()], width_m: 0.5, blending: Blending::Alpha };
        let mesh = ribbons.to_mesh(Point3::new(0.0, 0.0, 2.0));
        let triangles: Vec<[&Vertex; 3]> = mesh.triangles().collect();
        let furthest = |corners: &[&Vertex; 3]| corners.iter().map(|v| v.position[0]).fold(0.0, f32::max);
        assert_eq!(triangles.iter().map(furthest).collect::<Vec<_>>(), [3.0, 3.0, 1.0, 1.0]);
        for [a, b, c] in triangles {
            let [a, b, c] = [a, b, c].map(|v| Vector3::from(v.position));
            assert!((b - a).cross(&(c - a)).z > 0.0);
        }
        assert!(mesh.vertices.iter().all(|vertex| vertex.position[1].abs() == 0.25));
    }
}
