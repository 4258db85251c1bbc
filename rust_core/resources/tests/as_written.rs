//! Files as other people's tools write them: encodings, ends of lines, XML that is not well-formed, faces first.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use std::fs;
use std::task::Poll;

use common::{binary_stl, fault, load, load_bytes, normals, positions, uvs, DAE, TEXT_STL, TRIANGLES};
use rcs_resources::{MeshFault, MeshStore, PackageIndex, ResourceOptions, Retry};

type Corners = (Vec<[f32; 3]>, Vec<[f32; 3]>, Vec<[f32; 2]>);

/// Positions, normals and texture coordinates of the parts, and the warnings.
fn read(name: &str, bytes: &[u8]) -> (Vec<Corners>, Vec<String>) {
    let mesh = load_bytes(name, bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
    let parts = mesh.parts.iter().map(|part| (positions(part), normals(part), uvs(part)));
    (parts.collect(), mesh.warnings.iter().map(ToString::to_string).collect())
}

fn utf_16(text: &str) -> Vec<u8> {
    text.encode_utf16().flat_map(u16::to_le_bytes).collect()
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn what_is_passed_over_is_a_warning_of_the_store() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.dae");
    fs::write(&file, DAE.replacen("<asset>", "<asset><title>nuts & bolts</title>", 1)).unwrap();
    let options = ResourceOptions { folders: vec![folder.path().to_owned()], ..ResourceOptions::default() };
    let store = MeshStore::with_options(PackageIndex::new([]), options);
    assert_eq!(store.warnings(), Vec::<String>::new());
    let url = format!("file://{}", file.display());
    assert!(matches!(store.mesh(&url, Retry::Yes), Poll::Ready(Ok(_))));
    let [passed_over, texture] = &store.warnings()[..] else { panic!("{:?}", store.warnings()) };
    assert!(passed_over.starts_with(&format!("mesh {url}: ")) && passed_over.contains("line 3"), "{passed_over}");
    assert!(texture.contains("tex ture.png"), "{texture}");
}

#[test]
fn meshes_of_any_encoding_and_end_of_line_are_the_same() {
    for (name, text) in [("a.obj", OBJ), ("a.stl", TEXT_STL), ("a.ply", PLY)] {
        let expected = read(name, text.as_bytes());
        for end in ["\r\n", "\r"] {
            assert_eq!(read(name, text.replace('\n', end).as_bytes()), expected, "{name} {end:?}");
        }
        if name != "a.ply" {
            assert_eq!(read(name, &utf_16(text)), expected, "{name}");
            assert_eq!(read(name, &utf_16(&format!("\u{feff}{text}"))), expected, "{name}");
        }
    }
    let in_one_line = TEXT_STL.replace('\n', " ");
    assert_eq!(read("a.stl", in_one_line.as_bytes()), read("a.stl", TEXT_STL.as_bytes()));
}

#[test]
fn a_binary_plys_header_may_end_its_lines_with_cr() {
    let header = &PLY[..PLY.find("0 0 0").unwrap()].replace("ascii", "binary_little_endian");
    // The first number begins with the byte of a line feed.
    let mut body: Vec<u8> = vec![b'\n', 0, 0, 0];
    body.extend([0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|value| value.to_le_bytes()));
    body.push(3);
    body.extend([0_i32, 1, 2].iter().flat_map(|index| index.to_le_bytes()));
    let expected = read("a.ply", PLY.as_bytes());
    for end in ["\n", "\r\n", "\r"] {
        assert_eq!(read("a.ply", &[header.replace('\n', end).as_bytes(), &body].concat()), expected, "{end:?}");
    }
}

#[test]
fn a_material_library_of_any_end_of_line_colours_the_mesh() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("a.obj"), format!("mtllib a.mtl\nusemtl red\n{OBJ}")).unwrap();
    for end in ["\n", "\r\n", "\r"] {
        fs::write(dir.path().join("a.mtl"), "# V\u{e9}lo\nnewmtl red\nKd 1 0 0\n".replace('\n', end)).unwrap();
        let mesh = load(&dir.path().join("a.obj")).unwrap();
        assert_eq!(mesh.parts[0].material.diffuse.to_array()[..3], [1.0, 0.0, 0.0], "{end:?}");
    }
}

