//! The JSON of a glTF file: the keys that are used. Missing keys have their defaults, unknown keys are skipped.

use serde::Deserialize;

use crate::MeshFault;

/// The fault of a broken rule.
pub(super) fn fault(what: impl Into<String>) -> MeshFault {
    MeshFault::Malformed(what.into())
}

/// A whole file.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct GltfRoot {
    pub(super) asset: GltfAsset,
    pub(super) extensions_required: Vec<String>,
    /// Index of the scene that is drawn.
    pub(super) scene: usize,
    pub(super) scenes: Vec<GltfScene>,
    pub(super) nodes: Vec<GltfNode>,
    pub(super) meshes: Vec<GltfMesh>,
    pub(super) accessors: Vec<GltfAccessor>,
    pub(super) buffer_views: Vec<GltfBufferView>,
    pub(super) buffers: Vec<GltfBuffer>,
    pub(super) materials: Vec<GltfMaterial>,
    pub(super) textures: Vec<GltfTexture>,
    pub(super) images: Vec<GltfImage>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfAsset {
    pub(super) version: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfScene {
    pub(super) nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfNode {
    pub(super) children: Vec<usize>,
    pub(super) mesh: Option<usize>,
    /// Column by column.
    pub(super) matrix: Option<Box<[f32; 16]>>,
    pub(super) translation: Option<[f32; 3]>,
    /// x, y, z and w of a quaternion.
    pub(super) rotation: Option<[f32; 4]>,
    pub(super) scale: Option<[f32; 3]>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfMesh {
    pub(super) primitives: Vec<GltfPrimitive>,
}

#[derive(Debug, Deserialize)]
#[serde(default)]
pub(super) struct GltfPrimitive {
    pub(super) attributes: GltfAttributes,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    /// OpenGL's number of the primitive.
    pub(super) mode: u32,
}

impl Default for GltfPrimitive {
    fn default() -> Self {
        Self { attributes: GltfAttributes::default(), indices: None, material: None, mode: 4 }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfAttributes {
    #[serde(rename = "POSITION")]
    pub(super) position: Option<usize>,
    #[serde(rename = "NORMAL")]
    pub(super) normal: Option<usize>,
    #[serde(rename = "TEXCOORD_0")]
    pub(super) uv: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct GltfAccessor {
    pub(super) buffer_view: Option<usize>,
    pub(super) byte_offset: usize,
    /// OpenGL's number of the type.
    pub(super) component_type: u32,
    pub(super) normalized: bool,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<GltfSparse>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfSparse {
    pub(super) count: usize,
    pub(super) indices: SparsePlace,
    pub(super) values: SparsePlace,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct SparsePlace {
    pub(super) buffer_view: usize,
    pub(super) byte_offset: usize,
    /// The type of indices; values have the accessor's.
    pub(super) component_type: u32,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct GltfBufferView {
    pub(super) buffer: usize,
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    /// Bytes from one value to the next; by default without gaps.
    pub(super) byte_stride: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfBuffer {
    /// A file beside the mesh or a data URI; `None` for the bytes after the JSON of a GLB.
    pub(super) uri: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct GltfMaterial {
    pub(super) pbr_metallic_roughness: Pbr,
    pub(super) normal_texture: Option<TextureRef>,
    pub(super) occlusion_texture: Option<TextureRef>,
    pub(super) emissive_texture: Option<TextureRef>,
    pub(super) emissive_factor: [f32; 3],
    pub(super) extensions: MaterialExtensions,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Pbr {
    pub(super) base_color_factor: [f32; 4],
    pub(super) base_color_texture: Option<TextureRef>,
    pub(super) metallic_roughness_texture: Option<TextureRef>,
}

impl Default for Pbr {
    fn default() -> Self {
        Self { base_color_factor: [1.0; 4], base_color_texture: None, metallic_roughness_texture: None }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(super) specular_glossiness: Option<SpecularGlossiness>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct SpecularGlossiness {
    pub(super) diffuse_factor: [f32; 4],
    pub(super) diffuse_texture: Option<TextureRef>,
    pub(super) specular_glossiness_texture: Option<TextureRef>,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self { diffuse_factor: [1.0; 4], diffuse_texture: None, specular_glossiness_texture: None }
    }
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct TextureRef {
    pub(super) index: usize,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfTexture {
    pub(super) source: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct GltfImage {
    /// A file beside the mesh, or a data URI.
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<usize>,
}
