//! Tables on standard output: each column as wide as its widest cell.

use std::io::{self, Write};

use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

/// Widest cell in columns of a terminal, except in the last column of the table: longer ones are cut.
const MAX_CELL_WIDTH: usize = 60;

/// Prints the rows, each after `indent`. Control characters are escaped, so that a row is a line.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn print<const N: usize>(rows: &[[String; N]], indent: &str, out: &mut dyn Write) -> io::Result<()> {
    let shorten = |(column, cell): (usize, &String)| {
        let text = escaped(cell);
        if column + 1 == N || text.width() <= MAX_CELL_WIDTH {
            return text;
        }
        let mut width = 1;
        let is_within = |c: &char| {
            width += c.width().unwrap_or(0);
            width <= MAX_CELL_WIDTH
        };
        text.chars().take_while(is_within).chain(['…']).collect()
    };
    let rows: Vec<Vec<String>> = rows.iter().map(|row| row.iter().enumerate().map(shorten).collect()).collect();
    let width =
        |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.width()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..N).map(width).collect();
    for row in &rows {
        let pad =
            |(cell, width): (&String, &usize)| format!("{cell}{}", " ".repeat(width.saturating_sub(cell.width())));
        let cells: Vec<String> = row.iter().zip(&widths).map(pad).collect();
        writeln!(out, "{}", format!("{indent}{}", cells.join("  ")).trim_end())?;
    }
    Ok(())
}

fn escaped(cell: &str) -> String {
    cell.chars().flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_whatever_the_cells_hold() {
        let row = |cells: [&str; 3]| cells.map(str::to_owned);
        let long = "x".repeat(100);
        let rows = [row(["é", "b\nc", "last"]), row(["name", "", &long]), row([&long, "b", ""])];
        let mut out = Vec::new();
        print(&rows, "  ", &mut out).unwrap();
        let cut = format!("{}…", "x".repeat(59));
        let expected = format!("  {:60}  b\\nc  last\n  {:60}        {long}\n  {cut}  b\n", "é", "name");
        assert_eq!(String::from_utf8(out).unwrap(), expected);
    }

    #[test]
    fn wide_characters_take_two_columns() {
        let rows = [["点云", "a"], ["cloud", "b"], ["e\u{301}", "c"]].map(|row| row.map(str::to_owned));
        let mut out = Vec::new();
        print(&rows, "", &mut out).unwrap();
        assert_eq!(String::from_utf8(out).unwrap(), "点云   a\ncloud  b\ne\u{301}      c\n");
        let mut out = Vec::new();
        print(&[["点".repeat(40), "a".to_owned()]], "", &mut out).unwrap();
        assert_eq!(String::from_utf8(out).unwrap(), format!("{}…  a\n", "点".repeat(29)));
    }
}
