//! PLY meshes as rviz shows them.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use common::{fault, load, load_bytes, normals, positions, uvs, PLY};
use rcs_resources::{LoadedMesh, MeshFault};
use rcs_scene::Rgba;

/// The rows of [`PLY`] as bytes.
fn binary(is_big_endian: bool) -> Vec<u8> {
    let format = if is_big_endian { "binary_big_endian" } else { "binary_little_endian" };
    let (header, rows) = PLY.split_once("end_header\n").unwrap();
    let mut bytes = header.replace("ascii", format).into_bytes();
    bytes.extend(b"end_header\n");
    let ordered = |mut bytes: Vec<u8>| {
        if is_big_endian {
            bytes.reverse();
        }
        bytes
    };
    // Five vertices, a thing, and faces.
    for (number, row) in rows.lines().enumerate() {
        let numbers: Vec<f64> = row.split_whitespace().map(|word| word.parse().unwrap()).collect();
        match numbers.as_slice() {
            [x, y, z, red] if number < 5 => {
                [x, y].iter().for_each(|value| bytes.extend(ordered((**value as f32).to_le_bytes().to_vec())));
                bytes.extend(ordered(z.to_le_bytes().to_vec()));
                bytes.push(*red as u8);
            }
            [_] => bytes.extend(ordered((numbers[0] as i16).to_le_bytes().to_vec())),
            [count, indices @ ..] => {
                bytes.push(*count as u8);
                indices.iter().for_each(|index| bytes.extend(ordered((*index as i32).to_le_bytes().to_vec())));
            }
            [] => {}
        }
    }
    bytes
}

fn corners(mesh: &LoadedMesh) -> Vec<[f32; 3]> {
    mesh.parts.iter().flat_map(positions).collect()
}

#[test]
fn faces_of_any_number_of_corners_are_read_from_text_and_from_bytes_of_either_order() {
    let expected = [[0, 1, 2], [0, 2, 3], [0, 1, 4]].map(|face| {
        face.map(|vertex| [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.5]][vertex])
    });
    let crlf = PLY.replace('\n', "\r\n").into_bytes();
    for bytes in [PLY.as_bytes().to_vec(), binary(false), binary(true), crlf] {
        let mesh = load_bytes("a.ply", &bytes).unwrap();
        assert_eq!(corners(&mesh), expected.concat());
    }
}

#[test]
fn colours_of_vertices_do_not_show_and_the_material_is_white() {
    let mesh = load_bytes("a.ply", PLY.as_bytes()).unwrap();
    let [part] = mesh.parts.as_slice() else { panic!("one part is expected") };
    assert!(part.material.embedded && part.material.texture.is_none());
    assert_eq!(part.material.diffuse, Rgba::WHITE);
    assert!(part.mesh.vertices.iter().all(|vertex| vertex.color == [255; 4]));
}

#[test]
fn a_vertex_without_a_normal_has_that_of_its_last_face() {
    let mesh = load_bytes("a.ply", PLY.as_bytes()).unwrap();
    let normals = normals(&mesh.parts[0]);
    // Vertices 0 and 1 are of the sloping face, too, which comes last.
    assert_eq!(normals[0], normals[6]);
    assert_ne!(normals[0], [0.0, 0.0, 1.0]);
    assert_eq!(normals[2], [0.0, 0.0, 1.0]);
}

#[test]
fn normals_and_texture_coordinates_of_vertices_are_read() {
    let text = "ply\nformat ascii 1.0\ncomment made by hand\ncomment TextureFile my wood.png\nelement vertex 3\n\
                property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n\
                property float nz\nproperty float s\nproperty float t\nelement face 1\n\
                property list uchar int vertex_index\nend_header\n\
                0 0 0 0 0.6 0.8 0 0\n1 0 0 0 0.6 0.8 1 0\n0 1 0 0 0.6 0.8 0 0.75\n3 0 1 2\n";
    let dir = tempfile::tempdir().unwrap();
    image::RgbaImage::from_pixel(2, 2, image::Rgba([9, 8, 7, 255])).save(dir.path().join("my wood.png")).unwrap();
    std::fs::write(dir.path().join("a.ply"), text).unwrap();
    let mesh = load(&dir.path().join("a.ply")).unwrap();
    let [part] = mesh.parts.as_slice() else { panic!("one part is expected") };
    assert_eq!(normals(part), [[0.0, 0.6, 0.8]; 3]);
    // v points down once loaded.
    assert_eq!(uvs(part), [[0.0, 1.0], [1.0, 1.0], [0.0, 0.25]]);
    assert_eq!(part.material.texture.as_ref().unwrap().rgba[0], [9, 8, 7, 255]);
}

