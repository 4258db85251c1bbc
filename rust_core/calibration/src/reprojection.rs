//! How far light lands from where it should, by points whose pixel is known.

use nalgebra::Isometry3;

use crate::{Lens, Sample};

/// Distances between the pixels that light points and the pixels that should.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReprojectionError {
    /// How many points were compared; points behind the projector are not.
    pub count: usize,
    /// Root mean square, without the farthest 1 % of the points, pixels.
    pub rms_px: f64,
    /// The same at the points' depths, metres.
    pub rms_m: f64,
    /// The middle one, pixels.
    pub median_px: f64,
    /// The largest without the farthest 1 %, pixels.
    pub most_px: f64,
}

impl ReprojectionError {
    /// Compares samples with a lens and a pose.
    pub fn measure(samples: &[Sample], lens: &Lens, projector_from_camera: &Isometry3<f64>) -> Self {
        let mut misses: Vec<[f64; 2]> = samples
            .iter()
            .filter_map(|sample| {
                let point = projector_from_camera * sample.point;
                let miss = sample.pixel - lens.project(&point)?;
                Some([miss.norm(), miss.component_div(&lens.focal_px).norm() * point.z])
            })
            .collect();
        misses.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let kept = &misses[..misses.len() - misses.len() / 100];
        let rms =
            |index: usize| (kept.iter().map(|miss| miss[index].powi(2)).sum::<f64>() / kept.len().max(1) as f64).sqrt();
        Self {
            count: misses.len(),
            rms_px: rms(0),
            rms_m: rms(1),
            median_px: misses.get(misses.len() / 2).map_or(0.0, |miss| miss[0]),
            most_px: kept.last().map_or(0.0, |miss| miss[0]),
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
        let landed = ReprojectionError::measure(&shifted, &lens, &pose);
        assert_eq!(landed.count, 200);
        assert!((landed.rms_px - 5.0).abs() < 1e-9 && (landed.median_px - 5.0).abs() < 1e-9);
        assert!((landed.rms_m - 0.01).abs() < 1e-9, "5 px of f 1000 at 2 m");
        // A few gross errors of decoding do not count.
        let mut with_errors = shifted.clone();
        with_errors[7].pixel = Point2::new(1e4, 0.0);
        assert!((ReprojectionError::measure(&with_errors, &lens, &pose).rms_px - 5.0).abs() < 1e-9);
        let behind = Isometry3::from(Vector3::new(0.0, 0.0, -5.0));
        assert_eq!(ReprojectionError::measure(&shifted, &lens, &behind).count, 0);
        assert_eq!(ReprojectionError::measure(&[], &lens, &pose).count, 0);
    }
}
