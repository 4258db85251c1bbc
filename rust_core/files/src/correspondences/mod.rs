//! Correspondences as text: which projector pixel lights which point, or which of the camera's pixels.
//!
//! `points.csv` has a header and a row for each point; the camera's optical frame, metres, and the projector's pixels:
//!
//! ```csv
//! u_px,v_px,x_m,y_m,z_m,scan,sigma_px,sigma_m
//! 612.2500,388.7500,-0.041250,0.102310,1.254000,0,0.2500,0.0012
//! ```
//!
//! Columns come in any order; `scan`, `sigma_px` and `sigma_m` (see [`rcs_calibration::Sample`]) may be missing. Blank
//! lines and those that begin with `#` are skipped; quotes are not known. `pixels.csv` has the columns
//! `cam_u_px,cam_v_px,u_px,v_px`.
//!
//! **Numbers of scans belong to their file.** A file without the column is one scan, number 0. If several files are
//! read, a number that two of them have means two scans: the numbers of a file that shares one with the files before
//! are shifted, all by the same, so that they begin after the largest. [`Points::scans`] says what became of which.

mod error;
mod parse;
mod write;

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use nalgebra::Point3;
use rcs_calibration::Sample;

pub use error::{PointsError, RowProblem};
pub use write::{write_pixels, write_points, PointColumns};

/// The most bytes of a file.
pub const MOST_BYTES: u64 = 4 << 30;
/// The most points of all files together.
pub const MOST_POINTS: usize = 50_000_000;

/// The points of one or several files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Points {
    /// All points, in the order of the files and their rows.
    pub samples: Vec<Sample>,
    /// Where each scan is from, in rising order of [`Scan::number`].
    pub scans: Vec<Scan>,
    /// Columns that have no meaning; each is a phrase that names the file.
    pub warnings: Vec<String>,
}

/// A scan among the points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scan {
    /// Its number in the samples.
    pub number: u32,
    /// The file that it is from.
    pub path: PathBuf,
    /// Its number in that file; 0 if that has no numbers.
    pub number_in_file: u32,
}

/// Reads places of things: a file with the columns `x_m`, `y_m` and `z_m`; pixels in it are not looked at.
///
/// # Errors
/// [`PointsError`] with the file and, where there is one, the line.
pub fn read_places(path: &Path) -> Result<Vec<Point3<f64>>, PointsError> {
    let parsed = parse::parse(path, &read_bytes(path)?, parse::NEEDED_BY_PLACES)?;
    Ok(parsed.samples.into_iter().map(|sample| sample.point).collect())
}

impl Points {
    /// Reads files.
    ///
    /// # Errors
    /// [`PointsError`] with the file and, where there is one, the line.
    pub fn read<P: AsRef<Path>>(paths: &[P]) -> Result<Self, PointsError> {
        let mut points = Self::default();
        for path in paths {
            let path = path.as_ref();
            let bytes = read_bytes(path)?;
            points.add(path, &bytes)?;
        }
        points.scans.sort_by_key(|scan| scan.number);
        Ok(points)
    }

    /// Reads the text of one file; `path` only names it in errors.
    ///
    /// # Errors
    /// [`PointsError`] with the file and, where there is one, the line.
    pub fn parse(path: &Path, text: &[u8]) -> Result<Self, PointsError> {
        let mut points = Self::default();
        points.add(path, text)?;
        Ok(points)
    }

    fn add(&mut self, path: &Path, text: &[u8]) -> Result<(), PointsError> {
        let parse::Parsed { mut samples, ignored_columns } = parse::parse(path, text, parse::NEEDED)?;
        if self.samples.len() + samples.len() > MOST_POINTS {
            return Err(PointsError::TooMany { path: path.to_owned(), most: MOST_POINTS });
        }
        let numbers: BTreeSet<u32> = distinct_scans(&samples);
        let shift = self.shift_of(&numbers).ok_or_else(|| PointsError::ScanNumbers { path: path.to_owned() })?;
        samples.iter_mut().for_each(|sample| sample.scan += shift);
        self.scans.extend(numbers.into_iter().map(|number_in_file| Scan {
            number: number_in_file + shift,
            path: path.to_owned(),
            number_in_file,
        }));
        self.warnings.extend(
            ignored_columns
                .iter()
                .map(|name| format!("{}: column '{name}' is not known and is ignored", path.display())),
        );
        if self.samples.is_empty() {
            self.samples = samples;
        } else {
            self.samples.append(&mut samples);
        }
        Ok(())
    }

    /// What to add to a file's numbers so that none is that of an earlier file; none if they would be too large.
    fn shift_of(&self, numbers: &BTreeSet<u32>) -> Option<u32> {
        if !self.scans.iter().any(|scan| numbers.contains(&scan.number)) {
            return Some(0);
        }
        let (Some(first), Some(last)) = (numbers.first(), numbers.last()) else { return Some(0) };
        let next = self.scans.iter().map(|scan| scan.number).max()?.checked_add(1)?;
        // A number that is taken is not above the largest one, so the first is not above the next.
        let shift = next - first;
        last.checked_add(shift).map(|_| shift)
    }
}

/// The numbers of the scans.
fn distinct_scans(samples: &[Sample]) -> BTreeSet<u32> {
    let mut numbers = BTreeSet::new();
    let mut before = None;
    for sample in samples {
        // Mostly, those of one scan follow one another.
        if before != Some(sample.scan) {
            before = Some(sample.scan);
            numbers.insert(sample.scan);
        }
    }
    numbers
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, PointsError> {
    let read_error = |source| PointsError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(read_error)?;
    let size = file.metadata().map_err(read_error)?.len();
    let mut bytes = Vec::with_capacity(size.min(MOST_BYTES) as usize);
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(read_error)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(PointsError::TooLong { path: path.to_owned(), most_bytes: MOST_BYTES });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests;
