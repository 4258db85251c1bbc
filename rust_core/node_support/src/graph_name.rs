//! Names of topics, services and parameters as a user types them.

/// A name of the ROS graph: words of letters, digits and `_`, with `/` between them; begins with a letter, `/` or `~`.
///
/// # Errors
/// The form of such a name.
pub fn graph_name(text: &str) -> Result<String, String> {
    let words = text.strip_prefix(['/', '~']).unwrap_or(text);
    let words = if text.starts_with('~') { words.strip_prefix('/').unwrap_or(words) } else { words };
    let is_word = |word: &str| !word.is_empty() && word.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_');
    let begins_well = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '/' || c == '~');
    if begins_well && words.split('/').all(is_word) {
        return Ok(text.to_owned());
    }
    Err("a ROS name: letters, digits, _ and /, and a letter, / or ~ first".to_owned())
}

/// A topic's whole name, with the `/` in front that a user may leave out.
///
/// # Errors
/// The form of such a name.
pub fn topic_name(text: &str) -> Result<String, String> {
    let name = graph_name(text)?;
    if name.starts_with('~') {
        return Err("a topic's whole name, without ~".to_owned());
    }
    Ok(if name.starts_with('/') { name } else { format!("/{name}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topics_name_is_whole() {
        assert_eq!(topic_name("/a/b"), Ok("/a/b".to_owned()));
        assert_eq!(topic_name("points"), Ok("/points".to_owned()));
        for text in ["", "/", "~points", "a//b", "1st", "a b"] {
            assert!(topic_name(text).is_err(), "{text}");
        }
    }
}
