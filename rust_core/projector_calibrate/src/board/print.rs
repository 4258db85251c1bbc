//! `projector_calibrate board`: a chessboard to print.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use rcs_calibration::board::Chessboard;
use rcs_files::atomic_file::write_atomically;
use rcs_files::FileError;

use super::pdf::Page;
use crate::arguments::{check_output, chessboard};
use crate::Failure;

/// Sheets of A4 to A0, millimetres.
const SHEETS: [(&str, [f64; 2]); 5] = [
    ("A4", [297.0, 210.0]),
    ("A3", [420.0, 297.0]),
    ("A2", [594.0, 420.0]),
    ("A1", [841.0, 594.0]),
    ("A0", [1189.0, 841.0]),
];
/// Margins at the left, and below and above; and the strip of ruler and text at the right, millimetres.
const LEFT_MM: f64 = 7.0;
const BELOW_MM: f64 = 4.5;
const STRIP_MM: f64 = 13.0;
/// Millimetres of the longest ruler.
const RULER_MM: u32 = 150;

/// Writes a chessboard to print, with a ruler to check its size by
///
/// Print it at 100 %, not "fit to page", on the smallest sheet from A4 to A0 on which it fits, and glue it onto
/// something flat and stiff, such as glass or aluminium. Then measure the ruler.
#[derive(Debug, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate board -o board.pdf")]
#[command(after_help = "\
Exit codes: 0 written; 1 not written; 2 invalid arguments")]
pub(crate) struct BoardArguments {
    /// Inner corners, where four squares meet, and a square's side
    #[arg(long, value_name = "chessboard:CxR:SIDE", default_value = "chessboard:10x7:25mm", value_parser = chessboard)]
    board: Chessboard,
    /// The file to write
    #[arg(short, long, value_name = "FILE.pdf")]
    output: PathBuf,
}

/// Runs the command.
pub(crate) fn run(arguments: &BoardArguments) -> Result<(), Failure> {
    let BoardArguments { board, output } = arguments;
    check_output(output)?;
    let (sheet, file) = drawn(board)?;
    let failed = |error: std::io::Error| FileError { path: output.clone(), problem: format!("cannot write: {error}") };
    write_atomically(output, |writer| writer.write_all(&file).map_err(failed), failed).map_err(Failure::refused)?;
    eprintln!("written: {}; print it on {sheet} at 100 %, and measure its ruler", output.display());
    Ok(())
}

/// The sheet's name, and the file.
fn drawn(board: &Chessboard) -> Result<(&'static str, Vec<u8>), Failure> {
    let side_mm = 1000.0 * board.square_m;
    let [columns, rows] = board.corners.map(|corners| corners + 1);
    let size_mm = [f64::from(columns) * side_mm, f64::from(rows) * side_mm];
    let fits =
        |sheet: &[f64; 2]| size_mm[0] + LEFT_MM + STRIP_MM <= sheet[0] && size_mm[1] + 2.0 * BELOW_MM <= sheet[1];
    let (name, sheet_mm) = SHEETS.into_iter().find(|(_, sheet)| fits(sheet)).ok_or_else(|| {
        let [width, height] = size_mm;
        Failure::Unreadable(anyhow::anyhow!("a board of {width:.0}x{height:.0} mm fits on no sheet up to A0"))
    })?;
    let mut page = Page::new(sheet_mm);
    let left = LEFT_MM + 0.5 * (sheet_mm[0] - LEFT_MM - STRIP_MM - size_mm[0]);
    let below = 0.5 * (sheet_mm[1] - size_mm[1]);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        if (row + column) % 2 == 0 {
            let corner_mm = [left + f64::from(column) * side_mm, below + f64::from(row) * side_mm];
            page.rectangle(corner_mm, [side_mm; 2]);
        }
    }
    let strip = left + size_mm[0] + 2.0;
    let ruler_mm = RULER_MM.min((sheet_mm[1] - 2.0 * BELOW_MM) as u32 / 10 * 10);
    let foot = 0.5 * (sheet_mm[1] - f64::from(ruler_mm));
    for mm in 0..=ruler_mm {
        let length = if mm % 10 == 0 { 4.0 } else { 2.0 };
        page.rectangle([strip, foot + f64::from(mm) - 0.05], [length, 0.1]);
    }
    let [columns, rows] = board.corners;
    let text = format!("chessboard:{columns}x{rows}:{side_mm}mm - print at 100 %: the ruler has {ruler_mm} mm");
    page.text_upwards([strip + 8.0, foot], &text);
    Ok((name, page.finish()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_is_drawn_to_scale_on_the_sheet_that_it_fits_on() {
        let (sheet, file) = drawn(&Chessboard { corners: [10, 7], square_m: 0.025 }).unwrap();
        let text = String::from_utf8(file).unwrap();
        // 25 mm in points.
        assert_eq!(text.matches(" 70.866 70.866 re f").count(), 44, "of 88 squares");
        assert_eq!((sheet, text.matches("11.339 0.283 re f").count()), ("A4", 16), "marks of centimetres");
        assert!(text.contains("(chessboard:10x7:25mm - print at 100 %: the ruler has 150 mm) Tj"));
        assert_eq!(drawn(&Chessboard { corners: [10, 7], square_m: 0.035 }).unwrap().0, "A3");
        assert!(drawn(&Chessboard { corners: [10, 7], square_m: 0.5 }).is_err());
    }
}
