//! The header of a PLY file: lines of text that list the elements, their counts and their properties.
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

use crate::{
    import::{imported::check_count, scalar::ScalarType},
    MeshFault,
};

/// Most elements, and most properties; a file with more is damaged.
const MAX_PROPERTIES: usize = 1000;

/// Encoding of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyEncoding {
    /// A line of words for each row.
    Text,
    /// Binary, lowest byte first.
    LittleEndian,
    /// Binary, highest byte first.
    BigEndian,
}

/// The type of a name.
fn scalar_type(name: &str) -> Option<ScalarType> {
    Some(match name {
        "char" | "int8" => ScalarType::I8,
        "uchar" | "uint8" => ScalarType::U8,
        "short" | "int16" => ScalarType::I16,
        "ushort" | "uint16" => ScalarType::U16,
        "int" | "int32" => ScalarType::I32,
        "uint" | "uint32" => ScalarType::U32,
        "float" | "float32" => ScalarType::F32,
        "double" | "float64" | "double64" => ScalarType::F64,
        _ => return None,
    })
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
    /// Number of roles.
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
    /// Indices of its vertices.
    Indices,
    /// Coordinates u and v of its corners.
    TexCoords,
}

/// A number or list that each row of an element has. Without a role it is skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyProperty {
    Scalar { kind: ScalarType, role: Option<ScalarRole> },
    List { count: ScalarType, kind: ScalarType, role: Option<ListRole> },
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
pub(super) struct PlyElement {
    pub(super) kind: ElementKind,
    pub(super) name: String,
    /// Number of rows in the header, unchecked.
    pub(super) count: u64,
    pub(super) properties: Vec<PlyProperty>,
}

/// A whole header.
#[derive(Debug)]
pub(super) struct PlyHeader<'a> {
    pub(super) encoding: PlyEncoding,
    pub(super) elements: Vec<PlyElement>,
    /// The texture's file; empty for none.
    pub(super) texture: String,
    /// The bytes after the header.
    pub(super) body: &'a [u8],
    /// The line on which the body begins, from 1.
    pub(super) body_line: usize,
}

impl<'a> PlyHeader<'a> {
    /// Reads the header at the beginning of a file.
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, MeshFault> {
        let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        // Of a file whose lines end with CR alone, the first byte of the body may be any.
        let first_end = rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(0);
        let is_cr = rest.get(first_end) == Some(&b'\r') && rest.get(first_end + 1) != Some(&b'\n');
        let line_end = if is_cr { b'\r' } else { b'\n' };
        let (mut encoding, mut elements, mut texture) = (None, Vec::<PlyElement>::new(), String::new());
        let mut properties = 0;
        for line in 1.. {
            if rest.is_empty() {
                break;
            }
            let end = rest.iter().position(|&byte| byte == line_end).map_or(rest.len(), |end| end + 1);
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
                        "ascii" => PlyEncoding::Text,
                        "binary_little_endian" => PlyEncoding::LittleEndian,
                        "binary_big_endian" => PlyEncoding::BigEndian,
                        _ => return Err(bad(format!("{name:?} is not a format of PLY"))),
                    });
                }
                ["comment", "TextureFile", ..] => {
                    let name = text.split_once("TextureFile").map_or("", |(_, name)| name.trim());
                    name.clone_into(&mut texture);
                }
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| bad(format!("{count:?} is not a number of elements")))?;
                    elements.push(PlyElement::new(name, count));
                }
                ["property", of @ ..] => {
                    let element = elements.last_mut().ok_or_else(|| bad("a property of no element".to_owned()))?;
                    let property =
                        PlyProperty::of(of).ok_or_else(|| bad(format!("{:?} is no property", text.trim())))?;
                    element.properties.push(property);
                    properties += 1;
                }
                ["end_header"] => {
                    let encoding = encoding.ok_or_else(|| bad("there is no format line".to_owned()))?;
                    return Ok(Self { encoding, elements, texture, body: rest, body_line: line + 1 });
                }
                // Comments, obj_info and others.
                _ => {}
            }
            check_count(properties.max(elements.len()), MAX_PROPERTIES, "properties")?;
        }
        Err(MeshFault::Malformed("not a PLY file, or cut off in its header".to_owned()))
    }
}

impl PlyElement {
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

impl PlyProperty {
    /// The property that the words after `property` describe.
    fn of(words: &[&str]) -> Option<Self> {
        match *words {
            ["list", count, kind, name] => {
                let role = match name {
                    "vertex_index" | "vertex_indices" => Some(ListRole::Indices),
                    "texcoord" => Some(ListRole::TexCoords),
                    _ => None,
                };
                Some(Self::List { count: scalar_type(count)?, kind: scalar_type(kind)?, role })
            }
            [kind, name] => Some(Self::Scalar { kind: scalar_type(kind)?, role: ScalarRole::of(name) }),
            _ => None,
        }
    }
}
