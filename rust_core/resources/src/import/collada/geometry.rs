//! Geometries: sources, inputs and primitives into corners.
//!
//! A geometry's primitives, one after the other, fill one list of corners; each primitive element is a group with its
//! own material symbol. Inputs that some primitives lack are filled up as Assimp does: normals with (0, 1, 0), texture
//! coordinates with zero; those that the last primitives lack are missing from these only.

use std::collections::HashMap;

use super::dom::{attribute, children, fault, floats, number, reference, Node};
use crate::{
    import::{Polygons, MAX_CORNERS},
    MeshFault,
};

/// Texture coordinate sets that Assimp keeps.
const UV_SETS: usize = 8;

/// A geometry with all its primitives.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) groups: Vec<Group>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: [Vec<[f32; 2]>; UV_SETS],
    face_sizes: Vec<u32>,
}

/// The faces of one primitive element.
#[derive(Debug)]
pub(super) struct Group {
    /// The material symbol that instances bind.
    pub(super) symbol: String,
    pub(super) faces: usize,
}

/// Geometries, and controllers' skins, by id.
pub(super) type Geometries = HashMap<String, Geometry>;

/// A float source: where a value's components lie.
#[derive(Clone, Debug, Default)]
struct Source<'a> {
    /// Which array, by id.
    array: &'a str,
    count: usize,
    stride: usize,
    offset: usize,
    /// Where x, y, z and w (or s, t, p) lie in a value. An accessor without names has them all at 0, as in Assimp.
    components: [usize; 4],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Semantic {
    Position,
    Normal,
    Uv(usize),
    /// Refers to the inputs of `<vertices>`.
    Vertex,
}

#[derive(Clone, Debug)]
struct Input<'a> {
    semantic: Semantic,
    source: &'a str,
    /// Which of a corner's indices is this input's.
    offset: usize,
}

/// Sources seen so far in the file; Assimp looks ids up across geometries.
#[derive(Default)]
struct Sources<'a> {
    by_id: HashMap<&'a str, Source<'a>>,
    arrays: HashMap<&'a str, Vec<f32>>,
}

/// Reads `library_geometries`; of two geometries with one id the first counts.
pub(super) fn read_geometries(root: Node<'_, '_>) -> Result<Geometries, MeshFault> {
    let mut sources = Sources::default();
    let mut geometries = Geometries::new();
    for library in children(root, "library_geometries") {
        for geometry in children(library, "geometry") {
            let id = attribute(geometry, "id");
            if geometries.contains_key(id) {
                continue;
            }
            let mut read = Geometry::default();
            for mesh in children(geometry, "mesh") {
                read.read_mesh(mesh, &mut sources)?;
            }
            geometries.insert(id.to_owned(), read);
        }
    }
    Ok(geometries)
}

