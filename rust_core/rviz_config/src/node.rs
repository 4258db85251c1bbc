//! YAML text as a tree in which every value knows its line.
//!
//! The tree is built from parser events without recursion. What yaml-cpp gives rviz is reproduced: only the first
//! document counts, an unquoted `~`, `null` or nothing is no value, keys may repeat, an alias stands for the value
//! it names, `<<` is a key like any other.
//!
//! Aliases share their value. A few lines of them can describe a tree of astronomic size or depth, so each value
//! carries its height and its expanded size, and a text that passes [`MAX_DEPTH`] or [`MAX_VALUES`] is refused.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use saphyr_parser::{Event, Marker, Parser, ScalarStyle};

/// Deepest nesting that is read, as in yaml-cpp.
pub(crate) const MAX_DEPTH: usize = 500;

/// Most values of a text with its aliases expanded.
pub(crate) const MAX_VALUES: usize = 1_000_000;

/// A YAML value and where it begins.
#[derive(Debug)]
pub(crate) struct Node {
    /// Line of the value's first character, from 1.
    pub(crate) line: usize,
    /// Index of that character in the text.
    pub(crate) start: usize,
    pub(crate) content: Content,
    /// Levels of lists and maps from here down; 0 for a scalar.
    height: usize,
    /// Number of values from here down, aliases counted as often as they occur.
    size: usize,
}

/// The value of a [`Node`].
#[derive(Debug)]
pub(crate) enum Content {
    Null,
    Scalar(String),
    List(Vec<Rc<Node>>),
    Map(Vec<MapEntry>),
}

/// A key of a map with its value.
#[derive(Debug)]
pub(crate) struct MapEntry {
    pub(crate) key: String,
    /// Line of the key, from 1.
    pub(crate) line: usize,
    /// The key's characters in the text.
    pub(crate) place: Range<usize>,
    pub(crate) value: Rc<Node>,
}

/// Error of a text that is no usable YAML tree; line and column from 1.
#[derive(Debug)]
pub(crate) struct SyntaxError {
    pub(crate) line: usize,
    pub(crate) column: usize,
    pub(crate) reason: String,
}

impl Node {
    /// The value of a key without one.
    pub(crate) const NO_VALUE: Node = Node { line: 0, start: 0, content: Content::Null, height: 0, size: 1 };

    fn leaf(line: usize, start: usize, content: Content) -> Node {
        Node { line, start, content, height: 0, size: 1 }
    }

    /// The entry of `key` when this is a map that has it; of repeated keys the last.
    pub(crate) fn entry(&self, key: &str) -> Option<&MapEntry> {
        match &self.content {
            Content::Map(entries) => entries.iter().rev().find(|entry| entry.key == key),
            _ => None,
        }
    }

    /// The value under `key` when this is a map that has it.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        self.entry(key).map(|entry| &*entry.value)
    }

    /// The text of a scalar.
    pub(crate) fn scalar(&self) -> Option<&str> {
        match &self.content {
            Content::Scalar(text) => Some(text),
            _ => None,
        }
    }

    /// The items of a list; none of another value.
    pub(crate) fn items(&self) -> &[Rc<Node>] {
        match &self.content {
            Content::List(items) => items,
            _ => &[],
        }
    }

    /// The entries of a map; none of another value.
    pub(crate) fn entries(&self) -> &[MapEntry] {
        match &self.content {
            Content::Map(entries) => entries,
            _ => &[],
        }
    }
}

/// A list or map that is not complete yet.
struct Open {
    anchor: usize,
    node: Node,
    /// The key whose value comes next, in a map.
    key: Option<(String, usize, Range<usize>)>,
}

impl Open {
    fn add(&mut self, child: Rc<Node>, line: usize, place: Range<usize>) {
        self.node.height = self.node.height.max(child.height + 1);
        self.node.size = self.node.size.saturating_add(child.size);
        match &mut self.node.content {
            Content::List(items) => items.push(child),
            Content::Map(entries) => match self.key.take() {
                None => self.key = Some((key_text(&child), line, place)),
                Some((key, line, place)) => entries.push(MapEntry { key, line, place, value: child }),
            },
            Content::Null | Content::Scalar(_) => {}
        }
    }
}

/// A map's key as text. rviz reads no key that is a list or a map; the name is for the report.
fn key_text(key: &Node) -> String {
    match &key.content {
        Content::Scalar(text) => text.clone(),
        Content::Null => "null".to_owned(),
        Content::List(_) => "[a list as key]".to_owned(),
        Content::Map(_) => "{a map as key}".to_owned(),
    }
}

fn is_null(text: &str) -> bool {
    matches!(text, "" | "~" | "null" | "Null" | "NULL")
}

/// Number of lines, including the empty one after a last line break. A break is `\n`, `\r` or both.
fn count_lines(text: &str) -> usize {
    let breaks = text.matches(['\n', '\r']).count() - text.matches("\r\n").count();
    breaks + 1
}

/// The text with spaces for tabs between a key's colon and its value, where only yaml-cpp, with which rviz reads,
/// takes tabs.
fn spaces_after_colons(text: &str) -> Cow<'_, str> {
    if !text.contains(":\t") {
        return text.into();
    }
    let (mut quote, mut is_after_colon) = (None, false);
    let replace = |letter: char| {
        quote = match quote {
            None if matches!(letter, '"' | '\'') => Some(letter),
            Some(opened) if opened == letter || letter == '\n' => None,
            unchanged => unchanged,
        };
        is_after_colon = quote.is_none() && (letter == ':' || (is_after_colon && matches!(letter, ' ' | '\t')));
        let is_replaced = is_after_colon && letter == '\t';
        if is_replaced {
            ' '
        } else {
            letter
        }
    };
    text.chars().map(replace).collect::<String>().into()
}

