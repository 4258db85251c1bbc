//! Arguments of the form `KEY=VALUE`.

/// The two sides of the first `=`, without spaces around them. `None` without a `=`, or without a key before it.
pub fn split(text: &str) -> Option<(&str, &str)> {
    let (key, value) = text.split_once('=')?;
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
    fn a_key_ends_at_the_first_sign() {
        assert_eq!(split("NAME=a=b"), Some(("NAME", "a=b")));
        assert_eq!(split(" head = 0.2 "), Some(("head", "0.2")));
        assert_eq!(split("a="), Some(("a", "")));
        for neither in ["", "a", "=1", " = "] {
            assert_eq!(split(neither), None, "{neither}");
        }
    }
}
