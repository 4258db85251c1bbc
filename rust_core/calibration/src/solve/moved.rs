//! Whether what one pose leaves over agrees with another: then something moved during the scan.

use rayon::prelude::*;

use super::adjust::{robustly, Adjusted};
use super::consensus;
use super::input::{Observation, Observations};
use super::model::{Free, State};
use super::noise::{quantile, LIMIT};
use super::{spread, Refusal};

/// The least share of a scan's samples that make a second pose.
const SECOND_SHARE: f64 = 0.08;
/// The least share of what the first pose leaves over that agrees with the second. Gross errors agree with none.
const OF_LEFT_OVER: f64 = 0.5;
/// A second pose that is one of its own: what agrees with it covers this share of the picture, since any pose can be
/// turned to agree at one place;
const LEAST_OUTLINE: f64 = 0.02;
/// and it misses the first pose by so many pixels, and so many times as much as its own. Samples that err more than
/// others, or in another direction, do not.
const LEAST_MISS_PX: f64 = 1.5;
const APART: f64 = 3.0;
/// The least number of samples that a second pose is looked for among.
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
    let left_over = Observations {
        all: range
            .filter(|i| !adjusted.weights[*i].is_used())
            .map(|i| Observation { scan: 0, ..observations.all[i] })
            .collect(),
        scans: vec![number],
    };
    let count = left_over.all.len();
    if count < LEAST || (count as f64) < SECOND_SHARE * total as f64 {
        return None;
    }
    let few = left_over.thinned(2000, seed);
    let second = consensus::pose(&few, &adjusted.state.lens, seed)?;
    let second = robustly(&few, &second.state, &Free::poses(1), adjusted.noise, 1);
    let weights = adjusted.noise.weights(&few, &second.state, LIMIT);
    let agreeing: Vec<_> =
        few.all.iter().zip(&weights).filter(|(_, weight)| weight.is_used()).map(|(o, _)| *o).collect();
    let share = agreeing.len() as f64 / weights.len().max(1) as f64;
    let second_share = share * count as f64 / total as f64;
    if share <= OF_LEFT_OVER || second_share <= SECOND_SHARE {
        return None;
    }
    let pixels: Vec<_> = agreeing.iter().map(|observation| observation.pixel).collect();
    let is_spread = spread::outline_share(&pixels, adjusted.state.lens.size_px) > LEAST_OUTLINE;
    let first = State { lens: adjusted.state.lens, poses: vec![adjusted.state.poses[scan]] };
    let far_px = typical_miss_px(&agreeing, &first);
    let near_px = typical_miss_px(&agreeing, &second.state);
    (is_spread && far_px > LEAST_MISS_PX && far_px > APART * near_px).then(|| Refusal::Moved {
        scan: number,
        first_percent: 100.0 * (total - count) as f64 / total as f64,
        second_percent: 100.0 * second_share,
    })
}

/// By how many pixels a state of one pose misses samples, in the middle; infinite without samples.
fn typical_miss_px(samples: &[Observation], state: &State) -> f64 {
    let miss = |sample: &Observation| {
        state.project(0, &sample.point).map_or(f64::INFINITY, |pixel| (sample.pixel - pixel).norm())
    };
    let typical_px = quantile(&mut samples.iter().map(miss).collect::<Vec<_>>(), 0.5);
    if typical_px.is_nan() {
        f64::INFINITY
    } else {
        typical_px
    }
}
