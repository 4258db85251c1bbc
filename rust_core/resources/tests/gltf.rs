//! glTF meshes as rviz shows them.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use std::fs;

use common::{fault, glb, load, load_bytes, normals, positions, uvs, GLTF, GLTF_DATA};
use rcs_resources::{warning_texture, LoadedMesh, MeshFault, ResourceError};
use rcs_scene::Rgba;

/// [`GLTF`] with its data inside.
fn text() -> String {
    GLTF.replace("DATA", GLTF_DATA)
}

/// [`text`] with a replacement.
fn changed(from: &str, to: &str) -> String {
    let text = text().replacen(from, to, 1);
    assert!(text.contains(to), "{from}");
    text
}

fn read(text: &str) -> LoadedMesh {
    LoadedMesh::clone(&load_bytes("a.gltf", text.as_bytes()).unwrap())
}

/// Positions, normals and colour of a part.
type Part = (Vec<[f32; 3]>, Vec<[f32; 3]>, Rgba);

fn all(mesh: &LoadedMesh) -> Vec<Part> {
    mesh.parts.iter().map(|part| (positions(part), normals(part), part.material.diffuse)).collect()
}

#[test]
fn the_root_loses_its_rotation_and_its_children_keep_theirs() {
    let mesh = read(&text());
    let [root, child] = mesh.parts.as_slice() else { panic!("two parts are expected") };
    // Scaled by 2 and moved by (0, 0, 1), not turned about z.
    assert_eq!(positions(root), [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]]);
    // Its child is turned by 90 degrees about z, and moved by (1, 0, 0), in the scaled root.
    assert_eq!(positions(child), [[2.0, 0.0, 1.0], [2.0, 2.0, 1.0], [0.0, 0.0, 1.0]]);
    assert_eq!(normals(child), [[0.0, 0.0, 1.0]; 3]);
}

#[test]
fn nodes_keep_their_rotation_where_there_are_several_roots() {
    let mesh = read(&changed("\"nodes\": [0]", "\"nodes\": [0, 2]"));
    assert_eq!(positions(&mesh.parts[0]), [[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [-2.0, 0.0, 1.0]]);
}

/// As the specification of glTF 2.0 demands (3.7.4).
#[test]
fn mirrored_nodes_turn_their_triangles() {
    let mirrored = read(&changed("\"translation\": [1,0,0]", "\"translation\": [1,0,0], \"scale\": [1,1,-1]"));
    let [root, child] = mirrored.parts.as_slice() else { panic!("two parts are expected") };
    assert_eq!(positions(root), positions(&read(&text()).parts[0]));
    let [a, b, c] = positions(&read(&text()).parts[1])[..] else { panic!("a triangle is expected") };
    assert_eq!(positions(child), [a, c, b]);
}

#[test]
fn a_matrix_is_read_column_by_column() {
    let matrix = "\"matrix\": [0,1,0,0, -1,0,0,0, 0,0,1,0, 1,0,0,1]";
    let mesh = read(&changed("\"translation\": [1,0,0], \"rotation\": [0,0,0.70710678,0.70710678]", matrix));
    assert_eq!(all(&mesh), all(&read(&text())));
}

#[test]
fn a_materials_base_colour_is_diffuse_and_opaque() {
    let mesh = read(&text());
    assert_eq!(mesh.parts[0].material.diffuse, Rgba::new(0.5, 0.25, 0.125, 1.0));
    assert_eq!(mesh.parts[0].material.emissive, Rgba::new(0.0, 0.0, 0.5, 1.0));
    assert!(mesh.parts[0].material.embedded);
    // A primitive without a material.
    assert_eq!(mesh.parts[1].material.diffuse, Rgba::WHITE);
}

#[test]
fn a_glb_and_data_beside_the_file_are_read_as_data_inside() {
    let expected = all(&read(&text()));
    let in_glb = load_bytes("a.glb", &glb(&GLTF.replace(", \"uri\": \"data:x/y;base64,DATA\"", ""))).unwrap();
    assert_eq!(all(&in_glb), expected);
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("the data.bin"), common::gltf_data()).unwrap();
    for name in ["the data.bin", "the%20data.bin"] {
        fs::write(dir.path().join("a.gltf"), GLTF.replace("data:x/y;base64,DATA", name)).unwrap();
        assert_eq!(all(&load(&dir.path().join("a.gltf")).unwrap()), expected, "{name}");
    }
}

#[test]
fn data_outside_of_allowed_folders_are_not_read() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("secret.bin"), common::gltf_data()).unwrap();
    fs::create_dir(dir.path().join("meshes")).unwrap();
    let path = dir.path().join("meshes/a.gltf");
    fs::write(&path, GLTF.replace("data:x/y;base64,DATA", "../secret.bin")).unwrap();
    let error = load(&path).unwrap_err();
    assert!(
        matches!(&error, ResourceError::BadMesh { fault: MeshFault::Malformed(what), .. }
        if what.contains("secret.bin") && what.contains("--mesh-folder")),
        "{error}"
    );
}

