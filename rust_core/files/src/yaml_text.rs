//! Formatting of numbers and texts in YAML files, for YAML 1.1 and 1.2.

use std::fmt::Write as _;

/// Formats a number exactly, with a point before and a sign in its exponent.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:?}");
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{mantissa}{point}e{sign}{exponent}")
}

/// Quotes a text, with escapes for all but letters, digits and visible ASCII characters.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = "\"".to_owned();
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            _ if character == ' ' || character.is_ascii_graphic() || character.is_alphanumeric() => {
                quoted.push(character);
            }
            _ => {
                // Writing to a String cannot fail.
                let _ = write!(quoted, "\\U{:08x}", u32::from(character));
            }
        }
    }
    quoted + "\""
}

/// Replaces control characters by spaces.
pub(crate) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// The beginning of a text of any length, in a line.
pub(crate) fn beginning(text: &str) -> String {
    const MOST: usize = 60;
    let (text, mut rest) = (one_line(text), text.chars().skip(MOST));
    text.chars().take(MOST).chain(rest.next().map(|_| '…')).collect()
}

/// Shortens a YAML error, which may repeat a text as long as the file, to a line.
pub(crate) fn brief(error: &serde_yaml_ng::Error) -> String {
    const BEGIN: usize = 160;
    const END: usize = 60;
    let text: Vec<char> = one_line(&error.to_string()).chars().collect();
    if text.len() <= BEGIN + END {
        return text.into_iter().collect();
    }
    // The end names line and column.
    let (begin, end) = (&text[..BEGIN], &text[text.len() - END..]);
    begin.iter().chain(&[' ', '…', ' ']).chain(end).collect()
}

/// Formats a number exactly, infinities and NaN included.
pub(crate) fn exact(value: f64) -> String {
    if value.is_nan() {
        ".nan".to_owned()
    } else if value.is_infinite() {
        if value > 0.0 { ".inf" } else { "-.inf" }.to_owned()
    } else {
        number(value)
    }
}

/// Formats a number with six significant digits.
pub(crate) fn figure(value: f64) -> String {
    exact(format!("{value:.5e}").parse().unwrap_or(value))
}

/// Formats a list of numbers with six significant digits.
pub(crate) fn figures(values: &[f64]) -> String {
    list(values, figure)
}

/// Formats a list of numbers.
pub(crate) fn list(values: &[f64], text: impl Fn(f64) -> String) -> String {
    let texts: Vec<String> = values.iter().map(|value| text(*value)).collect();
    format!("[{}]", texts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_with_yaml_fits_into_a_line() {
        let error = |text: &str| serde_yaml_ng::from_str::<u32>(text).unwrap_err();
        assert_eq!(brief(&error("a b")), error("a b").to_string());
        let brief = brief(&error(&"word\n ".repeat(1000)));
        assert!(brief.starts_with("invalid type: string \"word word") && brief.contains(" … "), "{brief}");
        assert!(brief.chars().count() < 250 && !brief.contains(char::is_control));
    }

    #[test]
    fn numbers_have_a_point_and_a_sign_in_the_exponent() {
        assert_eq!([1e-7, 1.5e300, -0.0, 2e16].map(number), ["1.0e-7", "1.5e+300", "-0.0", "2.0e+16"]);
    }

    #[test]
    fn texts_are_quoted_and_escaped() {
        assert_eq!(quoted("a \"b\" \\ ü\n"), r#""a \"b\" \\ ü\U0000000a""#);
    }
}
