//! Meshes as rviz shows them, by way of Assimp.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use std::{fs, path::Path, sync::Arc};

use common::{
    binary_stl, fault, get, load, load_bytes, normals, positions, store_of, uvs, DAE, MTL, OBJ, TEXT_STL, TRIANGLES,
};
use rcs_resources::{warning_texture, LoadedMesh, MeshFault, MeshStore, PackageIndex, ResourceError};
use rcs_scene::{Blending, CullMode, Filtering, Lighting, Rgba, Wrapping};

fn write_png(path: &Path, texel: [u8; 4]) {
    image::RgbaImage::from_pixel(2, 3, image::Rgba(texel)).save(path).unwrap();
}

#[test]
fn stl_faces_have_the_files_normals_at_all_corners() {
    let mesh = load_bytes("a.stl", &binary_stl(b"", &TRIANGLES)).unwrap();
    let [part] = mesh.parts.as_slice() else { panic!("one part is expected") };
    assert_eq!(positions(part)[..3], TRIANGLES[0][1..]);
    // Not (0, 0, 1), which the corners would give, and made unit length.
    assert_eq!(normals(part)[..3], [[0.0, 0.6, 0.8]; 3]);
    assert_eq!(normals(part)[3..], [[0.0, 1.0, 0.0]; 3]);
    assert!(!part.material.embedded);
}

#[test]
fn one_zero_normal_makes_all_of_an_stl_files_normals_computed() {
    for zero in [[0.0; 3], [f32::NAN, 0.0, 1.0]] {
        let mut triangles = TRIANGLES;
        triangles[1][0] = zero;
        let mesh = load_bytes("a.stl", &binary_stl(b"", &triangles)).unwrap();
        assert_eq!(normals(&mesh.parts[0])[..3], [[0.0, 0.0, 1.0]; 3]);
        assert_eq!(normals(&mesh.parts[0])[3..], [[1.0, 0.0, 0.0]; 3]);
    }
}

#[test]
fn a_binary_stl_file_may_begin_like_a_text_file_and_have_more_bytes_but_not_fewer() {
    for (name, header, more) in [
        ("a.STL", &b"solid made by a CAD program"[..], &b""[..]),
        ("a.stl", b"", b"some more"),
        ("a.stl", b"solid\0", b"some more"),
    ] {
        let mesh = load_bytes(name, &[&binary_stl(header, &TRIANGLES), more].concat()).unwrap();
        assert_eq!(mesh.parts[0].mesh.indices.len(), 6);
    }
    let bytes = binary_stl(b"", &TRIANGLES);
    let fault = fault(load_bytes("a.stl", &bytes[..bytes.len() - 1]));
    assert_eq!(fault, MeshFault::TruncatedStl { announced: 2, present: 1 });
}

#[test]
fn each_solid_of_a_text_stl_file_is_a_part() {
    let mesh = load_bytes("a.stl", TEXT_STL.as_bytes()).unwrap();
    let [first, second] = mesh.parts.as_slice() else { panic!("two parts are expected") };
    assert_eq!(positions(first), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(normals(second), [[1.0, 0.0, 0.0]; 3]);
}

#[test]
fn faults_in_text_stl_files_are_reported_with_their_line() {
    let text = "solid x\nfacet normal 0 0 1\nvertex 1 2\n";
    assert!(matches!(fault(load_bytes("a.stl", text.as_bytes())), MeshFault::Line { line: 3, .. }));
    assert_eq!(fault(load_bytes("a.stl", b"solid empty\nendsolid empty\n")), MeshFault::Empty);
    assert_eq!(fault(load_bytes("a.stl", b"not a mesh")), MeshFault::NotStl);
}

fn obj_folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("thing.obj"), OBJ).unwrap();
    fs::write(dir.path().join("things.mtl"), MTL).unwrap();
    write_png(&dir.path().join("red.png"), [255, 128, 0, 255]);
    dir
}

