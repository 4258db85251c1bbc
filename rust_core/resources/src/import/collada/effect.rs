//! Materials and their effects: the colours and the diffuse texture. Transparency has no effect in rviz, see
//! [`MaterialSpec`].

use std::collections::{BTreeMap, HashMap};

use percent_encoding::percent_decode_str;

use super::dom::{attribute, floats, text, Node};
use crate::import::imported::MaterialSpec;

/// Materials in the order of their ids, as Assimp numbers them.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub(super) specs: Vec<MaterialSpec>,
    /// Index into `specs` of a material's id.
    pub(super) by_id: HashMap<String, usize>,
}

/// An effect's colour and texture of one kind.
#[derive(Clone, Debug)]
struct EffectChannel {
    color: [f32; 4],
    /// The name of a sampler or image; empty for none.
    texture: String,
}

/// The channels of an effect, with Assimp's default grey.
const CHANNELS: [(&str, f32); 7] = [
    ("emission", 0.0),
    ("diffuse", 0.6),
    ("ambient", 0.1),
    ("specular", 0.4),
    ("transparent", 0.0),
    ("reflective", 0.0),
    ("bump", 0.0),
];

/// Reads `library_materials` with its effects and images.
pub(super) fn read_materials(root: Node<'_>) -> Materials {
    let mut images = HashMap::new();
    let mut effects: HashMap<&str, Node<'_>> = HashMap::new();
    let mut effect_of: BTreeMap<&str, &str> = BTreeMap::new();
    for library in root.elements.iter() {
        match library.name {
            "library_images" => read_images(library, &mut images),
            "library_effects" => {
                for effect in library.children("effect") {
                    effects.insert(attribute(effect, "id"), effect);
                }
            }
            "library_materials" => {
                for material in library.children("material") {
                    let effect = material.children("instance_effect").last();
                    let url = effect.map(|effect| attribute(effect, "url")).unwrap_or_default();
                    effect_of.insert(attribute(material, "id"), url.trim_start_matches('#'));
                }
            }
            _ => {}
        }
    }
    for effect in effects.values() {
        for profile in effect.children("profile_COMMON") {
            read_images(profile, &mut images);
        }
    }
    let mut materials = Materials::default();
    for (id, effect) in effect_of {
        if let Some(effect) = effects.get(effect) {
            materials.by_id.insert(id.to_owned(), materials.specs.len());
            materials.specs.push(read_effect(effect, &images));
        }
    }
    materials
}

/// File names by image id: the text of `init_from`, or in COLLADA 1.5 of the `ref` in it.
fn read_images<'a>(parent: Node<'a>, images: &mut HashMap<&'a str, String>) {
    for image in parent.children("image") {
        let from = image.child("init_from");
        let name = from.map(|from| text(from.child("ref").unwrap_or(from))).unwrap_or_default();
        let name = name.strip_prefix("file://").unwrap_or(name);
        images.insert(attribute(image, "id"), percent_decode_str(name).decode_utf8_lossy().into_owned());
    }
}

fn read_effect(effect: Node<'_>, images: &HashMap<&str, String>) -> MaterialSpec {
    let mut channels =
        CHANNELS.map(|(_, grey)| EffectChannel { color: [grey, grey, grey, 1.0], texture: String::new() });
    let mut flat = false;
    // Targets of parameters: a sampler's surface, a surface's image.
    let mut parameters: HashMap<&str, &str> = HashMap::new();

    for node in effect.children("profile_COMMON").flat_map(|profile| profile.descendants()) {
        match node.name {
            "newparam" => {
                if let Some(target) = parameter_target(node) {
                    parameters.insert(attribute(node, "sid"), target);
                }
            }
            "faceted" => flat = matches!(text(node), "1" | "true"),
            name => {
                let known = CHANNELS.iter().position(|(known, _)| *known == name);
                if let Some(channel) = known.and_then(|index| channels.get_mut(index)) {
                    channel.read(node);
                }
            }
        }
    }

    let texture_count = channels.iter().filter(|channel| !channel.texture.is_empty()).count();
    let [emission, diffuse, ..] = &channels;
    let rgb = |channel: &EffectChannel| {
        let [r, g, b, _] = channel.color;
        [r, g, b]
    };
    MaterialSpec {
        diffuse: rgb(diffuse),
        emissive: rgb(emission),
        flat,
        diffuse_texture: image_file(&diffuse.texture, &parameters, images),
        texture_count,
    }
}

impl EffectChannel {
    /// Reads the `color` or `texture` in an element; a texture's colour is white.
    fn read(&mut self, node: Node<'_>) {
        for child in node.descendants().skip(1) {
            match child.name {
                "color" => self.color.iter_mut().zip(floats(child)).for_each(|(channel, value)| *channel = value),
                "texture" => {
                    attribute(child, "texture").clone_into(&mut self.texture);
                    self.color = [1.0; 4];
                }
                _ => {}
            }
        }
    }
}

/// The target of a `newparam`: a surface's `init_from`, a sampler's `source` or (1.5) `instance_image`.
fn parameter_target<'a>(parameter: Node<'a>) -> Option<&'a str> {
    parameter
        .descendants()
        .filter_map(|node| match node.name {
            "init_from" | "source" => Some(text(node)),
            "instance_image" => Some(attribute(node, "url").trim_start_matches('#')),
            _ => None,
        })
        .last()
}

/// The file of a texture's image, followed through samplers and surfaces; `name.jpg` when there is no such image.
fn image_file(texture: &str, parameters: &HashMap<&str, &str>, images: &HashMap<&str, String>) -> String {
    if texture.is_empty() {
        return String::new();
    }
    let mut name = texture;
    // No chain is longer than there are parameters, unless it is a ring.
    for _ in 0..=parameters.len() {
        match parameters.get(name) {
            Some(target) => name = target,
            None => break,
        }
    }
    images.get(name).cloned().unwrap_or_else(|| format!("{name}.jpg"))
}
