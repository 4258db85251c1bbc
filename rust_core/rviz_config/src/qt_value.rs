//! Text to values as Qt converts them for rviz.
//!
//! rviz keeps every scalar of a config as text and asks Qt's `QVariant` for the number, bool or colour. The rules
//! differ from YAML's: `no` is true, `10.0` is no integer, white space around a number is allowed.

/// The colour of a text, red, green and blue: `r; g; b` with each from 0 to 255, `#rrggbb`, or a name of SVG's. `None`
/// for any other text.
///
/// ```
/// assert_eq!(rcs_rviz_config::color("0; 120; 255"), Some([0, 120, 255]));
/// assert_eq!(rcs_rviz_config::color("steelblue"), rcs_rviz_config::color("#4682b4"));
/// assert_eq!(rcs_rviz_config::color("0; 0; 300"), None);
/// ```
pub fn color(text: &str) -> Option<[u8; 3]> {
    to_color(text).filter(|(_, is_in_range)| *is_in_range).map(|(rgb, _)| rgb)
}

/// A bool as `QVariant::toBool` reads it: empty text, `0` and `false` are false and all else is true. The second value
/// is `false` for text that is not meant as this bool.
pub(crate) fn to_bool(text: &str) -> (bool, bool) {
    let lower = text.to_lowercase();
    match lower.as_str() {
        "0" | "false" => (false, true),
        "" => (false, false),
        "1" | "true" | "yes" | "on" => (true, true),
        _ => (true, false),
    }
}

/// A decimal integer, or `None` where `QString::toInt` fails.
pub(crate) fn to_int(text: &str) -> Option<i32> {
    text.trim().parse().ok()
}

/// A number in C notation, or `None` where `QString::toDouble` fails. `inf` and `nan` are numbers.
pub(crate) fn to_f64(text: &str) -> Option<f64> {
    let text = text.trim();
    let digits = text.trim_start_matches(['+', '-']);
    if digits.starts_with(|c: char| c.is_ascii_digit() || c == '.') || digits == "inf" || digits == "nan" {
        text.parse().ok()
    } else {
        None
    }
}

/// A number in C notation or, failing that, as written in German (`1.234,5`), which rviz tries for the components of
/// vectors because old versions wrote them in the user's language.
pub(crate) fn to_f64_or_german(text: &str) -> Option<f64> {
    to_f64(text).or_else(|| to_f64(&text.replace('.', "").replace(',', ".")))
}

/// A colour: `r; g; b` with each 0 to 255, `#rgb` or `#rrggbb` (also with alpha or more digits, as Qt reads them), or
/// a name of SVG's. The second value is `true` if all components were in range.
pub(crate) fn to_color(text: &str) -> Option<([u8; 3], bool)> {
    if text.contains(';') {
        let mut parts = text.split(';');
        let (r, g, b) = (to_int(parts.next()?)?, to_int(parts.next()?)?, to_int(parts.next()?)?);
        let rgb = [r, g, b];
        let in_range = rgb.iter().all(|value| (0..=255).contains(value));
        return Some((rgb.map(|value| value.clamp(0, 255) as u8), in_range));
    }
    if let Some(hex) = text.strip_prefix('#') {
        return hex_color(hex).map(|rgb| (rgb, true));
    }
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_alphabetic()) {
        return None;
    }
    let [r, g, b, _] = csscolorparser::parse(text).ok()?.to_rgba8();
    Some(([r, g, b], true))
}

/// `rgb`, `rrggbb`, `aarrggbb`, `rrrgggbbb` or `rrrrggggbbbb`; more than eight bits are cut to the highest eight.
fn hex_color(hex: &str) -> Option<[u8; 3]> {
    if !hex.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let (hex, digits) = match hex.len() {
        3 => (hex, 1),
        6 => (hex, 2),
        8 => (hex.get(2..)?, 2),
        9 => (hex, 3),
        12 => (hex, 4),
        _ => return None,
    };
    let component = |index: usize| -> Option<u8> {
        let value = u16::from_str_radix(hex.get(index * digits..(index + 1) * digits)?, 16).ok()?;
        Some(match digits {
            1 => (value * 17) as u8,
            2 => value as u8,
            3 => (value >> 4) as u8,
            _ => (value >> 8) as u8,
        })
    };
    Some([component(0)?, component(1)?, component(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bools_follow_qt_not_yaml() {
        assert_eq!(to_bool("true"), (true, true));
        assert_eq!(to_bool("False"), (false, true));
        assert_eq!(to_bool("0"), (false, true));
        assert_eq!(to_bool(""), (false, false));
        assert_eq!(to_bool("no"), (true, false), "Qt knows no \"no\"");
    }

    #[test]
    fn numbers_follow_qt_not_rust() {
        assert_eq!(to_int(" 12 "), Some(12));
        assert_eq!(to_int("10.0"), None);
        assert_eq!(to_int("99999999999"), None);
        assert_eq!(to_f64("1e-3"), Some(1e-3));
        assert_eq!(to_f64("-.5"), Some(-0.5));
        assert_eq!(to_f64("infinity"), None);
        assert_eq!(to_f64("1,5"), None);
        assert_eq!(to_f64(""), None);
        assert_eq!(to_f64("++1"), None);
        assert_eq!(to_f64_or_german("1.234,5"), Some(1234.5));
    }

    #[test]
    fn colours_in_each_notation() {
        assert_eq!(to_color("255; 120;0"), Some(([255, 120, 0], true)));
        assert_eq!(to_color("300; -1; 7"), Some(([255, 0, 7], false)));
        assert_eq!(to_color("1; 2"), None);
        assert_eq!(to_color("1; 2; 3.5"), None);
        assert_eq!(to_color("#f80"), Some(([255, 136, 0], true)));
        assert_eq!(to_color("#80ff7f01"), Some(([255, 127, 1], true)));
        assert_eq!(to_color("#ffff7fff00ff"), Some(([255, 127, 0], true)));
        assert_eq!(to_color("#gg0000"), None);
        assert_eq!(to_color("SteelBlue"), Some(([70, 130, 180], true)));
        assert_eq!(to_color("rgb(1,2,3)"), None);
        assert_eq!(to_color("1 2 3"), None);
    }
}
