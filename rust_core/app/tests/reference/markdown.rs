//! Help texts as Markdown.

/// Writes the pages.
pub(crate) const COMMAND: &str = "RCS_WRITE_DOCS=1 cargo test --release -p rcs_app --test reference";

/// The comment that begins a generated page.
pub(crate) fn generated() -> String {
    format!("<!-- Generated: {COMMAND} -->\n")
}

/// A row of a table. Cells have no spaces around them, so that `wc -w` counts words alone.
pub(crate) fn row(cells: &[String]) -> String {
    format!("|{}|\n", cells.join("|"))
}

/// The head of a table.
pub(crate) fn head(names: &[&str]) -> String {
    let cells: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    row(&cells) + "|" + &"---|".repeat(names.len()) + "\n"
}

/// Code for a cell of a table.
pub(crate) fn code(text: &str) -> String {
    format!("`{}`", text.replace('|', "\\|"))
}

/// Plain text for a cell: words that are names, options or values become code, and so do lists in braces.
pub(crate) fn text(plain: &str) -> String {
    if plain.contains('`') {
        return plain.to_owned();
    }
    let mut words: Vec<String> = Vec::new();
    let mut braces = String::new();
    for word in plain.split_whitespace() {
        braces += if braces.is_empty() { "" } else { " " };
        braces += word;
        if braces.matches('{').count() <= braces.matches('}').count() {
            words.push(coded(&std::mem::take(&mut braces)));
        }
    }
    words.extend((!braces.is_empty()).then_some(braces));
    words.join(" ")
}

/// A word as code if it is a name or Markdown would read it otherwise, without the punctuation around it.
fn coded(word: &str) -> String {
    let start = word.trim_start_matches('(');
    let core = start.trim_end_matches([',', ';', '.', ':', ')']);
    let core = core.strip_suffix("'s").unwrap_or(core);
    // A bracket around a remark is none of the name's.
    let core = if core.contains('[') { core } else { core.trim_end_matches(']') };
    let core = if start.starts_with(&format!("{core}:=")) { start } else { core };
    let starts_with_letter = |text: &str| text.starts_with(char::is_alphabetic);
    let is_code = core.contains(['_', '~', '|', '<', '*', '{'])
        || core.contains(":=")
        || (core.ends_with('=') && starts_with_letter(core))
        || core.strip_prefix("--").is_some_and(starts_with_letter)
        || core.strip_prefix(['-', '/']).is_some_and(starts_with_letter);
    match (is_code, word.split_once(core)) {
        (true, Some((before, after))) => format!("{before}{}{after}", code(core)),
        _ => word.to_owned(),
    }
}

#[test]
fn names_in_plain_text_become_code() {
    let expected = "With `--live`, `/tf` (or `~x`) is 0.5 [m]; `a\\|b`.";
    assert_eq!(text("With --live, /tf (or ~x) is 0.5 [m]; a|b."), expected);
    assert_eq!(text("cloud:=/other, and CAMERA= for one"), "`cloud:=/other`, and `CAMERA=` for one");
    assert_eq!(text("fx != fy of the_node's, as [s; 0: never]"), "fx != fy of `the_node`'s, as [s; 0: never]");
    assert_eq!(text("limits, [{topic: T, limit: L}]: seconds"), "limits, `[{topic: T, limit: L}]`: seconds");
    assert_eq!(text("as `it is` --written"), "as `it is` --written");
}
