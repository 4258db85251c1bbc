//! Sources: arrays of numbers, accessors that cut them into values, and the inputs that refer to them.

use std::collections::HashMap;

use super::dom::{attribute, fault, floats, number, reference, Node};
use crate::MeshFault;

/// Most indices of a corner; a file with more is damaged.
const MAX_INDICES: usize = 64;

/// The layout of values in an array.
#[derive(Clone, Debug, Default)]
struct Accessor<'a> {
    /// The id of the array.
    array: &'a str,
    count: usize,
    stride: usize,
    offset: usize,
    /// Indices of x, y and z (or s, t and p) in a value; all 0 for an accessor without names, as in Assimp.
    components: [usize; 3],
}

/// All sources read so far: as in Assimp, ids are valid across geometries.
#[derive(Default)]
pub(super) struct Sources<'a> {
    accessors: HashMap<&'a str, Accessor<'a>>,
    arrays: HashMap<&'a str, Vec<f32>>,
}

/// The meaning of an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Semantic {
    /// A corner's position.
    Position,
    /// A corner's normal.
    Normal,
    /// A corner's texture coordinate in a set.
    Uv(usize),
    /// Refers to the inputs of `<vertices>`.
    Vertex,
}

/// An `<input>` of a kind that is used.
#[derive(Clone, Debug)]
pub(super) struct ColladaInput<'a> {
    pub(super) semantic: Semantic,
    /// The source's id.
    pub(super) source: &'a str,
    /// Position of its index among a corner's indices.
    pub(super) offset: usize,
}

/// An input with its values.
pub(super) struct InputChannel<'a> {
    pub(super) semantic: Semantic,
    /// Position of its index among a corner's indices.
    pub(super) offset: usize,
    accessor: &'a Accessor<'a>,
    array: &'a [f32],
}

impl<'a> Sources<'a> {
    /// Reads a `<source>`.
    pub(super) fn read(&mut self, source: Node<'a>) {
        for node in source.descendants() {
            match node.name {
                "float_array" => {
                    let count = number(node, "count").unwrap_or(0);
                    self.arrays.insert(attribute(node, "id"), floats(node).take(count).collect());
                }
                "accessor" => {
                    let mut accessor = Accessor {
                        array: attribute(node, "source").trim_start_matches('#'),
                        count: number(node, "count").unwrap_or(0),
                        stride: number(node, "stride").unwrap_or(1),
                        offset: number(node, "offset").unwrap_or(0),
                        components: [0; 3],
                    };
                    for (i, param) in node.children("param").enumerate() {
                        let component = match attribute(param, "name") {
                            "X" | "R" | "S" | "U" => 0,
                            "Y" | "G" | "T" | "V" => 1,
                            "Z" | "B" | "P" => 2,
                            _ => continue,
                        };
                        if let Some(slot) = accessor.components.get_mut(component) {
                            *slot = i;
                        }
                    }
                    self.accessors.insert(attribute(source, "id"), accessor);
                }
                _ => {}
            }
        }
    }

    /// The values of inputs except `VERTEX`. `at_offset` overrides their offsets.
    pub(super) fn channels(
        &'a self,
        inputs: &[ColladaInput<'_>],
        at_offset: Option<usize>,
    ) -> Result<Vec<InputChannel<'a>>, String> {
        let channel = |input: &ColladaInput<'_>| {
            let accessor =
                self.accessors.get(input.source).ok_or_else(|| format!("there is no source {:?}", input.source))?;
            let array = self
                .arrays
                .get(accessor.array)
                .ok_or_else(|| format!("there is no float array {:?}", accessor.array))?;
            Ok(InputChannel { semantic: input.semantic, offset: at_offset.unwrap_or(input.offset), accessor, array })
        };
        inputs.iter().filter(|input| input.semantic != Semantic::Vertex).map(channel).collect()
    }
}

impl InputChannel<'_> {
    /// The value of an index; a third component past the array's end is 0.
    pub(super) fn value(&self, index: usize) -> Result<[f32; 3], String> {
        let Accessor { count, stride, offset, components, .. } = *self.accessor;
        let start = index.checked_mul(stride).and_then(|start| start.checked_add(offset));
        let values = (index < count)
            .then(|| self.array.get(start?..))
            .flatten()
            .ok_or_else(|| format!("index {index} is past the {count} values of its source"))?;
        match components.map(|at| values.get(at).copied()) {
            [Some(x), Some(y), z] => Ok([x, y, z.unwrap_or(0.0)]),
            _ => Err(format!("float array {:?} ends within value {index}", self.accessor.array)),
        }
    }
}

/// Reads the inputs of an element, without unknown semantics.
pub(super) fn read_inputs<'a>(element: Node<'a>) -> Result<Vec<ColladaInput<'a>>, MeshFault> {
    let mut inputs = Vec::new();
    for input in element.children("input") {
        let set = number(input, "set").unwrap_or(0);
        let semantic = match attribute(input, "semantic") {
            "POSITION" => Semantic::Position,
            "NORMAL" => Semantic::Normal,
            "TEXCOORD" => Semantic::Uv(set),
            "VERTEX" => Semantic::Vertex,
            _ => continue,
        };
        let offset = number(input, "offset").unwrap_or(0);
        if offset >= MAX_INDICES {
            return Err(fault(input, format!("an offset of {offset} is past what is plausible")));
        }
        inputs.push(ColladaInput { semantic, source: reference(input, "source")?, offset });
    }
    Ok(inputs)
}

/// Number of indices of a corner, including those of unused inputs such as colours.
pub(super) fn indices_per_corner(element: Node<'_>) -> usize {
    let offset = |input| number(input, "offset").unwrap_or(0).min(MAX_INDICES - 1);
    element.children("input").map(|input| offset(input) + 1).max().unwrap_or(1)
}
