//! A first lens and pose that most samples agree with, whatever the others say: RANSAC (Fischler and Bolles, 1981) with
//! a score without a scale and local optimisation (Chum, Matas and Kittler, 2003).
//!
//! Small random sets of samples are solved exactly. Each solution's score is the geometric mean of the distances of all
//! samples. So nothing has to be known of the noise; a gross error counts little more than a small one; of two sets
//! that agree among themselves one is chosen instead of something between them; and a solution that is right on a wall
//! only, which leaves the lens open, is worse than one that is right on all. The best solutions are adjusted to the
//! samples within some times the distance within which 40 % lie.

use nalgebra::{Isometry3, Vector3};
use rayon::prelude::*;

use super::adjust;
use super::input::{Observation, Observations};
use super::model::{Free, State};
use super::noise::{quantile, Noise};
use super::random::SplitMix64;
use super::{dlt, p3p};
use crate::Lens;

/// Samples that solutions are scored with.
const SCORED: usize = 600;
/// The share of samples whose distance says which are near.
const AGREEING: f64 = 0.4;
/// Sets of six samples: with 40 % gross errors, one in 21 has none.
const SETS_OF_SIX: usize = 1600;
/// Sets of three samples: with 50 % gross errors, one in 8 has none.
const SETS_OF_THREE: usize = 200;
/// Streams of random numbers, each a task for a thread.
const STREAMS: usize = 8;
/// The best solutions of each stream that are kept.
const KEPT: usize = 2;
/// The best solutions of all streams that are adjusted, and of these those that are adjusted again with more unknowns.
const POLISHED: [usize; 2] = [8, 3];
/// The squared distance, in deviations, of a sample that cannot be projected; none counts more.
const LOST: f64 = 1e8;
/// The squared distance, in deviations, below which nearer is no better.
const EXACT: f64 = 1e-2;

/// A state and how well samples agree with it.
#[derive(Debug, Clone)]
pub(super) struct Agreed {
    pub(super) state: State,
    pub(super) score: Score,
}

/// How far samples are from where a state puts them, in deviations of their pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Score {
    /// The geometric mean: states of smaller ones are better.
    pub(super) mean: f64,
    /// The distance within which 40 % lie.
    pub(super) near: f64,
}

impl Score {
    /// The score of a state; `buffer` is for reuse.
    pub(super) fn new(observations: &[Observation], state: &State, buffer: &mut Vec<f64>) -> Self {
        buffer.clear();
        // The logarithm of a product is that of many, as long as it does not overflow.
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

/// Lens and pose of a single scan whose scene is not flat. `frees` are what is adjusted, one after the other.
pub(super) fn lens_and_pose(scan: &Observations, size_px: [u32; 2], frees: &[Free], seed: u64) -> Option<Agreed> {
    let few = scan.thinned(SCORED, seed);
    let solve = |random: &mut SplitMix64| {
        let drawn = random.distinct::<6>(few.all.len()).map(|i| &few.all[i]);
        let solved = dlt::lens_and_pose(&drawn.map(|o| o.point), &drawn.map(|o| o.pixel), size_px);
        solved.into_iter().map(|(lens, pose)| State { lens, poses: vec![pose] }).collect()
    };
    let mut candidates = drawn(&few, SETS_OF_SIX, seed, solve);
    for (free, kept) in frees.iter().zip(POLISHED) {
        candidates.truncate(kept);
        candidates = polished(&few, &candidates, free);
    }
    candidates.into_iter().next()
}

/// The pose of a single scan with this lens.
pub(super) fn pose(scan: &Observations, lens: &Lens, seed: u64) -> Option<Agreed> {
    let few = scan.thinned(SCORED, seed);
    let rays: Vec<Option<Vector3<f64>>> = few.all.iter().map(|observation| lens.ray(observation.pixel)).collect();
    let solve = |random: &mut SplitMix64| -> Vec<State> {
        let drawn = random.distinct::<3>(few.all.len());
        let [Some(a), Some(b), Some(c)] = drawn.map(|i| rays[i]) else { return Vec::new() };
        let points = drawn.map(|i| few.all[i].point.coords);
        p3p::poses(points, [a, b, c]).map(|pose: Isometry3<f64>| State { lens: *lens, poses: vec![pose] }).collect()
    };
    let mut candidates = drawn(&few, SETS_OF_THREE, seed, solve);
    candidates.truncate(POLISHED[1]);
    polished(&few, &candidates, &Free::poses(1)).into_iter().next()
}

/// The best solutions of random sets.
fn drawn(
    observations: &Observations,
    sets: usize,
    seed: u64,
    solve: impl Fn(&mut SplitMix64) -> Vec<State> + Sync,
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

/// The solutions adjusted to the samples that are near, the best first.
fn polished(observations: &Observations, candidates: &[Agreed], free: &Free) -> Vec<Agreed> {
    let polish = |candidate: &Agreed| {
        let (mut best, mut buffer) = (candidate.clone(), Vec::new());
        for _ in 0..3 {
            let noise = Noise::first(best.score.near, observations.all.len());
            let weights = noise.weights(observations, &best.state, super::noise::LIMIT);
            let state = adjust::minimise(observations, &weights, &best.state, free, adjust::Effort::ROUGH);
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
