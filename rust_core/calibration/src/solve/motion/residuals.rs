//! Residuals of a scan's samples in small groups of neighbours, with their derivatives by a small motion. Errors that
//! change slowly over the camera's image (smooth depth errors, unmodelled distortion) are nearly equal in a group.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use rayon::prelude::*;

use crate::solve::input::{Observation, Observations};
use crate::solve::model::{SolverState, LENS};
use crate::solve::noise::{Noise, Weight};
use crate::statistics::{median, quantile};

/// Number of unknowns of a motion: the camera's rotation and translation, and the projector's relative zoom.
pub(super) const MOTION: usize = 7;
pub(super) type Motion = SVector<f64, MOTION>;

/// Gross errors are farther from their group's median than this multiple of the 60 % quantile and than a given
/// distance, and always beyond `SURELY_GROSS_PX`.
const GROSS: f64 = 4.0;
const GROSS_SHARE: f64 = 0.6;
const SURELY_GROSS_PX: f64 = 25.0;
/// Maximum size of a group, which is divided down to half of it, and minimum size without gross errors.
const MOST_IN_GROUP: usize = 24;
const LEAST_IN_GROUP: usize = 6;

#[derive(Debug, Clone, Copy)]
pub(super) struct MotionResidual {
    /// Observed minus predicted pixel.
    pub(super) px: Vector2<f64>,
    /// Derivatives of the predicted pixel by a motion.
    pub(super) slopes: SMatrix<f64, 2, MOTION>,
    /// Inverse covariance of `px`.
    pub(super) information: Matrix2<f64>,
    /// Index in the given order of samples.
    pub(super) order: usize,
    /// Index of the nearest neighbour of the group.
    pub(super) nearest: usize,
}

/// Residuals of a scan, group by group, without gross errors.
#[derive(Debug, Clone)]
pub(super) struct MotionResiduals {
    pub(super) all: Vec<MotionResidual>,
    /// End of each group.
    pub(super) ends: Vec<usize>,
}

impl MotionResiduals {
    /// Residuals of a single scan at a state, without samples farther than `gross_px` from their group's median, unless
    /// many are.
    pub(super) fn new(observations: &Observations, state: &SolverState, noise: &Noise, gross_px: f64) -> Self {
        let (rays, residuals): (Vec<_>, Vec<_>) = (observations.all.par_iter().enumerate())
            .filter_map(|(order, observation)| {
                Some((observation.ray.xy(), MotionResidual::new(order, observation, state, noise)?))
            })
            .unzip();
        let (groups, residuals) = (groups(&rays), &residuals);
        let middles: Vec<Vector2<f64>> = groups.iter().map(|group| middle(residuals, group)).collect();
        let mut distances: Vec<f64> = (groups.iter().zip(&middles))
            .flat_map(|(group, middle)| group.iter().map(move |i| (residuals[*i].px - middle).norm()))
            .collect();
        let limit_px = (GROSS * quantile(&mut distances, GROSS_SHARE)).clamp(gross_px, SURELY_GROSS_PX);
        let mut sorted = Self { all: Vec::with_capacity(residuals.len()), ends: Vec::new() };
        for (group, middle) in groups.iter().zip(&middles) {
            let kept: Vec<usize> =
                group.iter().copied().filter(|i| (residuals[*i].px - middle).norm() <= limit_px).collect();
            if kept.len() < LEAST_IN_GROUP {
                continue;
            }
            let from = sorted.all.len();
            let place_of = |i: usize| from + kept.iter().position(|kept| *kept == i).unwrap_or(0);
            for i in &kept {
                let nearest = nearest(&rays, &kept, *i).map_or(from, place_of);
                sorted.all.push(MotionResidual { nearest, ..residuals[*i] });
            }
            sorted.ends.push(sorted.all.len());
        }
        sorted
    }

    /// Groups, each with the index of its first residual.
    pub(super) fn groups(&self) -> impl Iterator<Item = (usize, &[MotionResidual])> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(from, to)| (from, &self.all[from..*to]))
    }
}

impl MotionResidual {
    fn new(order: usize, observation: &Observation, state: &SolverState, noise: &Noise) -> Option<Self> {
        let prediction = state.predict(0, &observation.point)?;
        let by_depth = prediction.by_point * (state.poses[0].rotation * observation.ray);
        let weight = Weight::new(by_depth, noise.pixel * observation.sigma_px, noise.depth * observation.sigma_m);
        let along = weight.direction * weight.direction.transpose();
        let [along2, across2] = [weight.along, weight.across].map(|inverse| inverse * inverse);
        let jacobian = &prediction.jacobian;
        let mut slopes = SMatrix::<f64, 2, MOTION>::zeros();
        slopes.fixed_columns_mut::<6>(0).copy_from(&jacobian.fixed_columns::<6>(LENS));
        let focal = state.lens.focal_px;
        let zoom = Vector2::new(jacobian[(0, 0)] * focal.x, jacobian[(1, 1)] * focal.y);
        slopes.set_column(6, &zoom);
        Some(Self {
            px: observation.pixel - prediction.pixel,
            slopes,
            information: along * along2 + (Matrix2::identity() - along) * across2,
            order,
            nearest: 0,
        })
    }
}

/// Median of a group's residuals in each direction.
fn middle(residuals: &[MotionResidual], group: &[usize]) -> Vector2<f64> {
    let middle = |axis: usize| median(&mut group.iter().map(|i| residuals[*i].px[axis]).collect::<Vec<_>>());
    Vector2::new(middle(0), middle(1))
}

/// Divides places into groups of indices, by halving at the median along the longer side.
pub(super) fn groups(places: &[Vector2<f64>]) -> Vec<Vec<usize>> {
    let mut groups = Vec::new();
    let mut open = vec![(0..places.len()).collect::<Vec<usize>>()];
    while let Some(mut group) = open.pop() {
        if group.len() <= MOST_IN_GROUP {
            groups.push(group);
            continue;
        }
        let (mut least, mut most) = (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
        for i in &group {
            (least, most) = (least.inf(&places[*i]), most.sup(&places[*i]));
        }
        let axis = usize::from((most - least).y > (most - least).x);
        let middle = group.len() / 2;
        group.select_nth_unstable_by(middle, |a, b| places[*a][axis].total_cmp(&places[*b][axis]).then(a.cmp(b)));
        let second = group.split_off(middle);
        open.extend([second, group]);
    }
    groups
}

/// Nearest other member of a group to the place `i`.
pub(super) fn nearest(places: &[Vector2<f64>], group: &[usize], i: usize) -> Option<usize> {
    let distance = |other: &usize| (places[*other] - places[i]).norm_squared();
    group.iter().copied().filter(|other| *other != i).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_small_compact_and_complete() {
        let places: Vec<_> = (0..4800).map(|i| Vector2::new(f64::from(i % 80), f64::from(i / 80))).collect();
        let groups = groups(&places);
        let mut seen: Vec<usize> = groups.concat();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..4800));
        for group in &groups {
            assert!((MOST_IN_GROUP / 2..=MOST_IN_GROUP).contains(&group.len()));
            for i in group {
                assert!(group.iter().all(|j| (places[*i] - places[*j]).norm() < 12.0));
                let near = nearest(&places, group, *i).unwrap();
                assert!((places[*i] - places[near]).norm() == 1.0);
            }
        }
        assert!(nearest(&places, &[3], 3).is_none());
    }
}
