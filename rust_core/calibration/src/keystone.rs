//! Whether the projector distorts its picture.
//!
//! A keystone correction is a homography of the picture: it leaves a pinhole a pinhole, but one that is skewed, or
//! whose pixels are not square. A scaled picture's pixels are not square, either. Both show in a solution; a first one
//! rests on the crossings of coarse stripes, so that a scan need not be taken to its end.

use crate::solve::skew_of_all;
use crate::{crossings, solve, Lens, Parameter, Pictures, Refusal, Skew, Solution, SolveOptions};

/// Focal lengths that differ by more are not those of square pixels.
const SQUARE_PIXELS: f64 = 0.02;
/// A picture whose K has a larger skew, as a share of the focal length, is distorted by the projector,
const NO_SKEW: f64 = 0.003;
/// if this is not by chance: deviations.
const SIGNIFICANT: f64 = 4.0;
/// A skew that cannot be by chance, as a share of the focal length, if half of the crossings agree with it to this
/// share of what it moves the picture's edge by; a lens's distortion is among that.
const MUCH_SKEW: f64 = 0.02;
const AGREEING: f64 = 0.2;
/// Fewer crossings determine no lens that is to be trusted.
const LEAST_CROSSINGS: usize = 24;

/// What the first stripes of a scan tell of the picture. Shown, it says what to do.
#[derive(Debug, Clone, PartialEq)]
pub enum Keystone {
    /// The picture is skewed: nothing that is scanned determines the projector's lens.
    Skewed(String),
    /// Its pixels are not square.
    Stretched(String),
}

impl Keystone {
    /// What the coarse stripes, white and black of a scan tell, with depths as for [`crate::points`]; none if nothing
    /// is wrong, or if they do not determine a lens, as before a flat wall.
    pub fn find(pictures: &Pictures<'_>, depth_m: &[f32], camera: &Lens, projector_px: [u32; 2]) -> Option<Self> {
        let samples = crossings(pictures, depth_m, camera).ok().filter(|samples| samples.len() >= LEAST_CROSSINGS)?;
        match solve(&samples, &SolveOptions::new(projector_px)) {
            Ok(solution) => skewed(&solution).map(Self::Skewed).or_else(|| stretched(&solution).map(Self::Stretched)),
            // A picture that is skewed a lot has no solution without a skew.
            Err(
                Refusal::Moved { .. }
                | Refusal::TwoPoses { .. }
                | Refusal::FewInliers { .. }
                | Refusal::Inconsistent { .. }
                | Refusal::NoSolution { .. }
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

/// How skewed the picture is, if it is.
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

/// How far from square its pixels are, if they are.
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