fn error_at(at: Marker, reason: impl Into<String>) -> SyntaxError {
    SyntaxError { line: at.line(), column: at.col() + 1, reason: reason.into() }
}

/// The first document of `text`; an empty text is null.
pub(crate) fn parse(text: &str) -> Result<Rc<Node>, SyntaxError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // The parser ends a last line that has no break, and may place what follows from its end on the line after.
    let last_line = count_lines(text);
    let text = spaces_after_colons(text);
    let mut parser = Parser::new_from_str(&text);
    let mut open: Vec<Open> = Vec::new();
    let mut anchors: HashMap<usize, Rc<Node>> = HashMap::new();
    while let Some(event) = parser.next_event() {
        let (event, span) = event.map_err(|error| error_at(*error.marker(), error.info()))?;
        let at = span.start;
        let line = at.line().min(last_line);
        let leaf = |content| Node::leaf(line, at.index(), content);
        let (node, anchor) = match event {
            Event::Nothing | Event::StreamStart | Event::DocumentStart(_) => continue,
            Event::StreamEnd | Event::DocumentEnd => break,
            Event::SequenceStart(anchor, _) | Event::MappingStart(anchor, _) => {
                let is_list = matches!(event, Event::SequenceStart(..));
                let content = if is_list { Content::List(Vec::new()) } else { Content::Map(Vec::new()) };
                open.push(Open { anchor, node: leaf(content), key: None });
                check_depth(open.len(), at)?;
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some(closed) => (Rc::new(closed.node), closed.anchor),
                None => continue,
            },
            Event::Alias(anchor) => match anchors.get(&anchor) {
                Some(named) => (Rc::clone(named), 0),
                None => return Err(error_at(at, "an alias inside the value that it names")),
            },
            Event::Scalar(text, style, anchor, tag) => {
                let null = style == ScalarStyle::Plain && tag.is_none() && is_null(&text);
                let content = if null { Content::Null } else { Content::Scalar(text.into_owned()) };
                (Rc::new(leaf(content)), anchor)
            }
        };
        if anchor != 0 {
            anchors.insert(anchor, Rc::clone(&node));
        }
        check_depth(open.len() + node.height, at)?;
        let Some(parent) = open.last_mut() else {
            return Ok(node);
        };
        parent.add(node, line, at.index()..span.end.index());
        if parent.node.size > MAX_VALUES {
            return Err(error_at(at, format!("more than {MAX_VALUES} values")));
        }
    }
    Ok(Rc::new(Node::leaf(1, 0, Content::Null)))
}

fn check_depth(depth: usize, at: Marker) -> Result<(), SyntaxError> {
    if depth > MAX_DEPTH {
        return Err(error_at(at, format!("nested deeper than {MAX_DEPTH} levels")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar(node: &Node) -> Option<&str> {
        match &node.content {
            Content::Scalar(text) => Some(text),
            _ => None,
        }
    }

    #[test]
    fn every_value_and_key_knows_its_line() {
        let tree = parse("a: 1\nb:\n  - c: x\n    d:\n      y\n").unwrap();
        let Content::Map(entries) = &tree.content else {
            panic!("a map");
        };
        assert_eq!((entries[0].line, entries[1].line), (1, 2));
        let Content::List(items) = &entries[1].value.content else {
            panic!("a list");
        };
        assert_eq!(items[0].line, 3);
        let d = items[0].get("d").unwrap();
        assert_eq!((scalar(d), d.line), (Some("y"), 5));
    }

    #[test]
    fn only_plain_nothing_is_null() {
        let tree = parse("a: ~\nb:\nc: null\nd: ''\ne: 'null'\nf: !!str null\n").unwrap();
        for key in ["a", "b", "c"] {
            assert!(matches!(tree.get(key).unwrap().content, Content::Null));
        }
        assert_eq!(scalar(tree.get("d").unwrap()), Some(""));
        assert_eq!(scalar(tree.get("e").unwrap()), Some("null"));
        assert_eq!(scalar(tree.get("f").unwrap()), Some("null"));
    }

    #[test]
    fn an_alias_stands_for_the_value_it_names() {
        let tree = parse("a: &x {k: 1}\nb: *x\n").unwrap();
        assert_eq!(scalar(tree.get("b").unwrap().get("k").unwrap()), Some("1"));
    }

    #[test]
    fn aliases_that_multiply_or_contain_themselves_are_refused() {
        let mut text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n".to_owned();
        for level in 1..20 {
            let previous = format!("*a{},", level - 1).repeat(10);
            text += &format!("a{level}: &a{level} [{previous}]\n");
        }
        assert!(parse(&text).unwrap_err().reason.contains("values"));
        let own = parse("a: &x [1, *x]\n").unwrap_err();
        assert_eq!((own.line, own.reason.contains("alias")), (1, true));
    }

    #[test]
    fn deep_nesting_is_refused_with_its_line() {
        for text in ["[".repeat(200_000), "{a: ".repeat(200_000), "- ".repeat(200_000)] {
            assert_eq!(parse(&text).unwrap_err().line, 1);
        }
        let mut aliases = "a0: &a0 [x]\n".to_owned();
        for level in 1..2000 {
            aliases += &format!("a{level}: &a{level} [*a{}]\n", level - 1);
        }
        assert!(parse(&aliases).unwrap_err().reason.contains("nested"));
    }

    #[test]
    fn only_the_first_document_counts() {
        let tree = parse("--- {a: 1}\n--- {a: 2}\n").unwrap();
        assert_eq!(scalar(tree.get("a").unwrap()), Some("1"));
        assert!(matches!(parse("").unwrap().content, Content::Null));
    }
}
