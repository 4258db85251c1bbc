//! Text of a file in messages.

/// Longest path or value that a message repeats, in characters.
const MAX_QUOTED_CHARS: usize = 120;

/// The text as one line: control characters are escaped and a long text is cut.
pub(crate) fn one_line(text: &str) -> String {
    let mut line = String::new();
    for (index, c) in text.chars().enumerate() {
        if index == MAX_QUOTED_CHARS {
            line.push('…');
            break;
        }
        if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
    }
    line
}
