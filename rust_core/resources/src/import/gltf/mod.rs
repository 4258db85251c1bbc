//! glTF 2.0, as text (`.gltf`, with its data inside or in files beside it) and as binary (`.glb`).
//!
//! As in Assimp 5.2, where it matters for the image: the scene's nodes are traversed, a node's own mesh before its
//! children's; the base colour is the diffuse colour; primitives without a material are white; animations, skins, morph
//! targets, cameras, lights and vertex colours are not used. A texture is applied once for each slot in which Assimp
//! lists it (the base colour's in two), so it is darker in rviz. If a scene has one root node, rviz drops that node's
//! rotation. There is no conversion of the up axis, so a glTF file, whose y is up, lies on its side.
//!
//! Files that rviz 1.14 cannot load are loaded here: its streams count bytes where Assimp counts items, so it refuses
//! `.glb` and data in files beside a `.gltf`; it searches embedded images beside the file; and it takes integers
//! (texture coordinates, quantised meshes) for floats.

mod buffers;
mod faces;
mod json;
mod materials;

use std::collections::HashMap;

use nalgebra::{Matrix3, Matrix4, Vector3};

use super::imported::{check_count, Faces, Imported, MeshSource, PlacedMesh, Polygons, MAX_MESHES};
use crate::MeshFault;
use buffers::GltfBuffers;
use json::{fault, GltfNode, GltfPrimitive, GltfRoot};

/// Most values of the JSON, which take far more memory than their text.
const MAX_JSON_VALUES: usize = 4_000_000;
/// Nodes nest no deeper than this, or they contain themselves.
const MAX_DEPTH: usize = 200;
/// Most nodes of a scene.
const MAX_NODES: usize = 200_000;

/// Magic bytes of a GLB file.
const GLB_MAGIC: &[u8] = b"glTF";
const JSON_CHUNK: &[u8; 4] = b"JSON";
const BINARY_CHUNK: &[u8; 4] = b"BIN\0";

/// Reads a glTF file and the data beside it.
pub(super) fn read(bytes: &[u8], source: MeshSource<'_>) -> Result<Imported, MeshFault> {
    let (text, binary) = if bytes.starts_with(GLB_MAGIC) { chunks(bytes)? } else { (bytes, &[][..]) };
    // Strings hold few such bytes.
    check_count(text.iter().filter(|byte| matches!(byte, b',' | b'{')).count(), MAX_JSON_VALUES, "JSON values")?;
    let root: GltfRoot = serde_json::from_str(&rcs_text::decode(text)).map_err(|error| fault(error.to_string()))?;
    if !root.asset.version.starts_with('2') {
        return Err(fault(format!("glTF {:?} is not supported, only 2.0", root.asset.version)));
    }
    if let Some(name) = root.extensions_required.iter().find(|name| name.contains("compression")) {
        return Err(fault(format!("{name} is not supported; export the mesh without compression")));
    }
    let buffers = GltfBuffers::load(&root, binary, source)?;
    let mut reader = GltfReader {
        root: &root,
        buffers: &buffers,
        made: HashMap::new(),
        imported: Imported::default(),
        corners: 0,
        max_corners: source.options.max_corners(),
        nodes: 0,
    };
    reader.scene()?;
    let mut imported = reader.imported;
    (imported.materials, imported.images) = materials::read(&root, &buffers)?;
    Ok(imported)
}

/// JSON and binary data of a GLB: a header of 12 bytes, and chunks of a length, a type and that many bytes.
fn chunks(bytes: &[u8]) -> Result<(&[u8], &[u8]), MeshFault> {
    let number = |at: usize| bytes.get(at..).and_then(<[u8]>::first_chunk).map(|bytes| u32::from_le_bytes(*bytes));
    match number(4) {
        Some(2) => {}
        version => return Err(fault(format!("GLB of version {}, only 2 is read", version.unwrap_or(0)))),
    }
    let chunk = |at: usize, kind: &[u8; 4]| {
        let length = number(at)? as usize;
        let is_it = bytes.get(at + 4..)?.starts_with(kind);
        is_it.then(|| bytes.get(at + 8..)?.get(..length)).flatten()
    };
    let json = chunk(12, JSON_CHUNK).ok_or_else(|| fault("a GLB without JSON, or cut off in it"))?;
    let after = 20 + json.len().next_multiple_of(4);
    let binary = match bytes.get(after..) {
        None | Some([]) => &[],
        Some(_) => chunk(after, BINARY_CHUNK).ok_or_else(|| fault("a GLB cut off in its data"))?,
    };
    Ok((json, binary))
}

/// A file while its scene is read.
struct GltfReader<'a> {
    root: &'a GltfRoot,
    buffers: &'a GltfBuffers<'a>,
    /// The range of meshes made of each mesh of the file.
    made: HashMap<usize, std::ops::Range<usize>>,
    imported: Imported,
    corners: usize,
    max_corners: usize,
    nodes: usize,
}

impl<'a> GltfReader<'a> {
    /// Reads the scene.
    fn scene(&mut self) -> Result<(), MeshFault> {
        let scene = self.root.scenes.get(self.root.scene).ok_or_else(|| fault("there is no scene"))?;
        let is_only = scene.nodes.len() == 1;
        scene.nodes.iter().try_for_each(|&index| {
            let transform = transform(self.at(index)?);
            self.node(index, &if is_only { without_rotation(&transform) } else { transform }, 0)
        })
    }

