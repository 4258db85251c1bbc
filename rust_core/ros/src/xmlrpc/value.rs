//! Values, calls and answers as XML.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use roxmltree::{Document, Node, ParsingOptions};

/// Deepest nesting of values; ROS uses four levels.
const MAX_DEPTH: usize = 32;
/// Deepest nesting of elements: three for each value, such as value, array and data.
const MAX_ELEMENT_DEPTH: usize = 3 * (MAX_DEPTH + 1) + 6;
/// Most XML nodes of a message. A `getSystemState` of a thousand topics has some ten thousand.
const MAX_NODES: u32 = 2_000_000;

/// A value of a call or an answer, such as a parameter's. Displayed as YAML's flow style writes it.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `int`, `i4`, `i8`.
    Int(i32),
    /// `boolean`.
    Bool(bool),
    /// `double`.
    Double(f64),
    /// `string`.
    String(String),
    /// `array`.
    Array(Vec<Value>),
    /// `struct`.
    Struct(BTreeMap<String, Value>),
    /// `dateTime.iso8601` or `base64`, which are not used: the element's name and text.
    Other(&'static str, String),
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::String(text.to_owned())
    }
}

/// Scalars as values.
macro_rules! from_scalars {
    ($($scalar:ty: $variant:ident),+) => {
        $(impl From<$scalar> for Value {
            fn from(scalar: $scalar) -> Self {
                Self::$variant(scalar)
            }
        })+
    };
}
from_scalars!(String: String, bool: Bool, i32: Int, f64: Double);

impl Value {
    /// Text of a string.
    pub(crate) fn as_str(&self) -> Option<&str> {
        match self {
            Self::String(text) => Some(text),
            _ => None,
        }
    }

    /// The text of a string, a boolean, a number, or a list of these with commas between them.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Array(items) => Some(items.iter().map(Self::text).collect::<Option<Vec<_>>>()?.join(",")),
            Self::Struct(_) | Self::Other(..) => None,
            scalar => Some(scalar.to_string()),
        }
    }

    /// Items of an array.
    pub(crate) fn as_array(&self) -> Option<&[Value]> {
        match self {
            Self::Array(items) => Some(items),
            _ => None,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joined = |texts: Vec<String>| texts.join(", ");
        match self {
            Self::Int(value) => value.fmt(f),
            Self::Bool(value) => value.fmt(f),
            Self::Double(value) => value.fmt(f),
            Self::String(text) | Self::Other(_, text) => text.fmt(f),
            Self::Array(items) => write!(f, "[{}]", joined(items.iter().map(Self::to_string).collect())),
            Self::Struct(members) => {
                let member = |(name, value): (&String, &Self)| format!("{name}: {value}");
                write!(f, "{{{}}}", joined(members.iter().map(member).collect()))
            }
        }
    }
}

/// A text is not an XML-RPC message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum XmlError {
    #[error("not XML: {0}")]
    Xml(String),
    #[error("<{0}> is missing")]
    Missing(&'static str),
    #[error("'{0}' is no value of its type")]
    Value(String),
    #[error("values nested more than {MAX_DEPTH} deep")]
    TooDeep,
    /// The answer is a fault.
    #[error("fault {code}: {text}")]
    Fault { code: i32, text: String },
}

/// `true` if elements are nested too deep. Checked before parsing, because a tree is many times as large as the text.
fn is_too_deep(text: &str) -> bool {
    let mut depth = 0_usize;
    // Text after each '<'. One in a comment would count as an element without end, but no client of ROS sends any.
    text.split('<').skip(1).any(|tag| {
        match tag.as_bytes().first() {
            Some(b'/') => depth = depth.saturating_sub(1),
            Some(b'!' | b'?') | None => {}
            Some(_) if tag.split('>').next().is_some_and(|inside| inside.ends_with('/')) => {}
            Some(_) => depth += 1,
        }
        depth > MAX_ELEMENT_DEPTH
    })
}

fn document(text: &str) -> Result<Document<'_>, XmlError> {
    if is_too_deep(text) {
        return Err(XmlError::TooDeep);
    }
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| XmlError::Xml(error.to_string()))
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> Result<Node<'a, 'i>, XmlError> {
    node.children().find(|child| child.has_tag_name(name)).ok_or(XmlError::Missing(name))
}

