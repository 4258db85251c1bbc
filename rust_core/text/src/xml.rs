//! XML as TinyXML and pugixml read it: names with their prefixes, without namespaces, entities of document types and
//! most rules of well-formedness.
//!
//! What ends before its elements do, or closes another element than the last, is an error, as for both. Other faults
//! are passed over and noted.

use std::borrow::Cow;

use quick_xml::escape::{resolve_xml_entity, unescape};
use quick_xml::events::attributes::{AttrError, Attributes};
use quick_xml::events::{BytesRef, Event};
use quick_xml::Reader;

/// Deeper nesting is refused.
const MAX_DEPTH: usize = 256;
/// Most elements, which take far more memory than their text.
const MAX_ELEMENTS: usize = 2_000_000;
/// A fault that is passed over.
const RAW_AMPERSAND: &str = "a '&' that begins no known entity";

/// Text that is no XML.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}")]
pub struct XmlError {
    /// Line, from 1.
    pub line: usize,
    /// Description.
    pub what: String,
}

/// A fault that was passed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}")]
pub struct PassedOver {
    /// Line of its first occurrence, from 1.
    pub line: usize,
    /// Description, such as `an attribute given twice`.
    pub what: &'static str,
}

/// A parsed text.
#[derive(Debug, Default)]
pub struct Document<'t> {
    /// The outermost elements; a well-formed text has one.
    pub elements: Vec<Element<'t>>,
    /// Faults, each kind once.
    pub passed_over: Vec<PassedOver>,
}

/// An element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Element<'t> {
    /// Name, with its prefix.
    pub name: &'t str,
    attributes: Vec<(&'t str, Cow<'t, str>)>,
    /// Elements within, in their order.
    pub elements: Vec<Element<'t>>,
    /// Text between the elements within, as one piece.
    pub text: Cow<'t, str>,
    /// Line, from 1.
    pub line: usize,
}

impl<'t> Element<'t> {
    /// The value of an attribute; the first one of that name.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| *key == name).map(|(_, value)| &**value)
    }

    /// The elements within of a name, with its prefix.
    pub fn children<'a>(&'a self, name: &'a str) -> impl DoubleEndedIterator<Item = &'a Self> {
        self.elements.iter().filter(move |child| child.name == name)
    }

    /// The first element within of a name.
    pub fn child<'a>(&'a self, name: &'a str) -> Option<&'a Self> {
        self.children(name).next()
    }

    /// This element and all within, in the order of their beginnings.
    pub fn descendants(&self) -> impl Iterator<Item = &Self> {
        let mut next = vec![self];
        std::iter::from_fn(move || {
            let element = next.pop()?;
            next.extend(element.elements.iter().rev());
            Some(element)
        })
    }
}

/// Parses a text, such as [`decode`](crate::decode) returns.
///
/// ```
/// let document = rcs_text::xml::parse("<a b=c>x & y</a>")?;
/// assert_eq!((document.elements[0].attribute("b"), &*document.elements[0].text), (Some("c"), "x & y"));
/// assert_eq!(document.passed_over.len(), 2);
/// # Ok::<(), rcs_text::xml::XmlError>(())
/// ```
///
/// # Errors
/// Elements that are not closed, or closed by another name; nesting that is too deep; too many elements.
pub fn parse(text: &str) -> Result<Document<'_>, XmlError> {
    // The reader does not count a mark.
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = Reader::from_str(text);
    reader.config_mut().allow_dangling_amp = true;
    let open = vec![Element::default()];
    let mut parser = Parser { text, line: 1, counted: 0, elements: 0, open, passed_over: Vec::new() };
    loop {
        let begin = position(reader.buffer_position());
        parser.count_lines(begin);
        let event = match reader.read_event() {
            Ok(event) => event,
            // Nothing is read after the outermost element.
            Err(_) if parser.is_done() => {
                parser.pass_over("text after the last element");
                break;
            }
            Err(error) => {
                parser.count_lines(position(reader.error_position()));
                return Err(parser.error(error.to_string()));
            }
        };
        let raw = text.get(begin..position(reader.buffer_position())).unwrap_or_default();
        if matches!(event, Event::Eof) {
            break;
        }
        parser.take(event, raw)?;
    }
    parser.finish()
}

fn position(bytes: u64) -> usize {
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

struct Parser<'t> {
    text: &'t str,
    /// Line of the position up to which lines are counted.
    line: usize,
    counted: usize,
    /// Number of elements.
    elements: usize,
    /// The last is the innermost; the first stands for the document.
    open: Vec<Element<'t>>,
    passed_over: Vec<PassedOver>,
}

impl<'t> Parser<'t> {
    fn count_lines(&mut self, position: usize) {
        let passed = self.text.as_bytes().get(self.counted..position).unwrap_or_default();
        self.line += passed.iter().filter(|byte| **byte == b'\n').count();
        self.counted = self.counted.max(position);
    }

