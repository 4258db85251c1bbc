//! The header of a PLY file: lines of text that say which elements follow, how many, and of which properties.
//!
//! ```text
//! ply
//! format ascii 1.0                            or binary_little_endian, binary_big_endian
//! comment TextureFile wood.png
//! element vertex 4
//! property float x                            a type and a name
//! element face 2
//! property list uchar int vertex_indices      of the count, of the values, and a name
//! end_header
//! ```

use super::super::{check_count, without_byte_order_mark};
use crate::MeshFault;

/// The most elements and properties; a file with more is damaged.
const MAX_PROPERTIES: usize = 1000;

/// How values are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// A line of words for each row.
    Text,
    /// The lowest byte first.
    LittleEndian,
    /// The highest byte first.
    BigEndian,
}

/// The type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" | "double64" => Self::F64,
            _ => return None,
        })
    }
}

/// The role of a number of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScalarRole {
    X,
    Y,
    Z,
    NormalX,
    NormalY,
    NormalZ,
    U,
    V,
}

impl ScalarRole {
    /// How many there are.
    pub(super) const COUNT: usize = 8;

    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "x" => Self::X,
            "y" => Self::Y,
            "z" => Self::Z,
            "nx" => Self::NormalX,
            "ny" => Self::NormalY,
            "nz" => Self::NormalZ,
            "u" | "s" | "tx" | "texture_u" => Self::U,
            "v" | "t" | "ty" | "texture_v" => Self::V,
            _ => return None,
        })
    }
}

/// The role of a list of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ListRole {
    /// The numbers of its vertices.
    Indices,
    /// u and v of its corners.
    TexCoords,
}

/// A number or list that each row of an element has. Without a role it is skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Property {
    Scalar { kind: Kind, role: Option<ScalarRole> },
    List { count: Kind, kind: Kind, role: Option<ListRole> },
}

/// The kind of an element's rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementKind {
    Vertex,
    Face,
    Strips,
    Other,
}

/// An element: rows of the same properties.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) kind: ElementKind,
    pub(super) name: String,
    /// How many rows the header claims.
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// A whole header.
#[derive(Debug)]
pub(super) struct Header<'a> {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// The texture's file; empty for none.
    pub(super) texture: String,
    /// What follows.
    pub(super) body: &'a [u8],
    /// The line on which that begins, counted from 1.
    pub(super) body_line: usize,
}

impl<'a> Header<'a> {
    /// Reads the header at the beginning of a file.
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, MeshFault> {
        let mut rest = without_byte_order_mark(bytes);
        let (mut encoding, mut elements, mut texture) = (None, Vec::<Element>::new(), String::new());
        let mut properties = 0;
        for line in 1.. {
            if rest.is_empty() {
                break;
            }
            let end = rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |end| end + 1);
            let (text, after) = rest.split_at(end);
            rest = after;
            let bad = |what: String| MeshFault::Line { line, what };
            let text = String::from_utf8_lossy(text);
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            match words.as_slice() {
                [magic, ..] if line == 1 && magic.eq_ignore_ascii_case("ply") => {}
                _ if line == 1 => break,
                ["format", name, ..] => {
                    encoding = Some(match *name {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        _ => return Err(bad(format!("{name:?} is not a format of PLY"))),
                    });
                }
                ["comment", "TextureFile", ..] => {
                    let name = text.split_once("TextureFile").map_or("", |(_, name)| name.trim());
                    name.clone_into(&mut texture);
                }
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| bad(format!("{count:?} is not a number of elements")))?;
                    elements.push(Element::new(name, count));
                }
                ["property", of @ ..] => {
                    let element = elements.last_mut().ok_or_else(|| bad("a property of no element".to_owned()))?;
                    let property = Property::of(of).ok_or_else(|| bad(format!("{:?} is no property", text.trim())))?;
                    element.properties.push(property);
                    properties += 1;
                }
                ["end_header"] => {
                    let encoding = encoding.ok_or_else(|| bad("there is no format line".to_owned()))?;
                    return Ok(Self { encoding, elements, texture, body: rest, body_line: line + 1 });
                }
                // Comments, obj_info, and what else there may be.
                _ => {}
            }
            check_count(properties.max(elements.len()), MAX_PROPERTIES, "properties")?;
        }
        Err(MeshFault::Malformed("not a PLY file, or cut off in its header".to_owned()))
    }
}

impl Element {
    fn new(name: &str, count: u64) -> Self {
        let kind = match name {
            "vertex" => ElementKind::Vertex,
            "face" => ElementKind::Face,
            "tristrips" => ElementKind::Strips,
            _ => ElementKind::Other,
        };
        Self { kind, name: name.to_owned(), count, properties: Vec::new() }
    }
}

impl Property {
    /// The property that the words after `property` describe.
    fn of(words: &[&str]) -> Option<Self> {
        match *words {
            ["list", count, kind, name] => {
                let role = match name {
                    "vertex_index" | "vertex_indices" => Some(ListRole::Indices),
                    "texcoord" => Some(ListRole::TexCoords),
                    _ => None,
                };
                Some(Self::List { count: Kind::of(count)?, kind: Kind::of(kind)?, role })
            }
            [kind, name] => Some(Self::Scalar { kind: Kind::of(kind)?, role: ScalarRole::of(name) }),
            _ => None,
        }
    }
}
