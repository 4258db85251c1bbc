//! Triangle meshes.

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Metres in the object's frame.
    pub position: [f32; 3],
    /// Unit length in the object's frame; zero where the mesh has no normals (a lit surface is then dark but for its
    /// emissive colour).
    pub normal: [f32; 3],
    /// Texture coordinates, v down.
    pub uv: [f32; 2],
    /// Red first; used with [`Material::vertex_colors`](crate::Material::vertex_colors).
    pub color: [u8; 4],
}

impl Vertex {
    /// A white vertex without texture coordinates.
    pub const fn new(position: [f32; 3], normal: [f32; 3]) -> Self {
        Self { position, normal, uv: [0.0, 0.0], color: [255; 4] }
    }
}

/// Triangles that share vertices.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Mesh {
    /// The corners.
    pub vertices: Vec<Vertex>,
    /// Three for each triangle, counter-clockwise seen from the front; each below `vertices.len()`.
    pub indices: Vec<u32>,
}

impl Mesh {
    /// The corners of each triangle; those with an index past the end are left out.
    pub fn triangles(&self) -> impl Iterator<Item = [&Vertex; 3]> + '_ {
        self.indices.chunks_exact(3).filter_map(|i| {
            Some([
                self.vertices.get(i[0] as usize)?,
                self.vertices.get(i[1] as usize)?,
                self.vertices.get(i[2] as usize)?,
            ])
        })
    }
}
