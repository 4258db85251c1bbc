//! The solids that rviz builds its symbols from.
//!
//! rviz loads a cube, a cylinder, a cone and a sphere from mesh files; they are generated here with the same
//! tessellation and the same normals, because light is computed at the vertices and both show in the image.
//! All have a diameter (or edges) of 1 m and stand around the origin; cylinder and cone have y for their axis.

mod round;
mod sphere;

use std::sync::{Arc, OnceLock};

use rcs_scene::{Mesh, Vertex};

/// One of rviz's solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SolidShape {
    /// Edges of 1 m.
    Cube,
    /// Diameter 1 m, height 1 m along y.
    Cylinder,
    /// Diameter 1 m, apex at y = 0.5, base at y = −0.5.
    Cone,
    /// Diameter 1 m.
    Sphere,
}

impl SolidShape {
    /// Its triangles; made once and shared.
    pub(crate) fn mesh(self) -> Arc<Mesh> {
        static MESHES: OnceLock<[Arc<Mesh>; 4]> = OnceLock::new();
        let meshes = MESHES.get_or_init(|| [cube(), round::cylinder(), round::cone(), sphere::sphere()].map(Arc::new));
        meshes[self as usize].clone()
    }
}

fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [1.0_f32, -1.0] {
            let (side, up) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |s: f32, t: f32| {
                let mut position = [0.0; 3];
                (position[axis], position[side], position[up]) = (0.5 * sign, 0.5 * s * sign, 0.5 * t);
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                Vertex { uv: [s / 2.0 + 0.5, 0.5 - t / 2.0], ..Vertex::new(position, normal) }
            };
            let base = mesh.vertices.len() as u32;
            mesh.vertices.extend([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
            mesh.indices.extend([0, 1, 2, 2, 3, 0].map(|i| base + i));
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn the_sphere_has_rvizs_tessellation() {
        let mesh = SolidShape::Sphere.mesh();
        assert_eq!((mesh.indices.len() / 3, mesh.vertices.len()), (720, 362));
        assert!(mesh.vertices.iter().all(|v| (Vector3::from(v.position).norm() - 0.5).abs() < 1e-5));
    }
}
