//! Numbers in text files.

/// The longest number at the start of a word, as in Assimp: `0.5`, `.5`, `5.`, `1e-3`, `0,5`, `inf`, `nan`, `1.0foo`.
/// `None` when the word does not begin with a number.
pub(crate) fn leading_f32(word: &str) -> Option<f32> {
    if let Ok(value) = word.parse() {
        return Some(value);
    }
    let word = word.replacen(',', ".", 1);
    let bytes = word.as_bytes();
    let digits = |from: usize| bytes.iter().skip(from).take_while(|b| b.is_ascii_digit()).count();
    let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let whole = digits(end);
    end += whole;
    let mut fraction = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        end += 1 + fraction;
    }
    if whole + fraction == 0 {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign);
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    word.get(..end)?.parse().ok()
}

/// Three numbers from the words of a line.
pub(crate) fn three<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<[f32; 3]> {
    Some([leading_f32(words.next()?)?, leading_f32(words.next()?)?, leading_f32(words.next()?)?])
}

#[cfg(test)]
mod tests {
    use super::leading_f32;

    #[test]
    fn numbers_are_read_as_far_as_they_go() {
        for (word, value) in [
            ("0.5", Some(0.5)),
            (".5", Some(0.5)),
            ("5.", Some(5.0)),
            ("-1e-2", Some(-0.01)),
            ("+3E2x", Some(300.0)),
            ("1.5e", Some(1.5)),
            ("0,25", Some(0.25)),
            ("-1.#IND", Some(-1.0)),
            ("", None),
            ("-", None),
            (".", None),
            ("x1", None),
        ] {
            assert_eq!(leading_f32(word), value, "{word:?}");
        }
        assert!(leading_f32("nan").is_some_and(f32::is_nan));
    }
}