#[test]
fn obj_faces_become_a_part_for_each_material() {
    let dir = obj_folder();
    let mesh = load(&dir.path().join("thing.obj")).unwrap();
    let [red, blue] = mesh.parts.as_slice() else { panic!("two parts are expected") };
    assert!(mesh.warnings.is_empty());
    assert_eq!(red.mesh.indices, [0, 1, 2, 0, 2, 3]);
    // v points down once loaded.
    assert_eq!(uvs(red)[..3], [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]);
    let texture = red.material.texture.as_ref().unwrap();
    assert_eq!((texture.width, texture.height, texture.rgba[0]), (2, 3, [255, 128, 0, 255]));
    assert_eq!((texture.filtering, texture.wrapping), (Filtering::BilinearMipmap, Wrapping::Repeat));
    assert_eq!(positions(blue), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    assert_eq!(blue.material.emissive, Rgba::new(0.1, 0.1, 0.1, 1.0));
    assert!(blue.material.texture.is_none());
}

#[test]
fn a_files_transparency_does_not_show_in_rviz() {
    let dir = obj_folder();
    let mesh = load(&dir.path().join("thing.obj")).unwrap();
    assert_eq!(mesh.parts[0].material.diffuse, Rgba::new(1.0, 0.0, 0.0, 1.0));
    let material = mesh.parts[0].material.to_scene();
    assert_eq!((material.blending, material.depth_write, material.cull), (Blending::Replace, true, CullMode::Back));
    let Lighting::Lit { diffuse, .. } = material.lighting else { panic!("it is lit") };
    assert_eq!(diffuse.a, 1.0);
}

#[test]
fn a_missing_or_damaged_texture_is_reported_and_shows_ogres_stripes() {
    let dir = obj_folder();
    fs::remove_file(dir.path().join("red.png")).unwrap();
    let mesh = load(&dir.path().join("thing.obj")).unwrap();
    let texture = mesh.parts[0].material.texture.as_ref().unwrap();
    assert_eq!(**texture, *warning_texture());
    assert_eq!(texture.rgba[3..5], [[0, 0, 0, 255], [255, 255, 0, 255]]);
    let [warning] = mesh.warnings.as_slice() else { panic!("one warning is expected: {:?}", mesh.warnings) };
    assert!(warning.to_string().contains("red.png"), "{warning}");
    assert_eq!(mesh.parts.len(), 2);

    // The last is a JPEG on which its decoder panics, after the byte that chooses a format for the fuzzer.
    let jpeg = include_bytes!("../../../fuzz/regressions/compressed_image/jpeg_whose_decoder_panics");
    for damaged in [&b"\x89PNG\r\n\x1a\n damaged"[..], &jpeg[1..]] {
        fs::write(dir.path().join("red.png"), damaged).unwrap();
        let mesh = load(&dir.path().join("thing.obj")).unwrap();
        assert!(matches!(mesh.warnings.as_slice(), [ResourceError::BadImage { .. }]), "{:?}", mesh.warnings);
        assert_eq!(**mesh.parts[0].material.texture.as_ref().unwrap(), *warning_texture());
    }
}

#[test]
fn every_texture_of_a_material_lays_its_diffuse_texture_on_once_more() {
    let dir = obj_folder();
    fs::write(dir.path().join("things.mtl"), format!("{MTL}newmtl red\nmap_Bump -bm 0.2 bumps.png\n")).unwrap();
    let mesh = load(&dir.path().join("thing.obj")).unwrap();
    assert_eq!(mesh.parts[0].material.texture.as_ref().unwrap().rgba[0], [255, 64, 0, 255]);
}

#[test]
fn a_material_with_a_bump_texture_alone_shows_ogres_stripes() {
    let dir = obj_folder();
    fs::write(dir.path().join("things.mtl"), "newmtl red\nmap_Bump red.png\n").unwrap();
    let mesh = load(&dir.path().join("thing.obj")).unwrap();
    assert_eq!(mesh.parts[0].material.texture.as_deref(), Some(&*warning_texture()));
    assert!(matches!(mesh.warnings.as_slice(), [ResourceError::NoDiffuseTexture { .. }]), "{:?}", mesh.warnings);
}

#[test]
fn an_obj_file_without_its_materials_is_grey() {
    let mesh = load_bytes("thing.obj", OBJ.as_bytes()).unwrap();
    assert_eq!(mesh.parts.len(), 2);
    for part in &mesh.parts {
        assert_eq!((part.material.diffuse, part.material.embedded), (Rgba::new(0.6, 0.6, 0.6, 1.0), true));
    }
}

#[test]
fn a_material_library_of_another_name_is_found_by_the_meshs() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("thing.obj"), OBJ).unwrap();
    fs::write(dir.path().join("thing.mtl"), MTL).unwrap();
    let mesh = load(&dir.path().join("thing.obj")).unwrap();
    assert_eq!(mesh.parts[1].material.diffuse, Rgba::new(0.0, 0.0, 1.0, 1.0));
}

