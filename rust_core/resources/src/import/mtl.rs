//! OBJ's material files, with Assimp's defaults.

use super::{
    imported::{MaterialSpec, MAX_MATERIALS},
    lenient_float::{leading_f32, three},
};

/// Assimp's name for the material of faces without one.
pub(super) const DEFAULT_MATERIAL: &str = "DefaultMaterial";

/// Prefixes of texture statements with the kind of texture; the first that matches counts.
const TEXTURES: [(&str, &str); 17] = [
    ("map_kd", "diffuse"),
    ("map_ka", "ambient"),
    ("map_ks", "specular"),
    ("map_disp", "displacement"),
    ("disp", "displacement"),
    ("map_d", "opacity"),
    ("map_emissive", "emissive"),
    ("map_ke", "emissive"),
    ("map_bump", "bump"),
    ("bump", "bump"),
    ("map_kn", "normal"),
    ("norm", "normal"),
    ("refl", "reflection"),
    ("map_ns", "shininess"),
    ("map_pr", "roughness"),
    ("map_pm", "metallic"),
    ("map_ps", "sheen"),
];

/// A material with its name.
#[derive(Clone, Debug)]
pub(super) struct NamedMaterial {
    pub(super) name: String,
    pub(super) spec: MaterialSpec,
    /// The kinds of its textures; each counts once.
    textures: Vec<&'static str>,
}

impl NamedMaterial {
    /// A material before its file sets anything.
    pub(super) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), spec: MaterialSpec::DEFAULT, textures: Vec::new() }
    }
}

/// Adds a file's materials to `materials`, or changes those of the same name; `defined` is called with the index of
/// each and whether it is new.
pub(super) fn read(text: &str, materials: &mut Vec<NamedMaterial>, mut defined: impl FnMut(usize, bool)) {
    let mut current: Option<usize> = None;
    for line in text.lines() {
        let line = line.trim();
        let (keyword, rest) = line.split_once([' ', '\t']).unwrap_or((line, ""));
        let keyword = keyword.to_ascii_lowercase();
        if keyword == "newmtl" {
            let name = if rest.trim().is_empty() { DEFAULT_MATERIAL } else { rest.trim() };
            let known = materials.iter().position(|material| material.name == name);
            if known.is_none() && materials.len() > MAX_MATERIALS {
                // Above the limit, so the caller refuses the file.
                return;
            }
            let index = known.unwrap_or_else(|| {
                materials.push(NamedMaterial::new(name));
                materials.len() - 1
            });
            defined(index, known.is_none());
            current = Some(index);
            continue;
        }
        let Some(material) = current.and_then(|index| materials.get_mut(index)) else { continue };
        let spec = &mut material.spec;
        match keyword.as_str() {
            "kd" => spec.diffuse = color(rest),
            "ke" => spec.emissive = color(rest),
            _ => {
                let Some(&(_, kind)) = TEXTURES.iter().find(|(start, _)| keyword.starts_with(start)) else { continue };
                let file = after_options(rest);
                if file.is_empty() {
                    continue;
                }
                if !material.textures.contains(&kind) {
                    material.textures.push(kind);
                    spec.texture_count += 1;
                }
                if kind == "diffuse" {
                    file.clone_into(&mut spec.diffuse_texture);
                }
            }
        }
    }
}

/// Three channels; one alone is red, as Assimp reads it.
fn color(rest: &str) -> [f32; 3] {
    let mut words = rest.split_ascii_whitespace();
    if let Some(color) = three(&mut words.clone()) {
        return color;
    }
    [words.next().and_then(leading_f32).unwrap_or(0.0), 0.0, 0.0]
}

/// A texture statement's file name, which may hold blanks, past options such as `-s 1 1 1`.
fn after_options(mut rest: &str) -> &str {
    loop {
        rest = rest.trim_start();
        if !rest.starts_with('-') {
            return rest.trim_end();
        }
        let option = rest.split_ascii_whitespace().next().unwrap_or_default().to_ascii_lowercase();
        let values = match option.as_str() {
            "-clamp" | "-type" | "-bm" | "-blendu" | "-blendv" | "-boost" | "-texres" | "-imfchan" => 1,
            "-mm" => 2,
            "-o" | "-s" | "-t" => 3,
            _ => 0,
        };
        for _ in 0..=values {
            rest = rest.trim_start();
            rest = rest.find(char::is_whitespace).and_then(|end| rest.get(end..)).unwrap_or_default();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_before_a_texture_are_skipped() {
        for (statement, file) in [
            ("crate.png", "crate.png"),
            ("  my crate.png \r", "my crate.png"),
            ("-clamp on -s 1 1 1 a.png", "a.png"),
            ("-mm 0 1 -bm 0.3 a.png", "a.png"),
            ("-s 1", ""),
            ("-", ""),
        ] {
            assert_eq!(after_options(statement), file, "{statement:?}");
        }
    }

    #[test]
    fn materials_are_read_with_assimps_defaults() {
        let mut materials = Vec::new();
        let text = "newmtl a\nKd 1 0.5 0\nmap_Kd a.png\nmap_Bump b.png\nbump b.png\nnewmtl b\n  Kd 0.5";
        read(text, &mut materials, |_, _| {});
        let [a, b] = materials.as_slice() else { panic!("two materials are expected: {materials:?}") };
        assert_eq!((a.spec.diffuse, a.spec.texture_count), ([1.0, 0.5, 0.0], 2));
        assert_eq!(a.spec.diffuse_texture, "a.png");
        assert_eq!((b.spec.diffuse, b.spec.texture_count), ([0.5, 0.0, 0.0], 0));
    }
}
