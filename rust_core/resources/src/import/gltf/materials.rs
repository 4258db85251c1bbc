//! Materials and their embedded images.

use std::collections::HashMap;

use super::{
    buffers::{data_of_uri, GltfBuffers},
    json::{GltfMaterial, GltfRoot, TextureRef},
};
use crate::{import::imported::MaterialSpec, MeshFault};

/// Image files by their names in the materials.
pub(super) type Images = HashMap<String, Vec<u8>>;

/// The materials of a file, the default for primitives last, and their embedded images.
pub(super) fn read(root: &GltfRoot, buffers: &GltfBuffers<'_>) -> Result<(Vec<MaterialSpec>, Images), MeshFault> {
    let mut specs: Vec<MaterialSpec> = root.materials.iter().map(|material| spec(root, material)).collect();
    specs.push(spec(root, &GltfMaterial::default()));
    let mut images = Images::new();
    for (number, image) in root.images.iter().enumerate() {
        let name = embedded_name(number);
        if !specs.iter().any(|spec| spec.diffuse_texture == name) {
            continue;
        }
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => data_of_uri(uri).transpose()?.unwrap_or_default(),
            (None, Some(view)) => buffers.view(view)?.1.to_owned(),
            (None, None) => continue,
        };
        images.insert(name, bytes);
    }
    Ok((specs, images))
}

/// Assimp's name of an embedded image.
fn embedded_name(number: usize) -> String {
    format!("*{number}")
}

/// The material as Assimp reports it. Diffuse colour and texture are the base colour's, or the
/// specular-glossiness extension's.
fn spec(root: &GltfRoot, material: &GltfMaterial) -> MaterialSpec {
    let image_of = |texture: Option<TextureRef>| root.textures.get(texture?.index)?.source;
    let base = &material.pbr_metallic_roughness;
    let [red, green, blue, _] = base.base_color_factor;
    let base_image = image_of(base.base_color_texture);
    let mut spec =
        MaterialSpec { diffuse: [red, green, blue], emissive: material.emissive_factor, ..MaterialSpec::DEFAULT };
    let mut diffuse_image = base_image;
    // Base colour, metallic with roughness, normal, occlusion, emissive.
    let slots = [
        (base_image, 2),
        (image_of(base.metallic_roughness_texture), 3),
        (image_of(material.normal_texture), 1),
        (image_of(material.occlusion_texture), 1),
        (image_of(material.emissive_texture), 1),
    ];
    spec.texture_count = slots.iter().filter(|(image, _)| image.is_some()).map(|(_, times)| times).sum();
    if let Some(glossy) = &material.extensions.specular_glossiness {
        let [red, green, blue, _] = glossy.diffuse_factor;
        spec.diffuse = [red, green, blue];
        if let Some(image) = image_of(glossy.diffuse_texture) {
            // Replaces one of the base colour's two slots.
            spec.texture_count += usize::from(base_image.is_none());
            diffuse_image = Some(image);
        }
        spec.texture_count += usize::from(image_of(glossy.specular_glossiness_texture).is_some());
    }
    if let Some(number) = diffuse_image {
        let file = root.images.get(number).and_then(|image| image.uri.as_ref()).filter(|uri| !uri.starts_with("data:"));
        spec.diffuse_texture = file.map_or_else(|| embedded_name(number), String::clone);
    }
    spec
}
