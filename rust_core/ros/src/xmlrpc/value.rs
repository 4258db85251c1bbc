//! Values and the documents that carry them.

use roxmltree::{Document, Node};
use std::fmt::Write as _;

/// How deep values may lie in each other; ROS needs four.
const MAX_DEPTH: usize = 64;

/// An XML-RPC value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `i4` or `int`.
    Int(i32),
    /// `boolean`.
    Bool(bool),
    /// `double`.
    Double(f64),
    /// `string`, `dateTime.iso8601`, or the text of `base64`, not decoded.
    String(String),
    /// `array`.
    Array(Vec<Value>),
    /// `struct`, members in document order.
    Struct(Vec<(String, Value)>),
}

impl Value {
    /// The text of a string.
    pub fn as_str(&self) -> Option<&str> {
        match self {
            Self::String(text) => Some(text),
            _ => None,
        }
    }

    /// The elements of an array.
    pub fn as_array(&self) -> Option<&[Value]> {
        match self {
            Self::Array(values) => Some(values),
            _ => None,
        }
    }

    /// The strings of an array of strings.
    pub fn as_strings(&self) -> Option<Vec<String>> {
        self.as_array()?.iter().map(|value| value.as_str().map(str::to_owned)).collect()
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::String(text.to_owned())
    }
}

/// A document that is no XML-RPC.
#[derive(Debug, thiserror::Error)]
pub enum XmlError {
    /// It is no XML.
    #[error("no XML: {0}")]
    Xml(#[from] roxmltree::Error),
    /// It is some other XML.
    #[error("no XML-RPC: {0}")]
    Structure(&'static str),
    /// It reports a failure of the other side.
    #[error("fault: {0}")]
    Fault(String),
}

/// The document of a call.
pub(super) fn call_document(method: &str, params: &[Value]) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?><methodCall><methodName>");
    escape(method, &mut out);
    out.push_str("</methodName><params>");
    for param in params {
        out.push_str("<param>");
        write_value(param, &mut out);
        out.push_str("</param>");
    }
    out.push_str("</params></methodCall>");
    out
}

/// The document of an answer.
pub fn response_document(value: &Value) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?><methodResponse><params><param>");
    write_value(value, &mut out);
    out.push_str("</param></params></methodResponse>");
    out
}

/// The method and the parameters of a call's document.
pub fn parse_call(text: &str) -> Result<(String, Vec<Value>), XmlError> {
    let document = Document::parse(text)?;
    let root = document.root_element();
    let method = child(root, "methodName").ok_or(XmlError::Structure("no methodName"))?;
    let params = match child(root, "params") {
        None => Vec::new(),
        Some(params) => elements(params)
            .map(|param| child(param, "value").ok_or(XmlError::Structure("no value")))
            .map(|value| read_value(value?, 0))
            .collect::<Result<_, _>>()?,
    };
    Ok((text_of(method).trim().to_owned(), params))
}

/// The value of an answer's document.
pub fn parse_response(text: &str) -> Result<Value, XmlError> {
    let document = Document::parse(text)?;
    let root = document.root_element();
    if let Some(fault) = child(root, "fault") {
        let value = child(fault, "value").ok_or(XmlError::Structure("no value"))?;
        return Err(XmlError::Fault(format!("{:?}", read_value(value, 0)?)));
    }
    let value = child(root, "params")
        .and_then(|params| child(params, "param"))
        .and_then(|param| child(param, "value"))
        .ok_or(XmlError::Structure("no value"))?;
    read_value(value, 0)
}

fn elements<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(Node::is_element)
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    elements(node).find(|child| child.has_tag_name(name))
}

fn text_of(node: Node<'_, '_>) -> String {
    node.children().filter_map(|part| part.text()).collect()
}

