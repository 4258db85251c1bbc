//! The two lots that a scan's samples fall into best: by the order in which they were given, or in any.

use nalgebra::{SMatrix, Vector2};

use super::misses::{Miss, Misses, Motion, MOTION};
use super::split::{solved, Split};
use crate::solve::random::SplitMix64;

/// Where the order of samples is cut, as shares of them.
const CUTS: [f64; 7] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];
/// Pairs of neighbours that a motion is tried from, and how many motions are tried. A pair's difference is the motion
/// or its opposite, so 1 of 16 tries has all signs alike.
const PAIRS: usize = 5;
const TRIES: usize = 150;
/// Keeps such motions small in directions that a few pairs hardly determine.
const DAMPING: f64 = 1e-3;
/// The share of the pairs, of those that differ most, that are drawn from: they are of different lots.
const FARTHEST: f64 = 0.25;
/// Pairs that tries are compared on, at most.
const COMPARED: usize = 400;
/// Tries that are refined, and how often at most.
const REFINED: usize = 4;
const ROUNDS: usize = 15;

/// The best cut of the order; none without samples.
pub(super) fn by_order(misses: &Misses, given: usize) -> Option<Split> {
    let cut = |share: f64| {
        let limit = (share * given as f64) as usize;
        Split::new(misses, misses.all.iter().map(|miss| miss.order >= limit).collect())
    };
    CUTS.into_iter().filter_map(cut).min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// The best lots in any order, by k-means from motions that explain random pairs of neighbours.
pub(super) fn in_any_order(misses: &Misses, unsplit: &Split, seed: u64) -> Option<Split> {
    let pairs = Pair::all(misses);
    let count = (pairs.len() as f64 * FARTHEST) as usize;
    if count < PAIRS {
        return None;
    }
    let step = (pairs.len() / COMPARED).max(1);
    let mut random = SplitMix64::new(seed, 0x3307);
    let mut tries: Vec<(f64, Motion)> = (0..TRIES)
        .filter_map(|_| {
            let motion = Pair::motion(&random.distinct::<PAIRS>(count).map(|i| pairs[i]))?;
            Some((pairs.iter().step_by(step).map(|pair| pair.cost(&motion)).sum(), motion))
        })
        .collect();
    tries.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refined = tries.iter().take(REFINED).filter_map(|(_, motion)| refine(misses, unsplit, motion));
    refined.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Lots and motion in turns, until nothing changes.
fn refine(misses: &Misses, unsplit: &Split, motion: &Motion) -> Option<Split> {
    let mut split = Split::new(misses, unsplit.beyond(misses, motion, 0.0))?;
    for _ in 0..ROUNDS {
        let nearer = split.beyond(misses, &split.motion, 0.5);
        if nearer == split.is_second {
            break;
        }
        split = Split::new(misses, nearer)?;
    }
    Some(split)
}

/// The difference of two neighbours.
#[derive(Debug, Clone, Copy)]
struct Pair {
    px: Vector2<f64>,
    miss: Miss,
}

impl Pair {
    /// Each sample with its nearest neighbour, those first that differ most.
    fn all(misses: &Misses) -> Vec<Self> {
        let mut pairs: Vec<Self> =
            misses.all.iter().map(|miss| Self { px: miss.px - misses.all[miss.nearest].px, miss: *miss }).collect();
        let size = |pair: &Self| pair.px.dot(&(pair.miss.information * pair.px));
        pairs.sort_by(|a, b| size(b).total_cmp(&size(a)));
        pairs
    }

    /// The motion that explains all of these as differences of the second lot to the first.
    fn motion(pairs: &[Self]) -> Option<Motion> {
        let (mut matrix, mut right) = (SMatrix::<f64, MOTION, MOTION>::zeros(), Motion::zeros());
        for Self { px, miss } in pairs {
            let weighted = miss.slopes.transpose() * miss.information;
            matrix += weighted * miss.slopes;
            right += weighted * px;
        }
        solved(&matrix, &right, DAMPING)
    }

    /// How badly the pair fits, whether both are of the same lot or of different ones.
    fn cost(&self, motion: &Motion) -> f64 {
        let moved = self.miss.slopes * motion;
        let cost = |left: Vector2<f64>| left.dot(&(self.miss.information * left));
        cost(self.px).min(cost(self.px - moved)).min(cost(self.px + moved))
    }
}
