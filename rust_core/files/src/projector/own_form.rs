//! Values of other tools' files by this project's keys.

use serde_yaml_ng::{Mapping, Value};

use super::key_error::KeyError;

/// Keys of this project that these files may have.
const OWN: [&str; 5] = ["width", "height", "frame_id", "camera_info_topic", "frames"];

/// The values by this project's keys.
pub(super) fn own_form(
    given: &Mapping,
    tool: &str,
    k: Vec<f64>,
    d: Vec<f64>,
    size: Option<(Value, Value)>,
) -> Result<Mapping, KeyError> {
    let mut values = Mapping::new();
    if let Some((width, height)) = size {
        values.insert("width".into(), whole(&width));
        values.insert("height".into(), whole(&height));
    }
    values.extend(OWN.iter().filter_map(|key| Some(((*key).into(), whole(given.get(key)?)))));
    for key in ["width", "height"] {
        match values.get(key) {
            Some(size) if size.is_u64() => {}
            Some(_) => return Err((key, "it is no whole number of pixels".to_owned())),
            None => {
                let reason = "does not write the projector's size; add width and height in pixels";
                return Err((key, format!("missing: {tool} {reason}")));
            }
        }
    }
    if k.len() != 9 {
        return Err(("K", format!("the matrix of {tool} has {} numbers where 9 are needed", k.len())));
    }
    values.insert("K".into(), k.into());
    if !d.is_empty() {
        values.insert("D".into(), d.into());
    }
    Ok(values)
}

/// A size, which may have been written with a point.
fn whole(value: &Value) -> Value {
    match value.as_f64() {
        Some(number) if number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX) => {
            (number as u64).into()
        }
        _ => value.clone(),
    }
}

pub(super) fn whole_of(values: &Mapping, key: &str) -> Option<Value> {
    values.get(key).map(whole)
}

/// Numbers of an OpenCV matrix, or of a list of numbers or lists.
pub(super) fn numbers_of(values: &Mapping, key: &str) -> Option<Vec<f64>> {
    let mut numbers = Vec::new();
    add_numbers(values.get(key)?, 0, &mut numbers).then_some(numbers)
}

/// Collects the numbers of a value; `false` if anything else is in it.
fn add_numbers(value: &Value, depth: usize, numbers: &mut Vec<f64>) -> bool {
    match value {
        Value::Number(number) => number.as_f64().map(|number| numbers.push(number)).is_some(),
        Value::Sequence(list) => depth < 4 && list.iter().all(|item| add_numbers(item, depth + 1, numbers)),
        Value::Mapping(matrix) => {
            matrix.get("data").is_some_and(|data| depth < 4 && add_numbers(data, depth + 1, numbers))
        }
        Value::Tagged(tagged) => depth < 4 && add_numbers(&tagged.value, depth + 1, numbers),
        _ => false,
    }
}
