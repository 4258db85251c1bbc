//! Projection error of a calibration over the working volume.

use nalgebra::{Isometry3, Point2, Point3};
use rcs_calibration::Lens;

/// Depths before the projector, metres.
const DEPTHS_M: [f64; 8] = [0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0];
/// Columns and rows of the grid over the projector's image.
const GRID: [u32; 2] = [17, 11];

/// Projection error of a calibrated projector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightError {
    /// RMS over the image and depths from 0.6 to 2 m, projector pixels; infinite if all places are lost.
    pub rms_px: f64,
    /// Maximum, projector pixels.
    pub max_px: f64,
    /// RMS at the depth of each place, metres.
    pub rms_m: f64,
    /// Maximum, metres.
    pub max_m: f64,
    /// Number of places.
    pub count: usize,
    /// Number of places that the calibration cannot project; they do not count in the errors.
    pub lost: usize,
}

impl LightError {
    /// Compares a calibration with the truth: lenses, and the poses `projector_from_camera`.
    ///
    /// For points in the camera's frame, the error is the distance between the projector pixels by the calibration and
    /// by the truth, and the distance of the former's light from the point.
    pub fn between(truth: (&Lens, &Isometry3<f64>), calibrated: (&Lens, &Isometry3<f64>)) -> Self {
        let (true_lens, true_pose) = truth;
        let (lens, pose) = calibrated;
        let [width, height] = true_lens.size_px.map(f64::from);
        let mut error = Self { rms_px: 0.0, max_px: 0.0, rms_m: 0.0, max_m: 0.0, count: 0, lost: 0 };
        let mut known = 0.0;
        for (row, column) in (0..GRID[1]).flat_map(|row| (0..GRID[0]).map(move |column| (row, column))) {
            let share = |at: u32, of: u32| f64::from(at) / f64::from(of - 1);
            let pixel = Point2::new(share(column, GRID[0]) * (width - 1.0), share(row, GRID[1]) * (height - 1.0));
            let Some(place) = true_lens.plane(pixel) else { continue };
            for depth_m in DEPTHS_M {
                error.count += 1;
                let in_camera = true_pose.inverse_transform_point(&Point3::from(place.coords.push(1.0) * depth_m));
                let Some(lit) = lens.project(&(pose * in_camera)) else {
                    error.lost += 1;
                    continue;
                };
                let off_px = (lit - pixel).norm();
                // Where the true lens has no ray, its focal length gives an approximation.
                let off = true_lens.plane(lit).map(|lit| (lit - place).norm());
                let off_m = depth_m * off.unwrap_or_else(|| (lit - pixel).component_div(&true_lens.focal_px).norm());
                error.rms_px += off_px * off_px;
                error.rms_m += off_m * off_m;
                error.max_px = error.max_px.max(off_px);
                error.max_m = error.max_m.max(off_m);
                known += 1.0;
            }
        }
        let root_mean = |sum: f64| if known > 0.0 { (sum / known).sqrt() } else { f64::INFINITY };
        error.rms_px = root_mean(error.rms_px);
        error.rms_m = root_mean(error.rms_m);
        error
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, Vector2};

    use super::*;
    use crate::Rig;

    #[test]
    fn the_truth_has_no_error() {
        let rig = Rig::random(2);
        let pose = rig.projector_from_camera();
        let error = LightError::between((&rig.projector, &pose), (&rig.projector, &pose));
        assert!(error.max_px < 1e-6 && error.max_m < 1e-9 && error.lost == 0, "{error:?}");
        assert_eq!(error.count, 17 * 11 * 8);
    }

    #[test]
    fn errors_are_those_of_the_lens_and_the_pose() {
        let rig = Rig::random(2);
        let pose = rig.projector_from_camera();
        let mut lens = rig.projector;
        lens.center_px += Vector2::new(3.0, 4.0);
        let error = LightError::between((&rig.projector, &pose), (&lens, &pose));
        assert!((error.rms_px - 5.0).abs() < 1e-6 && (error.max_px - 5.0).abs() < 1e-6);
        let pinhole = Lens { distortion: rcs_calibration::Distortion::NONE, ..rig.projector };
        let moved = Translation3::new(0.01, 0.0, 0.0) * pose;
        let error = LightError::between((&pinhole, &pose), (&pinhole, &moved));
        // 1 cm off is 1 cm off at every depth.
        assert!((error.rms_m - 0.01).abs() < 1e-9 && (error.max_m - 0.01).abs() < 1e-9, "{error:?}");
    }
}
