//! Wavefront OBJ.
//!
//! As in Assimp: each object, group and change of material begins a mesh; faces before the first `usemtl` have the
//! material that was defined last; an undefined material is grey 0.6; a mesh whose faces lack some normals gets face
//! normals; an invalid index refuses the file if it is a vertex's, and drops the whole mesh's normals or texture
//! coordinates if it is one of those. Vertex colours are not used. `l` and `p` statements are lines and points.

use std::collections::HashMap;

use super::{
    imported::{check_count, Faces, Imported, MeshSource, Polygons, MAX_MATERIALS, MAX_MESHES},
    lenient_float::{leading_f32, three},
    mtl::{self, NamedMaterial, DEFAULT_MATERIAL},
};
use crate::{MeshFault, ResourceError};

/// Bytes that each material library counts in addition to its size.
const LIBRARY_BYTES: u64 = 4096;

/// An OBJ file while it is read.
struct ObjReader<'a> {
    source: MeshSource<'a>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    materials: Vec<NamedMaterial>,
    current_material: Option<usize>,
    meshes: Vec<ObjMesh>,
    objects: Objects,
    corners: usize,
    /// Line in the file, from 1.
    number: usize,
    /// The highest vertex index of a face, and its line.
    last_vertex: Option<(usize, usize)>,
    library_bytes: u64,
}

/// The objects and groups of a file, numbered in the order in which they begin.
#[derive(Default)]
struct Objects {
    count: usize,
    by_name: HashMap<String, usize>,
    current: Option<usize>,
    /// The name in the last `g` statement.
    group: String,
}

/// A mesh while it is read.
#[derive(Default)]
struct ObjMesh {
    /// The mesh without its faces.
    corners: Vec<ObjCorner>,
    face_sizes: Vec<u32>,
    /// Index of the object in which it begins.
    object: usize,
    material: Option<usize>,
}

/// The primitive of a statement with corners.
#[derive(Clone, Copy, PartialEq)]
enum ObjPrimitive {
    Polygon,
    Line,
    Point,
}

/// A corner: indices from 0 of the position, texture coordinate and normal, which may be out of range.
#[derive(Clone, Copy, Default)]
struct ObjCorner {
    position: usize,
    uv: Option<usize>,
    normal: Option<usize>,
}

/// Reads an OBJ file and its material libraries.
pub(super) fn read(bytes: &[u8], source: MeshSource<'_>) -> Result<Imported, MeshFault> {
    let text = rcs_text::decode(bytes);
    let mut reader = ObjReader {
        source,
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        materials: vec![NamedMaterial::new(DEFAULT_MATERIAL)],
        current_material: None,
        meshes: Vec::new(),
        objects: Objects::default(),
        corners: 0,
        number: 0,
        last_vertex: None,
        library_bytes: 0,
    };
    let mut joined = String::new();
    for (number, line) in text.lines().enumerate() {
        // A backslash at the end continues a line.
        if let Some(start) = line.trim_end().strip_suffix('\\') {
            joined.push_str(start);
            joined.push(' ');
            continue;
        }
        reader.number = number + 1;
        let result = if joined.is_empty() {
            reader.line(line)
        } else {
            joined.push_str(line);
            let result = reader.line(&joined);
            joined.clear();
            result
        };
        result.map_err(|what| MeshFault::Line { line: number + 1, what })?;
        check_count(reader.corners, source.options.max_corners(), "corners")?;
        check_count(reader.meshes.len(), MAX_MESHES, "meshes")?;
        check_count(reader.materials.len(), MAX_MATERIALS, "materials")?;
    }
    reader.finish()
}

