//! Orientation of the projector's image in the camera's: detects mirrored images.
//!
//! Camera and projector see the same side of a surface, so three neighbouring points have the same orientation in both
//! images unless one is mirrored. That needs no lens and pose, and holds on a flat wall, where a mirrored image fits a
//! projector behind the wall perfectly. It may fail at depth edges, so neighbours vote.

use nalgebra::Vector2;

use super::input::Observations;
use super::noise::Weight;

/// Voting points of each scan.
const VOTERS: usize = 300;
/// Minimum sine of a triangle's angle at the voter.
const LEAST_SINE: f64 = 0.3;

/// Share of neighbouring triples of used samples with equal orientation in both images; 1 if there are none.
pub(super) fn agreeing_share(observations: &Observations, weights: &[Weight]) -> f64 {
    let (mut agreeing, mut votes) = (0, 0);
    for scan in 0..observations.scans.len() {
        let range = observations.range(scan);
        let used: Vec<usize> = range.filter(|i| weights[*i].is_used()).collect();
        let step = used.len().div_ceil(VOTERS).max(1);
        let voters: Vec<_> = used
            .iter()
            .step_by(step)
            .map(|i| (observations.all[*i].ray.xy(), observations.all[*i].pixel.coords))
            .collect();
        for voter in &voters {
            if let Some(is_same) = vote(voter, &voters) {
                votes += 1;
                agreeing += usize::from(is_same);
            }
        }
    }
    if votes == 0 {
        1.0
    } else {
        agreeing as f64 / votes as f64
    }
}

fn vote(voter: &(Vector2<f64>, Vector2<f64>), all: &[(Vector2<f64>, Vector2<f64>)]) -> Option<bool> {
    let distance = |other: &(Vector2<f64>, Vector2<f64>)| (other.0 - voter.0).norm_squared();
    let others = || all.iter().filter(|other| distance(other) > 0.0);
    let first = others().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let along = (first.0 - voter.0).normalize();
    let second = others()
        .filter(|other| along.perp(&(other.0 - voter.0)).abs() > LEAST_SINE * distance(other).sqrt())
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let seen = (first.0 - voter.0).perp(&(second.0 - voter.0));
    let lit = (first.1 - voter.1).perp(&(second.1 - voter.1));
    (lit != 0.0).then_some((seen > 0.0) == (lit > 0.0))
}