    fn error(&self, what: impl Into<String>) -> XmlError {
        XmlError { line: self.line, what: what.into() }
    }

    fn pass_over(&mut self, what: &'static str) {
        if self.passed_over.iter().all(|known| known.what != what) {
            self.passed_over.push(PassedOver { line: self.line, what });
        }
    }

    fn take(&mut self, event: Event<'_>, raw: &'t str) -> Result<(), XmlError> {
        match event {
            Event::Start(_) if self.open.len() > MAX_DEPTH => {
                return Err(self.error(format!("nested deeper than {MAX_DEPTH} elements")));
            }
            Event::Start(_) => {
                let element = self.element(raw)?;
                self.open.push(element);
            }
            Event::Empty(_) => {
                let element = self.element(raw)?;
                self.add(element);
            }
            Event::End(_) => {
                if let Some(done) = self.open.pop() {
                    self.add(done);
                }
            }
            Event::Text(_) => self.add_text(raw),
            Event::CData(_) => {
                let inner = raw.strip_prefix("<![CDATA[").and_then(|raw| raw.strip_suffix("]]>"));
                self.append(inner.unwrap_or_default().into());
            }
            Event::GeneralRef(entity) => self.add_entity(&entity, raw),
            Event::Comment(_) if raw.trim_matches(['<', '!', '>', '-']).contains("--") => {
                self.pass_over("'--' in a comment");
            }
            _ => {}
        }
        Ok(())
    }

    /// `true` after the end of an outermost element.
    fn is_done(&self) -> bool {
        matches!(self.open.as_slice(), [document] if !document.elements.is_empty())
    }

    fn add(&mut self, done: Element<'t>) {
        if let Some(parent) = self.open.last_mut() {
            parent.elements.push(done);
        }
    }

    fn append(&mut self, text: Cow<'t, str>) {
        match self.open.last_mut() {
            Some(element) if element.text.is_empty() => element.text = text,
            Some(element) => element.text.to_mut().push_str(&text),
            None => {}
        }
    }

    fn add_text(&mut self, text: &'t str) {
        if text.contains('&') {
            self.pass_over(RAW_AMPERSAND);
        }
        self.note_controls(text);
        self.append(text.into());
    }

    fn note_controls(&mut self, text: &str) {
        if text.bytes().any(|byte| byte < b' ' && !byte.is_ascii_whitespace()) {
            self.pass_over("a control character");
        }
    }

    /// Text for an entity: one of XML's own, a character's number, or what is written.
    fn add_entity(&mut self, entity: &BytesRef<'_>, raw: &'t str) {
        let named = std::str::from_utf8(entity).ok().and_then(resolve_xml_entity).map(Cow::Borrowed);
        let numbered = || entity.resolve_char_ref().ok().flatten().map(|letter| letter.to_string().into());
        let text = named.or_else(numbered).unwrap_or_else(|| {
            self.pass_over(RAW_AMPERSAND);
            raw.into()
        });
        self.append(text);
    }

