//! First lens and pose by consensus: RANSAC (Fischler and Bolles, 1981) with a scale-free score and local optimisation
//! (Chum, Matas and Kittler, 2003).
//!
//! Small random sets of samples are solved exactly and scored by the geometric mean of all samples' errors. So the
//! noise need not be known, gross errors count little more than small ones, one of two consistent sets is chosen
//! instead of a compromise, and a solution for a wall only, which leaves the lens open, scores worse than one for all
//! samples. The best solutions are adjusted to the samples within a multiple of the 40 % quantile of the errors.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::adjust;
use super::input::{Observation, Observations};
use super::model::{Free, SolverState};
use super::noise::{Noise, LIMIT};
use super::random::SplitMix64;
use super::{dlt, p3p};
use crate::statistics::quantile;
use crate::Lens;

/// Number of scored samples.
const SCORED: usize = 600;
/// Share of agreeing samples.
const AGREEING: f64 = 0.4;
/// Number of sets of six samples: with 40 % gross errors, one in 21 has none.
const SETS_OF_SIX: usize = 1600;
/// Number of sets of three samples: with 50 % gross errors, one in 8 has none.
const SETS_OF_THREE: usize = 200;
/// Number of random streams, each a task.
const STREAMS: usize = 8;
/// Best solutions kept of each stream.
const KEPT: usize = 2;
/// Best solutions that are adjusted, and of these those adjusted again with more unknowns.
const POLISHED: [usize; 2] = [8, 3];
/// Steps of these adjustments, which are compared only.
const ROUGH_STEPS: usize = 5;
/// Maximum squared error, in deviations, also of a sample that cannot be projected.
const LOST: f64 = 1e8;
/// Squared error, in deviations, below which smaller is no better.
const EXACT: f64 = 1e-2;

#[derive(Debug, Clone)]
pub(super) struct Agreed {
    pub(super) state: SolverState,
    pub(super) score: Score,
}

/// Errors of samples under a state, in deviations of their pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Score {
    /// Geometric mean; smaller is better.
    pub(super) mean: f64,
    /// 40 % quantile.
    pub(super) near: f64,
}

impl Score {
    /// Scores a state; `buffer` is reused.
    pub(super) fn new(observations: &[Observation], state: &SolverState, buffer: &mut Vec<f64>) -> Self {
        buffer.clear();
        // One logarithm of a product replaces many, as long as the product does not overflow.
        let (mut logarithm, mut product) = (0.0, 1.0);
        buffer.extend(observations.iter().map(|observation| {
            let squared = state.project(observation.scan, &observation.point).map_or(LOST, |pixel| {
                ((observation.pixel - pixel).norm_squared() / (observation.sigma_px * observation.sigma_px)).min(LOST)
            });
            product *= squared + EXACT;
            if !(1e-100..1e100).contains(&product) {
                logarithm += product.ln();
                product = 1.0;
            }
            squared
        }));
        logarithm += product.ln();
        let mean = (0.5 * logarithm / observations.len() as f64).exp();
        Self { mean, near: quantile(buffer, AGREEING).sqrt() }
    }
}

/// Lens and pose of a single scan whose scene is not flat, adjusted with each of `frees` in turn.
pub(super) fn lens_and_pose(scan: &Observations, size_px: [u32; 2], frees: &[Free], seed: u64) -> Option<Agreed> {
    let few = scan.thinned(SCORED, seed);
    let solve = |random: &mut SplitMix64| {
        let drawn = random.distinct::<6>(few.all.len()).map(|i| &few.all[i]);
        let solved = dlt::lens_and_pose(&drawn.map(|o| o.point), &drawn.map(|o| o.pixel), size_px);
        solved.into_iter().map(|(lens, pose)| SolverState { lens, poses: vec![pose] }).collect()
    };
    let mut candidates = drawn(&few, SETS_OF_SIX, seed, solve);
    for (free, kept) in frees.iter().zip(POLISHED) {
        candidates.truncate(kept);
        candidates = polished(&few, &candidates, free);
    }
    candidates.into_iter().next()
}

/// Pose of a single scan with a known lens.
pub(super) fn pose(scan: &Observations, lens: &Lens, seed: u64) -> Option<Agreed> {
    let few = scan.thinned(SCORED, seed);
    let rays: Vec<Option<Vector3<f64>>> = few.all.iter().map(|observation| lens.ray(observation.pixel)).collect();
    let solve = |random: &mut SplitMix64| -> Vec<SolverState> {
        let drawn = random.distinct::<3>(few.all.len());
        let [Some(a), Some(b), Some(c)] = drawn.map(|i| rays[i]) else { return Vec::new() };
        let points = drawn.map(|i| few.all[i].point.coords);
        p3p::poses(points, [a, b, c]).map(|pose| SolverState { lens: *lens, poses: vec![pose] }).collect()
    };
    let mut candidates = drawn(&few, SETS_OF_THREE, seed, solve);
    candidates.truncate(POLISHED[1]);
    polished(&few, &candidates, &Free::poses(1)).into_iter().next()
}

/// Best solutions of random sets.
fn drawn(
    observations: &Observations,
    sets: usize,
    seed: u64,
    solve: impl Fn(&mut SplitMix64) -> Vec<SolverState> + Sync,
) -> Vec<Agreed> {
    let of_stream = |stream: usize| {
        let mut random = SplitMix64::new(seed, stream as u64);
        let (mut best, mut buffer) = (Vec::<Agreed>::new(), Vec::new());
        for _ in 0..sets / STREAMS {
            for state in solve(&mut random) {
                let score = Score::new(&observations.all, &state, &mut buffer);
                let is_better = best.last().is_none_or(|last| score.mean < last.score.mean);
                if score.mean.is_finite() && (best.len() < KEPT || is_better) {
                    best.truncate(KEPT - 1);
                    best.push(Agreed { state, score });
                    best.sort_by(|a, b| a.score.mean.total_cmp(&b.score.mean));
                }
            }
        }
        best
    };
    let best: Vec<Vec<Agreed>> = (0..STREAMS).into_par_iter().map(of_stream).collect();
    let mut best = best.concat();
    best.sort_by(|a, b| a.score.mean.total_cmp(&b.score.mean));
    best
}

/// Adjusts solutions to the agreeing samples and sorts them, the best first.
fn polished(observations: &Observations, candidates: &[Agreed], free: &Free) -> Vec<Agreed> {
    let polish = |candidate: &Agreed| {
        let (mut best, mut buffer) = (candidate.clone(), Vec::new());
        for _ in 0..3 {
            let noise = Noise::first(best.score.near, observations.all.len());
            let weights = noise.weights(observations, &best.state, LIMIT);
            let state = adjust::minimise(observations, &weights, &best.state, free, ROUGH_STEPS);
            let score = Score::new(&observations.all, &state, &mut buffer);
            if score.mean.is_nan() || score.mean >= best.score.mean {
                break;
            }
            best = Agreed { state, score };
        }
        best
    };
    let mut polished: Vec<Agreed> = candidates.par_iter().map(polish).collect();
    polished.sort_by(|a, b| a.score.mean.total_cmp(&b.score.mean));
    polished
}
