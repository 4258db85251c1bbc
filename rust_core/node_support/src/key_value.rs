//! Arguments of the form `KEY=VALUE`.

/// The two sides of the first `=`, without spaces around them; none where one of them is empty.
pub fn split(text: &str) -> Option<(&str, &str)> {
    let (key, value) = text.split_once('=')?;
    let (key, value) = (key.trim(), value.trim());
    (!key.is_empty() && !value.is_empty()).then_some((key, value))
}

/// The longest of the known keys that the text begins with, followed by `=`, and the value after that. Both keys and
/// values may have a `=` in them; the value may be empty.
pub fn split_at_known<'t, 'k>(text: &'t str, keys: impl IntoIterator<Item = &'k str>) -> Option<(&'k str, &'t str)> {
    let value_of =
        |key: &str| text.trim_start().strip_prefix(key.trim())?.trim_start().strip_prefix('=').map(str::trim);
    let found = keys.into_iter().filter_map(|key| Some((key, value_of(key)?)));
    found.max_by_key(|(key, _)| key.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_key_ends_at_the_first_sign() {
        assert_eq!(split("NAME=a=b"), Some(("NAME", "a=b")));
        assert_eq!(split(" head = 0.2 "), Some(("head", "0.2")));
        for neither in ["", "a", "=1", "a=", " = "] {
            assert_eq!(split(neither), None, "{neither}");
        }
    }

    #[test]
    fn a_known_key_is_the_longest_that_fits() {
        let keys = ["Left", "Left=right", "/data/run", ""];
        assert_eq!(split_at_known("Left=90", keys), Some(("Left", "90")));
        assert_eq!(split_at_known("Left=right=180", keys), Some(("Left=right", "180")));
        assert_eq!(split_at_known("Left = a=b", keys), Some(("Left", "a=b")));
        assert_eq!(split_at_known("Left=", keys), Some(("Left", "")));
        for other in ["Leftmost=1", "left=1", "Right=1", "90"] {
            assert_eq!(split_at_known(other, ["Left"]), None, "{other}");
        }
    }
}
