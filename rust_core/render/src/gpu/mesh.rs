//! Meshes on the GPU: indexed triangles.
//!
//! A mesh of millions of triangles is made anew when it is first seen, so all cores write straight into the memory that
//! the GPU fetches.

use std::borrow::Cow;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use rcs_scene::{Mesh, Vertex};

use super::device::Device;
use super::geometry::{is_finite, written};

/// Indexed triangles on the GPU.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Triangles {
    pub(super) vertices: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    pub(super) index_count: u32,
}

/// A vertex as the shader takes it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct GpuVertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    color: [u8; 4],
}

impl GpuVertex {
    /// Offsets of its fields.
    pub(super) const ATTRIBUTES: [wgpu::VertexAttribute; 4] =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Unorm8x4];

    fn of(vertex: &Vertex) -> Self {
        Self {
            position: vertex.position,
            normal: if is_finite(&vertex.normal) { vertex.normal } else { [0.0; 3] },
            uv: vertex.uv.map(|c| if c.is_finite() { c } else { 0.0 }),
            color: vertex.color,
        }
    }
}

/// Vertices, and indices, that a core takes at a time.
const VERTICES_IN_SHARE: usize = 1 << 11;
const INDICES_IN_SHARE: usize = 1 << 14;

/// The drawable triangles of a mesh, those whose corners exist and are finite; `None` where there are none.
pub(super) fn upload(device: &Device, mesh: &Mesh) -> Option<Triangles> {
    const SHARE_BYTES: usize = VERTICES_IN_SHARE * size_of::<GpuVertex>();
    let corners = drawable_corners(mesh);
    let (vertices, indices) = (&mesh.vertices, bytemuck::cast_slice(&corners));
    (!corners.is_empty()).then(|| Triangles {
        vertices: written::<_, _, SHARE_BYTES>(device, "vertices", vertices, |_, vertex| GpuVertex::of(vertex)),
        indices: device.buffer("indices", wgpu::BufferUsages::INDEX, indices),
        index_count: corners.len() as u32,
    })
}

/// The corners of these triangles, three each.
fn drawable_corners(mesh: &Mesh) -> Cow<'_, [u32]> {
    let whole = mesh.indices.as_chunks::<3>().0.as_flattened();
    let is_drawable = |corners: &[u32]| {
        corners.iter().all(|&i| mesh.vertices.get(i as usize).is_some_and(|vertex| is_finite(&vertex.position)))
    };
    if whole.par_chunks(INDICES_IN_SHARE).all(is_drawable) {
        return Cow::Borrowed(whole);
    }
    Cow::Owned(whole.chunks_exact(3).filter(|corners| is_drawable(corners)).flatten().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_without_a_corner_are_left_out() {
        let mut mesh = Mesh {
            vertices: vec![Vertex::new([0.0; 3], [0.0; 3]); 4],
            indices: vec![0, 1, 2, 1, 2, 3, 2, 3, 4, 3, 2, 1, 0],
        };
        assert_eq!(*drawable_corners(&mesh), [0, 1, 2, 1, 2, 3, 3, 2, 1]);
        mesh.vertices[3].position[1] = f32::NAN;
        assert_eq!(*drawable_corners(&mesh), [0, 1, 2]);
        mesh.indices.truncate(4);
        assert!(matches!(drawable_corners(&mesh), Cow::Borrowed([0, 1, 2])));
    }
}
