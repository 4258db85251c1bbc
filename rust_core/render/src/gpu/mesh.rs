//! Meshes on the GPU: indexed triangles, in pieces whose buffers are of a bounded size.
//!
//! A mesh of millions of triangles is made anew when it is first seen, so all cores write straight into the memory that
//! the GPU fetches. Triangles that follow one another mostly share vertices that do, too: a piece has the vertices from
//! the first to the last that its triangles name. Where these are too many, because triangles name vertices all over
//! the mesh, it has one for each corner.

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use rcs_scene::{Mesh, Vertex};

use super::device::Device;
use super::geometry::{is_finite, written, MAX_CHUNK_BYTES};

/// Indexed triangles on the GPU.
#[derive(Clone, Debug)]
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

/// A core writes so many vertices, or indices, before it takes the next.
const VERTICES_IN_SHARE: usize = 1 << 11;
const INDICES_IN_SHARE: usize = 1 << 14;

const MAX_VERTICES: usize = MAX_CHUNK_BYTES / size_of::<GpuVertex>();
const MAX_INDICES: usize = MAX_CHUNK_BYTES / size_of::<u32>();

/// The drawable triangles of a mesh: those whose corners exist and are finite.
pub(super) fn upload(device: &Device, mesh: &Mesh) -> Arc<[Triangles]> {
    let corners = drawable_corners(mesh);
    pieces(&corners).into_iter().map(|piece| piece.upload(device, mesh)).collect()
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

/// Triangles that fit into one buffer each of vertices and of indices.
#[derive(Debug, PartialEq)]
enum Piece<'a> {
    /// These corners, of vertices from `first` on.
    Shared { corners: &'a [u32], first: u32, count: usize },
    /// These corners, with a vertex each.
    Single { corners: &'a [u32] },
}

/// The triangles' pieces, in their order.
fn pieces(corners: &[u32]) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    add_pieces(corners, &mut pieces);
    pieces
}

fn add_pieces<'a>(corners: &'a [u32], pieces: &mut Vec<Piece<'a>>) {
    let ends = corners.par_iter().with_min_len(INDICES_IN_SHARE).map(|&i| (i, i));
    let Some((first, last)) = ends.reduce_with(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { return };
    let count = (last - first) as usize + 1;
    if count <= MAX_VERTICES && corners.len() <= MAX_INDICES {
        pieces.push(Piece::Shared { corners, first, count });
    } else if corners.len() <= MAX_VERTICES {
        pieces.push(Piece::Single { corners });
    } else {
        let (before, after) = corners.split_at(corners.len() / 6 * 3);
        add_pieces(before, pieces);
        add_pieces(after, pieces);
    }
}

impl Piece<'_> {
    fn upload(&self, device: &Device, mesh: &Mesh) -> Triangles {
        match *self {
            Self::Shared { corners, first, count } => {
                let begin = first as usize;
                let vertices = mesh.vertices.get(begin..begin + count).unwrap_or_default();
                triangles(device, vertices, GpuVertex::of, corners, |i| i - first)
            }
            Self::Single { corners } => {
                let of_corner = |&i: &u32| mesh.vertices.get(i as usize).map_or_else(GpuVertex::zeroed, GpuVertex::of);
                let indices: Vec<u32> = (0..corners.len() as u32).collect();
                triangles(device, corners, of_corner, &indices, |i| i)
            }
        }
    }
}

fn triangles<S: Sync>(
    device: &Device,
    vertices: &[S],
    vertex: impl Fn(&S) -> GpuVertex + Sync,
    indices: &[u32],
    index: impl Fn(u32) -> u32 + Sync,
) -> Triangles {
    const VERTEX_BYTES: usize = VERTICES_IN_SHARE * size_of::<GpuVertex>();
    const INDEX_BYTES: usize = INDICES_IN_SHARE * size_of::<u32>();
    let usage = wgpu::BufferUsages::VERTEX;
    Triangles {
        vertices: written::<S, GpuVertex, VERTEX_BYTES>(device, "vertices", usage, vertices, |_, from| vertex(from)),
        indices: written::<u32, u32, INDEX_BYTES>(device, "indices", wgpu::BufferUsages::INDEX, indices, |_, &i| {
            index(i)
        }),
        index_count: indices.len() as u32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_whose_triangles_share_neighbours_is_cut_where_its_vertices_are_too_many() {
        let few: Vec<u32> = [5, 6, 7, 6, 7, 8].to_vec();
        assert_eq!(pieces(&few), [Piece::Shared { corners: &few, first: 5, count: 4 }]);
        assert_eq!(pieces(&[]), []);
        // A strip of twice as many vertices as fit.
        let strip: Vec<u32> = (0..2 * MAX_VERTICES as u32).flat_map(|i| [i, i + 1, i + 2]).collect();
        let cut = pieces(&strip);
        assert_eq!(cut.len(), 4, "each half has a vertex too many");
        let mut joined = Vec::new();
        for piece in &cut {
            let Piece::Shared { corners, first, count } = piece else { panic!("{cut:?}") };
            assert!(*count <= MAX_VERTICES && corners.len() % 3 == 0);
            assert!(corners.iter().all(|i| (*first..*first + *count as u32).contains(i)));
            joined.extend_from_slice(corners);
        }
        assert!(joined == strip);
    }

    #[test]
    fn triangles_of_vertices_all_over_a_mesh_have_their_own() {
        let far = 3 * MAX_VERTICES as u32;
        let corners: Vec<u32> = (0..MAX_VERTICES as u32).flat_map(|i| [i, far - i, i]).collect();
        let cut = pieces(&corners);
        let mut joined = Vec::new();
        for piece in &cut {
            let Piece::Single { corners } = piece else { panic!("{cut:?}") };
            assert!(corners.len() <= MAX_VERTICES && corners.len() % 3 == 0);
            joined.extend_from_slice(corners);
        }
        assert!(joined == corners);
    }

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
