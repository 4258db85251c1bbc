//! Parser of `points.csv`. Of several invalid lines the first is reported.

use std::ops::Range;
use std::path::Path;

use nalgebra::{Point2, Point3};
use rcs_calibration::Sample;

use super::{PointsError, RowProblem};

/// Maximum coordinate, pixels and metres: the squares of larger ones lose significant digits.
const FARTHEST: f64 = 1e6;
/// Maximum characters of a field that an error quotes.
const QUOTED_CHARACTERS: usize = 40;

/// Known columns.
const NAMES: [&str; 8] = ["u_px", "v_px", "x_m", "y_m", "z_m", "scan", "sigma_px", "sigma_m"];
/// Required columns of correspondences.
pub(super) const NEEDED: Range<usize> = 0..5;
/// Required columns of places.
pub(super) const NEEDED_BY_PLACES: Range<usize> = 2..5;
const SCAN: usize = 5;
const SIGMA_PX: usize = 6;
const SIGMA_M: usize = 7;

/// Parsed file.
pub(super) struct Parsed {
    pub(super) samples: Vec<Sample>,
    pub(super) ignored_columns: Vec<String>,
}

/// Header line.
struct CsvHeader {
    /// Index in [`NAMES`] of each column of the file.
    columns: Vec<Option<usize>>,
    ignored: Vec<String>,
}

/// Parses a file with required columns; missing pixels are zero.
pub(super) fn parse(path: &Path, text: &[u8], needed: Range<usize>) -> Result<Parsed, PointsError> {
    let text = rcs_text::decode(text);
    let text = text.as_bytes();
    let lines = text.split(|byte| *byte == b'\n').enumerate().map(|(index, line)| (index + 1, line));
    // Blank lines and comments are skipped.
    let mut lines = lines.filter(|(_, line)| !matches!(line.trim_ascii_start().first(), None | Some(b'#')));
    let row_error = |line, problem| PointsError::Row { path: path.to_owned(), line, problem };
    let (number, line) = lines.next().ok_or_else(|| PointsError::Empty(path.to_owned()))?;
    let header = CsvHeader::parse(line, needed).map_err(|problem| row_error(number, problem))?;
    // A row of five columns has some forty bytes.
    let mut samples = Vec::with_capacity(text.len() / 36);
    for (number, line) in lines {
        samples.push(header.row(line).map_err(|problem| row_error(number, problem))?);
    }
    Ok(Parsed { samples, ignored_columns: header.ignored })
}

impl CsvHeader {
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
                None => header.ignored.push(quoted(name)),
            }
            header.columns.push(column);
        }
        match needed.find(|needed| !header.columns.contains(&Some(*needed))) {
            Some(missing) => Err(RowProblem::MissingColumn(NAMES[missing])),
            None => Ok(header),
        }
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
        return Err(RowProblem::NotANumber { column: column_name, field: quoted(field) });
    };
    if !value.is_finite() {
        return Err(RowProblem::NotFinite { column: column_name, field: quoted(field) });
    }
    let needed = match column {
        SIGMA_PX if value <= 0.0 => "a deviation of a pixel is above 0",
        SIGMA_M if value < 0.0 => "a deviation is not below 0",
        _ if value.abs() > FARTHEST => "no projector or camera reaches as far as 1e6",
        _ => return Ok(value),
    };
    Err(RowProblem::OutOfRange { column: column_name, field: quoted(field), needed })
}

/// Parses a whole number with or without decimals, since other programs write all columns with decimals.
fn scan_number(field: &[u8]) -> Result<u32, RowProblem> {
    let text = std::str::from_utf8(field).unwrap_or_default();
    if let Ok(scan) = text.parse() {
        return Ok(scan);
    }
    match text.parse::<f64>() {
        Ok(value) if !value.is_finite() => Err(RowProblem::NotFinite { column: NAMES[SCAN], field: quoted(field) }),
        Ok(value) if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) => Ok(value as u32),
        _ => Err(RowProblem::NotAScan(quoted(field))),
    }
}

/// Shortens and escapes a field for an error.
fn quoted(field: &[u8]) -> String {
    let text = String::from_utf8_lossy(field);
    let mut quoted: String = text.chars().take(QUOTED_CHARACTERS).flat_map(char::escape_debug).collect();
    if text.chars().nth(QUOTED_CHARACTERS).is_some() {
        quoted.push('…');
    }
    quoted
}
