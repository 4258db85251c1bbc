//! YAML text as a tree in which every value knows its bytes, for edits that leave all others as they are.

use std::ops::Range;

use saphyr_parser::{Event, Parser};

/// A YAML value.
#[derive(Debug)]
pub(crate) struct Node {
    /// Bytes of a scalar in the text, quotes included; space and a comment behind it may be among them. Of another
    /// value only the first byte counts.
    pub(crate) bytes: Range<usize>,
    /// Column of its first character, from 0.
    pub(crate) column: usize,
    pub(crate) content: Content,
}

/// Content of a [`Node`].
#[derive(Debug)]
pub(crate) enum Content {
    Scalar(String),
    List(Vec<Node>),
    /// Keys and values in turn.
    Map(Vec<Node>),
    Alias,
}

impl Node {
    /// The text of a scalar.
    pub(crate) fn scalar(&self) -> Option<&str> {
        match &self.content {
            Content::Scalar(text) => Some(text),
            _ => None,
        }
    }

    /// The items of a list; none of another value.
    pub(crate) fn items(&self) -> &[Node] {
        match &self.content {
            Content::List(items) => items,
            _ => &[],
        }
    }

    /// A key of a map and its value.
    pub(crate) fn entry(&self, key: &str) -> Option<(&Node, &Node)> {
        let Content::Map(entries) = &self.content else { return None };
        entries.chunks_exact(2).find_map(|entry| match entry {
            [name, value] if name.scalar() == Some(key) => Some((name, value)),
            _ => None,
        })
    }

    /// The value under a key of a map.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        self.entry(key).map(|(_, value)| value)
    }
}

/// The first document of a text that was read before; `None` if it is empty or invalid.
pub(crate) fn first_document(text: &str) -> Option<Node> {
    let starts: Vec<usize> = text.char_indices().map(|(start, _)| start).collect();
    // The parser counts characters.
    let byte = |character: usize| starts.get(character).copied().unwrap_or(text.len());
    let mut open: Vec<Node> = Vec::new();
    for event in Parser::new_from_str(text) {
        let (event, span) = event.ok()?;
        let (bytes, column) = (byte(span.start.index())..byte(span.end.index()), span.start.col());
        let complete = match event {
            Event::Scalar(text, ..) => Node { bytes, column, content: Content::Scalar(text.into_owned()) },
            Event::Alias(_) => Node { bytes, column, content: Content::Alias },
            Event::SequenceStart(..) => {
                open.push(Node { bytes, column, content: Content::List(Vec::new()) });
                continue;
            }
            Event::MappingStart(..) => {
                open.push(Node { bytes, column, content: Content::Map(Vec::new()) });
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => open.pop()?,
            _ => continue,
        };
        match open.last_mut().map(|parent| &mut parent.content) {
            Some(Content::List(children) | Content::Map(children)) => children.push(complete),
            _ => return Some(complete),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_value_knows_its_bytes() {
        let text = "# größer\na: {b: [1, 'é 2' ], c: 4} # ü\n---\nd: 3\n";
        let root = first_document(text).unwrap();
        let map = root.get("a").unwrap();
        assert!(text[map.bytes.start..].starts_with("{b: "));
        let list = map.get("b").unwrap();
        assert!(text[list.bytes.start..].starts_with("[1, "));
        let items: Vec<_> = list.items().iter().map(|item| text[item.bytes.clone()].trim_end()).collect();
        assert_eq!(items, ["1", "'é 2'"]);
        assert_eq!(list.items()[1].scalar(), Some("é 2"));
        let (key, _) = map.entry("c").unwrap();
        assert_eq!((&text[key.bytes.clone()], key.column), ("c", 20));
        assert!(root.get("d").is_none(), "of the second document");
        assert!(first_document("").is_none() && first_document("a: [").is_none());
    }
}
