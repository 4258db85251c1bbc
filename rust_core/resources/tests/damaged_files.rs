//! Damaged mesh files give errors or meshes that are whole, never a panic.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use common::{binary_stl, glb, load_bytes, DAE, GLTF, GLTF_DATA, MTL, OBJ, PLY, TEXT_STL, TRIANGLES};
use proptest::prelude::*;

/// Damage of a file: bytes are overwritten, removed, doubled, or the end is lost.
#[derive(Clone, Debug)]
enum Damage {
    Overwrite(usize, Vec<u8>),
    Remove(usize, usize),
    Repeat(usize, usize),
    CutOff(usize),
}

fn damage() -> impl Strategy<Value = Damage> {
    // Digits, separators and the ends of ranges do more than any byte.
    let telling = prop::sample::select(b"0123456789 -/.#<>\"\n\xff\x00ef".to_vec());
    prop_oneof![
        (any::<usize>(), prop::collection::vec(prop_oneof![telling, any::<u8>()], 1..5))
            .prop_map(|(at, bytes)| Damage::Overwrite(at, bytes)),
        (any::<usize>(), 1..40_usize).prop_map(|(at, count)| Damage::Remove(at, count)),
        (any::<usize>(), 1..200_usize).prop_map(|(at, count)| Damage::Repeat(at, count)),
        any::<usize>().prop_map(Damage::CutOff),
    ]
}

fn damaged(file: &[u8], damages: &[Damage]) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for damage in damages {
        let place = |at: usize| at % (bytes.len() + 1);
        match damage {
            Damage::Overwrite(at, new) => {
                let at = place(*at);
                let end = (at + new.len()).min(bytes.len());
                bytes.splice(at..end, new.iter().copied());
            }
            Damage::Remove(at, count) => {
                let at = place(*at);
                bytes.drain(at..(at + count).min(bytes.len()));
            }
            Damage::Repeat(at, count) => {
                let at = place(*at);
                let piece = bytes[at..(at + count).min(bytes.len())].to_vec();
                bytes.splice(at..at, piece);
            }
            Damage::CutOff(at) => bytes.truncate(place(*at)),
        }
    }
    bytes
}

/// Loads it; what loads is fit to draw.
fn check(name: &str, bytes: &[u8]) -> Result<(), TestCaseError> {
    if let Ok(mesh) = load_bytes(name, bytes) {
        for part in &mesh.parts {
            prop_assert!(!part.mesh.indices.is_empty() && part.mesh.indices.len() % 3 == 0);
            prop_assert!(part.mesh.indices.iter().all(|&index| (index as usize) < part.mesh.vertices.len()));
            for vertex in &part.mesh.vertices {
                prop_assert!(vertex.position.iter().chain(&vertex.normal).all(|x| x.is_finite()));
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_binary_stl(damages in prop::collection::vec(damage(), 1..4)) {
        check("a.stl", &damaged(&binary_stl(b"solid", &TRIANGLES), &damages))?;
    }

    #[test]
    fn damaged_text_stl(damages in prop::collection::vec(damage(), 1..4)) {
        check("a.stl", &damaged(TEXT_STL.as_bytes(), &damages))?;
    }

    #[test]
    fn damaged_obj(damages in prop::collection::vec(damage(), 1..4)) {
        check("a.obj", &damaged(OBJ.as_bytes(), &damages))?;
    }

    #[test]
    fn damaged_materials(damages in prop::collection::vec(damage(), 1..4)) {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("a.obj"), OBJ).unwrap();
        std::fs::write(dir.path().join("things.mtl"), damaged(MTL.as_bytes(), &damages)).unwrap();
        let mesh = common::load(&dir.path().join("a.obj"));
        prop_assert!(mesh.is_ok_and(|mesh| !mesh.parts.is_empty()));
    }

    #[test]
    fn damaged_collada(damages in prop::collection::vec(damage(), 1..4)) {
        check("a.dae", &damaged(DAE.as_bytes(), &damages))?;
    }

    #[test]
    fn damaged_ply(damages in prop::collection::vec(damage(), 1..4)) {
        check("a.ply", &damaged(PLY.as_bytes(), &damages))?;
    }

    #[test]
    fn damaged_gltf(damages in prop::collection::vec(damage(), 1..4)) {
        check("a.gltf", &damaged(GLTF.replace("DATA", GLTF_DATA).as_bytes(), &damages))?;
    }

    #[test]
    fn damaged_glb(damages in prop::collection::vec(damage(), 1..4)) {
        check("a.glb", &damaged(&glb(&GLTF.replace(", \"uri\": \"data:x/y;base64,DATA\"", "")), &damages))?;
    }

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        for name in ["a.stl", "a.obj", "a.dae", "a.ply", "a.gltf"] {
            check(name, &bytes)?;
        }
    }

    #[test]
    fn numbers_within_collada_of_any_size(number in any::<i64>(), place in 0..8_usize) {
        let places = ["count=\"4\"", "stride=\"3\"", "offset=\"1\"", "count=\"1\"", "count=\"12\"", "set=\"0\"", "<vcount>4", "<p>0"];
        let right = places[place];
        let wrong: String = right.chars().filter(|c| !c.is_ascii_digit()).collect::<String>();
        let wrong = match wrong.strip_suffix('"') {
            Some(start) => format!("{start}{number}\""),
            None => format!("{wrong}{number}"),
        };
        check("a.dae", DAE.replace(right, &wrong).as_bytes())?;
    }
}
