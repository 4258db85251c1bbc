//! The text of `points.csv`. After the header it is cut at ends of lines into pieces, which are parsed on all cores;
//! of several wrong lines the first is told.

use std::ops::Range;
use std::path::Path;

use nalgebra::{Point2, Point3};
use rayon::prelude::*;
use rcs_calibration::Sample;

use super::{PointsError, RowProblem};
use crate::text::without_byte_order_mark;

/// The bytes of a piece, about.
const PIECE_BYTES: usize = 1 << 18;
/// The farthest pixel and point, pixels and metres: beyond, squares lose the digits that matter.
const FARTHEST: f64 = 1e6;
/// The most characters of a field that an error repeats.
const SHOWN_CHARACTERS: usize = 40;

/// The columns that have a meaning, in the order of [`Column`].
const NAMES: [&str; 8] = ["u_px", "v_px", "x_m", "y_m", "z_m", "scan", "sigma_px", "sigma_m"];
/// Those that correspondences need,
pub(super) const NEEDED: Range<usize> = 0..5;
/// and those that places need.
pub(super) const NEEDED_BY_PLACES: Range<usize> = 2..5;
const SCAN: usize = 5;
const SIGMA_PX: usize = 6;
const SIGMA_M: usize = 7;

/// What a file has.
pub(super) struct Parsed {
    pub(super) samples: Vec<Sample>,
    pub(super) ignored_columns: Vec<String>,
}

/// For each column of the file which of [`NAMES`] it is.
struct Header {
    columns: Vec<Option<usize>>,
    ignored: Vec<String>,
}

/// Parses a file that needs these of the columns; pixels that it does not have are zero.
pub(super) fn parse(path: &Path, text: &[u8], needed: Range<usize>) -> Result<Parsed, PointsError> {
    let row_error = |line, problem| PointsError::Row { path: path.to_owned(), line, problem };
    let mut rest = without_byte_order_mark(text);
    let mut line = 0;
    let header = loop {
        if rest.is_empty() {
            return Err(PointsError::Empty { path: path.to_owned() });
        }
        let (first, after) = split_line(rest);
        line += 1;
        rest = after;
        if has_contents(first) {
            break Header::parse(first, needed).map_err(|problem| row_error(line, problem))?;
        }
    };
    let pieces: Vec<Result<Piece, (usize, RowProblem)>> =
        pieces(rest).into_par_iter().map(|piece| header.piece(piece)).collect();
    let mut samples = Vec::with_capacity(pieces.iter().flatten().map(|piece| piece.samples.len()).sum());
    for piece in pieces {
        let Piece { samples: some, lines } = piece.map_err(|(inside, problem)| row_error(line + inside, problem))?;
        samples.extend(some);
        line += lines;
    }
    Ok(Parsed { samples, ignored_columns: header.ignored })
}

/// The rows of a piece of the text, and how many lines it has.
struct Piece {
    samples: Vec<Sample>,
    lines: usize,
}

impl Header {
    fn parse(line: &[u8], mut needed: Range<usize>) -> Result<Self, RowProblem> {
        let mut header = Self { columns: Vec::new(), ignored: Vec::new() };
        for field in line.split(|byte| *byte == b',') {
            let name = field.trim_ascii();
            let column = NAMES.iter().position(|known| known.as_bytes() == name);
            match column {
                Some(known) if header.columns.contains(&column) => {
                    return Err(RowProblem::RepeatedColumn(NAMES[known].to_owned()));
                }
                Some(_) => {}
                None => header.ignored.push(shown(name)),
            }
            header.columns.push(column);
        }
        match needed.find(|needed| !header.columns.contains(&Some(*needed))) {
            Some(missing) => Err(RowProblem::MissingColumn(NAMES[missing])),
            None => Ok(header),
        }
    }

    /// Parses a piece; an error comes with its line in the piece, from 1.
    fn piece(&self, mut text: &[u8]) -> Result<Piece, (usize, RowProblem)> {
        // A row of five columns has some forty bytes.
        let mut piece = Piece { samples: Vec::with_capacity(text.len() / 36), lines: 0 };
        while !text.is_empty() {
            let (line, after) = split_line(text);
            text = after;
            piece.lines += 1;
            if has_contents(line) {
                piece.samples.push(self.row(line).map_err(|problem| (piece.lines, problem))?);
            }
        }
        Ok(piece)
    }