#[test]
fn obj_faces_without_normals_are_flat_and_lines_make_a_part() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nl 1 2 3\nf 1 2 3\nf 1 3 4\nl 3 4\n";
    let mesh = load_bytes("a.obj", text.as_bytes()).unwrap();
    let [lines, faces] = mesh.parts.as_slice() else { panic!("two parts are expected") };
    // rviz draws the corners of three lines as two triangles.
    assert_eq!(lines.mesh.indices.len(), 6);
    assert_eq!(positions(lines)[2..5], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(normals(faces), [[[0.0, 0.0, 1.0]; 3], [[1.0, 0.0, 0.0]; 3]].concat());
}

#[test]
fn faults_in_obj_files_are_reported_with_their_line() {
    for text in ["v 0 0 0\nf 1 2 3\n", "v 0 0 0\nf 1 1 0\n", "v 0 0 0\nv 1\n", "v 0 0 0\nf 1 1 -2\n", "\nf a b c\n"] {
        assert!(matches!(fault(load_bytes("a.obj", text.as_bytes())), MeshFault::Line { line: 2, .. }), "{text:?}");
    }
    assert_eq!(fault(load_bytes("a.obj", b"v 0 0 0\n")), MeshFault::Empty);
}

fn dae_folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("a.dae"), DAE).unwrap();
    write_png(&dir.path().join("tex ture.png"), [1, 2, 3, 255]);
    dir
}

#[test]
fn collada_parts_are_placed_in_metres_and_not_turned_to_the_up_axis() {
    let dir = dae_folder();
    let mesh = load(&dir.path().join("a.dae")).unwrap();
    let [quad, triangle] = mesh.parts.as_slice() else { panic!("two parts are expected") };
    assert!(mesh.warnings.is_empty(), "{:?}", mesh.warnings);
    let corners = [[0.1, 0.0, 0.0], [0.1, 1.0, 0.0], [-0.9, 1.0, 0.0]];
    assert_eq!(positions(quad)[..3], corners);
    assert_eq!(positions(triangle), corners);
    assert_eq!(normals(quad), [[0.0, 0.0, 1.0]; 6]);
    assert_eq!(uvs(quad), [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.25]]);
    // The triangle has no normals in the file.
    assert_eq!(normals(triangle), [[0.0, 0.0, 1.0]; 3]);
}

#[test]
fn collada_materials_are_those_that_the_instance_binds() {
    let dir = dae_folder();
    let mesh = load(&dir.path().join("a.dae")).unwrap();
    let [quad, triangle] = mesh.parts.as_slice() else { panic!("two parts are expected") };
    assert_eq!(quad.material.texture.as_ref().unwrap().rgba[0], [1, 2, 3, 255]);
    assert_eq!(quad.material.diffuse, Rgba::WHITE);
    assert_eq!(triangle.material.diffuse, Rgba::new(0.2, 0.4, 0.6, 1.0));
    assert_eq!(triangle.material.emissive, Rgba::new(0.1, 0.0, 0.0, 1.0));
}

#[test]
fn a_library_node_is_instanced_in_its_place() {
    let text = DAE.replace("<node id=\"n\">", "<node id=\"m\"><instance_node url=\"#lib\"/></node><node id=\"n\">");
    let mesh = load_bytes("a.dae", text.as_bytes()).unwrap();
    assert_eq!(mesh.parts.len(), 4);
    assert_eq!(positions(&mesh.parts[0])[1], [1.0, 0.0, 0.5]);
}

#[test]
fn collada_strips_fans_and_lines_become_faces() {
    for (element, corners) in [
        ("<tristrips material=\"two\" count=\"1\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/><p>0 1 3 2</p></tristrips>", 6),
        ("<trifans material=\"two\" count=\"1\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/><p>0 1 2 3</p></trifans>", 6),
        ("<polygons material=\"two\" count=\"2\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/><p>0 1 2</p><p>0 2 3</p></polygons>", 6),
        // Lines are drawn as triangles of whatever corners follow each other.
        ("<lines material=\"two\" count=\"9\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/><p>0 1 2 3</p></lines>", 3),
        ("<linestrips material=\"two\" count=\"1\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/><p>0 1 2 3</p></linestrips>", 6),
    ] {
        let start = DAE.find("<triangles").unwrap();
        let end = DAE.find("</triangles>").unwrap() + "</triangles>".len();
        let text = format!("{}{element}{}", &DAE[..start], &DAE[end..]);
        let mesh = load_bytes("a.dae", text.as_bytes()).unwrap();
        let triangles: Vec<_> = mesh.parts[1].mesh.triangles().collect();
        assert_eq!(triangles.len() * 3, corners, "{element}");
        assert!(triangles.iter().flatten().all(|vertex| vertex.normal == [0.0, 0.0, 1.0]), "{element}");
    }
}

