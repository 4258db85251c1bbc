//! Tables on standard output: each column as wide as its widest cell.

use std::io::{self, Write};

/// The longest part of a cell that is printed, in characters, but for the last column. A cell that is longer would push
/// all others out of sight.
const MAX_CELL_CHARS: usize = 60;

/// Prints the rows, each after `indent`. Control characters are escaped, so that a row is a line.
///
/// # Errors
/// When the output cannot be written.
pub(crate) fn print<const N: usize>(rows: &[[String; N]], indent: &str, out: &mut dyn Write) -> io::Result<()> {
    let shorten = |(column, cell): (usize, &String)| {
        let text = escaped(cell);
        if column + 1 == N || text.chars().count() <= MAX_CELL_CHARS {
            return text;
        }
        text.chars().take(MAX_CELL_CHARS - 1).chain(['…']).collect()
    };
    let rows: Vec<Vec<String>> = rows.iter().map(|row| row.iter().enumerate().map(shorten).collect()).collect();
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..N).map(width).collect();
    for row in &rows {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}")).collect();
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
}