impl Geometry {
    fn read_mesh<'a>(&mut self, mesh: Node<'a, '_>, sources: &mut Sources<'a>) -> Result<(), MeshFault> {
        let mut vertices_id = "";
        let mut vertices: Vec<Input<'a>> = Vec::new();
        for element in mesh.children() {
            match element.tag_name().name() {
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
        element: Node<'_, '_>,
        vertices: &[Input<'_>],
        vertices_id: &str,
        sources: &Sources<'_>,
    ) -> Result<(), MeshFault> {
        let inputs = read_inputs(element)?;
        // Inputs of other kinds, such as colours, have indices too.
        let per_corner = children(element, "input").map(|input| offset(input) + 1).max().unwrap_or(1);
        let vertex_input = inputs.iter().rfind(|input| input.semantic == Semantic::Vertex);
        let vertex_offset = vertex_input.map(|input| input.offset);
        if vertex_input.is_some_and(|input| input.source != vertices_id) {
            return Err(fault(element, "its VERTEX input is not the geometry's <vertices>"));
        }
        let announced = number(element, "count").unwrap_or(0);
        let counts: Vec<usize> = children(element, "vcount")
            .flat_map(|vcount| vcount.text().unwrap_or_default().split_ascii_whitespace())
            .take(announced)
            .map_while(|word| word.parse().ok())
            .collect();
        let faces_before = self.face_sizes.len();
        for p in children(element, "p") {
            if announced == 0 {
                break;
            }
            // Some exporters write negative indices; they count as 0.
            let indices: Vec<usize> = p
                .text()
                .unwrap_or_default()
                .split_ascii_whitespace()
                .map_while(|word| word.parse::<i64>().ok())
                .map(|index| usize::try_from(index).unwrap_or(0))
                .collect();
            let corners = indices.len() / per_corner;
            let faces = faces(element.tag_name().name(), corners, announced, &counts)
                .filter(|_| indices.len() % per_corner == 0)
                .ok_or_else(|| fault(p, format!("{} indices do not fit the primitives announced", indices.len())))?;
            for face in faces {
                self.face_sizes.push(face.len() as u32);
                for corner in face {
                    let Some(corner) = indices.get(corner * per_corner..(corner + 1) * per_corner) else { continue };
                    let at = |offset: usize| corner.get(offset).copied().unwrap_or(0);
                    let vertex = vertex_offset.map(|offset| vertices.iter().map(move |input| (input, at(offset))));
                    let own = inputs.iter().map(|input| (input, at(input.offset)));
                    for (input, index) in vertex.into_iter().flatten().chain(own) {
                        self.push(input, index, sources).map_err(|what| fault(p, what))?;
                    }
                }
                if self.positions.len() > MAX_CORNERS {
                    return Err(MeshFault::TooLarge { limit: MAX_CORNERS, what: "corners" });
                }
            }
        }
        let corners: usize = self.face_sizes.iter().map(|&size| size as usize).sum();
        if self.positions.len() != corners {
            return Err(fault(element, "its corners do not have one position each"));
        }
        let faces = self.face_sizes.len() - faces_before;
        self.groups.push(Group { symbol: attribute(element, "material").to_owned(), faces });
        Ok(())
    }

    /// Adds the value of an input at a corner, whose position is added first.
    fn push(&mut self, input: &Input<'_>, index: usize, sources: &Sources<'_>) -> Result<(), String> {
        if input.semantic == Semantic::Vertex {
            return Ok(());
        }
        let source = sources.by_id.get(input.source).ok_or_else(|| format!("there is no source {:?}", input.source))?;
        let [x, y, z, _] = sources.value(source, index)?;
        let before = self.positions.len().saturating_sub(1);
        match input.semantic {
            Semantic::Position => self.positions.push([x, y, z]),
            Semantic::Normal => push_padded(&mut self.normals, [x, y, z], before, [0.0, 1.0, 0.0]),
            Semantic::Uv(set) => {
                if let Some(uvs) = self.uvs.get_mut(set) {
                    push_padded(uvs, [x, y], before, [0.0; 2]);
                }
            }
            Semantic::Vertex => {}
        }
        Ok(())
    }

    /// The faces from `first_face` on with the corners from `first_corner` on, as a mesh of its own. Normals and
    /// texture coordinates that do not reach its end are left out; of the coordinate sets the first that does is taken.
    pub(super) fn slice(&self, first_face: usize, first_corner: usize, faces: usize) -> Option<Polygons> {
        let face_sizes = self.face_sizes.get(first_face..first_face + faces)?.to_vec();
        let corners: usize = face_sizes.iter().map(|&size| size as usize).sum();
        let range = first_corner..first_corner + corners;
        Some(Polygons {
            positions: self.positions.get(range.clone())?.to_vec(),
            normals: self.normals.get(range.clone()).unwrap_or_default().to_vec(),
            uvs: self.uvs.iter().find_map(|uvs| uvs.get(range.clone())).unwrap_or_default().to_vec(),
            face_sizes,
            material: 0,
        })
    }
}

/// Adds a value, and fillers before it so that it is the one of the corner at hand.
fn push_padded<T: Copy>(values: &mut Vec<T>, value: T, before: usize, filler: T) {
    if values.len() < before {
        values.resize(before, filler);
    }
    values.push(value);
}

/// The corners of each face of a `<p>`, or `None` when their number does not fit. A fan is one polygon to Assimp.
fn faces(primitive: &str, corners: usize, announced: usize, counts: &[usize]) -> Option<Vec<Vec<usize>>> {
    let of_size = |size: usize| (0..corners / size).map(|face| (face * size..(face + 1) * size).collect()).collect();
    match primitive {
        "triangles" => (corners == announced.checked_mul(3)?).then(|| of_size(3)),
        // SketchUp announces a wrong number of lines.
        "lines" => Some(of_size(2)),
        "linestrips" => Some((1..corners).map(|end| vec![end - 1, end]).collect()),
        "tristrips" => Some(
            (2..corners)
                .map(|end| if end % 2 == 0 { vec![end - 2, end - 1, end] } else { vec![end - 1, end - 2, end] })
                .collect(),
        ),
        "polylist" => {
            let mut start = 0_usize;
            let mut faces = Vec::with_capacity(counts.len());
            for &count in counts {
                let end = start.checked_add(count).filter(|&end| end <= corners)?;
                faces.push((start..end).collect());
                start = end;
            }
            (start == corners && counts.len() == announced).then_some(faces)
        }
        _ => Some(vec![(0..corners).collect()]),
    }
}

impl<'a> Sources<'a> {
    fn read(&mut self, source: Node<'a, '_>) {
        for node in source.descendants() {
            match node.tag_name().name() {
                "float_array" => {
                    let count = number(node, "count").unwrap_or(0);
                    self.arrays.insert(attribute(node, "id"), floats(node).take(count).collect());
                }
                "accessor" => {
                    let mut accessor = Source {
                        array: attribute(node, "source").trim_start_matches('#'),
                        count: number(node, "count").unwrap_or(0),
                        stride: number(node, "stride").unwrap_or(1),
                        offset: number(node, "offset").unwrap_or(0),
                        components: [0; 4],
                    };
                    for (i, param) in children(node, "param").enumerate() {
                        let component = match attribute(param, "name") {
                            "X" | "R" | "S" | "U" => 0,
                            "Y" | "G" | "T" | "V" => 1,
                            "Z" | "B" | "P" => 2,
                            "A" => 3,
                            _ => continue,
                        };
                        if let Some(slot) = accessor.components.get_mut(component) {
                            *slot = i;
                        }
                    }
                    self.by_id.insert(attribute(source, "id"), accessor);
                }
                _ => {}
            }
        }
    }

    fn value(&self, source: &Source<'_>, index: usize) -> Result<[f32; 4], String> {
        let array =
            self.arrays.get(source.array).ok_or_else(|| format!("there is no float array {:?}", source.array))?;
        let start = index.checked_mul(source.stride).and_then(|start| start.checked_add(source.offset));
        let values = (index < source.count)
            .then(|| array.get(start?..))
            .flatten()
            .ok_or_else(|| format!("index {index} is past the {} values of its source", source.count))?;
        let component = |at: usize| values.get(at).copied();
        match source.components.map(component) {
            [Some(x), Some(y), Some(z), w] => Ok([x, y, z, w.unwrap_or(0.0)]),
            // Texture coordinates of two components at the end of their array.
            [Some(x), Some(y), None, _] => Ok([x, y, 0.0, 0.0]),
            _ => Err(format!("float array {:?} ends within value {index}", source.array)),
        }
    }
}

fn read_inputs<'a>(element: Node<'a, '_>) -> Result<Vec<Input<'a>>, MeshFault> {
    let mut inputs = Vec::new();
    for input in children(element, "input") {
        let set = number(input, "set").unwrap_or(0);
        let semantic = match attribute(input, "semantic") {
            "POSITION" => Semantic::Position,
            "NORMAL" => Semantic::Normal,
            "TEXCOORD" => Semantic::Uv(set),
            "VERTEX" => Semantic::Vertex,
            _ => continue,
        };
        inputs.push(Input { semantic, source: reference(input, "source")?, offset: offset(input) });
    }
    Ok(inputs)
}

/// Which of a corner's indices is an input's; a corner with more indices than this is damaged.
fn offset(input: Node<'_, '_>) -> usize {
    number(input, "offset").unwrap_or(0).min(64)
}
