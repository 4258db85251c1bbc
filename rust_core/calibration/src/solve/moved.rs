//! Motion during a scan: outliers that agree with a second pose.

use rayon::prelude::*;

use super::adjust::{robustly, Adjusted};
use super::consensus;
use super::input::{Observation, Observations};
use super::model::{Free, SolverState};
use super::noise::LIMIT;
use super::{spread, Refusal};
use crate::statistics::median;

/// Minimum share of a scan's samples for a second pose.
const SECOND_SHARE: f64 = 0.08;
/// Minimum share of the first pose's outliers that agree with the second. Gross errors agree with none.
const OF_OUTLIERS: f64 = 0.5;
/// Minimum share of the image that the second pose's inliers cover, since any pose can be rotated to agree at one
/// place.
const LEAST_OUTLINE: f64 = 0.02;
/// Minimum error of these inliers under the first pose, pixels, and as a multiple of that under the second.
const LEAST_ERROR_PX: f64 = 1.5;
const APART: f64 = 3.0;
/// Minimum number of outliers.
const LEAST: usize = 12;

/// Refuses scans in which two poses each explain part of the samples.
pub(super) fn check(observations: &Observations, adjusted: &Adjusted, seed: u64) -> Result<(), Refusal> {
    let scans = observations.scans.par_iter().enumerate();
    let refusals: Vec<Option<Refusal>> =
        scans.map(|(scan, number)| moved(observations, adjusted, seed, scan, *number)).collect();
    refusals.into_iter().flatten().next().map_or(Ok(()), Err)
}

/// Why one scan is refused, if it is.
fn moved(observations: &Observations, adjusted: &Adjusted, seed: u64, scan: usize, number: u32) -> Option<Refusal> {
    let range = observations.range(scan);
    let total = range.len();
    let outliers = Observations {
        all: range
            .filter(|i| !adjusted.weights[*i].is_used())
            .map(|i| Observation { scan: 0, ..observations.all[i] })
            .collect(),
        scans: vec![number],
    };
    let count = outliers.all.len();
    if count < LEAST || (count as f64) < SECOND_SHARE * total as f64 {
        return None;
    }
    let few = outliers.thinned(2000, seed);
    let second = consensus::pose(&few, &adjusted.state.lens, seed)?;
    let second = robustly(&few, &second.state, &Free::poses(1), adjusted.noise, 1);
    let weights = adjusted.noise.weights(&few, &second.state, LIMIT);
    let agreeing: Vec<_> =
        few.all.iter().zip(&weights).filter(|(_, weight)| weight.is_used()).map(|(o, _)| *o).collect();
    let share = agreeing.len() as f64 / weights.len().max(1) as f64;
    let second_share = share * count as f64 / total as f64;
    if share <= OF_OUTLIERS || second_share <= SECOND_SHARE {
        return None;
    }
    let pixels: Vec<_> = agreeing.iter().map(|observation| observation.pixel).collect();
    let is_spread = spread::outline_share(&pixels, adjusted.state.lens.size_px) > LEAST_OUTLINE;
    let first = SolverState { lens: adjusted.state.lens, poses: vec![adjusted.state.poses[scan]] };
    let far_px = median_error_px(&agreeing, &first);
    let near_px = median_error_px(&agreeing, &second.state);
    (is_spread && far_px > LEAST_ERROR_PX && far_px > APART * near_px).then(|| Refusal::Moved {
        scan: number,
        first_percent: 100.0 * (total - count) as f64 / total as f64,
        second_percent: 100.0 * second_share,
    })
}

/// Median error under a state of one pose, pixels.
fn median_error_px(samples: &[Observation], state: &SolverState) -> f64 {
    let error = |sample: &Observation| {
        state.project(0, &sample.point).map_or(f64::INFINITY, |pixel| (sample.pixel - pixel).norm())
    };
    median(&mut samples.iter().map(error).collect::<Vec<_>>())
}
