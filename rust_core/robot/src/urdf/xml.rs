//! XML elements with their lines.
//!
//! Namespaces are ignored, as in TinyXML, which urdfdom reads with: descriptions use prefixes (`sensor:camera`,
//! `xacro:macro`) that they declare nowhere.

use quick_xml::events::{BytesStart, Event};
use quick_xml::Reader;

use super::model::UrdfError;

/// Deeper nesting is refused; a description has six levels.
const MAX_DEPTH: usize = 100;

/// An element without its text.
#[derive(Clone, Debug, Default)]
pub(super) struct Element {
    pub(super) name: String,
    attributes: Vec<(String, String)>,
    children: Vec<Element>,
    /// Line, from 1.
    pub(super) line: usize,
}

impl Element {
    /// The value of an attribute.
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// Children of a name.
    pub(super) fn children<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// First child of a name.
    pub(super) fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }

    /// First child.
    pub(super) fn first_child(&self) -> Option<&Element> {
        self.children.first()
    }

    /// Name in errors, such as `link "base"`.
    pub(super) fn describe(&self) -> String {
        match self.attribute("name") {
            Some(name) => format!("{} \"{name}\"", self.name),
            None => self.name.clone(),
        }
    }
}

/// Finds the lines of increasing positions in a text.
struct LineCounter<'a> {
    text: &'a [u8],
    position: usize,
    line: usize,
}

impl LineCounter<'_> {
    fn at(&mut self, position: usize) -> usize {
        let passed = self.text.get(self.position..position).unwrap_or_default();
        self.line += passed.iter().filter(|byte| **byte == b'\n').count();
        self.position = self.position.max(position);
        self.line
    }
}

/// Parses the outermost elements of a text.
///
/// # Errors
/// For a text that is not well-formed.
pub(super) fn parse(text: &str) -> Result<Vec<Element>, UrdfError> {
    let mut reader = Reader::from_str(text);
    let mut lines = LineCounter { text: text.as_bytes(), position: 0, line: 1 };
    // The last is the innermost; the first stands for the document.
    let mut open = vec![Element::default()];
    loop {
        let line = lines.at(usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX));
        let event = reader.read_event().map_err(|error| {
            let position = usize::try_from(reader.error_position()).unwrap_or(usize::MAX);
            UrdfError::new(lines.at(position), "XML", error.to_string())
        })?;
        match event {
            Event::Start(start) => {
                if open.len() > MAX_DEPTH {
                    return Err(UrdfError::new(line, "XML", format!("nested deeper than {MAX_DEPTH} elements")));
                }
                open.push(element(&start, line));
            }
            Event::Empty(start) => add(&mut open, element(&start, line)),
            Event::End(_) => {
                if let Some(done) = open.pop() {
                    add(&mut open, done);
                }
            }
            Event::Eof => break,
            _ => {}
        }
    }
    match open.as_mut_slice() {
        [document] => Ok(std::mem::take(&mut document.children)),
        unclosed => {
            let last = unclosed.last().map_or((0, String::new()), |element| (element.line, element.describe()));
            Err(UrdfError::new(last.0, last.1, "it is not closed"))
        }
    }
}

fn add(open: &mut [Element], done: Element) {
    if let Some(parent) = open.last_mut() {
        parent.children.push(done);
    }
}

fn element(start: &BytesStart<'_>, line: usize) -> Element {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let name = text(start.name().as_ref());
    let mut given = start.attributes();
    given.with_checks(false);
    let attributes = given.flatten().map(|attribute| {
        let raw = text(&attribute.value);
        let value = quick_xml::escape::unescape(&raw).map(|value| value.into_owned()).unwrap_or(raw.clone());
        (text(attribute.key.as_ref()), value)
    });
    let attributes = attributes.collect();
    Element { name, attributes, children: Vec::new(), line }
}