#[test]
fn a_texture_beside_the_file_or_in_it_is_laid_on_twice_as_in_rviz() {
    let dir = tempfile::tempdir().unwrap();
    image::RgbaImage::from_pixel(2, 2, image::Rgba([255, 128, 0, 255])).save(dir.path().join("t.png")).unwrap();
    let png = fs::read(dir.path().join("t.png")).unwrap();
    let textured = |image: &str| {
        changed("\"baseColorFactor\": [0.5,0.25,0.125,0.5]", "\"baseColorTexture\": {\"index\": 0}").replacen(
            "\"materials\"",
            &format!("\"textures\": [{{\"source\": 0}}], \"images\": [{image}], \"materials\""),
            1,
        )
    };
    let inside = format!("{{\"uri\": \"data:image/png;base64,{}\"}}", common::base64(&png));
    for image in ["{\"uri\": \"t.png\"}", &inside] {
        fs::write(dir.path().join("a.gltf"), textured(image)).unwrap();
        let mesh = load(&dir.path().join("a.gltf")).unwrap();
        assert!(mesh.warnings.is_empty(), "{:?}", mesh.warnings);
        assert_eq!(mesh.parts[0].material.texture.as_ref().unwrap().rgba[0], [255, 64, 0, 255]);
        assert!(mesh.parts[1].material.texture.is_none());
    }
    fs::write(dir.path().join("a.gltf"), textured("{\"uri\": \"none.png\"}")).unwrap();
    let mesh = load(&dir.path().join("a.gltf")).unwrap();
    assert_eq!(mesh.parts[0].material.texture.as_ref().unwrap().rgba[0], warning_texture().rgba[0]);
    assert_eq!(mesh.warnings.len(), 1);
}

#[test]
fn texture_coordinates_point_down_as_in_the_file() {
    // The first three vertices, read as u and v.
    let mesh =
        read(&changed("\"attributes\": {\"POSITION\": 0}", "\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 2}"));
    assert_eq!(uvs(&mesh.parts[0]), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
}

#[test]
fn integers_that_are_normalised_become_floats() {
    let mesh =
        read(&changed("\"attributes\": {\"POSITION\": 0}", "\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 3}"));
    // The bytes of the indices 0, 1 and 2, of 16 bits.
    let expected = [[0.0, 0.0], [1.0 / 255.0, 0.0], [2.0 / 255.0, 0.0]];
    for (uv, expected) in uvs(&mesh.parts[0]).iter().zip(expected) {
        assert!((uv[0] - expected[0]).abs() < 1e-6 && (uv[1] - expected[1]).abs() < 1e-6, "{uv:?}");
    }
}

#[test]
fn sparse_values_replace_those_of_their_accessor() {
    let sparse = "\"type\": \"VEC3\", \"sparse\": {\"count\": 1, \
                  \"indices\": {\"bufferView\": 1, \"byteOffset\": 4, \"componentType\": 5123}, \"values\": {\"bufferView\": 0, \"byteOffset\": 12}}";
    let mesh = read(&changed("\"type\": \"VEC3\"", sparse));
    assert_eq!(positions(&mesh.parts[0])[2], [2.0, 0.0, 1.0]);
}

#[test]
fn faces_with_indices_past_the_end_are_dropped_and_a_primitive_without_any_is_refused() {
    let error = fault(load_bytes(
        "a.gltf",
        changed("\"count\": 3, \"type\": \"VEC3\"", "\"count\": 2, \"type\": \"VEC3\"").as_bytes(),
    ));
    assert!(matches!(error, MeshFault::Malformed(what) if what.contains("no faces")));
}

#[test]
fn a_mesh_is_read_once_however_often_it_is_placed() {
    let mesh = read(&changed("\"children\": [1]", "\"children\": [1, 2, 2]"));
    assert_eq!(mesh.parts.len(), 4);
    assert_eq!(positions(&mesh.parts[2]), positions(&mesh.parts[3]));
}

#[test]
fn what_is_wrong_with_a_gltf_file_is_said() {
    let error = |text: &str| match fault(load_bytes("a.gltf", text.as_bytes())) {
        MeshFault::Malformed(what) => what,
        other => other.to_string(),
    };
    for (from, to, said) in [
        ("\"version\": \"2.0\"", "\"version\": \"1.0\"", "only 2.0"),
        ("\"asset\"", "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"asset\"", "KHR_draco"),
        ("\"nodes\": [0]", "\"nodes\": [7]", "no node 7"),
        ("\"children\": [1]", "\"children\": [0]", "contain themselves"),
        ("\"mesh\": 1", "\"mesh\": 9", "no mesh 9"),
        ("\"POSITION\": 0", "\"POSITION\": 9", "no accessor 9"),
        ("\"POSITION\": 0", "\"NORMAL\": 0", "no POSITION"),
        ("\"byteLength\": 36", "\"byteLength\": 3600", "past the end"),
        ("\"count\": 3", "\"count\": 30", "past the end"),
        ("\"componentType\": 5126", "\"componentType\": 1", "component type 1"),
        ("base64,", "base64,*", "not base64"),
        ("\"scene\": 0,", "\"scene\": 0,,", "line 2 column"),
        ("\"scenes\"", "\"others\"", "no scene"),
    ] {
        let what = error(&changed(from, to));
        assert!(what.contains(said), "{what}");
    }
    let glb = glb(&text());
    let error = |bytes: &[u8]| fault(load_bytes("a.glb", bytes)).to_string();
    assert!(error(&glb[..30]).contains("JSON"));
    assert!(error(&glb[..glb.len() - 1]).contains("cut off in its data"));
    assert!(error(b"glTF\x01\0\0\0").contains("version 1"));
}

#[test]
fn zeros_of_a_count_that_no_file_fills_are_refused() {
    let zeros = changed(
        "\"bufferView\": 0, \"componentType\": 5126, \"count\": 3",
        "\"componentType\": 5126, \"count\": 30000000",
    );
    assert!(matches!(fault(load_bytes("a.gltf", zeros.as_bytes())), MeshFault::TooLarge { .. }));
}
