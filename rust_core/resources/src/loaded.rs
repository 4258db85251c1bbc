//! A mesh as rviz draws it: parts in drawing order, each with rviz's material for it.

use std::sync::Arc;

use rcs_scene::{Lighting, Material, Mesh, Rgba, Texture};

use crate::ResourceError;

/// A mesh file's contents, ready to draw.
#[derive(Clone, Debug, Default)]
pub struct LoadedMesh {
    /// The parts (Ogre's sub-meshes) in the order in which rviz draws them, all in the file's own frame: the file's
    /// units are converted to metres and its node transforms applied, its up axis is not (rviz drops that rotation).
    pub parts: Vec<MeshPart>,
    /// Errors that are not fatal, such as a missing texture.
    pub warnings: Vec<ResourceError>,
}

/// A part with one material.
#[derive(Clone, Debug)]
pub struct MeshPart {
    /// The triangles, with unique vertices. Vertex colours are white, because rviz does not read a file's.
    pub mesh: Arc<Mesh>,
    /// The material that the file gives this part.
    pub material: MeshMaterial,
}

/// A material as rviz's mesh loader makes it from the file's.
#[derive(Clone, Debug)]
pub struct MeshMaterial {
    /// `false` for STL files, which have no materials: rviz then uses the marker's colour even when the marker requests
    /// embedded materials, and the URDF's material for a robot's link.
    pub embedded: bool,
    /// Diffuse colour. Always opaque: rviz requests a material's opacity from Assimp by a wrong name.
    pub diffuse: Rgba,
    /// Emissive colour.
    pub emissive: Rgba,
    /// Multiplied with the lit colour, alpha included. Yellow and black stripes, Ogre's warning texture, where the
    /// file names a texture that cannot be loaded.
    pub texture: Option<Arc<Texture>>,
}

impl MeshMaterial {
    /// The material of a file without materials: lit white, not embedded.
    pub const fn none() -> Self {
        Self { embedded: false, diffuse: Rgba::WHITE, emissive: Rgba::BLACK, texture: None }
    }

    /// The material in Ogre before a marker or a robot's link changes it: lit, opaque, front sides only (a file's
    /// `double_sided` is ignored).
    pub fn to_scene(&self) -> Material {
        Material {
            lighting: Lighting::Lit { diffuse: self.diffuse, emissive: self.emissive },
            texture: self.texture.clone(),
            ..Material::lit(Rgba::WHITE)
        }
    }
}
