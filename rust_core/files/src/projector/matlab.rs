//! Variables of a MATLAB script of a calibration toolbox: `fc = [ 1 2 ];`.

use serde_yaml_ng::{Mapping, Value};

/// Variables that are set to a number, or to numbers in brackets.
pub(super) fn variables(text: &str) -> Mapping {
    let code: Vec<&str> = text.lines().map(|line| line.split('%').next().unwrap_or_default()).collect();
    let code = code.join("\n");
    let mut variables = Mapping::new();
    let mut rest = code.as_str();
    while let Some((before, after)) = rest.split_once('=') {
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let name = before.trim_end();
        let name = &name[name.trim_end_matches(is_of_name).len()..];
        let after = after.trim_start();
        let (numbers, next) = match after.strip_prefix('[') {
            Some(list) => list.split_once(']').unwrap_or((list, "")),
            None => after.split_at(after.find([';', '\n']).unwrap_or(after.len())),
        };
        let words = numbers.split(|c: char| c.is_whitespace() || c == ',' || c == ';').filter(|word| !word.is_empty());
        let numbers: Option<Vec<Value>> = words.map(|word| word.parse::<f64>().ok().map(Value::from)).collect();
        if let Some(numbers) = numbers.filter(|numbers| !name.is_empty() && !numbers.is_empty()) {
            variables.insert(name.into(), numbers.into());
        }
        rest = next;
    }
    variables
}
