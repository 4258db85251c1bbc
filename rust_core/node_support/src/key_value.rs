//! Arguments of the form `KEY=VALUE`.

/// The two sides of the first `=`, without spaces around them. `None` without a `=`, or without a key before it.
pub fn split(text: &str) -> Option<(&str, &str)> {
    let (key, value) = text.split_once('=')?;
    let (key, value) = (key.trim(), value.trim());
    (!key.is_empty()).then_some((key, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_ends_at_the_first_sign() {
        assert_eq!(split("NAME=a=b"), Some(("NAME", "a=b")));
        assert_eq!(split(" head = 0.2 "), Some(("head", "0.2")));
        assert_eq!(split("a="), Some(("a", "")));
        for neither in ["", "a", "=1", " = "] {
            assert_eq!(split(neither), None, "{neither}");
        }
    }
}
