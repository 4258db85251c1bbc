//! Values of attributes as urdfdom reads them: decimal, finite numbers separated by blanks.

/// Parses a number; `None` for anything else, such as `nan`, `0x1` or `1 m`.
pub(super) fn number(text: &str) -> Option<f64> {
    let is_decimal = |letter: char| matches!(letter, '0'..='9' | '+' | '-' | '.' | 'e' | 'E');
    let text = text.trim();
    let value: f64 = text.chars().all(is_decimal).then(|| text.parse().ok())??;
    value.is_finite().then_some(value)
}

/// Parses a list of numbers.
pub(super) fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split_ascii_whitespace().map(number).collect()
}

/// Parses three numbers.
pub(super) fn vector(text: &str) -> Option<[f64; 3]> {
    numbers(text)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_finite_decimal_numbers_are_numbers() {
        for (text, value) in [("1", 1.0), ("-.5", -0.5), ("+2.", 2.0), ("1e-3", 0.001), (" 4 ", 4.0)] {
            assert_eq!(number(text), Some(value), "{text}");
        }
        for text in ["", "nan", "inf", "0x10", "1,5", "1.0m", "1e999"] {
            assert_eq!(number(text), None, "{text}");
        }
        assert_eq!(vector("1  2 \t3"), Some([1.0, 2.0, 3.0]));
        assert_eq!(vector("1 2"), None);
        assert_eq!(vector("1 2 x"), None);
    }
}
