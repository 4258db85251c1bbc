//! Regular expressions that choose frames by their names.
//!
//! rviz searches names with C++'s `std::regex`, whose grammar is ECMAScript's, as that of `regress`. The differences
//! are handled here: names of character classes such as `[[:digit:]]` become ranges, and expressions that `libstdc++`
//! refuses (`(?<=…)`, `(?i)`, a `{` that begins no count) are refused.

use regress::Regex;

/// Longest expression, in bytes.
const MAX_BYTES: usize = 4096;

/// The names of character classes inside brackets, with their ASCII characters.
const CLASSES: [(&str, &str); 15] = [
    ("alnum", "0-9A-Za-z"),
    ("alpha", "A-Za-z"),
    ("blank", " \\t"),
    ("cntrl", "\\x00-\\x1f\\x7f"),
    ("d", "0-9"),
    ("digit", "0-9"),
    ("graph", "\\x21-\\x7e"),
    ("lower", "a-z"),
    ("print", "\\x20-\\x7e"),
    ("punct", "\\x21-\\x2f\\x3a-\\x40\\x5b-\\x60\\x7b-\\x7e"),
    ("s", "\\s"),
    ("space", "\\s"),
    ("upper", "A-Z"),
    ("w", "\\w"),
    ("xdigit", "0-9A-Fa-f"),
];

/// A regular expression that is searched for in frames' names; an empty text is none.
#[derive(Debug, Clone, Default)]
pub struct FrameFilter {
    text: String,
    regex: Option<Regex>,
}

/// A regular expression that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct FilterError {
    /// The reason.
    pub reason: String,
}

impl FrameFilter {
    /// Compiles an expression.
    ///
    /// ```
    /// use rcs_rviz_config::FrameFilter;
    ///
    /// let lamps = FrameFilter::new("^lamp_[[:digit:]]+$").expect("a regular expression");
    /// assert_eq!(lamps.matches("lamp_12"), Some(true));
    /// assert_eq!(lamps.matches("my_lamp_12"), Some(false));
    /// assert_eq!(FrameFilter::default().matches("lamp_12"), None);
    /// assert!(FrameFilter::new("lamp(").is_err());
    /// ```
    ///
    /// # Errors
    /// [`FilterError`] for what `std::regex` would not compile, and above 4096 bytes.
    pub fn new(text: &str) -> Result<Self, FilterError> {
        if text.len() > MAX_BYTES {
            return Err(FilterError { reason: format!("longer than {MAX_BYTES} bytes") });
        }
        if text.is_empty() {
            return Ok(Self::default());
        }
        let regex =
            Regex::new(&without_class_names(text)?).map_err(|error| FilterError { reason: error.to_string() })?;
        Ok(Self { text: text.to_owned(), regex: Some(regex) })
    }

    /// `true` if the name contains the expression; `None` without an expression.
    pub fn matches(&self, frame: &str) -> Option<bool> {
        self.regex.as_ref().map(|regex| regex.find(frame).is_some())
    }
}