#[test]
fn texture_coordinates_of_a_face_lie_on_its_vertices() {
    let text = PLY.replace("vertex_indices\n", "vertex_indices\nproperty list uchar float texcoord\n");
    let text = text.replace("4 0 1 2 3\n", "4 0 1 2 3 0\n").replace("3 0 1 4\n", "3 0 1 4 6 0.1 0.2 0.3 0.4 0.5 0.6\n");
    let mesh = load_bytes("a.ply", text.as_bytes()).unwrap();
    let uvs = uvs(&mesh.parts[0]);
    let rounded = |uv: [f32; 2]| uv.map(|value| (value * 10.0).round() / 10.0);
    assert_eq!([uvs[6], uvs[7], uvs[8]].map(rounded), [[0.1, 0.8], [0.3, 0.6], [0.5, 0.4]]);
    assert_eq!(rounded(uvs[0]), [0.1, 0.8]);
}

#[test]
fn strips_become_triangles_that_face_the_same_way() {
    let (vertices, _) = PLY.split_once("element face").unwrap();
    let rows: Vec<&str> = PLY.split_once("end_header\n").unwrap().1.lines().take(6).collect();
    let text = format!(
        "{vertices}element tristrips 1\nproperty list int int vertex_indices\nend_header\n{}\n8 0 1 3 2 -1 0 1 4\n",
        rows.join("\n")
    );
    let mesh = load_bytes("a.ply", text.as_bytes()).unwrap();
    let corners = corners(&mesh);
    assert_eq!(corners.len(), 9);
    assert_eq!(corners[..6], [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.]]);
}

#[test]
fn what_is_wrong_is_said_with_its_line_or_element() {
    let error = |bytes: &[u8]| fault(load_bytes("a.ply", bytes));
    let changed = |from: &str, to: &str| {
        let text = PLY.replacen(from, to, 1);
        assert_ne!(text, PLY);
        error(text.as_bytes())
    };
    assert!(matches!(changed("format ascii", "format morse"), MeshFault::Line { line: 2, .. }));
    assert!(matches!(changed("property double z", "property quad z"), MeshFault::Line { line: 7, .. }));
    assert!(matches!(changed("vertex 5", "vertex five"), MeshFault::Line { line: 4, .. }));
    assert!(matches!(changed("1 0 0 20", "1 0 zero 20"), MeshFault::Line { line: 15, .. }));
    assert!(matches!(changed("1 0 0 20", "1 0 0"), MeshFault::Line { line: 15, .. }));
    assert!(matches!(changed("4 0 1 2 3", "4 0 1 2 9"), MeshFault::Malformed(what) if what.contains('9')));
    assert!(matches!(changed("4 0 1 2 3", "4 0 1 2 -1"), MeshFault::Malformed(_)));
    assert!(matches!(changed("face 2", "face 3"), MeshFault::Malformed(what) if what.contains("face 2 of 3")));
    assert!(matches!(changed("end_header", "the end"), MeshFault::Malformed(_)));
    assert!(matches!(error(b"solid"), MeshFault::Malformed(_)));
    let whole = binary(true);
    assert!(matches!(error(&whole[..whole.len() - 1]), MeshFault::Malformed(what) if what.contains("face 1 of 2")));
    let points = PLY.replace("element face 2", "element face 0");
    assert_eq!(error(points.as_bytes()), MeshFault::Empty);
}

#[test]
fn counts_that_the_file_does_not_fill_take_neither_memory_nor_time() {
    let text = PLY.replace("element face 2", "element nothing 18446744073709551615\nelement face 2");
    assert_eq!(load_bytes("a.ply", text.as_bytes()).unwrap().parts.len(), 1);
    for (from, to) in [("vertex 5", "vertex 4000000000"), ("4 0 1 2 3", "4000000000 0 1 2 3")] {
        assert!(load_bytes("a.ply", PLY.replace(from, to).as_bytes()).is_err());
    }
}
