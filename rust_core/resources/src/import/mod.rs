//! Mesh files into polygons, materials and placings, one reader for each format.

use std::{collections::HashMap, path::Path};

use nalgebra::Matrix4;

use crate::{MeshFault, ResourceError, ResourceOptions};

mod collada;
mod gltf;
mod lenient_float;
mod mtl;
mod obj;
mod ply;
mod process;
mod stl;
mod triangulate;

pub(crate) use process::{normalized, process, Triangles};
pub(crate) use triangulate::Triangulation;

/// The most meshes of a file, counted after instancing; each is drawn by itself.
const MAX_MESHES: usize = 50_000;
/// The most materials of a file.
const MAX_MATERIALS: usize = 10_000;

/// A mesh file, and the rules by which files beside it are read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) options: &'a ResourceOptions,
}

/// Which reader a file goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Stl,
    Collada,
    Obj,
    Ply,
    Gltf,
}

impl Format {
    /// The format that the file's extension stands for, in upper or lower case.
    pub(crate) fn from_path(path: &Path) -> Result<Self, ResourceError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        match extension.as_str() {
            "stl" | "stlb" => Ok(Self::Stl),
            "dae" => Ok(Self::Collada),
            "obj" => Ok(Self::Obj),
            "ply" => Ok(Self::Ply),
            "gltf" | "glb" => Ok(Self::Gltf),
            "mesh" => Err(ResourceError::UnsupportedFormat { path: path.to_owned(), format: "Ogre .mesh".to_owned() }),
            "" => Err(ResourceError::UnsupportedFormat { path: path.to_owned(), format: "(no extension)".to_owned() }),
            other => Err(ResourceError::UnsupportedFormat { path: path.to_owned(), format: format!(".{other}") }),
        }
    }
}

/// The contents of a file.
#[derive(Debug, Default)]
pub(crate) struct Imported {
    pub(crate) meshes: Vec<Polygons>,
    /// Empty where the format has none (STL).
    pub(crate) materials: Vec<MaterialSpec>,
    /// Which mesh is drawn at which pose, in drawing order.
    pub(crate) placed: Vec<Placed>,
    /// Images within the file, by the names by which its materials refer to them.
    pub(crate) images: HashMap<String, Vec<u8>>,
}

/// A mesh at a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// Index into [`Imported::meshes`].
    pub(crate) mesh: usize,
    pub(crate) object_from_mesh: Matrix4<f32>,
}

/// The faces of a mesh.
#[derive(Clone, Debug)]
pub(crate) enum Faces {
    /// Triangles only. Normals are those of the faces, one for each.
    Triangles,
    /// Corners of each face: 1 a point, 2 a line. Normals are those of the corners.
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
    /// The vertices. Those of the first face, then of the second, and so on, unless `corners` says otherwise.
    pub(crate) positions: Vec<[f32; 3]>,
    /// One for each vertex or, see [`Faces`], each face; or none at all.
    pub(crate) normals: Vec<[f32; 3]>,
    /// One for each vertex, or none at all; v up, as in most files.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// The vertices of the first face, then of the second, and so on, of formats whose faces share vertices. All exist.
    pub(crate) corners: Option<Vec<u32>>,
    pub(crate) faces: Faces,
    /// Index into [`Imported::materials`].
    pub(crate) material: usize,
}

impl Polygons {
    /// The corners of all faces.
    fn corner_count(&self) -> usize {
        self.corners.as_ref().map_or(self.positions.len(), Vec::len)
    }
}

/// A material as Assimp would report it, before rviz makes its own of it. Opacity is left out: rviz requests it by a
/// key (`$clr.opacity`) that Assimp never had (`$mat.opacity`), so that all materials of files are opaque in rviz.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MaterialSpec {
    pub(crate) diffuse: [f32; 3],
    pub(crate) ambient: [f32; 3],
    pub(crate) specular: [f32; 3],
    pub(crate) emissive: [f32; 3],
    pub(crate) shininess: f32,
    /// One normal for each face (COLLADA's `faceted`).
    pub(crate) flat: bool,
    /// The diffuse texture: a file beside the mesh, or one of [`Imported::images`]; empty for none.
    pub(crate) diffuse_texture: String,
    /// How many textures of any kind are named.
    pub(crate) texture_count: usize,
}

impl MaterialSpec {
    /// What Assimp gives to meshes of a file without materials: grey 0.6.
    pub(crate) const DEFAULT: Self = Self {
        diffuse: [0.6; 3],
        ambient: [0.0; 3],
        specular: [1.0; 3],
        emissive: [0.0; 3],
        shininess: 0.0,
        flat: false,
        diffuse_texture: String::new(),
        texture_count: 0,
    };
}

/// Reads the contents of a mesh file.
pub(crate) fn import(format: Format, bytes: &[u8], source: Source<'_>) -> Result<Imported, MeshFault> {
    let max_corners = source.options.max_corners();
    let imported = match format {
        Format::Stl => stl::read(bytes),
        Format::Collada => collada::read(bytes, max_corners),
        Format::Obj => obj::read(bytes, source),
        Format::Ply => ply::read(bytes, max_corners),
        Format::Gltf => gltf::read(bytes, source),
    }?;
    // A small file may place a mesh any number of times.
    check_count(imported.placed.len(), MAX_MESHES, "meshes")?;
    check_count(imported.materials.len(), MAX_MATERIALS, "materials")?;
    let placed = imported.placed.iter().filter_map(|placed| imported.meshes.get(placed.mesh));
    let corners = placed.fold(0_usize, |sum, mesh| sum.saturating_add(mesh.corner_count()));
    check_count(corners, max_corners, "corners")?;
    if corners == 0 {
        return Err(MeshFault::Empty);
    }
    Ok(imported)
}

/// A text file's bytes without the byte order mark that Windows tools put before UTF-8.
fn without_byte_order_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Refuses more than is plausible.
fn check_count(count: usize, limit: usize, what: &'static str) -> Result<(), MeshFault> {
    if count > limit {
        return Err(MeshFault::TooLarge { limit, what });
    }
    Ok(())
}
