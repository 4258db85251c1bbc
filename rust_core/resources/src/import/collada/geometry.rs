//! Geometries: primitives into corners.
//!
//! A geometry's primitives fill one list of corners; each primitive element is a group with its own material symbol.
//! Inputs that some primitives lack are padded as in Assimp, normals with (0, 1, 0), texture coordinates with zero, but
//! not for the last primitives, which go without.

use std::collections::HashMap;

use super::{
    dom::{attribute, fault, number, Node},
    source::{indices_per_corner, read_inputs, ColladaInput, Semantic, Sources},
};
use crate::{
    import::imported::{check_count, strip_triangles, Faces, Polygons},
    MeshFault,
};

/// Number of texture coordinate sets in Assimp.
const UV_SETS: usize = 8;

/// A geometry with all its primitives.
#[derive(Debug, Default)]
pub(super) struct ColladaGeometry {
    pub(super) groups: Vec<Group>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: [Vec<[f32; 2]>; UV_SETS],
    face_sizes: Vec<u32>,
    /// Limit of its corners.
    max_corners: usize,
}

/// The faces of one primitive element.
#[derive(Debug)]
pub(super) struct Group {
    /// The material symbol that instances bind.
    pub(super) symbol: String,
    pub(super) faces: usize,
}

/// Geometries, and controllers' skins, by id.
pub(super) type Geometries = HashMap<String, ColladaGeometry>;

/// Reads `library_geometries`; of two geometries with one id the first counts.
pub(super) fn read_geometries(root: Node<'_>, max_corners: usize) -> Result<Geometries, MeshFault> {
    let mut sources = Sources::default();
    let mut geometries = Geometries::new();
    for library in root.children("library_geometries") {
        for geometry in library.children("geometry") {
            let id = attribute(geometry, "id");
            if geometries.contains_key(id) {
                continue;
            }
            let mut read = ColladaGeometry { max_corners, ..ColladaGeometry::default() };
            for mesh in geometry.children("mesh") {
                read.read_mesh(mesh, &mut sources)?;
            }
            geometries.insert(id.to_owned(), read);
        }
    }
    Ok(geometries)
}