impl PartialEq for FrameFilter {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

/// The expression with character classes as ranges.
///
/// # Errors
/// [`FilterError`] for syntax that `std::regex` does not know.
fn without_class_names(text: &str) -> Result<String, FilterError> {
    let refused = |what: &str| Err(FilterError { reason: format!("unsupported {what}") });
    let mut read = String::new();
    let mut rest = text;
    let mut is_in_brackets = false;
    while let Some(c) = rest.chars().next() {
        let mut taken = c.len_utf8();
        match c {
            '\\' => taken += rest[taken..].chars().next().map_or(0, char::len_utf8),
            '[' if is_in_brackets && rest.starts_with("[:") => {
                let Some((name, after)) = rest[2..].split_once(":]") else { return refused("class without :]") };
                let Some((_, characters)) = CLASSES.iter().find(|(known, _)| *known == name) else {
                    return refused(&format!("class [:{name}:]"));
                };
                read += characters;
                rest = after;
                continue;
            }
            '[' => is_in_brackets = true,
            ']' => is_in_brackets = false,
            '(' if !is_in_brackets && rest.starts_with("(?") && !rest[2..].starts_with([':', '=', '!']) => {
                return refused("group (?…) that is none of (?:…), (?=…) and (?!…)");
            }
            '{' if !is_in_brackets && !begins_count(&rest[1..]) => return refused("{ that begins no count"),
            _ => {}
        }
        read += &rest[..taken];
        rest = &rest[taken..];
    }
    Ok(read)
}

/// `true` if a count, such as `2}`, `2,}` or `2,3}`, follows.
fn begins_count(after_brace: &str) -> bool {
    let Some((count, _)) = after_brace.split_once('}') else { return false };
    let (least, most) = count.split_once(',').unwrap_or((count, ""));
    let is_number = |text: &str| text.bytes().all(|c| c.is_ascii_digit());
    !least.is_empty() && is_number(least) && is_number(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Results of `std::regex_search` in libstdc++ 12; `None` where it could not compile the expression.
    const BY_STD_REGEX: [(&str, &str, Option<bool>); 42] = [
        ("lamp", "my_lamp_1", Some(true)),
        ("^lamp", "my_lamp_1", Some(false)),
        ("LAMP", "lamp", Some(false)),
        ("^(?!cam)", "cam", Some(false)),
        ("^(?!cam)", "lamp", Some(true)),
        ("\\d+$", "lamp_1", Some(true)),
        ("a|", "x", Some(true)),
        ("a||b", "c", Some(true)),
        ("x*", "b", Some(true)),
        ("()", "a", Some(true)),
        ("\\/", "a/b", Some(true)),
        ("\\_", "a_b", Some(true)),
        ("]", "]", Some(true)),
        ("}", "}", Some(true)),
        ("[[:digit:]]", "lamp_1", Some(true)),
        ("[^[:alpha:]_]", "a1", Some(true)),
        ("[^[:alpha:]_]", "a_b", Some(false)),
        ("[[:d:]]", "1", Some(true)),
        ("[:digit:]", "d", Some(true)),
        ("[\\w-]", "-", Some(true)),
        ("[\\d]", "1", Some(true)),
        ("(a)\\1", "aa", Some(true)),
        ("a+?", "a", Some(true)),
        ("a{2}", "aa", Some(true)),
        ("a{2}", "a", Some(false)),
        ("[{]", "{", Some(true)),
        ("\\{", "{", Some(true)),
        ("\\x61", "a", Some(true)),
        ("\\u0061", "a", Some(true)),
        ("[]", "a", Some(false)),
        ("[^]", "a", Some(true)),
        ("\\ba", "a", Some(true)),
        ("(?<=a)b", "ab", None),
        ("(?<n>a)", "a", None),
        ("(?i)a", "A", None),
        ("a{", "a{", None),
        ("a{,2}", "a", None),
        ("*a", "a", None),
        ("(", "a", None),
        ("[", "a", None),
        ("[z-a]", "a", None),
        ("[[:foo:]]", "a", None),
    ];

    #[test]
    fn expressions_mean_what_they_mean_to_rviz() {
        for (text, frame, expected) in BY_STD_REGEX {
            let matches = FrameFilter::new(text).ok().and_then(|filter| filter.matches(frame));
            assert_eq!(matches, expected, "{text} in {frame}");
        }
    }

    #[test]
    fn no_expression_is_too_deep_or_too_long_for_the_stack() {
        for text in ["(".repeat(4000), "[".repeat(4000), "(a*".repeat(1300), "a?".repeat(2000), "é[[:".repeat(800)] {
            let _ = FrameFilter::new(&text);
        }
        assert!(FrameFilter::new(&"a".repeat(MAX_BYTES + 1)).is_err());
        assert!(FrameFilter::new("\\").is_err());
    }
}
