//! Imperfections of a scan: light, lenses, sensor, and user errors.

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};

use crate::Random;

/// Conditions of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// Focus distance of the projector, metres.
    pub focus_m: f64,
    /// Projector blur in focus: standard deviation, projector pixels.
    pub sharpest_px: f64,
    /// Projector blur out of focus: standard deviation, projector pixels per dioptre (1/m).
    pub defocus_px: f64,
    /// Light of a black projector pixel as a share of a white one's.
    pub black_level: f64,
    /// Ambient light as a share of the projector's white at 1 m.
    pub ambient: f64,
    /// Strength of interreflections: 1 is physical, 0 is none.
    pub interreflection: f64,
    /// Share of the image's mean light that the camera's lens scatters everywhere.
    pub scatter: f64,
    /// Camera blur without its pixels' extent: standard deviation, camera pixels.
    pub camera_blur_px: f64,
    /// Electrons of a just white pixel; shot noise is their square root.
    pub full_well: f64,
    /// Read noise: standard deviation, electrons.
    pub read_noise: f64,
    /// Gamma: level = light ^ (1 / gamma).
    pub gamma: f64,
    /// Share of the full well at the 99.5th percentile of the white image; values above 1 clip.
    pub exposure: f64,
    /// Relative growth of the exposure from each image to the next.
    pub drift_per_image: f64,
    /// Relative random change of an image's brightness: standard deviation.
    pub flicker: f64,
    /// Motion of the camera during the scan.
    pub motion: Option<Motion>,
    /// Homography from pixels of the projector's panel, as in a [`View`](crate::View), to those of the displayed image,
    /// for mirrored or keystone-corrected images.
    pub image_from_panel: Matrix3<f64>,
    /// Seed of the noise.
    pub seed: u64,
}

/// Single motion of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// First image after the motion.
    pub from_image: u32,
    /// Shift of the image's content, camera pixels.
    pub shift_px: Vector2<f64>,
}

impl Conditions {
    /// Sharp, dark and noise-free; levels have 8 bits.
    pub fn ideal() -> Self {
        Self {
            focus_m: 1.3,
            sharpest_px: 0.3,
            defocus_px: 0.0,
            black_level: 0.0,
            ambient: 0.0,
            interreflection: 0.0,
            scatter: 0.0,
            camera_blur_px: 0.0,
            full_well: f64::INFINITY,
            read_noise: 0.0,
            gamma: 1.0,
            exposure: 0.9,
            drift_per_image: 0.0,
            flicker: 0.0,
            motion: None,
            image_from_panel: Matrix3::identity(),
            seed: 0,
        }
    }

    /// Random conditions of a room with some daylight, a cheap projector and a Kinect's camera.
    pub fn random(seed: u64) -> Self {
        let random = &mut Random::new(&[seed, 0x434f_4e44]);
        let mut uniform = |low, high| random.uniform(low, high);
        Self {
            focus_m: uniform(1.0, 1.6),
            sharpest_px: uniform(0.4, 0.8),
            defocus_px: uniform(0.8, 3.0),
            black_level: uniform(0.01, 0.03),
            ambient: uniform(0.03, 0.25),
            interreflection: uniform(0.8, 1.2),
            scatter: uniform(0.01, 0.04),
            camera_blur_px: uniform(0.35, 0.7),
            full_well: uniform(4000.0, 10_000.0),
            read_noise: uniform(6.0, 15.0),
            gamma: uniform(1.0, 2.2),
            exposure: uniform(0.75, 0.92),
            flicker: uniform(0.0, 0.004),
            seed,
            ..Self::ideal()
        }
    }

    /// Mirrors left to right, as for rear projection, for a projector of a width.
    pub fn mirrored(width_px: u32) -> Matrix3<f64> {
        Matrix3::new(-1.0, 0.0, f64::from(width_px) - 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    }

    /// Keystone correction of a 1280×800 projector for a wall rotated about the image's rows and columns, degrees, by
    /// electronics that know the throw but not the principal point.
    pub fn keystone(about_rows: f64, about_columns: f64) -> Matrix3<f64> {
        let lens = Matrix3::new(1400.0, 0.0, 639.5, 0.0, 1400.0, 399.5, 0.0, 0.0, 1.0);
        let [about_rows, about_columns] = [about_rows, about_columns].map(f64::to_radians);
        let rotation = Rotation3::from_axis_angle(&Vector3::x_axis(), about_rows)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), about_columns);
        lens * rotation.into_inner() * lens.try_inverse().unwrap_or_else(Matrix3::identity)
    }

    /// Keystone correction that keeps the image's lower edge and narrows the upper one to a share above 0, up to 1.
    pub fn trapezoid(size_px: [u32; 2], upper: f64) -> Matrix3<f64> {
        let [right, bottom] = size_px.map(|size| f64::from(size) - 1.0);
        let left = 0.5 * (1.0 - upper) * right;
        let panel_from_image =
            Matrix3::new(upper, -left / bottom, left, 0.0, upper, 0.0, 0.0, (upper - 1.0) / bottom, 1.0);
        panel_from_image.try_inverse().unwrap_or_else(Matrix3::identity)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;

    #[test]
    fn homographies_map_the_corners() {
        let keystone = Conditions::trapezoid([1280, 800], 0.8);
        let at = |matrix: &Matrix3<f64>, x, y| matrix.transform_point(&Point2::new(x, y));
        assert!((at(&keystone, 0.0, 799.0) - Point2::new(0.0, 799.0)).norm() < 1e-9);
        assert!((at(&keystone, 1279.0, 799.0) - Point2::new(1279.0, 799.0)).norm() < 1e-9);
        assert!((at(&keystone, 127.9, 0.0) - Point2::new(0.0, 0.0)).norm() < 1e-9);
        assert!((at(&keystone, 1151.1, 0.0) - Point2::new(1279.0, 0.0)).norm() < 1e-9);
        assert!((at(&Conditions::mirrored(1280), 0.0, 7.0) - Point2::new(1279.0, 7.0)).norm() < 1e-9);
    }
}