    fn row(&self, line: &[u8]) -> Result<Sample, RowProblem> {
        let mut values = [0.0; NAMES.len()];
        values[SIGMA_PX] = Sample::SIGMA_PX;
        let mut fields = line.split(|byte| *byte == b',');
        let mut scan = 0;
        for (index, column) in self.columns.iter().enumerate() {
            let Some(field) = fields.next() else {
                return Err(RowProblem::Fields { fields: index, columns: self.columns.len() });
            };
            match column {
                None => {}
                Some(SCAN) => scan = scan_number(field.trim_ascii())?,
                Some(column) => values[*column] = number(*column, field.trim_ascii())?,
            }
        }
        let more = fields.count();
        if more > 0 {
            let columns = self.columns.len();
            return Err(RowProblem::Fields { fields: columns + more, columns });
        }
        let [u, v, x, y, z, _, sigma_px, sigma_m] = values;
        Ok(Sample { pixel: Point2::new(u, v), point: Point3::new(x, y, z), scan, sigma_px, sigma_m })
    }
}

fn number(column: usize, field: &[u8]) -> Result<f64, RowProblem> {
    let parsed: Option<f64> = std::str::from_utf8(field).ok().and_then(|text| text.parse().ok());
    let column_name = NAMES[column];
    let Some(value) = parsed else {
        return Err(RowProblem::NotANumber { column: column_name, field: shown(field) });
    };
    if !value.is_finite() {
        return Err(RowProblem::NotFinite { column: column_name, field: shown(field) });
    }
    let needed = match column {
        SIGMA_PX if value <= 0.0 => "a deviation of a pixel is above 0",
        SIGMA_M if value < 0.0 => "a deviation is not below 0",
        _ if value.abs() > FARTHEST => "no projector or camera reaches as far as 1e6",
        _ => return Ok(value),
    };
    Err(RowProblem::OutOfRange { column: column_name, field: shown(field), needed })
}

/// A whole number, with or without a point: tables of other programs make fractions of all columns.
fn scan_number(field: &[u8]) -> Result<u32, RowProblem> {
    let text = std::str::from_utf8(field).unwrap_or_default();
    if let Ok(scan) = text.parse() {
        return Ok(scan);
    }
    match text.parse::<f64>() {
        Ok(value) if !value.is_finite() => Err(RowProblem::NotFinite { column: NAMES[SCAN], field: shown(field) }),
        Ok(value) if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) => Ok(value as u32),
        _ => Err(RowProblem::NotAScan(shown(field))),
    }
}

/// A field as an error repeats it: short, on one line.
fn shown(field: &[u8]) -> String {
    let text = String::from_utf8_lossy(field);
    let mut shown: String = text.chars().take(SHOWN_CHARACTERS).flat_map(char::escape_debug).collect();
    if text.chars().nth(SHOWN_CHARACTERS).is_some() {
        shown.push('…');
    }
    shown
}

/// Whether a line is neither blank nor a comment.
fn has_contents(line: &[u8]) -> bool {
    !matches!(line.trim_ascii_start().first(), None | Some(b'#'))
}

/// The first line without its end, and what follows.
fn split_line(text: &[u8]) -> (&[u8], &[u8]) {
    match text.iter().position(|byte| *byte == b'\n') {
        Some(end) => (&text[..end], &text[end + 1..]),
        None => (text, &[]),
    }
}

/// The text cut at ends of lines.
fn pieces(mut text: &[u8]) -> Vec<&[u8]> {
    let mut pieces = Vec::with_capacity(text.len() / PIECE_BYTES + 1);
    while text.len() > PIECE_BYTES {
        let end = text[PIECE_BYTES..].iter().position(|byte| *byte == b'\n');
        let end = end.map_or(text.len(), |end| PIECE_BYTES + end + 1);
        pieces.push(&text[..end]);
        text = &text[end..];
    }
    pieces.push(text);
    pieces
}