impl ColladaGeometry {
    fn read_mesh<'a>(&mut self, mesh: Node<'a>, sources: &mut Sources<'a>) -> Result<(), MeshFault> {
        let mut vertices_id = "";
        let mut vertices: Vec<ColladaInput<'a>> = Vec::new();
        for element in mesh.elements.iter() {
            match element.name {
                "source" => sources.read(element),
                "vertices" => {
                    vertices_id = attribute(element, "id");
                    vertices.extend(read_inputs(element)?);
                }
                "triangles" | "lines" | "linestrips" | "polygons" | "polylist" | "trifans" | "tristrips" => {
                    self.read_primitives(element, &vertices, vertices_id, sources)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn read_primitives(
        &mut self,
        element: Node<'_>,
        vertices: &[ColladaInput<'_>],
        vertices_id: &str,
        sources: &Sources<'_>,
    ) -> Result<(), MeshFault> {
        let inputs = read_inputs(element)?;
        let per_corner = indices_per_corner(element);
        let vertex_input = inputs.iter().rfind(|input| input.semantic == Semantic::Vertex);
        if vertex_input.is_some_and(|input| input.source != vertices_id) {
            return Err(fault(element, "its VERTEX input is not the geometry's <vertices>"));
        }
        let announced = number(element, "count").unwrap_or(0);
        let counts: Vec<usize> = element
            .children("vcount")
            .flat_map(|vcount| vcount.text.split_ascii_whitespace())
            .take(announced)
            .map_while(|word| word.parse().ok())
            .collect();
        let mut face_count = 0;
        for p in element.children("p").take_while(|_| announced > 0) {
            let vertex_channels = vertex_input.map(|input| sources.channels(vertices, Some(input.offset)));
            let mut channels = vertex_channels.transpose().map_err(|what| fault(p, what))?.unwrap_or_default();
            channels.extend(sources.channels(&inputs, None).map_err(|what| fault(p, what))?);
            // Some exporters write negative indices; they count as 0.
            let indices: Vec<u32> = p
                .text
                .split_ascii_whitespace()
                .map_while(|word| word.parse::<i64>().ok())
                .map(|index| u32::try_from(index.max(0)).unwrap_or(u32::MAX))
                .collect();
            // A strip has three corners for each of its indices.
            let possible = self.positions.len().saturating_add(indices.len() / per_corner);
            check_count(possible, self.max_corners, "corners")?;
            let faces = PrimitiveFaces::of(element.name, indices.len() / per_corner, announced, &counts)
                .filter(|_| indices.len().is_multiple_of(per_corner))
                .ok_or_else(|| fault(p, format!("{} indices do not fit the primitives announced", indices.len())))?;
            for corner in faces.corners {
                let start = corner * per_corner;
                for channel in &channels {
                    let index = indices.get(start + channel.offset).copied().unwrap_or(0);
                    let value = channel.value(index as usize).map_err(|what| fault(p, what))?;
                    self.push(channel.semantic, value);
                }
            }
            face_count += faces.sizes.len();
            self.face_sizes.extend(faces.sizes);
            check_count(self.positions.len(), self.max_corners, "corners")?;
        }
        let corners: usize = self.face_sizes.iter().map(|&size| size as usize).sum();
        if self.positions.len() != corners {
            return Err(fault(element, "its corners do not have one position each"));
        }
        self.groups.push(Group { symbol: attribute(element, "material").to_owned(), faces: face_count });
        Ok(())
    }

    /// Adds a value of the current corner, whose position comes first.
    fn push(&mut self, semantic: Semantic, [x, y, z]: [f32; 3]) {
        let before = self.positions.len().saturating_sub(1);
        match semantic {
            Semantic::Position => self.positions.push([x, y, z]),
            Semantic::Normal => push_padded(&mut self.normals, [x, y, z], before, [0.0, 1.0, 0.0]),
            Semantic::Uv(set) => {
                if let Some(uvs) = self.uvs.get_mut(set) {
                    push_padded(uvs, [x, y], before, [0.0; 2]);
                }
            }
            Semantic::Vertex => {}
        }
    }

    /// The faces from `first_face` on with the corners from `first_corner` on, as a mesh. Normals that do not reach its
    /// end are left out; of the texture coordinate sets, the first that does counts.
    pub(super) fn slice(&self, first_face: usize, first_corner: usize, faces: usize) -> Option<Polygons> {
        let face_sizes = self.face_sizes.get(first_face..first_face + faces)?.to_vec();
        let corners: usize = face_sizes.iter().map(|&size| size as usize).sum();
        let range = first_corner..first_corner + corners;
        Some(Polygons {
            positions: self.positions.get(range.clone())?.to_vec(),
            normals: self.normals.get(range.clone()).unwrap_or_default().to_vec(),
            uvs: self.uvs.iter().find_map(|uvs| uvs.get(range.clone())).unwrap_or_default().to_vec(),
            corners: None,
            faces: Faces::Sizes(face_sizes),
            material: 0,
        })
    }
}

/// Adds a value at index `before` or later, and fillers up to it.
fn push_padded<T: Copy>(values: &mut Vec<T>, value: T, before: usize, filler: T) {
    if values.len() < before {
        values.resize(before, filler);
    }
    values.push(value);
}

/// The faces of a `<p>`.
struct PrimitiveFaces {
    /// Corners of each face.
    sizes: Vec<u32>,
    /// The corners face by face, as indices into the `<p>`.
    corners: Vec<usize>,
}

impl PrimitiveFaces {
    /// The faces of `count` corners; `None` when the element announces another number. A fan is one polygon in Assimp.
    fn of(primitive: &str, count: usize, announced: usize, vcounts: &[usize]) -> Option<Self> {
        let of_size =
            |size: usize| Self { sizes: vec![size as u32; count / size], corners: (0..count / size * size).collect() };
        match primitive {
            "triangles" => (count == announced.checked_mul(3)?).then(|| of_size(3)),
            // SketchUp announces a wrong number of lines.
            "lines" => Some(of_size(2)),
            "linestrips" => {
                let lines = count.saturating_sub(1);
                Some(Self { sizes: vec![2; lines], corners: (0..lines).flat_map(|i| [i, i + 1]).collect() })
            }
            "tristrips" => {
                let strip: Vec<usize> = (0..count).collect();
                let corners: Vec<usize> = strip_triangles(&strip).flatten().collect();
                Some(Self { sizes: vec![3; corners.len() / 3], corners })
            }
            "polylist" => {
                let total = vcounts.iter().try_fold(0_usize, |total, &size| total.checked_add(size))?;
                let sizes = vcounts.iter().map(|&size| size as u32).collect();
                (total == count && vcounts.len() == announced).then(|| Self { sizes, corners: (0..count).collect() })
            }
            _ => Some(Self { sizes: vec![count as u32], corners: (0..count).collect() }),
        }
    }
}
