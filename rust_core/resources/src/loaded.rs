//! A mesh as rviz shows it: parts in drawing order, each with the material that rviz makes for it.

use std::sync::Arc;

use rcs_scene::{Lighting, Material, Mesh, Rgba, Texture};

use crate::ResourceError;

/// A mesh file's contents, ready to draw.
#[derive(Clone, Debug, Default)]
pub struct LoadedMesh {
    /// The parts (Ogre's sub-meshes) in the order in which rviz draws them, all in the file's own frame: the file's
    /// units are converted to metres and its node transforms applied, its up axis is not (rviz drops that rotation).
    pub parts: Vec<MeshPart>,
    /// What is wrong but not fatal, such as a missing texture.
    pub warnings: Vec<ResourceError>,
}

/// A part with one material.
#[derive(Clone, Debug)]
pub struct MeshPart {
    /// The triangles. Each vertex is there once; vertex colours are white, because rviz does not read those of a file.
    pub mesh: Arc<Mesh>,
    /// The material that the file gives this part.
    pub material: MeshMaterial,
}

/// A material as rviz's mesh loader makes it from the file's.
#[derive(Clone, Debug)]
pub struct MeshMaterial {
    /// False for STL files, which have none: rviz then takes the marker's colour even when the marker requests
    /// embedded materials, and the URDF's material for a robot's link.
    pub embedded: bool,
    /// Diffuse colour. Always opaque: rviz requests a material's opacity from Assimp by a wrong name, so that a file's
    /// transparency never shows.
    pub diffuse: Rgba,
    /// Ambient colour, halved by rviz. rviz's scene has no ambient light, so it does not show.
    pub ambient: Rgba,
    /// Specular colour. The specular part of rviz's light is black, so it does not show.
    pub specular: Rgba,
    /// Specular exponent.
    pub shininess: f32,
    /// Colour given off without light.
    pub emissive: Rgba,
    /// Multiplied with the lit colour, alpha included. Yellow and black stripes, Ogre's warning texture, where the
    /// file names a texture that cannot be loaded.
    pub texture: Option<Arc<Texture>>,
}

impl MeshMaterial {
    /// The material of a file that has none: lit white, not embedded.
    pub const fn none() -> Self {
        Self {
            embedded: false,
            diffuse: Rgba::WHITE,
            ambient: Rgba::BLACK,
            specular: Rgba::BLACK,
            shininess: 0.0,
            emissive: Rgba::BLACK,
            texture: None,
        }
    }

    /// How Ogre draws it before a marker or a robot's link changes anything: lit, only the front sides (a file's
    /// `double_sided` is not heeded), opaque. Specular is left out, see [`MeshMaterial::specular`].
    pub fn to_scene(&self) -> Material {
        Material {
            lighting: Lighting::Lit { diffuse: self.diffuse, emissive: self.emissive },
            texture: self.texture.clone(),
            ..Material::lit(Rgba::WHITE)
        }
    }
}
