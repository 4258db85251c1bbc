//! OpenCV's XML (`cv::FileStorage`) as the values of its YAML.
//!
//! A matrix is an element with `rows`, `cols`, `dt` and `data`; numbers of a list are separated by spaces, other values
//! are in elements `_`, texts in quotes.

use rcs_text::xml::{self, Element};
use serde_yaml_ng::{Mapping, Value};

/// Name of the root element.
const ROOT: &str = "opencv_storage";
/// Deepest nesting of values.
const DEEPEST: usize = 8;

/// Values of a file by name.
///
/// # Errors
/// Not XML, or another kind of XML.
pub(super) fn values(text: &str) -> Result<Mapping, String> {
    let document = xml::parse(text).map_err(|error| format!("it is not XML as OpenCV writes it: {error}"))?;
    let root = document.elements.first().ok_or("it is not XML as OpenCV writes it: no element in it")?;
    match root.name {
        ROOT => Ok(children(root, 0)),
        "ProjectorCameraEnsemble" => Err("it seems to be a calibration of the RoomAlive Toolkit, which is not read: \
                                          write its projector's size, K and D into a projector file"
            .to_owned()),
        other => Err(format!("it is XML, but <{other}> where OpenCV writes <{ROOT}>")),
    }
}

fn children(element: &Element<'_>, depth: usize) -> Mapping {
    element.elements.iter().map(|child| (child.name.into(), value(child, depth + 1))).collect()
}

fn value(element: &Element<'_>, depth: usize) -> Value {
    match element.elements.first() {
        Some(_) if depth >= DEEPEST => Value::Null,
        Some(first) if first.name == "_" => element.elements.iter().map(|item| value(item, depth + 1)).collect(),
        Some(_) => children(element, depth).into(),
        None => text_value(element.text.trim()),
    }
}

/// A number, a list of numbers, or a text.
fn text_value(text: &str) -> Value {
    let numbers: Option<Vec<Value>> = text.split_ascii_whitespace().map(number).collect();
    match numbers {
        Some(numbers) => match <[Value; 1]>::try_from(numbers) {
            Ok([number]) => number,
            Err(numbers) => numbers.into(),
        },
        None => text.trim_matches('"').into(),
    }
}

/// A number as OpenCV writes it: `5.`, `.Nan`, whole ones without a point.
fn number(word: &str) -> Option<Value> {
    match word {
        ".Nan" => Some(f64::NAN.into()),
        ".Inf" => Some(f64::INFINITY.into()),
        "-.Inf" => Some(f64::NEG_INFINITY.into()),
        _ => word.parse::<i64>().map(Value::from).or_else(|_| word.parse::<f64>().map(Value::from)).ok(),
    }
}
