//! PLY (Stanford), as text and as binary of either byte order.
//!
//! As in Assimp: the element `vertex` has the vertices, `face` the faces (any number of corners) in the list
//! `vertex_index` or `vertex_indices`; `s`/`t`, `u`/`v` and `texture_u`/`texture_v` are texture coordinates, and so is
//! the list `texcoord` of a face, which sets its vertices'; `comment TextureFile NAME` is the diffuse texture.
//! Everything else is skipped, materials (which only ancient files have) included. Colours of vertices are not used
//! because rviz does not read them: without a tint or a texture a PLY mesh is white. All triangles of `tristrips` are
//! drawn, where Assimp keeps the last one.

mod body;
mod header;

use super::imported::{check_count, strip_triangles, Faces, Imported, MaterialSpec, Polygons};
use crate::MeshFault;
use body::Body;
use header::{ElementKind, ListRole, PlyElement, PlyEncoding, PlyHeader, PlyProperty, ScalarRole};

/// Reads a PLY file of at most `max_corners` corners.
pub(super) fn read(bytes: &[u8], max_corners: usize) -> Result<Imported, MeshFault> {
    let decoded;
    let mut header = PlyHeader::parse(bytes)?;
    if header.encoding == PlyEncoding::Text {
        decoded = rcs_text::decode(bytes);
        header = PlyHeader::parse(decoded.as_bytes())?;
    }
    let mut body = Body::new(header.encoding, header.body, header.body_line);
    let mut reader = PlyReader { mesh: Polygons::default(), sizes: Vec::new(), corners: Vec::new(), max_corners };
    for element in &header.elements {
        // Rows without properties take no bytes, so any number could be claimed.
        if element.properties.is_empty() {
            continue;
        }
        for row in 0..element.count {
            reader.row(element, &mut body).map_err(|fault| match fault {
                MeshFault::Malformed(what) => {
                    MeshFault::Malformed(format!("{what}: {} {row} of {}", element.name, element.count))
                }
                other => other,
            })?;
        }
    }
    let PlyReader { mut mesh, sizes, corners, .. } = reader;
    if let Some(bad) = corners.iter().find(|&&corner| corner as usize >= mesh.positions.len()) {
        let reason = format!("a face has vertex {bad}, there are {} vertices", mesh.positions.len());
        return Err(MeshFault::Malformed(reason));
    }
    (mesh.faces, mesh.corners) = (Faces::Sizes(sizes), Some(corners));
    // Assimp gives white to PLY files.
    let material = MaterialSpec {
        diffuse: [1.0; 3],
        texture_count: usize::from(!header.texture.is_empty()),
        diffuse_texture: header.texture,
        ..MaterialSpec::DEFAULT
    };
    Ok(Imported::untransformed(vec![mesh], vec![material]))
}

/// A mesh while it is read.
struct PlyReader {
    mesh: Polygons,
    sizes: Vec<u32>,
    corners: Vec<u32>,
    max_corners: usize,
}

impl PlyReader {
    /// Reads a row of an element.
    fn row(&mut self, element: &PlyElement, body: &mut Body<'_>) -> Result<(), MeshFault> {
        body.begin_row()?;
        let mut scalars = [None; ScalarRole::COUNT];
        let (mut face, mut texcoords) = (Vec::new(), Vec::new());
        for property in &element.properties {
            match *property {
                PlyProperty::Scalar { kind, role } => {
                    let value = body.value(kind)?;
                    if let Some(slot) = role.and_then(|role| scalars.get_mut(role as usize)) {
                        *slot = Some(value as f32);
                    }
                }
                PlyProperty::List { count, kind, role } => {
                    let count = body.value(count)? as u64;
                    let mut values = (0..count).map(|_| body.value(kind));
                    match role {
                        Some(ListRole::Indices) => face = values.collect::<Result<_, _>>()?,
                        Some(ListRole::TexCoords) => texcoords = values.collect::<Result<_, _>>()?,
                        None => values.try_for_each(|value| value.map(drop))?,
                    }
                }
            }
        }
        match element.kind {
            ElementKind::Vertex => self.vertex(&scalars),
            ElementKind::Face => self.face(&face, &texcoords),
            ElementKind::Strips => self.strips(&face),
            ElementKind::Other => Ok(()),
        }
    }

    fn vertex(&mut self, scalars: &[Option<f32>; ScalarRole::COUNT]) -> Result<(), MeshFault> {
        let [x, y, z, nx, ny, nz, u, v] = scalars.map(|value| value.unwrap_or_default());
        let [.., has_nx, has_ny, has_nz, has_u, has_v] = scalars.map(|value| value.is_some());
        self.mesh.positions.push([x, y, z]);
        if has_nx || has_ny || has_nz {
            self.mesh.normals.push([nx, ny, nz]);
        }
        if has_u || has_v {
            self.mesh.uvs.push([u, v]);
        }
        check_count(self.mesh.positions.len(), self.max_corners, "vertices")
    }

    fn face(&mut self, indices: &[f64], texcoords: &[f64]) -> Result<(), MeshFault> {
        self.add_face(indices)?;
        // Two coordinates for each corner of a triangle.
        if texcoords.len() / 3 == 2 {
            self.mesh.uvs.resize(self.mesh.positions.len(), [0.0; 2]);
            for (index, uv) in indices.iter().zip(texcoords.chunks_exact(2)) {
                if let (Some(slot), &[u, v]) = (self.mesh.uvs.get_mut(vertex_number(*index) as usize), uv) {
                    *slot = [u as f32, v as f32];
                }
            }
        }
        Ok(())
    }

    /// Adds the triangles of strips; −1 begins a new strip.
    fn strips(&mut self, indices: &[f64]) -> Result<(), MeshFault> {
        for strip in indices.split(|index| *index < 0.0) {
            strip_triangles(strip).try_for_each(|triangle| self.add_face(&triangle))?;
        }
        Ok(())
    }

    fn add_face(&mut self, indices: &[f64]) -> Result<(), MeshFault> {
        self.corners.extend(indices.iter().map(|index| vertex_number(*index)));
        self.sizes.push(indices.len() as u32);
        check_count(self.corners.len(), self.max_corners, "corners")
    }
}

/// A number as an index; an invalid one is out of range.
fn vertex_number(index: f64) -> u32 {
    if index >= 0.0 {
        index as u32
    } else {
        u32::MAX
    }
}