fn text_of(node: Node<'_, '_>) -> String {
    node.children().filter_map(|child| child.text()).collect()
}

fn value(node: Node<'_, '_>, depth: usize) -> Result<Value, XmlError> {
    if depth > MAX_DEPTH {
        return Err(XmlError::TooDeep);
    }
    // Text without an element is a string.
    let Some(typed) = node.children().find(Node::is_element) else { return Ok(Value::String(text_of(node))) };
    let text = text_of(typed);
    let wrong = || XmlError::Value(text.chars().take(40).collect());
    Ok(match typed.tag_name().name() {
        "int" | "i4" | "i8" => Value::Int(text.trim().parse().map_err(|_| wrong())?),
        "boolean" => match text.trim() {
            "1" | "true" => Value::Bool(true),
            "0" | "false" => Value::Bool(false),
            _ => return Err(wrong()),
        },
        "double" => Value::Double(text.trim().parse().map_err(|_| wrong())?),
        "string" => Value::String(text),
        "dateTime.iso8601" => Value::Other("dateTime.iso8601", text),
        "base64" => Value::Other("base64", text),
        "nil" => Value::String(String::new()),
        "array" => {
            let items = child(typed, "data")?.children().filter(|item| item.has_tag_name("value"));
            Value::Array(items.map(|item| value(item, depth + 1)).collect::<Result<_, _>>()?)
        }
        "struct" => {
            let member = |member: Node<'_, '_>| {
                Ok((text_of(child(member, "name")?), value(child(member, "value")?, depth + 1)?))
            };
            let members = typed.children().filter(|member| member.has_tag_name("member"));
            Value::Struct(members.map(member).collect::<Result<_, XmlError>>()?)
        }
        other => return Err(XmlError::Value(format!("<{other}>"))),
    })
}

fn params(node: Node<'_, '_>) -> Result<Vec<Value>, XmlError> {
    let Some(params) = node.children().find(|child| child.has_tag_name("params")) else { return Ok(Vec::new()) };
    let params = params.children().filter(|param| param.has_tag_name("param"));
    params.map(|param| value(child(param, "value")?, 0)).collect()
}

/// Parses a call: the method's name and its parameters.
///
/// # Errors
/// [`XmlError`].
pub(crate) fn parse_call(text: &str) -> Result<(String, Vec<Value>), XmlError> {
    let document = document(text)?;
    let call = document.root_element();
    if !call.has_tag_name("methodCall") {
        return Err(XmlError::Missing("methodCall"));
    }
    Ok((text_of(child(call, "methodName")?).trim().to_owned(), params(call)?))
}

/// Parses the value of an answer.
///
/// # Errors
/// [`XmlError`], for a fault as well.
pub(crate) fn parse_response(text: &str) -> Result<Value, XmlError> {
    let document = document(text)?;
    let answer = document.root_element();
    if !answer.has_tag_name("methodResponse") {
        return Err(XmlError::Missing("methodResponse"));
    }
    if let Ok(fault) = child(answer, "fault") {
        let Value::Struct(members) = value(child(fault, "value")?, 0)? else { return Err(XmlError::Missing("struct")) };
        let code = match members.get("faultCode") {
            Some(Value::Int(code)) => *code,
            _ => 0,
        };
        let text = members.get("faultString").and_then(Value::as_str).unwrap_or_default().to_owned();
        return Err(XmlError::Fault { code, text });
    }
    params(answer)?.into_iter().next().ok_or(XmlError::Missing("param"))
}

fn write_text(out: &mut String, text: &str) {
    for character in text.chars() {
        match character {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            // A parser would read it as a line feed.
            '\r' => out.push_str("&#13;"),
            // XML 1.0 cannot express other control characters.
            '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            other => out.push(other),
        }
    }
}

