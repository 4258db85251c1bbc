//! Orientation of the projector's image in the camera's: detects mirrored images.
//!
//! Camera and projector see the same side of a surface, so three neighbouring points have the same orientation in both
//! images unless one is mirrored. That needs no lens and pose, and holds on a flat wall, where a mirrored image fits a
//! projector behind the wall perfectly. It may fail at depth edges, so neighbours vote.

use nalgebra::Vector2;

use super::input::Observations;

/// Voting points of each scan.
const VOTERS: usize = 1000;
/// Minimum sine of a triangle's angle at the voter.
const LEAST_SINE: f64 = 0.3;
/// Majority against equal orientation that means a mirrored image, standard deviations of undecided votes.
const SIGNIFICANT: f64 = 1.4;

/// `true` if most neighbouring triples of samples have opposite orientations in both images. Gross errors are votes at
/// random: up to half of the samples may be some.
pub(super) fn is_mirrored(observations: &Observations) -> bool {
    let (mut votes, mut majority) = (0.0, 0.0);
    for scan in 0..observations.scans.len() {
        let all = &observations.all[observations.range(scan)];
        let step = all.len().div_ceil(VOTERS).max(1);
        let voters: Vec<_> = all.iter().step_by(step).map(|one| (one.ray.xy(), one.pixel.coords)).collect();
        for is_same in voters.iter().filter_map(|voter| vote(voter, &voters)) {
            votes += 1.0;
            majority += if is_same { -1.0 } else { 1.0 };
        }
    }
    majority > SIGNIFICANT * f64::sqrt(votes)
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
