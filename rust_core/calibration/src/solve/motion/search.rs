//! Search for the best two clusters of a scan's samples: by their given order, or in any order.

use nalgebra::{SMatrix, Vector2};

use super::residuals::{Motion, MotionResidual, MotionResiduals, MOTION};
use super::split::{solved, Split};
use crate::solve::random::SplitMix64;

/// Tried cuts of the order, as shares of the samples.
const CUTS: [f64; 7] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];
/// Pairs of neighbours per tried motion, and number of tries. A pair's difference is the motion or its opposite, so 1
/// of 16 tries has equal signs.
const PAIRS: usize = 5;
const TRIES: usize = 150;
/// Damping of motions in directions that a few pairs hardly determine.
const DAMPING: f64 = 1e-3;
/// Share of the most different pairs, from which tries are drawn: these are in different clusters.
const FARTHEST: f64 = 0.25;
/// Maximum number of pairs for comparing tries.
const COMPARED: usize = 400;
/// Number of refined tries, and maximum rounds.
const REFINED: usize = 4;
const ROUNDS: usize = 15;

/// Best cut of the order; `None` without samples.
pub(super) fn by_order(residuals: &MotionResiduals, given: usize) -> Option<Split> {
    let cut = |share: f64| {
        let limit = (share * given as f64) as usize;
        Split::new(residuals, residuals.all.iter().map(|residual| residual.order >= limit).collect())
    };
    CUTS.into_iter().filter_map(cut).min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Best clusters in any order, by k-means from motions that explain random pairs of neighbours.
pub(super) fn in_any_order(residuals: &MotionResiduals, unsplit: &Split, seed: u64) -> Option<Split> {
    let pairs = NeighbourPair::all(residuals);
    let count = (pairs.len() as f64 * FARTHEST) as usize;
    if count < PAIRS {
        return None;
    }
    let step = (pairs.len() / COMPARED).max(1);
    let mut random = SplitMix64::new(seed, 0x3307);
    let mut tries: Vec<(f64, Motion)> = (0..TRIES)
        .filter_map(|_| {
            let motion = NeighbourPair::motion(&random.distinct::<PAIRS>(count).map(|i| pairs[i]))?;
            Some((pairs.iter().step_by(step).map(|pair| pair.cost(&motion)).sum(), motion))
        })
        .collect();
    tries.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refined = tries.iter().take(REFINED).filter_map(|(_, motion)| refine(residuals, unsplit, motion));
    refined.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Alternates between clusters and motion until convergence.
fn refine(residuals: &MotionResiduals, unsplit: &Split, motion: &Motion) -> Option<Split> {
    let mut split = Split::new(residuals, unsplit.beyond(residuals, motion, 0.0))?;
    for _ in 0..ROUNDS {
        let nearer = split.beyond(residuals, &split.motion, 0.5);
        if nearer == split.is_second {
            break;
        }
        split = Split::new(residuals, nearer)?;
    }
    Some(split)
}

/// Difference of two neighbours.
#[derive(Debug, Clone, Copy)]
struct NeighbourPair {
    px: Vector2<f64>,
    residual: MotionResidual,
}

impl NeighbourPair {
    /// Each sample with its nearest neighbour, the most different first.
    fn all(residuals: &MotionResiduals) -> Vec<Self> {
        let all = residuals.all.iter();
        let mut pairs: Vec<Self> = all
            .map(|residual| Self { px: residual.px - residuals.all[residual.nearest].px, residual: *residual })
            .collect();
        let size = |pair: &Self| pair.px.dot(&(pair.residual.information * pair.px));
        pairs.sort_by(|a, b| size(b).total_cmp(&size(a)));
        pairs
    }

    /// Motion that explains all pairs as differences from the first to the second cluster.
    fn motion(pairs: &[Self]) -> Option<Motion> {
        let (mut matrix, mut right) = (SMatrix::<f64, MOTION, MOTION>::zeros(), Motion::zeros());
        for Self { px, residual } in pairs {
            let weighted = residual.slopes.transpose() * residual.information;
            matrix += weighted * residual.slopes;
            right += weighted * px;
        }
        solved(&matrix, &right, DAMPING)
    }

    /// Cost of the pair, with both in the same or in different clusters.
    fn cost(&self, motion: &Motion) -> f64 {
        let moved = self.residual.slopes * motion;
        let cost = |left: Vector2<f64>| left.dot(&(self.residual.information * left));
        cost(self.px).min(cost(self.px - moved)).min(cost(self.px + moved))
    }
}