    /// The element of a tag.
    fn element(&mut self, tag: &'t str) -> Result<Element<'t>, XmlError> {
        self.elements += 1;
        if self.elements > MAX_ELEMENTS {
            return Err(self.error(format!("more than {MAX_ELEMENTS} elements")));
        }
        let tag = tag.trim_start_matches('<').trim_end_matches('>').trim_end_matches('/');
        let name_len = tag.find(|c: char| c.is_ascii_whitespace()).unwrap_or(tag.len());
        let (name, line) = (&tag[..name_len], self.line);
        let collect = |mut given: Attributes<'t>| given.with_checks(false).collect::<Result<Vec<_>, AttrError>>();
        let given = collect(Attributes::new(tag, name_len)).or_else(|_| {
            self.pass_over("an attribute without quotes");
            collect(Attributes::html(tag, name_len)).map_err(|error| self.error(format!("<{name}>: {error}")))
        })?;
        let mut attributes: Vec<(&'t str, Cow<'t, str>)> = Vec::with_capacity(given.len());
        for attribute in given {
            let value = match attribute.value {
                Cow::Borrowed(value) => std::str::from_utf8(value).unwrap_or_default(),
                // Only a value that has another end of line than this.
                Cow::Owned(_) => "",
            };
            let key = std::str::from_utf8(attribute.key.0).unwrap_or_default();
            if attributes.iter().any(|(known, _)| *known == key) {
                self.pass_over("an attribute given twice");
            }
            self.note_controls(value);
            attributes.push((key, self.unescaped(value)));
        }
        Ok(Element { name, attributes, line, ..Element::default() })
    }

    /// A value with its entities replaced, except unknown ones.
    fn unescaped(&mut self, mut rest: &'t str) -> Cow<'t, str> {
        let mut replaced = String::new();
        while let Some(at) = rest.find('&') {
            let (before, from) = rest.split_at(at);
            let entity = from.find(';').map(|end| &from[..=end]).filter(|entity| entity.rfind('&') == Some(0));
            let text = entity.and_then(|entity| Some((unescape(entity).ok()?, entity.len())));
            let (text, len) = text.unwrap_or_else(|| {
                self.pass_over(RAW_AMPERSAND);
                ("&".into(), 1)
            });
            replaced.push_str(before);
            replaced.push_str(&text);
            rest = &from[len..];
        }
        if replaced.is_empty() {
            rest.into()
        } else {
            (replaced + rest).into()
        }
    }

    fn finish(mut self) -> Result<Document<'t>, XmlError> {
        match self.open.as_mut_slice() {
            [document] => {
                Ok(Document { elements: std::mem::take(&mut document.elements), passed_over: self.passed_over })
            }
            unclosed => {
                let last = unclosed.last().map_or((0, ""), |element| (element.line, element.name));
                Err(XmlError { line: last.0, what: format!("<{}> is not closed", last.1) })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn passed_over(text: &str) -> Vec<(usize, &'static str)> {
        parse(text).unwrap().passed_over.iter().map(|fault| (fault.line, fault.what)).collect()
    }

    #[test]
    fn well_formed_text_becomes_a_tree() {
        let text =
            "\u{feff}\n<?xml version=\"1.0\"?><!DOCTYPE a><!-- a - b -->\n<a b='1' q:c=\"&lt;&#65;&amp;\">x<q:d/>y\n\
                    <e>z<!-- -->&gt;<![CDATA[<&]]></e></a>\n";
        let document = parse(text).unwrap();
        let [root] = document.elements.as_slice() else { panic!("{document:?}") };
        assert_eq!((root.name, root.line, &*root.text), ("a", 3, "xy\n"));
        assert_eq!(["b", "q:c", "c"].map(|name| root.attribute(name)), [Some("1"), Some("<A&"), None]);
        let names: Vec<_> = root.descendants().map(|element| (element.name, element.line)).collect();
        assert_eq!(names, [("a", 3), ("q:d", 3), ("e", 4)]);
        assert_eq!((root.child("d"), &*root.child("e").unwrap().text), (None, "z><&"));
        assert_eq!(document.passed_over, []);
    }

    #[test]
    fn what_tinyxml_and_pugixml_pass_over_is_noted_with_its_line() {
        for (text, expected) in [
            ("<a>\nx & y &amp; z</a>", (2, RAW_AMPERSAND)),
            ("<a>&nbsp;</a>", (1, RAW_AMPERSAND)),
            ("<a\nb=\"x & y\"/>", (1, RAW_AMPERSAND)),
            ("<a b=c/>", (1, "an attribute without quotes")),
            ("<a b='1' b='2'/>", (1, "an attribute given twice")),
            ("<!-- x -- y --><a/>", (1, "'--' in a comment")),
            ("<a>\u{1}</a>", (1, "a control character")),
            ("<a/>\n\0", (1, "a control character")),
            ("<a/>\n</b>", (2, "text after the last element")),
            ("<a/>\n<!-- ", (2, "text after the last element")),
        ] {
            assert_eq!(passed_over(text), [expected], "{text}");
        }
        for fine in ["<a b=\"<X>\"/>", "<a b = '1'/>", "<a b='1'c='2'/>", "<a/>\n x \n", "\n\n<a>]]></a>"] {
            assert_eq!(passed_over(fine), [], "{fine}");
        }
        let document = parse("<a b='1' b='2' c='&nbsp;&amp;&'>&nbsp; & &lt;</a>").unwrap();
        let [root] = document.elements.as_slice() else { panic!("{document:?}") };
        assert_eq!((root.attribute("b"), root.attribute("c")), (Some("1"), Some("&nbsp;&&")));
        assert_eq!(root.text, "&nbsp; & <");
    }

    #[test]
    fn what_both_refuse_is_an_error_with_its_line() {
        for (text, line, what) in [
            ("\n<a>", 2, "<a> is not closed"),
            ("<a>\n<!-- </a>", 2, "comment"),
            ("<a>\n</b>", 2, "`</b>`"),
            ("<a>\n<b></a>", 2, "`</a>`"),
            ("<a><![CDATA[</a>", 1, "CDATA"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.line == line && error.what.contains(what), "{text}: {error}");
        }
        assert!(parse(&"<a>".repeat(MAX_DEPTH + 1)).unwrap_err().what.contains("nested deeper"));
        assert!(parse("").unwrap().elements.is_empty() && parse("rubbish").unwrap().elements.is_empty());
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "[<>/&;#x!\\-a='\"? \n\\[\\]CDATA]{0,60}") {
            let _is_read = parse(&text).is_ok();
        }
    }
}
