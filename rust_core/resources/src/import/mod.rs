//! Mesh files into polygons, materials and instances, one reader for each format.

use std::path::Path;

use crate::{MeshFault, ResourceError};

mod collada;
mod gltf;
mod imported;
mod lenient_float;
mod mtl;
mod obj;
mod ply;
mod process;
mod scalar;
mod stl;
mod triangulate;
mod vectors;

use imported::{check_count, MAX_MATERIALS, MAX_MESHES};
pub(crate) use imported::{Imported, MaterialSpec, MeshSource};
pub(crate) use process::{process, PrimitiveMesh};
pub(crate) use triangulate::Triangulation;
pub(crate) use vectors::normalized;

/// The format of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeshFormat {
    Stl,
    Collada,
    Obj,
    Ply,
    Gltf,
}

impl MeshFormat {
    /// The format of a file's extension, in upper or lower case.
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

/// Reads the contents of a mesh file.
pub(crate) fn import(format: MeshFormat, bytes: &[u8], source: MeshSource<'_>) -> Result<Imported, MeshFault> {
    let max_corners = source.options.max_corners();
    let imported = match format {
        MeshFormat::Stl => stl::read(bytes),
        MeshFormat::Collada => collada::read(bytes, max_corners),
        MeshFormat::Obj => obj::read(bytes, source),
        MeshFormat::Ply => ply::read(bytes, max_corners),
        MeshFormat::Gltf => gltf::read(bytes, source),
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
