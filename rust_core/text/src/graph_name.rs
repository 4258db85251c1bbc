//! Names of topics, services, parameters and nodes, checked and cleaned as roscpp's `ros::names` does.

/// A name with one slash where there are several, and none at the end.
///
/// ```
/// let names = ["//m", "/a//b", "/m/", "~/x", "/"].map(rcs_text::clean_name);
/// assert_eq!(names, ["/m", "/a/b", "/m", "~/x", ""]);
/// ```
pub fn clean_name(name: &str) -> String {
    let mut cleaned = String::with_capacity(name.len());
    for letter in name.chars() {
        if letter != '/' || !cleaned.ends_with('/') {
            cleaned.push(letter);
        }
    }
    cleaned.truncate(cleaned.trim_end_matches('/').len());
    cleaned
}

/// A name of the ROS graph, cleaned: letters, digits, `_` and `/` behind a letter, `/` or `~`.
///
/// # Errors
/// The form of such a name.
pub fn graph_name(text: &str) -> Result<String, String> {
    let cleaned = clean_name(text);
    let begins_well = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '/' || c == '~');
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'/';
    if begins_well && !cleaned.is_empty() && text.bytes().skip(1).all(is_plain) {
        return Ok(cleaned);
    }
    Err("a ROS name: letters, digits, _ and /, and a letter, / or ~ first".to_owned())
}

/// The whole name of a topic or parameter, cleaned, with the `/` in front that a user may leave out.
///
/// # Errors
/// The form of such a name.
pub fn topic_name(text: &str) -> Result<String, String> {
    let name = graph_name(text)?;
    if name.starts_with('~') {
        return Err("a whole name, without ~".to_owned());
    }
    Ok(full_name(&name))
}

/// A topic's whole name without a node: cleaned, and below the root where it has no slash in front.
///
/// ```
/// assert_eq!(["tf", "/tf", "//tf/"].map(rcs_text::full_name), ["/tf"; 3]);
/// ```
pub fn full_name(topic: &str) -> String {
    clean_name(&format!("/{topic}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_cleaned_as_by_roscpp() {
        for (name, cleaned) in [
            ("/m", "/m"),
            ("//m", "/m"),
            ("///a///b///", "/a/b"),
            ("a//b/", "a/b"),
            ("~//x", "~/x"),
            ("~", "~"),
            ("/1/2", "/1/2"),
        ] {
            assert_eq!(graph_name(name).as_deref(), Ok(cleaned), "{name}");
        }
        for wrong in ["", "/", "//", "1st", "_a", "a b", "/fo$o", "a~b", "/~a", "/é", "a-b"] {
            assert!(graph_name(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_topics_name_is_whole() {
        for (name, whole) in [("/a/b", "/a/b"), ("points", "/points"), ("a//b/", "/a/b"), ("//m", "/m")] {
            assert_eq!(topic_name(name).as_deref(), Ok(whole), "{name}");
        }
        for wrong in ["", "/", "~points", "1st", "a b"] {
            assert!(topic_name(wrong).is_err(), "{wrong}");
        }
    }
}
