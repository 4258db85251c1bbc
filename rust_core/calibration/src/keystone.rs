//! Keystone detection: whether the projector distorts its image.
//!
//! A keystone correction is a homography of the image: a pinhole stays a pinhole, but with skew or with pixels that are
//! not square. Scaling makes pixels that are not square, too. Both show in a solution; an early one uses the crossings
//! of coarse stripes, so that a bad scan can be stopped.

use crate::solve::skew_of_all;
use crate::{crossings, solve, Images, Lens, Parameter, Refusal, Skew, Solution, SolveOptions};

/// Maximum relative difference of the focal lengths of square pixels.
pub(crate) const SQUARE_PIXELS: f64 = 0.02;
/// Maximum skew of an undistorted image: as a share of the focal length,
const NO_SKEW: f64 = 0.003;
/// and in standard deviations.
const SIGNIFICANT: f64 = 4.0;
/// Certain skew, as a share of the focal length, if the median residual is at most this share of the skew's effect at
/// the image's edge; the residual includes lens distortion.
const MUCH_SKEW: f64 = 0.02;
const AGREEING: f64 = 0.2;
/// Minimum number of crossings for a trustworthy lens.
const LEAST_CROSSINGS: usize = 24;

/// Image distortion by the projector, with advice as text.
#[derive(Debug, Clone, PartialEq)]
pub enum Keystone {
    /// The image is skewed: no scan of it determines the lens.
    Skewed(String),
    /// The pixels are not square.
    Stretched(String),
}

impl Keystone {
    /// Detects a distortion from the coarse stripes, white and black of a scan, with depths as for [`crate::points`].
    /// `None` if there is none, or if the stripes do not determine a lens, as on a flat wall.
    pub fn find(images: &Images<'_>, depth_m: &[f32], camera: &Lens, projector_px: [u32; 2]) -> Option<Self> {
        let samples = crossings(images, depth_m, camera).ok().filter(|samples| samples.len() >= LEAST_CROSSINGS)?;
        match solve(&samples, &SolveOptions::new(projector_px)) {
            Ok(solution) => skewed(&solution).map(Self::Skewed).or_else(|| stretched(&solution).map(Self::Stretched)),
            // A large skew leaves no solution without one.
            Err(
                Refusal::Moved { .. }
                | Refusal::TwoPoses { .. }
                | Refusal::FewInliers { .. }
                | Refusal::Inconsistent(_)
                | Refusal::NoSolution(_)
                | Refusal::Unpredictive { .. },
            ) => {
                let (skew, typical_px) = skew_of_all(&samples, projector_px)?;
                let is_certain =
                    skew.abs() > MUCH_SKEW && typical_px < AGREEING * skew.abs() * 0.5 * f64::from(projector_px[0]);
                is_certain.then(|| Self::Skewed(advice(skew.abs(), "")))
            }
            Err(_) => None,
        }
    }
}

/// Reason text if the solution has a significant skew.
pub(crate) fn skewed(solution: &Solution) -> Option<String> {
    let Skew { value_px, sigma_px } = solution.skew?;
    let focal_px = solution.lens.focal_px.min();
    (value_px.abs() > (NO_SKEW * focal_px).max(SIGNIFICANT * sigma_px))
        .then(|| advice(value_px.abs() / focal_px, &format!(" (K[0][1] would be {value_px:.1} ± {sigma_px:.1} px)")))
}

fn advice(skew: f64, figures: &str) -> String {
    format!(
        "keystone correction seems to be on, the picture is skewed by {:.1} %{figures}: turn it off in the projector's \
         menu and scan again",
        100.0 * skew
    )
}

/// Reason text if the solution's pixels are not square.
pub(crate) fn stretched(solution: &Solution) -> Option<String> {
    let is_free = |parameter| matches!(parameter, Parameter::Fx | Parameter::Fy);
    let is_solved = solution.estimates.iter().any(|estimate| is_free(estimate.parameter) && estimate.sigma > 0.0);
    let differ = (solution.lens.focal_px.x / solution.lens.focal_px.y - 1.0).abs();
    (is_solved && differ > SQUARE_PIXELS).then(|| {
        format!(
            "fx and fy differ by {:.1} %, but a projector's pixels are square: switch keystone correction and scaling \
             off, set the native resolution",
            100.0 * differ
        )
    })
}
