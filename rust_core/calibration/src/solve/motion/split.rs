//! Samples in two lots, of which one was seen after a small motion: the motion that explains them best.
//!
//! Each group of neighbours has an unknown centre of its own, which takes up all that neighbours share, so that the
//! motion is found from differences of neighbours alone (the "within" estimate of fixed effects in econometrics).

use nalgebra::{DMatrix, DVector, Matrix2, SMatrix, Vector2};

use super::misses::{Miss, Misses, Motion, MOTION};
use crate::solve::adjust::solve_positive;
use crate::solve::noise::quantile;

/// Keeps motions finite that the samples do not determine, as a zoom and a shift along the light before a wall.
const DAMPING: f64 = 1e-6;

/// Samples in two lots.
#[derive(Debug, Clone)]
pub(super) struct Split {
    /// Whether each sample belongs to the second lot, in the order of the misses.
    pub(super) is_second: Vec<bool>,
    /// The motion between both.
    pub(super) motion: Motion,
    /// For each group, the miss of its samples of the first lot.
    centres: Vec<Vector2<f64>>,
    /// The sum of squared misses, in deviations.
    pub(super) cost: f64,
}

/// What speaks for a split.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Evidence {
    /// How far apart the light of both lots is, root of the mean square, pixels.
    pub(super) apart_px: f64,
    /// The deviation along the motion that is left over, as a share of that without a motion, in the median group.
    /// Cutting normal deviates in two leaves 0.60 over, cutting evenly distributed ones 0.5.
    pub(super) left_over: f64,
    /// The share of the second lot.
    pub(super) second: f64,
    /// How often neighbours are of different lots, as a share of how often they would be by chance.
    pub(super) mixed: f64,
    /// How much the motion explains for each of its unknowns, as a multiple of what chance does (Fisher's F).
    pub(super) explained: f64,
}

/// The motion that solves normal equations; none if they are singular.
pub(super) fn solved(matrix: &SMatrix<f64, MOTION, MOTION>, right: &Motion, damping: f64) -> Option<Motion> {
    let mut matrix = DMatrix::from_column_slice(MOTION, MOTION, matrix.as_slice());
    for i in 0..MOTION {
        matrix[(i, i)] *= 1.0 + damping;
    }
    let motion = solve_positive(&matrix, &DVector::from_column_slice(right.as_slice()))?;
    Some(Motion::from_column_slice(motion.as_slice()))
}

impl Split {
    /// The best motion for given lots; none if there is nothing to compare.
    pub(super) fn new(misses: &Misses, is_second: Vec<bool>) -> Option<Self> {
        let mut matrix = SMatrix::<f64, MOTION, MOTION>::zeros();
        let mut right = Motion::zeros();
        let mut sums = Vec::with_capacity(misses.ends.len());
        for (from, group) in misses.groups() {
            let (mut information, mut moment) = (Matrix2::zeros(), Vector2::zeros());
            let mut slopes = SMatrix::<f64, 2, MOTION>::zeros();
            for (miss, is_second) in group.iter().zip(&is_second[from..]) {
                let weighted_px = miss.information * miss.px;
                information += miss.information;
                moment += weighted_px;
                if *is_second {
                    let weighted = miss.information * miss.slopes;
                    slopes += weighted;
                    matrix += miss.slopes.transpose() * weighted;
                    right += miss.slopes.transpose() * weighted_px;
                }
            }
            let inverse = information.try_inverse()?;
            matrix -= slopes.transpose() * inverse * slopes;
            right -= slopes.transpose() * inverse * moment;
            sums.push((inverse, moment, slopes));
        }
        let motion = if is_second.contains(&true) { solved(&matrix, &right, DAMPING)? } else { Motion::zeros() };
        let centres = sums.iter().map(|(inverse, moment, slopes)| inverse * (moment - slopes * motion)).collect();
        let mut split = Self { is_second, motion, centres, cost: 0.0 };
        split.cost = split.sums(misses, |left, information, _| left.dot(&(information * left))).iter().sum();
        Some(split)
    }

    /// For each group the sum over what is left over of its samples, with its information and the sample's motion.
    fn sums(&self, misses: &Misses, term: impl Fn(Vector2<f64>, &Matrix2<f64>, Vector2<f64>) -> f64) -> Vec<f64> {
        let sum = |((from, group), centre): ((usize, &[Miss]), &Vector2<f64>)| {
            let terms = group.iter().zip(&self.is_second[from..]).map(|(miss, is_second)| {
                let moved = miss.slopes * self.motion;
                let left = miss.px - centre - if *is_second { moved } else { Vector2::zeros() };
                term(left, &miss.information, moved)
            });
            terms.sum()
        };
        misses.groups().zip(&self.centres).map(sum).collect()
    }

    /// Whether each sample lies on the far side of a place between its group's centre (0) and that moved (1).
    pub(super) fn beyond(&self, misses: &Misses, motion: &Motion, place: f64) -> Vec<bool> {
        let mut beyond = Vec::with_capacity(misses.all.len());
        for ((_, group), centre) in misses.groups().zip(&self.centres) {
            beyond.extend(group.iter().map(|miss| {
                let moved = miss.slopes * motion;
                (miss.information * moved).dot(&(miss.px - centre - place * moved)) > 0.0
            }));
        }
        beyond
    }

    /// What speaks for this split. `unsplit` has all samples in one lot.
    pub(super) fn evidence(&self, misses: &Misses, unsplit: &Self) -> Evidence {
        let count = misses.all.len() as f64;
        let second = self.is_second.iter().filter(|is_second| **is_second).count() as f64 / count;
        let differing = (misses.all.iter().zip(&self.is_second))
            .filter(|(miss, is_second)| self.is_second[miss.nearest] != **is_second)
            .count() as f64;
        let in_direction = Self { motion: self.motion, ..unsplit.clone() };
        let without = in_direction.sums(misses, along_motion);
        let mut shares: Vec<f64> =
            self.sums(misses, along_motion).iter().zip(&without).map(|(with, without)| with / without).collect();
        let apart2 = misses.all.iter().map(|miss| (miss.slopes * self.motion).norm_squared()).sum::<f64>() / count;
        let freedom = 2.0 * (count - misses.ends.len() as f64) - MOTION as f64;
        Evidence {
            apart_px: apart2.sqrt(),
            left_over: quantile(&mut shares, 0.5).sqrt(),
            second,
            mixed: differing / count / (2.0 * second * (1.0 - second)),
            explained: (unsplit.cost - self.cost) / MOTION as f64 / (self.cost / freedom.max(1.0)),
        }
    }
}

/// The square of what is left over of a sample along its motion, in deviations.
fn along_motion(left: Vector2<f64>, information: &Matrix2<f64>, moved: Vector2<f64>) -> f64 {
    let weighted = information * moved;
    let size = weighted.dot(&moved);
    if size > 0.0 {
        weighted.dot(&left).powi(2) / size
    } else {
        0.0
    }
}