fn read_value(node: Node<'_, '_>, depth: usize) -> Result<Value, XmlError> {
    if depth > MAX_DEPTH {
        return Err(XmlError::Structure("values nested too deeply"));
    }
    let Some(typed) = elements(node).next() else {
        return Ok(Value::String(text_of(node)));
    };
    let text = text_of(typed);
    let trimmed = text.trim();
    Ok(match typed.tag_name().name() {
        "i4" | "int" => Value::Int(trimmed.parse().map_err(|_| XmlError::Structure("bad int"))?),
        "boolean" => Value::Bool(trimmed == "1" || trimmed == "true"),
        "double" => Value::Double(trimmed.parse().map_err(|_| XmlError::Structure("bad double"))?),
        "string" | "dateTime.iso8601" | "base64" => Value::String(text),
        "array" => {
            let data = child(typed, "data").ok_or(XmlError::Structure("array without data"))?;
            Value::Array(elements(data).map(|value| read_value(value, depth + 1)).collect::<Result<_, _>>()?)
        }
        "struct" => Value::Struct(
            elements(typed)
                .map(|member| {
                    let name = child(member, "name").ok_or(XmlError::Structure("member without name"))?;
                    let value = child(member, "value").ok_or(XmlError::Structure("member without value"))?;
                    Ok((text_of(name), read_value(value, depth + 1)?))
                })
                .collect::<Result<_, XmlError>>()?,
        ),
        _ => return Err(XmlError::Structure("unknown type")),
    })
}

fn write_value(value: &Value, out: &mut String) {
    out.push_str("<value>");
    // Writing to a String cannot fail.
    match value {
        Value::Int(number) => {
            let _ = write!(out, "<i4>{number}</i4>");
        }
        Value::Bool(truth) => {
            let _ = write!(out, "<boolean>{}</boolean>", u8::from(*truth));
        }
        Value::Double(number) => {
            let _ = write!(out, "<double>{number}</double>");
        }
        Value::String(text) => {
            out.push_str("<string>");
            escape(text, out);
            out.push_str("</string>");
        }
        Value::Array(values) => {
            out.push_str("<array><data>");
            for value in values {
                write_value(value, out);
            }
            out.push_str("</data></array>");
        }
        Value::Struct(members) => {
            out.push_str("<struct>");
            for (name, value) in members {
                out.push_str("<member><name>");
                escape(name, out);
                out.push_str("</name>");
                write_value(value, out);
                out.push_str("</member>");
            }
            out.push_str("</struct>");
        }
    }
    out.push_str("</value>");
}

fn escape(text: &str, out: &mut String) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            c => out.push(c),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_call_survives_its_document() {
        let params = [
            Value::from("/node <&>"),
            Value::Array(vec![Value::Int(-3), Value::Bool(true), Value::Double(0.25)]),
            Value::Struct(vec![("a".to_owned(), Value::Array(vec![]))]),
        ];
        let (method, read) = parse_call(&call_document("requestTopic", &params)).unwrap();
        assert_eq!(method, "requestTopic");
        assert_eq!(read, params);
    }

    #[test]
    fn text_without_a_type_is_a_string() {
        let text = "<methodResponse><params><param><value> a b</value></param></params></methodResponse>";
        assert_eq!(parse_response(text).unwrap(), Value::from(" a b"));
    }

    #[test]
    fn a_fault_is_an_error_with_its_words() {
        let text = "<methodResponse><fault><value><string>no</string></value></fault></methodResponse>";
        assert!(parse_response(text).unwrap_err().to_string().contains("no"));
    }

    #[test]
    fn deep_nesting_is_an_error() {
        let open = "<value><array><data>".repeat(200);
        let close = "</data></array></value>".repeat(200);
        let text = format!("<methodResponse><params><param>{open}{close}</param></params></methodResponse>");
        assert!(parse_response(&text).is_err());
    }

    proptest! {
        #[test]
        fn arbitrary_text_never_panics(text in "(<|>|/|value|array|data|params?|methodCall|int|5|&|;| ){0,60}") {
            let _ = parse_call(&text);
            let _ = parse_response(&text);
        }
    }
}