#[test]
fn obj_faces_may_stand_before_their_vertices() {
    let expected = read("a.obj", OBJ.as_bytes());
    let (vertices, face) = OBJ.split_at(OBJ.find('f').unwrap());
    assert_eq!(read("a.obj", format!("{face}{vertices}").as_bytes()), expected);
    assert_eq!(read("a.obj", OBJ.replace("f ", "fo ").as_bytes()), expected);
    for text in ["\nf 1 1 1\n", "\nf 1 1 2\nv 0 0 0\n"] {
        assert!(matches!(fault(load_bytes("a.obj", text.as_bytes())), MeshFault::Line { line: 2, .. }), "{text:?}");
    }
}

#[test]
fn collada_that_assimp_reads_is_read_and_its_faults_are_warnings() {
    let quad = |text: &str| read("a.dae", text.as_bytes());
    // Without a texture that would be missing.
    let dae = DAE.replace("<texture", "<no_texture");
    let (expected, no_warnings) = quad(&dae);
    assert!(no_warnings.is_empty(), "{no_warnings:?}");
    let node = dae.find("<node").unwrap() + "<node".len();
    let within = |what: &str| format!("{}{what}{}", &dae[..node], &dae[node..]);
    let before = |what: &str| within("").replacen("<asset", &format!("{what}<asset"), 1);
    for (text, warning) in [
        (within(" class=\"<STL_BINARY>\""), None),
        (within(" class=\"a&b\""), Some("'&'")),
        (within(" class=\"1\" class=\"2\""), Some("twice")),
        (before("<extra>a & b&nbsp;</extra>"), Some("'&'")),
        (before("<!-- a -- b -->"), Some("'--'")),
        (before("<extra>\u{1}</extra>"), Some("control")),
        (format!("{dae}\n\0"), Some("control")),
        (format!("\n\n{dae}\n\n"), None),
        (before("<x:extra/>"), None),
    ] {
        let (parts, warnings) = quad(&text);
        assert_eq!(parts, expected, "{text}");
        match warning {
            Some(warning) => assert!(warnings.len() == 1 && warnings[0].contains(warning), "{warnings:?}"),
            None => assert!(warnings.is_empty(), "{warnings:?}"),
        }
    }
    assert_eq!(read("a.dae", &utf_16(&dae)).0, expected);
    let cut = &dae[..dae.len() - 20];
    assert!(matches!(fault(load_bytes("a.dae", cut.as_bytes())), MeshFault::Xml(_)));
}

#[test]
fn polygons_with_holes_are_said_to_be_left_out() {
    let text = DAE.replace("<texture", "<no_texture").replacen(
        "<triangles",
        "<polygons count=\"1\"><ph/></polygons><triangles",
        1,
    );
    let (_, warnings) = read("a.dae", text.as_bytes());
    assert!(warnings.iter().any(|warning| warning.contains("holes, which are left out")), "{warnings:?}");
}

#[test]
fn manifests_that_rospack_reads_name_their_package() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = "<?xml version=\"1.0\"?>\n<package><name>arm</name><author>V\u{e9} & lo</author></package>";
    let latin: Vec<u8> =
        manifest.replace("\"1.0\"", "\"1.0\" encoding=\"ISO-8859-1\"").chars().map(|c| c as u8).collect();
    for bytes in [
        manifest.as_bytes().to_vec(),
        latin,
        utf_16(manifest),
        manifest.replace("<package>", "<!DOCTYPE package SYSTEM \"p.dtd\"><package>").into_bytes(),
    ] {
        let folder = dir.path().join("src/other_name");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("package.xml"), bytes).unwrap();
        assert_eq!(PackageIndex::new([dir.path().to_owned()]).package("arm"), Some(folder));
    }
}

#[test]
fn a_binary_stl_stays_binary() {
    // Its size and contents would do for UTF-16 as well.
    let bytes = binary_stl(b"s\0o\0l\0i\0d\0", &TRIANGLES);
    assert_eq!(read("a.stl", &bytes).0.len(), 1);
}
