//! Reprojection errors of a projector at points whose pixel is known.

use nalgebra::Isometry3;

use crate::statistics::root_mean_square;
use crate::{Lens, Sample};

/// Statistics of the distances between observed and predicted projector pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReprojectionError {
    /// Number of compared points; those behind the projector are skipped.
    pub count: usize,
    /// RMS without the largest 1 %, pixels.
    pub rms_px: f64,
    /// RMS without the largest 1 %, at the points' depths, metres.
    pub rms_m: f64,
    /// Median, pixels.
    pub median_px: f64,
    /// Maximum without the largest 1 %, pixels.
    pub max_px: f64,
}

impl ReprojectionError {
    /// Measures the errors of samples under a lens and a pose.
    pub fn measure(samples: &[Sample], lens: &Lens, projector_from_camera: &Isometry3<f64>) -> Self {
        let mut errors: Vec<[f64; 2]> = samples
            .iter()
            .filter_map(|sample| {
                let point = projector_from_camera * sample.point;
                let error = sample.pixel - lens.project(&point)?;
                Some([error.norm(), error.component_div(&lens.focal_px).norm() * point.z])
            })
            .collect();
        errors.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let trimmed = &errors[..errors.len() - errors.len() / 100];
        let rms = |unit: usize| root_mean_square(trimmed.iter().map(|error| error[unit]));
        Self {
            count: errors.len(),
            rms_px: rms(0),
            rms_m: rms(1),
            median_px: errors.get(errors.len() / 2).map_or(0.0, |error| error[0]),
            max_px: trimmed.last().map_or(0.0, |error| error[0]),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point2, Point3, Vector2, Vector3};

    use super::*;

    #[test]
    fn a_shift_is_measured_in_pixels_and_metres() {
        let lens = Lens::pinhole([1280, 800], [1000.0, 1000.0], [640.0, 400.0]);
        let pose = Isometry3::translation(0.2, 0.0, 0.0);
        let sample = |index: i32, shift: Vector2<f64>| {
            let point = Point3::new(0.01 * f64::from(index % 20), 0.1, 2.0);
            Sample::new(lens.project(&(pose * point)).unwrap() + shift, point)
        };
        let shifted: Vec<Sample> = (0..200).map(|index| sample(index, Vector2::new(3.0, 4.0))).collect();
        let error = ReprojectionError::measure(&shifted, &lens, &pose);
        assert_eq!(error.count, 200);
        assert!((error.rms_px - 5.0).abs() < 1e-9 && (error.median_px - 5.0).abs() < 1e-9);
        assert!((error.rms_m - 0.01).abs() < 1e-9, "5 px of f 1000 at 2 m");
        // A few gross errors of decoding do not count.
        let mut with_errors = shifted.clone();
        with_errors[7].pixel = Point2::new(1e4, 0.0);
        assert!((ReprojectionError::measure(&with_errors, &lens, &pose).rms_px - 5.0).abs() < 1e-9);
        let behind = Isometry3::from(Vector3::new(0.0, 0.0, -5.0));
        assert_eq!(ReprojectionError::measure(&shifted, &lens, &behind).count, 0);
        assert_eq!(ReprojectionError::measure(&[], &lens, &pose).count, 0);
    }
}
