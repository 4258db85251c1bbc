//! Whether what one pose leaves over agrees with another: then something moved during the scan.

use rayon::prelude::*;

use super::adjust::{robustly, Adjusted};
use super::consensus;
use super::input::Observations;
use super::model::{Free, State};
use super::noise::{Noise, LIMIT};
use super::Refusal;

/// The least share of a scan's samples that make a second pose.
const SECOND_SHARE: f64 = 0.08;
/// The least share of what the first pose leaves over that agrees with the second. Gross errors agree with none.
const OF_LEFT_OVER: f64 = 0.5;
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
            .map(|i| super::input::Observation { scan: 0, ..observations.all[i] })
            .collect(),
        scans: vec![number],
    };
    let count = left_over.all.len();
    if count < LEAST || (count as f64) < SECOND_SHARE * total as f64 {
        return None;
    }
    let few = left_over.thinned(2000, seed);
    let second = consensus::pose(&few, &adjusted.state.lens, seed)?;
    let agreeing = agreeing(&few, &second.state, adjusted.noise);
    let second_share = agreeing * count as f64 / total as f64;
    (agreeing > OF_LEFT_OVER && second_share > SECOND_SHARE).then(|| Refusal::Moved {
        scan: number,
        first_percent: 100.0 * (total - count) as f64 / total as f64,
        second_percent: 100.0 * second_share,
    })
}

/// The share of samples that a pose explains as well as the first explains its own.
fn agreeing(observations: &Observations, state: &State, noise: Noise) -> f64 {
    let adjusted = robustly(observations, state, &Free::poses(1), noise, 1);
    let weights = noise.weights(observations, &adjusted.state, LIMIT);
    weights.iter().filter(|weight| weight.is_used()).count() as f64 / weights.len().max(1) as f64
}
