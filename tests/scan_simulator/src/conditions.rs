//! What makes pictures of a scan worse than the patterns: light, lenses, sensor, and what people do wrong.

use nalgebra::{Matrix3, Vector2};

use crate::Random;

/// The conditions of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// At which depth the projector's picture is sharp, metres.
    pub focus_m: f64,
    /// The projector's blur there: standard deviation, projector pixels.
    pub sharpest_px: f64,
    /// How much blur there is out of focus: standard deviation, projector pixels for each dioptre (1/m) off the focus.
    pub defocus_px: f64,
    /// The light of a black projector pixel as a share of a white one's.
    pub black_level: f64,
    /// The room's own light as a share of the projector's white 1 m away.
    pub ambient: f64,
    /// How much of the light between surfaces counts: 1 for what physics says, 0 for none.
    pub interreflection: f64,
    /// The mean light of the picture that the camera's lens scatters everywhere, as a share.
    pub scatter: f64,
    /// The camera's blur besides its pixels' extent: standard deviation, camera pixels.
    pub camera_blur_px: f64,
    /// Electrons of a pixel that is just white: shot noise is their square root.
    pub full_well: f64,
    /// The sensor's read noise: standard deviation, electrons.
    pub read_noise: f64,
    /// A level is light to the power of 1/gamma.
    pub gamma: f64,
    /// How much of the full well the brightest places fill when the projector is white; the brightest 0.5 % of the
    /// picture are not looked at. Above 1 they clip.
    pub exposure: f64,
    /// By which share the camera's exposure grows from each picture to the next.
    pub drift_per_picture: f64,
    /// By which share the brightness of a picture differs at random: standard deviation.
    pub flicker: f64,
    /// The camera moves during the scan.
    pub motion: Option<Motion>,
    /// Takes pixels of the projector's panel to those of the picture that it shows, where a mirrored,
    /// keystone-corrected or scaled picture differs from the panel: a homography. A [`View`](crate::View) tells pixels
    /// of the panel.
    pub picture_from_panel: Matrix3<f64>,
    /// The noise follows from it.
    pub seed: u64,
}

/// The camera moves once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// The first picture taken from the other place.
    pub from_picture: u32,
    /// By how much everything in the picture has moved then, camera pixels.
    pub shift_px: Vector2<f64>,
}

impl Conditions {
    /// Sharp, dark and without noise; only levels are still 8 bits.
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
            drift_per_picture: 0.0,
            flicker: 0.0,
            motion: None,
            picture_from_panel: Matrix3::identity(),
            seed: 0,
        }
    }

    /// What a room with some daylight, a cheap projector and a Kinect's camera may be like.
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

    /// The picture shown mirrored left to right, as for rear projection, by a projector so many pixels wide.
    pub fn mirrored(width_px: u32) -> Matrix3<f64> {
        Matrix3::new(-1.0, 0.0, f64::from(width_px) - 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    }

    /// A picture of one size shown on all of a panel of another one.
    pub fn scaled(picture_px: [u32; 2], panel_px: [u32; 2]) -> Matrix3<f64> {
        let scale = |axis: usize| f64::from(picture_px[axis]) / f64::from(panel_px[axis]);
        let (x, y) = (scale(0), scale(1));
        Matrix3::new(x, 0.0, 0.5 * x - 0.5, 0.0, y, 0.5 * y - 0.5, 0.0, 0.0, 1.0)
    }

    /// A keystone correction: the picture's lower edge fills the panel, the upper one a share of it in the middle
    /// (above 0, up to 1).
    pub fn keystone(size_px: [u32; 2], upper: f64) -> Matrix3<f64> {
        let [right, bottom] = size_px.map(|size| f64::from(size) - 1.0);
        let left = 0.5 * (1.0 - upper) * right;
        let panel_from_picture =
            Matrix3::new(upper, -left / bottom, left, 0.0, upper, 0.0, 0.0, (upper - 1.0) / bottom, 1.0);
        panel_from_picture.try_inverse().unwrap_or_else(Matrix3::identity)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;

    #[test]
    fn corners_of_the_picture_are_where_they_should_be() {
        let keystone = Conditions::keystone([1280, 800], 0.8);
        let at = |matrix: &Matrix3<f64>, x, y| matrix.transform_point(&Point2::new(x, y));
        assert!((at(&keystone, 0.0, 799.0) - Point2::new(0.0, 799.0)).norm() < 1e-9);
        assert!((at(&keystone, 1279.0, 799.0) - Point2::new(1279.0, 799.0)).norm() < 1e-9);
        assert!((at(&keystone, 127.9, 0.0) - Point2::new(0.0, 0.0)).norm() < 1e-9);
        assert!((at(&keystone, 1151.1, 0.0) - Point2::new(1279.0, 0.0)).norm() < 1e-9);
        let scaled = Conditions::scaled([1024, 768], [1280, 800]);
        assert!((at(&scaled, -0.5, 799.5) - Point2::new(-0.5, 767.5)).norm() < 1e-9);
        assert!((at(&Conditions::mirrored(1280), 0.0, 7.0) - Point2::new(1279.0, 7.0)).norm() < 1e-9);
    }
}
