//! Writer of correspondences: pixels with four decimals, metres with six.

use std::io::{self, Write};
use std::path::Path;

use nalgebra::Point2;
use rcs_calibration::Sample;

use super::{distinct_scans, PointsError};
use crate::atomic_file::write_atomically;

/// Optional columns of a file of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PointColumns {
    /// `scan` if there are several.
    #[default]
    Plain,
    /// Also `sigma_px` and `sigma_m`.
    WithSigmas,
}

/// Writes `points.csv` atomically, replacing an existing file. The folder must exist.
///
/// # Errors
/// [`PointsError::Write`].
pub fn write_points(path: &Path, samples: &[Sample], columns: PointColumns) -> Result<(), PointsError> {
    let has_scans = distinct_scans(samples).len() > 1;
    let has_sigmas = columns == PointColumns::WithSigmas;
    write(path, |file| {
        file.write_all(b"u_px,v_px,x_m,y_m,z_m")?;
        file.write_all(if has_scans { b",scan" } else { b"" })?;
        file.write_all(if has_sigmas { b",sigma_px,sigma_m\n" } else { b"\n" })?;
        for Sample { pixel, point, scan, sigma_px, sigma_m } in samples {
            let (u, v, x, y, z) = (pixel.x, pixel.y, point.x, point.y, point.z);
            write!(file, "{u:.4},{v:.4},{x:.6},{y:.6},{z:.6}")?;
            if has_scans {
                write!(file, ",{scan}")?;
            }
            if has_sigmas {
                // Zero would be no valid deviation.
                write!(file, ",{:.4},{sigma_m:.6}", sigma_px.max(0.0001))?;
            }
            file.write_all(b"\n")?;
        }
        Ok(())
    })
}

/// Writes `pixels.csv` atomically, replacing an existing file: camera pixels (u, v) with the projector pixels that
/// light them. The folder must exist.
///
/// # Errors
/// [`PointsError::Write`].
pub fn write_pixels(path: &Path, pixels: impl IntoIterator<Item = ([u32; 2], Point2<f64>)>) -> Result<(), PointsError> {
    write(path, |file| {
        file.write_all(b"cam_u_px,cam_v_px,u_px,v_px\n")?;
        for ([cam_u, cam_v], pixel) in pixels {
            writeln!(file, "{cam_u},{cam_v},{:.4},{:.4}", pixel.x, pixel.y)?;
        }
        Ok(())
    })
}

fn write(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), PointsError> {
    let io_error = |source| PointsError::Write { path: path.to_owned(), source };
    write_atomically(path, |file| write(file).map_err(io_error), io_error)
}