    /// Adds instances of a node's mesh, then of its children's.
    fn node(&mut self, index: usize, object_from_node: &Matrix4<f32>, depth: usize) -> Result<(), MeshFault> {
        self.nodes += 1;
        check_count(self.nodes, MAX_NODES, "nodes")?;
        if depth > MAX_DEPTH {
            return Err(fault("nodes nest too deeply, or contain themselves"));
        }
        let node = self.at(index)?;
        if let Some(mesh) = node.mesh {
            let meshes = self.mesh(mesh)?;
            check_count(self.imported.placed.len() + meshes.len(), MAX_MESHES, "meshes")?;
            // The specification (3.7.4, Instantiation) turns the triangles of mirrored nodes.
            let is_turned = object_from_node.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
            let placed = meshes.map(|mesh| PlacedMesh { mesh, object_from_mesh: *object_from_node, is_turned });
            self.imported.placed.extend(placed);
        }
        node.children
            .iter()
            .try_for_each(|&child| self.node(child, &(object_from_node * transform(self.at(child)?)), depth + 1))
    }

    fn at(&self, index: usize) -> Result<&'a GltfNode, MeshFault> {
        self.root.nodes.get(index).ok_or_else(|| fault(format!("there is no node {index}")))
    }

    /// The meshes of a mesh's primitives.
    fn mesh(&mut self, index: usize) -> Result<std::ops::Range<usize>, MeshFault> {
        if let Some(made) = self.made.get(&index) {
            return Ok(made.clone());
        }
        let mesh = self.root.meshes.get(index).ok_or_else(|| fault(format!("there is no mesh {index}")))?;
        let first = self.imported.meshes.len();
        for primitive in &mesh.primitives {
            let polygons = self.primitive(primitive)?;
            self.imported.meshes.push(polygons);
            check_count(self.imported.meshes.len(), MAX_MESHES, "meshes")?;
        }
        let made = first..self.imported.meshes.len();
        self.made.insert(index, made.clone());
        Ok(made)
    }

    fn primitive(&mut self, primitive: &GltfPrimitive) -> Result<Polygons, MeshFault> {
        let attributes = &primitive.attributes;
        let position = attributes.position.ok_or_else(|| fault("a primitive has no POSITION"))?;
        let indices = primitive.indices.map(|index| self.buffers.count(index)).transpose()?;
        // Before memory is allocated for them.
        self.corners = self.corners.saturating_add(self.buffers.count(position)?.max(indices.unwrap_or(0)));
        check_count(self.corners, self.max_corners, "corners")?;
        let positions = self.buffers.vectors::<3>(position)?;
        let count = positions.len();
        let normals = attributes.normal.map(|index| self.buffers.vectors::<3>(index)).transpose()?;
        let uvs = attributes.uv.map(|index| self.buffers.vectors::<2>(index)).transpose()?;
        let indices = match primitive.indices {
            Some(index) => self.buffers.indices(index)?,
            None => (0..count as u32).collect(),
        };
        let (corners, sizes) = faces::faces(primitive.mode, &indices, count);
        if sizes.is_empty() {
            return Err(fault("a primitive has no faces"));
        }
        Ok(Polygons {
            positions,
            normals: normals.filter(|normals| normals.len() == count).unwrap_or_default(),
            // v points down in glTF.
            uvs: uvs
                .filter(|uvs| uvs.len() == count)
                .unwrap_or_default()
                .into_iter()
                .map(|[u, v]| [u, 1.0 - v])
                .collect(),
            corners: Some(corners),
            faces: Faces::Sizes(sizes),
            material: primitive.material.unwrap_or(self.root.materials.len()),
        })
    }
}

/// The pose of a node in its parent.
fn transform(node: &GltfNode) -> Matrix4<f32> {
    if let Some(matrix) = &node.matrix {
        return Matrix4::from_column_slice(matrix.as_slice());
    }
    let mut transform = node.translation.map_or_else(Matrix4::identity, |t| Matrix4::new_translation(&t.into()));
    if let Some([x, y, z, w]) = node.rotation {
        // Not normalized: a quaternion of another length scales too, as in Assimp.
        #[rustfmt::skip]
        let rotation = Matrix3::new(
            1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w),
            2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w),
            2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y),
        );
        transform *= rotation.to_homogeneous();
    }
    if let Some(scale) = node.scale {
        transform *= Matrix4::new_nonuniform_scaling(&scale.into());
    }
    transform
}

/// The scale and translation of a root node without its rotation, as in rviz; a mirror image is mirrored on all axes.
fn without_rotation(transform: &Matrix4<f32>) -> Matrix4<f32> {
    let linear = transform.fixed_view::<3, 3>(0, 0);
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    let scale = Vector3::from_fn(|axis, _| sign * linear.column(axis).norm());
    let place = transform.fixed_view::<3, 1>(0, 3).into_owned();
    Matrix4::new_translation(&place) * Matrix4::new_nonuniform_scaling(&scale)
}
