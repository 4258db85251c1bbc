//! Helpers over the XML tree.

use rcs_text::xml::Element;

use crate::{import::lenient_float::leading_f32, MeshFault};

pub(super) type Node<'a> = &'a Element<'a>;

/// A fault at an element.
pub(super) fn fault(node: Node<'_>, what: impl Into<String>) -> MeshFault {
    MeshFault::Line { line: node.line, what: what.into() }
}

/// An element's text, trimmed.
pub(super) fn text<'a>(node: Node<'a>) -> &'a str {
    node.text.trim()
}

/// An attribute, or the empty string.
pub(super) fn attribute<'a>(node: Node<'a>, name: &str) -> &'a str {
    node.attribute(name).unwrap_or_default()
}

/// A whole number in an attribute.
pub(super) fn number(node: Node<'_>, name: &str) -> Option<usize> {
    attribute(node, name).trim().parse().ok()
}

/// The id in a reference such as `#part`.
pub(super) fn reference<'a>(node: Node<'a>, name: &str) -> Result<&'a str, MeshFault> {
    let value = attribute(node, name);
    value.strip_prefix('#').ok_or_else(|| fault(node, format!("{name}={value:?} is not a reference within the file")))
}

/// The numbers of an element's text, up to the first other word.
pub(super) fn floats<'a>(node: Node<'a>) -> impl Iterator<Item = f32> + 'a {
    node.text.split_ascii_whitespace().map_while(leading_f32)
}
