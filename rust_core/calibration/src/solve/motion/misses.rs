//! What a solution leaves over of a scan's samples, and how a small motion would change it.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use rayon::prelude::*;

use super::groups::{groups, nearest};
use crate::solve::input::{Observation, Observations};
use crate::solve::model::{State, LENS};
use crate::solve::noise::{quantile, Noise, Weight};

/// A motion: the camera's turn and shift, and by which share the projector zooms.
pub(super) const MOTION: usize = 7;
/// Unknowns of a motion.
pub(super) type Motion = SVector<f64, MOTION>;

/// Samples are gross errors if they are farther from the middle of their group than so many times as 60 % of all are,
/// and farther than a given distance; beyond this one, pixels, they always are.
const GROSS: f64 = 4.0;
const GROSS_SHARE: f64 = 0.6;
const SURELY_GROSS_PX: f64 = 25.0;
/// Members that a group needs.
const LEAST_IN_GROUP: usize = 6;

/// What is left over of a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Miss {
    /// The pixel that was seen less the predicted one, pixels.
    pub(super) px: Vector2<f64>,
    /// How the predicted pixel follows a motion.
    pub(super) slopes: SMatrix<f64, 2, MOTION>,
    /// The inverse of the covariance of `px`.
    pub(super) information: Matrix2<f64>,
    /// The sample's place in the order in which samples were given.
    pub(super) order: usize,
    /// The index of the miss that is the nearest of its group in the camera's picture.
    pub(super) nearest: usize,
}

/// The misses of a scan, group by group, without gross errors.
#[derive(Debug, Clone)]
pub(super) struct Misses {
    pub(super) all: Vec<Miss>,
    /// The end of each group.
    pub(super) ends: Vec<usize>,
}

impl Misses {
    /// Those of a single scan at a state, without samples that are farther than `gross_px` from the middle of their
    /// group, unless many are.
    pub(super) fn new(observations: &Observations, state: &State, noise: &Noise, gross_px: f64) -> Self {
        let (rays, misses): (Vec<_>, Vec<_>) = (observations.all.par_iter().enumerate())
            .filter_map(|(order, observation)| {
                Some((observation.ray.xy(), Miss::new(order, observation, state, noise)?))
            })
            .unzip();
        let (groups, misses) = (groups(&rays), &misses);
        let middles: Vec<Vector2<f64>> = groups.iter().map(|group| middle(misses, group)).collect();
        let mut distances: Vec<f64> = (groups.iter().zip(&middles))
            .flat_map(|(group, middle)| group.iter().map(move |i| (misses[*i].px - middle).norm()))
            .collect();
        let limit_px = (GROSS * quantile(&mut distances, GROSS_SHARE)).clamp(gross_px, SURELY_GROSS_PX);
        let mut sorted = Self { all: Vec::with_capacity(misses.len()), ends: Vec::new() };
        for (group, middle) in groups.iter().zip(&middles) {
            let kept: Vec<usize> =
                group.iter().copied().filter(|i| (misses[*i].px - middle).norm() <= limit_px).collect();
            if kept.len() < LEAST_IN_GROUP {
                continue;
            }
            let from = sorted.all.len();
            let place_of = |i: usize| from + kept.iter().position(|kept| *kept == i).unwrap_or(0);
            for i in &kept {
                let nearest = nearest(&rays, &kept, *i).map_or(from, place_of);
                sorted.all.push(Miss { nearest, ..misses[*i] });
            }
            sorted.ends.push(sorted.all.len());
        }
        sorted
    }

    /// The groups, each with the index of its first miss.
    pub(super) fn groups(&self) -> impl Iterator<Item = (usize, &[Miss])> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(from, to)| (from, &self.all[from..*to]))
    }
}

impl Miss {
    fn new(order: usize, observation: &Observation, state: &State, noise: &Noise) -> Option<Self> {
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

/// The middle of a group's misses in each direction.
fn middle(misses: &[Miss], group: &[usize]) -> Vector2<f64> {
    let middle = |axis: usize| quantile(&mut group.iter().map(|i| misses[*i].px[axis]).collect::<Vec<_>>(), 0.5);
    Vector2::new(middle(0), middle(1))
}
