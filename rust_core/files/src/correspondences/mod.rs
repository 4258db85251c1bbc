//! Correspondences of projector pixels and points, or camera pixels, as CSV.
//!
//! `points.csv` has a header and a row for each point, in the camera's optical frame, metres, and projector pixels:
//!
//! ```csv
//! u_px,v_px,x_m,y_m,z_m,scan,sigma_px,sigma_m
//! 612.2500,388.7500,-0.041250,0.102310,1.254000,0,0.2500,0.0012
//! ```
//!
//! Columns may have any order; `scan`, `sigma_px` and `sigma_m` (see [`rcs_calibration::Sample`]) are optional. Blank
//! lines and those that begin with `#` are skipped; quotes are unsupported. `pixels.csv` has the columns
//! `cam_u_px,cam_v_px,u_px,v_px`.
//!
//! **Scan numbers belong to their file.** A file without the column is one scan, number 0. A number in two files means
//! two scans: all numbers of a file that shares one with the files before are shifted to begin after the largest.
//! [`Correspondences::scans`] has the mapping.

mod error;
mod parse;
mod write;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use nalgebra::Point3;
use rcs_calibration::Sample;

pub use error::{PointsError, RowProblem};
pub use write::{write_pixels, write_points, PointColumns};

/// Maximum bytes of a file.
pub const MOST_BYTES: u64 = 4 << 30;
/// Maximum points of all files together.
pub const MOST_POINTS: usize = 50_000_000;

/// Points of one or several files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Correspondences {
    /// Points in the order of files and rows.
    pub samples: Vec<Sample>,
    /// Origin of each scan, by rising [`Scan::number`].
    pub scans: Vec<Scan>,
    /// Messages about unknown columns, with the file.
    pub warnings: Vec<String>,
}

/// Origin of a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scan {
    /// Number in the samples.
    pub number: u32,
    /// File.
    pub path: PathBuf,
    /// Number in the file; 0 if it has no numbers.
    pub number_in_file: u32,
}

/// Reads places of objects: a file with the columns `x_m`, `y_m` and `z_m`; pixels are ignored.
///
/// # Errors
/// [`PointsError`] with the file and, where there is one, the line.
pub fn read_places(path: &Path) -> Result<Vec<Point3<f64>>, PointsError> {
    let parsed = parse::parse(path, &read_bytes(path)?, parse::NEEDED_BY_PLACES)?;
    Ok(parsed.samples.into_iter().map(|sample| sample.point).collect())
}

impl Correspondences {
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

    /// Parses the text of one file; `path` only names it in errors.
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
        let shift = self.shift_of(&numbers).ok_or_else(|| PointsError::ScanNumbers(path.to_owned()))?;
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
        self.samples.append(&mut samples);
        Ok(())
    }

    /// Shift of a file's numbers past those of the files before; `None` on overflow.
    fn shift_of(&self, numbers: &BTreeSet<u32>) -> Option<u32> {
        if !self.scans.iter().any(|scan| numbers.contains(&scan.number)) {
            return Some(0);
        }
        let (Some(first), Some(last)) = (numbers.first(), numbers.last()) else { return Some(0) };
        let next = self.scans.iter().map(|scan| scan.number).max()?.checked_add(1)?;
        // A shared number is at most the largest one, so `first` is below `next`.
        let shift = next - first;
        last.checked_add(shift).map(|_| shift)
    }
}

/// Scan numbers of samples.
fn distinct_scans(samples: &[Sample]) -> BTreeSet<u32> {
    samples.chunk_by(|a, b| a.scan == b.scan).map(|run| run[0].scan).collect()
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, PointsError> {
    rcs_user_files::read(path, MOST_BYTES).map_err(|source| PointsError::Read { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests;
