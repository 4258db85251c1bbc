//! Small mesh files and what they are loaded as.

use std::{fs, path::Path, sync::Arc, task::Poll};

use rcs_resources::{LoadedMesh, MeshFault, MeshPart, MeshStore, PackageIndex, ResourceError, ResourceOptions, Retry};

/// Loads a file by its path.
pub(crate) fn load(path: &Path) -> Result<Arc<LoadedMesh>, ResourceError> {
    get(&store_of(path.parent().unwrap()), path.to_str().unwrap())
}

/// A store that loads at once, what is in packages and in a folder.
pub(crate) fn store_of(folder: &Path) -> MeshStore {
    let options = ResourceOptions { folders: vec![folder.to_owned()], ..ResourceOptions::default() };
    MeshStore::with_options(PackageIndex::new([]), options)
}

/// The mesh of an address, from a store that loads at once.
pub(crate) fn get(store: &MeshStore, url: &str) -> Result<Arc<LoadedMesh>, ResourceError> {
    match store.mesh(url, Retry::Yes) {
        Poll::Ready(result) => result,
        Poll::Pending => panic!("{url} is loading in the background"),
    }
}

/// Loads a file of that name and contents, alone in a folder.
pub(crate) fn load_bytes(name: &str, bytes: &[u8]) -> Result<Arc<LoadedMesh>, ResourceError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    fs::write(&path, bytes).unwrap();
    load(&path)
}

/// Positions of the corners of a part's triangles, rounded.
pub(crate) fn positions(part: &MeshPart) -> Vec<[f32; 3]> {
    part.mesh.triangles().flatten().map(|vertex| vertex.position.map(|x| (x * 1e5).round() / 1e5)).collect()
}

/// The normals at the corners of a part's triangles, rounded.
pub(crate) fn normals(part: &MeshPart) -> Vec<[f32; 3]> {
    part.mesh.triangles().flatten().map(|vertex| vertex.normal.map(|x| (x * 1e5).round() / 1e5)).collect()
}

/// The texture coordinates at the corners of a part's triangles.
pub(crate) fn uvs(part: &MeshPart) -> Vec<[f32; 2]> {
    part.mesh.triangles().flatten().map(|vertex| vertex.uv).collect()
}

/// The fault in a mesh that was not loaded.
pub(crate) fn fault(result: Result<Arc<LoadedMesh>, ResourceError>) -> MeshFault {
    match result {
        Err(ResourceError::BadMesh { fault, .. }) => fault,
        other => panic!("a fault in the mesh is expected, not {other:?}"),
    }
}

