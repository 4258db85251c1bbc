//! A mesh file after reading, the same for all formats: polygons, materials and instances.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use nalgebra::Matrix4;
use rcs_text::xml::PassedOver;

use crate::{MeshFault, ResourceOptions};

/// Most meshes of a file after instancing; each is drawn by itself.
pub(super) const MAX_MESHES: usize = 50_000;
/// Most materials of a file.
pub(super) const MAX_MATERIALS: usize = 10_000;

/// A mesh file, and the rules for reading files beside it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshSource<'a> {
    pub(crate) path: &'a Path,
    pub(crate) options: &'a ResourceOptions,
}

impl MeshSource<'_> {
    /// The path of a file beside the mesh. rviz puts a slash between folder and name, so an absolute name is searched
    /// for there as well.
    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name.trim_start_matches('/'))
    }
}

/// The contents of a file.
#[derive(Debug, Default)]
pub(crate) struct Imported {
    pub(crate) meshes: Vec<Polygons>,
    /// Empty for a format without materials (STL).
    pub(crate) materials: Vec<MaterialSpec>,
    /// The instances of the meshes, in drawing order.
    pub(crate) placed: Vec<PlacedMesh>,
    /// Images within the file, by their names in its materials.
    pub(crate) images: HashMap<String, Vec<u8>>,
    /// Faults of the file that were passed over.
    pub(crate) passed_over: Vec<PassedOver>,
}

impl Imported {
    /// A file that has each mesh once, untransformed.
    pub(super) fn untransformed(meshes: Vec<Polygons>, materials: Vec<MaterialSpec>) -> Self {
        let placed = |mesh| PlacedMesh { mesh, object_from_mesh: Matrix4::identity(), is_turned: false };
        let placed = (0..meshes.len()).map(placed).collect();
        Self { meshes, materials, placed, ..Self::default() }
    }
}

/// An instance of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedMesh {
    /// Index into [`Imported::meshes`].
    pub(crate) mesh: usize,
    pub(crate) object_from_mesh: Matrix4<f32>,
    /// The front of each triangle is its back here.
    pub(crate) is_turned: bool,
}

/// The faces of a mesh.
#[derive(Clone, Debug)]
pub(crate) enum Faces {
    /// Triangles only, with one normal for each face.
    Triangles,
    /// Number of corners of each face, 1 for a point, 2 for a line, with one normal for each corner.
    Sizes(Vec<u32>),
}

impl Default for Faces {
    fn default() -> Self {
        Self::Sizes(Vec::new())
    }
}

/// Faces of any number of corners.
#[derive(Clone, Debug, Default)]
pub(crate) struct Polygons {
    /// The vertices; without `corners`, face by face.
    pub(crate) positions: Vec<[f32; 3]>,
    /// Normals of the vertices or, see [`Faces`], of the faces; may be empty.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Texture coordinates of the vertices, v up as in most files; may be empty.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// Vertex indices, face by face, of formats whose faces share vertices. All are in range.
    pub(crate) corners: Option<Vec<u32>>,
    pub(crate) faces: Faces,
    /// Index into [`Imported::materials`].
    pub(crate) material: usize,
}

impl Polygons {
    /// Number of corners of all faces.
    pub(super) fn corner_count(&self) -> usize {
        self.corners.as_ref().map_or(self.positions.len(), Vec::len)
    }
}

/// A material as Assimp reports it, before rviz converts it. Without opacity: rviz requests it by a key
/// (`$clr.opacity`) that Assimp never had (`$mat.opacity`), so all materials of files are opaque in rviz. Without
/// ambient and specular colours: the ambient light of rviz's scene and the specular part of its light are black.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MaterialSpec {
    pub(crate) diffuse: [f32; 3],
    pub(crate) emissive: [f32; 3],
    /// One normal for each face (COLLADA's `faceted`).
    pub(crate) flat: bool,
    /// The diffuse texture: a file beside the mesh, or one of [`Imported::images`]; empty for none.
    pub(crate) diffuse_texture: String,
    /// Number of textures of any kind.
    pub(crate) texture_count: usize,
}

impl MaterialSpec {
    /// Assimp's material for a file without materials: grey 0.6.
    pub(crate) const DEFAULT: Self =
        Self { diffuse: [0.6; 3], emissive: [0.0; 3], flat: false, diffuse_texture: String::new(), texture_count: 0 };
}

/// Refuses counts above a limit.
pub(super) fn check_count(count: usize, limit: usize, what: &'static str) -> Result<(), MeshFault> {
    if count > limit {
        return Err(MeshFault::TooLarge { limit, what });
    }
    Ok(())
}

/// Triangles of a strip; every second one is turned, so that all face the same way.
pub(super) fn strip_triangles<T: Copy>(strip: &[T]) -> impl Iterator<Item = [T; 3]> + '_ {
    let triangle = |(number, corners): (usize, &[T])| match *corners {
        [a, b, c] if number.is_multiple_of(2) => Some([a, b, c]),
        [a, b, c] => Some([b, a, c]),
        _ => None,
    };
    strip.windows(3).enumerate().filter_map(triangle)
}
