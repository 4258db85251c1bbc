//! Arguments of the form `KEY=VALUE`.

/// Stands in the place of the `=` where key and value come from a parameter's struct: both may then have a `=`.
pub const FIELD_SEPARATOR: char = '\u{1f}';

/// The two sides of `KEY=VALUE`, without spaces around them. The key is the longest of the known ones that fits, else
/// ends at the first `=`. `None` without a `=`, or without a key before it.
pub fn split<'t>(text: &'t str, known: &[String]) -> Option<(&'t str, &'t str)> {
    let text = text.trim();
    let fits =
        |key: &&str| !key.is_empty() && text.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='));
    let known_len = known.iter().map(|key| key.trim()).filter(fits).map(str::len).max().unwrap_or(0);
    let (key, value) = text.split_once(FIELD_SEPARATOR).or_else(|| {
        let (_, rest) = text.split_at(known_len);
        let at = known_len + rest.find('=')?;
        Some((&text[..at], &text[at + 1..]))
    })?;
    let (key, value) = (key.trim(), value.trim());
    (!key.is_empty()).then_some((key, value))
}

/// The candidate that a misspelt name was probably meant to be; `None` if none is near.
///
/// ```
/// use rcs_node_support::key_value::nearest;
///
/// let displays = ["markers", "path"].map(str::to_owned);
/// assert_eq!(nearest("Markrs", &displays), Some("markers"));
/// assert_eq!(nearest("grid", &displays), None);
/// ```
pub fn nearest<'c>(name: &str, candidates: &'c [String]) -> Option<&'c str> {
    let distance = |candidate: &String| strsim::osa_distance(&name.to_lowercase(), &candidate.to_lowercase());
    let found = candidates.iter().min_by_key(|candidate| distance(candidate))?;
    (distance(found) <= found.chars().count() / 3).then_some(found.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_key_ends_at_the_first_sign() {
        assert_eq!(split("NAME=a=b", &[]), Some(("NAME", "a=b")));
        assert_eq!(split(" head = 0.2 ", &[]), Some(("head", "0.2")));
        assert_eq!(split("a=", &[]), Some(("a", "")));
        for neither in ["", "a", "=1", " = "] {
            assert_eq!(split(neither, &[]), None, "{neither}");
        }
    }

    #[test]
    fn a_known_key_is_the_longest_that_fits() {
        let keys = ["Left", "Left=right", "/data/run", ""].map(str::to_owned);
        assert_eq!(split("Left=90", &keys), Some(("Left", "90")));
        assert_eq!(split("Left=right=180", &keys), Some(("Left=right", "180")));
        assert_eq!(split("Left = a=b", &keys), Some(("Left", "a=b")));
        assert_eq!(split("Leftmost=1", &keys), Some(("Leftmost", "1")));
    }

    #[test]
    fn a_struct_of_a_parameter_is_split_where_its_fields_meet() {
        let text = format!("a=b{FIELD_SEPARATOR}c=d");
        assert_eq!(split(&text, &["a".to_owned()]), Some(("a=b", "c=d")));
    }
}