impl ObjReader<'_> {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let line = line.trim();
        let (keyword, rest) = line.split_once([' ', '\t']).unwrap_or((line, ""));
        match keyword {
            "v" => self.position(rest)?,
            "vn" => {
                let normal = three(&mut rest.split_ascii_whitespace());
                self.normals.push(normal.ok_or("a normal of three numbers is expected")?);
            }
            "vt" => {
                let mut words = rest.split_ascii_whitespace();
                let u = words.next().and_then(leading_f32).ok_or("a texture coordinate is expected")?;
                let v = words.next().and_then(leading_f32).unwrap_or(0.0);
                self.uvs.push([u, v].map(|value| if value.is_finite() { value } else { 0.0 }));
            }
            // `fo` is the old name.
            "f" | "fo" => self.corners(ObjPrimitive::Polygon, rest)?,
            "l" => self.corners(ObjPrimitive::Line, rest)?,
            "p" => self.corners(ObjPrimitive::Point, rest)?,
            "o" => self.object(rest.split_ascii_whitespace().next().unwrap_or_default()),
            "g" if self.objects.group != rest.trim() => {
                rest.trim().clone_into(&mut self.objects.group);
                self.begin_object(rest.trim());
            }
            "usemtl" => self.use_material(rest.trim()),
            "mtllib" => self.library(rest.trim()),
            _ => {}
        }
        Ok(())
    }

    fn position(&mut self, rest: &str) -> Result<(), String> {
        let numbers: Vec<f32> = rest.split_ascii_whitespace().map_while(leading_f32).take(7).collect();
        let position = match numbers.as_slice() {
            // The last three of six are a colour.
            &[x, y, z] | &[x, y, z, _, _, _] => [x, y, z],
            &[_, _, _, 0.0] => return Err("a homogeneous vertex has a last number of 0".to_owned()),
            &[x, y, z, w] => [x / w, y / w, z / w],
            _ => return Err("a vertex of three numbers is expected".to_owned()),
        };
        self.positions.push(position);
        Ok(())
    }

    fn corners(&mut self, kind: ObjPrimitive, rest: &str) -> Result<(), String> {
        let words = rest.split_ascii_whitespace().take_while(|word| !word.starts_with('#'));
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        if corners.is_empty() {
            return Ok(());
        }
        if self.objects.current.is_none() {
            self.begin_object("defaultobject");
        }
        let Some(mesh) = self.meshes.last_mut() else { return Ok(()) };
        self.corners += corners.len();
        let last = corners.iter().map(|corner| corner.position).max().unwrap_or(0);
        if self.last_vertex.is_none_or(|(known, _)| last > known) {
            self.last_vertex = Some((last, self.number));
        }
        match kind {
            ObjPrimitive::Polygon => {
                mesh.face_sizes.push(corners.len() as u32);
                mesh.corners.extend(corners);
            }
            ObjPrimitive::Line => {
                mesh.face_sizes.extend(corners.windows(2).map(|_| 2));
                mesh.corners.extend(corners.windows(2).flatten());
            }
            ObjPrimitive::Point => {
                mesh.face_sizes.extend(corners.iter().map(|_| 1));
                mesh.corners.extend(corners);
            }
        }
        Ok(())
    }

    /// Reads `7`, `7/1`, `7//2` or `7/1/2`; negative numbers count back from the last.
    fn corner(&self, word: &str) -> Result<ObjCorner, String> {
        let mut parts = word.split('/');
        let index = |part: Option<&str>, count: usize| -> Result<Option<usize>, String> {
            match part {
                None | Some("") => Ok(None),
                Some(part) => match part.parse::<i64>() {
                    Ok(0) | Err(_) => Err(format!("{word:?} is not a face corner")),
                    Ok(number) if number > 0 => Ok(Some(usize::try_from(number - 1).unwrap_or(usize::MAX))),
                    // Further back than the first wraps to an index that does not exist.
                    Ok(number) => Ok(Some((count as i64 + number).try_into().unwrap_or(usize::MAX))),
                },
            }
        };
        let position = index(parts.next(), self.positions.len())?.ok_or("a face corner has no vertex")?;
        let mut uv = index(parts.next(), self.uvs.len())?;
        let mut normal = index(parts.next(), self.normals.len())?;
        if self.uvs.is_empty() && !self.normals.is_empty() && uv.is_some() && normal.is_none() {
            // Without texture coordinates in the file the second number is the normal's.
            normal = uv.take();
        }
        Ok(ObjCorner { position, uv, normal })
    }

    fn object(&mut self, name: &str) {
        if name.is_empty() {
            return;
        }
        match self.objects.by_name.get(name) {
            // Faces of a repeated object first go on with the current mesh; the next mesh belongs to the object.
            Some(&object) => self.objects.current = Some(object),
            None => self.begin_object(name),
        }
    }

    fn begin_object(&mut self, name: &str) {
        let object = self.objects.count;
        self.objects.count += 1;
        // Of two groups of one name the first is found.
        self.objects.by_name.entry(name.to_owned()).or_insert(object);
        self.objects.current = Some(object);
        self.meshes.push(ObjMesh { object, material: self.current_material, ..ObjMesh::default() });
    }

    fn use_material(&mut self, name: &str) {
        let current = self.current_material.and_then(|index| self.materials.get(index));
        if name.is_empty() || current.is_some_and(|current| current.name == name) {
            return;
        }
        let index = self.materials.iter().position(|material| material.name == name).unwrap_or_else(|| {
            log::debug!("OBJ material {name:?} is not defined, it is grey");
            self.materials.push(NamedMaterial::new(name));
            self.materials.len() - 1
        });
        self.current_material = Some(index);
        match self.meshes.last_mut() {
            // A mesh has only one material.
            Some(mesh) if mesh.material.is_some_and(|material| material != index) && !mesh.face_sizes.is_empty() => {
                let object = self.objects.current.unwrap_or(0);
                self.meshes.push(ObjMesh { object, material: Some(index), ..ObjMesh::default() });
            }
            Some(mesh) => mesh.material = Some(index),
            None => {}
        }
    }

    /// Reads a material library: the file of that name beside the mesh, else the mesh's own name with `.mtl`.
    fn library(&mut self, name: &str) {
        let MeshSource { path, options } = self.source;
        self.library_bytes = self.library_bytes.saturating_add(LIBRARY_BYTES);
        let text = if self.library_bytes > options.max_file_bytes {
            Err(ResourceError::TooLarge { path: path.to_owned(), max_mb: options.max_file_bytes >> 20 })
        } else {
            options
                .read(&self.source.beside(name))
                .or_else(|error| options.read(&path.with_extension("mtl")).map_err(|_| error))
        };
        let bytes = match text {
            Ok(bytes) => bytes,
            Err(error) => {
                log::warn!("{}: material library {name:?}: {error}", path.display());
                return;
            }
        };
        self.library_bytes = self.library_bytes.saturating_add(bytes.len() as u64);
        let (current, meshes) = (&mut self.current_material, &mut self.meshes);
        mtl::read(&rcs_text::decode(&bytes), &mut self.materials, |index, is_new| {
            *current = Some(index);
            if is_new {
                if let Some(mesh) = meshes.last_mut() {
                    mesh.material = Some(index);
                }
            }
        });
    }

    /// The meshes, whose faces may stand before their vertices.
    fn finish(mut self) -> Result<Imported, MeshFault> {
        if let Some((_, line)) = self.last_vertex.filter(|(last, _)| *last >= self.positions.len()) {
            return Err(MeshFault::Line { line, what: "a vertex index is out of range".to_owned() });
        }
        let mut meshes = Vec::new();
        self.meshes.sort_by_key(|mesh| mesh.object);
        for mesh in self.meshes {
            if mesh.face_sizes.is_empty() {
                continue;
            }
            let corners = &mesh.corners;
            meshes.push(Polygons {
                positions: corners.iter().map(|corner| self.positions[corner.position]).collect(),
                normals: of_corners(&self.normals, corners.iter().map(|corner| corner.normal)),
                uvs: of_corners(&self.uvs, corners.iter().map(|corner| corner.uv)),
                corners: None,
                faces: Faces::Sizes(mesh.face_sizes),
                material: mesh.material.unwrap_or(0),
            });
        }
        Ok(Imported::untransformed(meshes, self.materials.into_iter().map(|material| material.spec).collect()))
    }
}

/// Values of corners, if at least one has one; none if one's index is out of range.
fn of_corners<T: Copy + Default>(values: &[T], indices: impl Iterator<Item = Option<usize>> + Clone) -> Vec<T> {
    if indices.clone().all(|index| index.is_none()) {
        return Vec::new();
    }
    let value = |index: Option<usize>| index.map_or(Some(T::default()), |index| values.get(index).copied());
    indices.map(value).collect::<Option<_>>().unwrap_or_default()
}