#[test]
fn a_geometry_that_is_instanced_twice_is_read_once_for_each_material() {
    let text = DAE.replace(
        "<node id=\"n\">",
        "<node id=\"m\"><instance_node url=\"#lib\"/><instance_node url=\"#lib\"/></node><node id=\"n\">",
    );
    let mesh = load_bytes("a.dae", text.as_bytes()).unwrap();
    assert_eq!(mesh.parts.len(), 6);
    // Unbound symbols: the first material of the file.
    assert_eq!(mesh.parts[1].material.diffuse, Rgba::WHITE);
    assert_eq!(positions(&mesh.parts[0]), positions(&mesh.parts[2]));
}

#[test]
fn a_faceted_material_has_one_normal_a_face() {
    let text = DAE.replace(
        "</lambert>",
        "</lambert><extra><technique profile=\"MAX3D\"><faceted>1</faceted></technique></extra>",
    );
    let text = text.replace("<triangles material=\"two\" count=\"1\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/><p>0 1 2</p>",
        "<triangles material=\"two\" count=\"1\"><input semantic=\"VERTEX\" source=\"#verts\" offset=\"0\"/><input semantic=\"NORMAL\" source=\"#pos\" offset=\"1\"/><p>0 1 1 2 2 3</p>");
    assert_ne!(text, DAE);
    let mesh = load_bytes("a.dae", text.as_bytes()).unwrap();
    // The last corner's, turned with its node.
    assert_eq!(normals(&mesh.parts[1]), [[-1.0, 0.0, 0.0]; 3]);
}

#[test]
fn undeclared_prefixes_are_accepted() {
    let text = DAE.replace("<node id=\"n\">", "<node id=\"n\" xsi:type=\"x\"><x:extra/>");
    assert_eq!(load_bytes("a.dae", text.as_bytes()).unwrap().parts.len(), 2);
}

#[test]
fn entities_of_document_types_are_not_expanded() {
    let mut types = String::from("<!DOCTYPE COLLADA [<!ENTITY e0 \"0 0 0 0 0 0 0 0\">");
    for i in 1..40 {
        types += &format!("<!ENTITY e{i} \"&e{0};&e{0};&e{0};&e{0};\">", i - 1);
    }
    let text = DAE.replace("<COLLADA ", &format!("{types}]><COLLADA ")).replace("<p>0 1 2</p>", "<p>&e39;</p>");
    assert!(matches!(fault(load_bytes("a.dae", text.as_bytes())), MeshFault::Line { .. }));
    let text = DAE.replace("<COLLADA ", "<!DOCTYPE COLLADA><COLLADA ");
    assert_eq!(load_bytes("a.dae", text.as_bytes()).unwrap().parts.len(), 2);
}

#[test]
fn a_node_that_contains_itself_is_refused() {
    let text = DAE.replace("<node id=\"lib\">", "<node id=\"lib\"><instance_node url=\"#lib\"/>");
    let text = text.replace("<node id=\"n\">", "<node id=\"n\"><instance_node url=\"#lib\"/>");
    assert!(matches!(fault(load_bytes("a.dae", text.as_bytes())), MeshFault::Line { .. }));
}

#[test]
fn nodes_that_double_again_and_again_are_refused() {
    let mut nodes = String::new();
    for i in 0..60 {
        let next = format!("<instance_node url=\"#d{}\"/>", i + 1);
        nodes += &format!("<node id=\"d{i}\">{next}{next}</node>");
    }
    let text = DAE.replace("<library_nodes>", &format!("<library_nodes>{nodes}"));
    let text = text.replace("<node id=\"n\">", "<node id=\"n\"><instance_node url=\"#d0\"/>");
    assert!(matches!(fault(load_bytes("a.dae", text.as_bytes())), MeshFault::TooLarge { .. }));
}

