//! Check that a projector still has the zoom of its file.
//!
//! A zoom scales the image, and so does a motion along the axis, at one depth. They differ in the motion of farther and
//! nearer points, and a little before a slanted plane. The deviation of the focal length tells whether that suffices.

use crate::solve::{zoom, ZoomEstimate};
use crate::statistics::{median, quantile};
use crate::{Lens, Sample};

/// Minimum variation of depth that tells a zoom from a motion, as a share of the depth.
const LEAST_VARIATION: f64 = 0.15;
/// Shares of the points that are nearer and farther than the range that counts as the variation.
const ENDS: [f64; 2] = [0.05, 0.95];
/// Minimum number of samples: the deviation of fewer is uncertain itself.
const LEAST_SAMPLES: usize = 12;
/// Minimum share of samples that agree with one zoom and pose.
const LEAST_AGREEING: f64 = 0.5;
/// Minimum change of a changed zoom, as a share of the focal length, and change that an unchanged one excludes.
const NEGLIGIBLE: f64 = 0.01;
const EXCLUDED: f64 = 0.02;
/// Deviations that separate both from the estimate.
const SURE: f64 = 4.0;

/// Projector's zoom compared with that of its file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Zoom {
    /// It is as in the file, within this deviation: a share of the focal length.
    Unchanged {
        /// Standard deviation, as a share of the focal length.
        sigma: f64,
    },
    /// It differs.
    Changed {
        /// Change as a share of the focal length.
        change: f64,
        /// Standard deviation of that.
        sigma: f64,
    },
    /// The scene is too flat to tell, or there are too few samples.
    Undecidable {
        /// Variation of depth, as a share of it.
        variation: f64,
    },
}

/// Compares the zoom with that of a lens. `None` if the samples fit no zoom of it.
pub(super) fn check(samples: &[Sample], lens: &Lens) -> Option<Zoom> {
    let mut depths: Vec<f64> = samples.iter().map(|sample| sample.point.z).collect();
    let [near, far] = ENDS.map(|share| quantile(&mut depths, share));
    let variation = (far - near) / median(&mut depths);
    let undecidable = Zoom::Undecidable { variation };
    if variation.is_nan() || variation < LEAST_VARIATION || samples.len() < LEAST_SAMPLES {
        return Some(undecidable);
    }
    let ZoomEstimate { change, sigma, agreeing } = zoom(samples, lens)?;
    if agreeing < LEAST_AGREEING {
        return None;
    }
    let doubt = SURE * sigma;
    Some(if change.abs() > NEGLIGIBLE.max(doubt) {
        Zoom::Changed { change, sigma }
    } else if change.abs() + doubt < EXCLUDED {
        Zoom::Unchanged { sigma }
    } else {
        undecidable
    })
}