fn write_value(out: &mut String, value: &Value) {
    out.push_str("<value>");
    // Writing to a String cannot fail.
    let _ = match value {
        Value::Int(number) => write!(out, "<i4>{number}</i4>"),
        Value::Bool(yes) => write!(out, "<boolean>{}</boolean>", u8::from(*yes)),
        Value::Double(number) => write!(out, "<double>{number}</double>"),
        _ => Ok(()),
    };
    match value {
        Value::String(text) => {
            out.push_str("<string>");
            write_text(out, text);
            out.push_str("</string>");
        }
        Value::Other(name, text) => {
            let _ = write!(out, "<{name}>");
            write_text(out, text);
            let _ = write!(out, "</{name}>");
        }
        Value::Array(items) => {
            out.push_str("<array><data>");
            items.iter().for_each(|item| write_value(out, item));
            out.push_str("</data></array>");
        }
        Value::Struct(members) => {
            out.push_str("<struct>");
            for (name, member) in members {
                out.push_str("<member><name>");
                write_text(out, name);
                out.push_str("</name>");
                write_value(out, member);
                out.push_str("</member>");
            }
            out.push_str("</struct>");
        }
        Value::Int(_) | Value::Bool(_) | Value::Double(_) => {}
    }
    out.push_str("</value>");
}

/// A call as XML.
pub(crate) fn request(method: &str, params: &[Value]) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?>\n<methodCall><methodName>");
    write_text(&mut out, method);
    out.push_str("</methodName><params>");
    for param in params {
        out.push_str("<param>");
        write_value(&mut out, param);
        out.push_str("</param>");
    }
    out.push_str("</params></methodCall>\n");
    out
}

/// An answer as XML.
pub(crate) fn response(value: &Value) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?>\n<methodResponse><params><param>");
    write_value(&mut out, value);
    out.push_str("</param></params></methodResponse>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn values() -> impl Strategy<Value = Value> {
        let text = "[ -~\\r\\n\\té😀]{0,12}";
        let leaf = prop_oneof![
            any::<i32>().prop_map(Value::Int),
            any::<bool>().prop_map(Value::Bool),
            (-1e9..1e9_f64).prop_map(Value::Double),
            text.prop_map(Value::String),
        ];
        leaf.prop_recursive(4, 32, 5, move |inner| {
            prop_oneof![
                prop::collection::vec(inner.clone(), 0..5).prop_map(Value::Array),
                prop::collection::btree_map("[a-z<&]{1,6}", inner, 0..5).prop_map(Value::Struct),
            ]
        })
    }

    proptest! {
        #[test]
        fn what_was_written_reads_the_same(method in "[a-zA-Z.]{1,20}", params in prop::collection::vec(values(), 0..4)) {
            prop_assert_eq!(parse_call(&request(&method, &params)), Ok((method, params.clone())));
            for value in params {
                prop_assert_eq!(parse_response(&response(&value)), Ok(value));
            }
        }

        #[test]
        fn any_text_is_read_or_refused(text in "(<[/a-z?!]{0,12}>|[ -~]){0,40}") {
            let _ = parse_call(&text);
            let _ = parse_response(&text);
        }
    }

    #[test]
    fn untyped_text_is_a_string_and_a_fault_is_an_error() {
        let answer = |inner: &str| parse_response(&format!("<methodResponse>{inner}</methodResponse>"));
        assert_eq!(answer("<params><param><value>x &amp; y</value></param></params>"), Ok("x & y".into()));
        let fault = "<fault><value><struct><member><name>faultCode</name><value><int>4</int></value></member>\
                     <member><name>faultString</name><value><string>no</string></value></member></struct></value></fault>";
        assert_eq!(answer(fault), Err(XmlError::Fault { code: 4, text: "no".to_owned() }));
        assert_eq!(answer(""), Err(XmlError::Missing("param")));
    }

    #[test]
    fn deep_nesting_is_refused() {
        let deep = |levels: usize| {
            let open = "<value><array><data>".repeat(levels);
            let close = "</data></array></value>".repeat(levels);
            parse_response(&format!(
                "<methodResponse><params><param>{open}<value>x</value>{close}</param></params></methodResponse>"
            ))
        };
        assert!(deep(MAX_DEPTH).is_ok());
        assert_eq!(deep(MAX_DEPTH + 1), Err(XmlError::TooDeep));
        assert_eq!(parse_response(&"<value>".repeat(100_000)), Err(XmlError::TooDeep), "before a tree is made of it");
    }
}
