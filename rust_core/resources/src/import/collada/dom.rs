//! Helpers over the XML tree.

pub(super) use roxmltree::Node;
use roxmltree::{Document, Error, ParsingOptions};

use crate::{import::lenient_float::leading_f32, MeshFault};

/// Most prefixes without a namespace that are accepted.
const MAX_PREFIXES: usize = 16;
/// Most nodes of the XML tree, which take far more memory than their text.
const MAX_XML_NODES: u32 = 4_000_000;

/// Parses a document and passes its root to `read`. Undeclared prefixes, which some exporters write and lenient parsers
/// ignore, are declared.
pub(super) fn parse<T>(text: &str, read: impl FnOnce(Node<'_, '_>) -> Result<T, MeshFault>) -> Result<T, MeshFault> {
    let mut text = std::borrow::Cow::Borrowed(text);
    for _ in 0..MAX_PREFIXES {
        // roxmltree bounds what entities of a document type can expand to.
        let options = ParsingOptions { allow_dtd: true, nodes_limit: MAX_XML_NODES, ..ParsingOptions::default() };
        match Document::parse_with_options(&text, options) {
            Ok(document) => return read(document.root_element()),
            Err(Error::UnknownNamespace(prefix, _)) => {
                let Some(at) = text.find("<COLLADA").map(|at| at + "<COLLADA".len()) else { break };
                let mut declared = text.into_owned();
                declared.insert_str(at, &format!(" xmlns:{prefix}=\"undeclared:{prefix}\""));
                text = declared.into();
            }
            Err(error) => return Err(MeshFault::Xml(error.to_string())),
        }
    }
    Err(MeshFault::Xml("prefixes without a namespace".to_owned()))
}

/// A fault at an element.
pub(super) fn fault(node: Node<'_, '_>, what: impl Into<String>) -> MeshFault {
    let line = node.document().text_pos_at(node.range().start).row;
    MeshFault::Line { line: line as usize, what: what.into() }
}

/// The child elements of a name.
pub(super) fn children<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'a str) -> impl Iterator<Item = Node<'a, 'i>> + 'a {
    node.children().filter(move |child| child.tag_name().name() == name)
}

/// The first child element of a name.
pub(super) fn child<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'a str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

/// An element's text, trimmed.
pub(super) fn text<'a>(node: Node<'a, '_>) -> &'a str {
    node.text().unwrap_or_default().trim()
}

/// An attribute, or the empty string.
pub(super) fn attribute<'a>(node: Node<'a, '_>, name: &str) -> &'a str {
    node.attribute(name).unwrap_or_default()
}

/// A whole number in an attribute.
pub(super) fn number(node: Node<'_, '_>, name: &str) -> Option<usize> {
    attribute(node, name).trim().parse().ok()
}

/// The id in a reference such as `#part`.
pub(super) fn reference<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, MeshFault> {
    let value = attribute(node, name);
    value.strip_prefix('#').ok_or_else(|| fault(node, format!("{name}={value:?} is not a reference within the file")))
}

/// The numbers of an element's text, up to the first other word.
pub(super) fn floats<'a>(node: Node<'a, '_>) -> impl Iterator<Item = f32> + 'a {
    node.text().unwrap_or_default().split_ascii_whitespace().map_while(leading_f32)
}