/// A binary STL file: each triangle's normal and corners.
pub(crate) fn binary_stl(header: &[u8], triangles: &[[[f32; 3]; 4]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend(triangle.iter().flatten().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

/// Two triangles: in the plane z = 0 facing up, and in the plane x = 0, with normals that do not fit them.
pub(crate) const TRIANGLES: [[[f32; 3]; 4]; 2] = [
    [[0.0, 0.6, 0.8], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[0.0, 2.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
];

/// A text STL file of two solids.
pub(crate) const TEXT_STL: &str = "solid first name with words
  facet normal 0 0 1
    outer loop
      vertex 0 0 0
      vertex 1 0 0
      vertex 0 1e0 0
    endloop
  endfacet
endsolid first
solid
  facet normal 1 0 0 outer loop vertex 0 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet
endsolid
";

/// An OBJ file with two materials, a quad and a line.
pub(crate) const OBJ: &str = "# two faces
mtllib things.mtl
o thing
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
usemtl red
f 1/1/1 2/2/1 3/3/1 4/4/1
usemtl blue
f -4//-1 -3//-1 \\
  -2//-1
";

/// The materials of [`OBJ`].
pub(crate) const MTL: &str =
    "newmtl red\nKd 1 0 0\nKa 0.4 0 0\nd 0.5\nmap_Kd red.png\nnewmtl blue\nKd 0 0 1\nKe 0.1 0.1 0.1\n";

/// A COLLADA file: a quad and a triangle in one geometry, bound to two materials, under a node that turns and moves
/// it, in centimetres with y up.
pub(crate) const DAE: &str = r##"<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
  <library_images><image id="img"><init_from>file://tex%20ture.png</init_from></image></library_images>
  <library_effects>
    <effect id="plain-fx"><profile_COMMON><technique sid="common"><lambert>
      <emission><color>0.1 0 0 1</color></emission><diffuse><color>0.2 0.4 0.6 1</color></diffuse>
      <transparent opaque="A_ONE"><color>1 1 1 1</color></transparent><transparency><float>0.25</float></transparency>
    </lambert></technique></profile_COMMON></effect>
    <effect id="textured-fx"><profile_COMMON>
      <newparam sid="surface"><surface type="2D"><init_from>img</init_from></surface></newparam>
      <newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>
      <technique sid="common"><phong><diffuse><texture texture="sampler" texcoord="UV"/></diffuse></phong></technique>
    </profile_COMMON></effect>
  </library_effects>
  <library_materials>
    <material id="a-textured"><instance_effect url="#textured-fx"/></material>
    <material id="b-plain"><instance_effect url="#plain-fx"/></material>
  </library_materials>
  <library_geometries><geometry id="geo"><mesh>
    <source id="pos"><float_array id="pos-array" count="12">0 0 0  100 0 0  100 100 0  0 100 0</float_array>
      <technique_common><accessor source="#pos-array" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
    <source id="uv"><float_array id="uv-array" count="8">0 0  1 0  1 1  0 0.75</float_array>
      <technique_common><accessor source="#uv-array" count="4" stride="2"><param name="S" type="float"/><param name="T" type="float"/></accessor></technique_common></source>
    <source id="nor"><float_array id="nor-array" count="3">0 0 1</float_array>
      <technique_common><accessor source="#nor-array" count="1" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
    <vertices id="verts"><input semantic="POSITION" source="#pos"/></vertices>
    <polylist material="one" count="1">
      <input semantic="VERTEX" source="#verts" offset="0"/><input semantic="NORMAL" source="#nor" offset="1"/>
      <input semantic="TEXCOORD" source="#uv" offset="2" set="0"/>
      <vcount>4</vcount><p>0 0 0 1 0 1 2 0 2 3 0 3</p></polylist>
    <triangles material="two" count="1"><input semantic="VERTEX" source="#verts" offset="0"/><p>0 1 2</p></triangles>
  </mesh></geometry></library_geometries>
  <library_nodes><node id="lib"><translate>0 0 50</translate>
    <instance_geometry url="#geo"/></node></library_nodes>
  <library_visual_scenes><visual_scene id="scene">
    <node id="n"><translate>10 0 0</translate><rotate>0 0 1 90</rotate>
      <instance_geometry url="#geo"><bind_material><technique_common>
        <instance_material symbol="one" target="#a-textured"/><instance_material symbol="two" target="#b-plain"/>
      </technique_common></bind_material></instance_geometry></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"##;

/// A PLY file of a quad and a sloping triangle that share an edge, with a colour and an unknown element.
pub(crate) const PLY: &str = "ply
format ascii 1.0
comment five vertices
element vertex 5
property float x
property float y
property double z
property uchar red
element thing 1
property short weight
element face 2
property list uchar int vertex_indices
end_header
0 0 0 10
1 0 0 20
1 1 0 30
0 1 0 40
0.5 0.5 1.5 50
-7
4 0 1 2 3
3 0 1 4
";

/// A glTF file of a triangle with a material under a turned root, and again without one under its turned child. `DATA`
/// stands for [`GLTF_DATA`].
pub(crate) const GLTF: &str = r#"{
  "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
  "nodes": [
    {"mesh": 0, "translation": [0,0,1], "rotation": [0,0,0.70710678,0.70710678], "scale": [2,2,2], "children": [1]},
    {"mesh": 1, "translation": [1,0,0], "rotation": [0,0,0.70710678,0.70710678]},
    {"mesh": 1}
  ],
  "meshes": [
    {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
    {"primitives": [{"attributes": {"POSITION": 0}}]}
  ],
  "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5,0.25,0.125,0.5]}, "emissiveFactor": [0,0,0.5]}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
    {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
    {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
    {"bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC2", "normalized": true}
  ],
  "bufferViews": [
    {"buffer": 0, "byteOffset": 0, "byteLength": 36},
    {"buffer": 0, "byteOffset": 36, "byteLength": 6},
    {"buffer": 0, "byteOffset": 0, "byteLength": 36, "byteStride": 12}
  ],
  "buffers": [{"byteLength": 42, "uri": "data:x/y;base64,DATA"}]
}"#;

/// The corners (0, 0, 0), (1, 0, 0) and (0, 1, 0), and the indices 0, 1 and 2.
pub(crate) fn gltf_data() -> Vec<u8> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0_f32]];
    let mut data: Vec<u8> = corners.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    data.extend([0_u16, 1, 2].iter().flat_map(|index| index.to_le_bytes()));
    data
}

/// [`gltf_data`] in base64.
pub(crate) const GLTF_DATA: &str = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA";

/// Bytes in base64.
pub(crate) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let number = (0..3).fold(0, |number, i| number << 8 | u32::from(three.get(i).copied().unwrap_or(0)));
        for digit in 0..=three.len() {
            text.push(char::from(DIGITS[(number >> (18 - 6 * digit)) as usize % 64]));
        }
    }
    text
}

/// A GLB of a JSON text and [`gltf_data`].
pub(crate) fn glb(json: &str) -> Vec<u8> {
    let padded = |mut bytes: Vec<u8>, filler| {
        bytes.resize(bytes.len().next_multiple_of(4), filler);
        bytes
    };
    let (json, data) = (padded(json.as_bytes().to_vec(), b' '), padded(gltf_data(), 0));
    let number = |number: usize| (number as u32).to_le_bytes();
    let length = 12 + 8 + json.len() + 8 + data.len();
    let parts: [&[u8]; 9] = [
        b"glTF",
        &number(2),
        &number(length),
        &number(json.len()),
        b"JSON",
        &json,
        &number(data.len()),
        b"BIN\0",
        &data,
    ];
    parts.concat()
}