#[test]
fn faults_in_collada_files_are_reported_with_their_line() {
    let scene_line = 1 + DAE.lines().position(|line| line.contains("<scene>")).unwrap();
    let text = DAE.replace("url=\"#scene\"", "url=\"#other\"");
    assert!(matches!(fault(load_bytes("a.dae", text.as_bytes())),
        MeshFault::Line { line, what } if line == scene_line && what.contains("other")));
    for (right, wrong) in [
        ("<p>0 1 2</p>", "<p>0 1 7</p>"),
        ("<p>0 1 2</p>", "<p>0 1</p>"),
        ("source=\"#pos-array\"", "source=\"#none\""),
        ("source=\"#verts\"", "source=\"#none\""),
        ("<vcount>4</vcount>", "<vcount>400000000000</vcount>"),
        ("<COLLADA ", "<Other "),
    ] {
        let text =
            DAE.replace(right, wrong).replace("</COLLADA>", if wrong == "<Other " { "</Other>" } else { "</COLLADA>" });
        assert_ne!(text, DAE);
        assert!(matches!(fault(load_bytes("a.dae", text.as_bytes())), MeshFault::Line { .. }), "{wrong}");
    }
    assert!(matches!(fault(load_bytes("a.dae", b"<COLLADA><a></b></COLLADA>")), MeshFault::Xml(_)));
}

#[test]
fn other_formats_are_named_in_their_error() {
    for (name, format) in [("a.mesh", "Ogre .mesh"), ("a.fbx", ".fbx"), ("a", "(no extension)")] {
        let error = load_bytes(name, b"").unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(format), "{error}");
    }
}

#[test]
fn a_mesh_is_loaded_once() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("robot")).unwrap();
    fs::write(dir.path().join("robot/package.xml"), "<package><name>robot</name></package>").unwrap();
    let store = MeshStore::new(PackageIndex::new([dir.path().to_owned()]));
    let url = "package://robot/b.stl";
    fs::write(dir.path().join("robot/b.stl"), TEXT_STL).unwrap();
    let mesh = get(&store, url).unwrap();
    fs::remove_file(dir.path().join("robot/b.stl")).unwrap();
    assert!(Arc::ptr_eq(&mesh, &get(&store, url).unwrap()));
}

#[test]
fn threads_that_ask_for_one_mesh_get_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.stl");
    fs::write(&path, TEXT_STL).unwrap();
    let store = store_of(dir.path());
    let url = format!("file://{}", path.display());
    let meshes: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(|| get(&store, &url).unwrap())).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(meshes.iter().all(|mesh| Arc::ptr_eq(mesh, &meshes[0])));
}

#[test]
fn obj_meshes_are_drawn_object_by_object() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\no a\nusemtl x\nf 1 2 3\no b\nf 2 3 1\no a\nusemtl y\nf 3 1 2\n";
    let mesh = load_bytes("a.obj", text.as_bytes()).unwrap();
    let firsts: Vec<_> = mesh.parts.iter().map(|part| positions(part)[0]).collect();
    assert_eq!(firsts, [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
}

/// Names are compared and opened, and given to no shell.
#[test]
fn a_command_in_an_address_is_not_run() {
    let folder = tempfile::tempdir().unwrap();
    let store = store_of(folder.path());
    let inside = folder.path().join("ran");
    // A name of a package has no slash: the command would leave its file where the test runs.
    let beside = format!("ran_by_an_address_{}", std::process::id());
    for target in [beside.clone(), inside.display().to_string()] {
        let command = format!("$(touch {target})`touch {target}`;touch {target};'\"|touch {target}&");
        for address in ["package://", "file://", "file:///", ""].map(|scheme| format!("{scheme}{command}/a.stl")) {
            assert!(get(&store, &address).is_err(), "{address}");
        }
    }
    assert!(!inside.exists() && !Path::new(&beside).exists());
}

#[test]
fn a_byte_order_mark_before_a_text_file_changes_nothing() {
    let marked = |text: &str| ["\u{feff}", text].concat();
    let all = |mesh: &LoadedMesh| mesh.parts.iter().map(|part| (positions(part), normals(part))).collect::<Vec<_>>();
    for (name, text) in [("a.stl", TEXT_STL), ("a.obj", OBJ), ("a.dae", DAE)] {
        let with = load_bytes(name, marked(text).as_bytes()).unwrap();
        assert_eq!(all(&with), all(&load_bytes(name, text.as_bytes()).unwrap()), "{name}");
    }
    let folder = obj_folder();
    fs::write(folder.path().join("things.mtl"), marked(MTL)).unwrap();
    let mesh = load(&folder.path().join("thing.obj")).unwrap();
    assert_eq!(mesh.parts[0].material.diffuse, Rgba::new(1.0, 0.0, 0.0, 1.0));
}
