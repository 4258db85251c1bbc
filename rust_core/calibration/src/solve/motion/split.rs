//! Two clusters of samples, one observed after a small motion: the best motion for given clusters.
//!
//! Each group of neighbours has its own unknown centre, which absorbs errors that neighbours share, so that the motion
//! comes from differences of neighbours alone (the "within" estimator of fixed effects in econometrics).

use nalgebra::{DMatrix, DVector, Matrix2, SMatrix, Vector2};

use super::residuals::{Motion, MotionResidual, MotionResiduals, MOTION};
use crate::solve::levenberg_marquardt::solve_positive;
use crate::statistics::median;

/// Damping of undetermined motions, as a zoom and a shift along the light before a wall.
const DAMPING: f64 = 1e-6;

/// Two clusters of samples.
#[derive(Debug, Clone)]
pub(super) struct Split {
    /// Membership of the second cluster, by residual.
    pub(super) is_second: Vec<bool>,
    pub(super) motion: Motion,
    /// Centre of the first cluster in each group.
    centres: Vec<Vector2<f64>>,
    /// Sum of squared residuals, in deviations.
    pub(super) cost: f64,
}

/// Evidence for a split.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Evidence {
    /// RMS distance of the clusters, pixels.
    pub(super) apart_px: f64,
    /// Remaining deviation along the motion as a share of that without motion, in the median group: 0.60 for a normal
    /// distribution cut in two, 0.5 for a uniform one.
    pub(super) remaining: f64,
    /// Share of the second cluster.
    pub(super) second: f64,
    /// Rate of neighbours in different clusters, as a share of that by chance.
    pub(super) mixed: f64,
    /// F statistic of the motion.
    pub(super) explained: f64,
}

/// Solves normal equations; `None` if they are singular.
pub(super) fn solved(matrix: &SMatrix<f64, MOTION, MOTION>, right: &Motion, damping: f64) -> Option<Motion> {
    let mut matrix = DMatrix::from_column_slice(MOTION, MOTION, matrix.as_slice());
    for i in 0..MOTION {
        matrix[(i, i)] *= 1.0 + damping;
    }
    let motion = solve_positive(&matrix, &DVector::from_column_slice(right.as_slice()))?;
    Some(Motion::from_column_slice(motion.as_slice()))
}

impl Split {
    /// Best motion for given clusters; `None` if it is undetermined.
    pub(super) fn new(residuals: &MotionResiduals, is_second: Vec<bool>) -> Option<Self> {
        let mut matrix = SMatrix::<f64, MOTION, MOTION>::zeros();
        let mut right = Motion::zeros();
        let mut sums = Vec::with_capacity(residuals.ends.len());
        for (from, group) in residuals.groups() {
            let (mut information, mut moment) = (Matrix2::zeros(), Vector2::zeros());
            let mut slopes = SMatrix::<f64, 2, MOTION>::zeros();
            for (residual, is_second) in group.iter().zip(&is_second[from..]) {
                let weighted_px = residual.information * residual.px;
                information += residual.information;
                moment += weighted_px;
                if *is_second {
                    let weighted = residual.information * residual.slopes;
                    slopes += weighted;
                    matrix += residual.slopes.transpose() * weighted;
                    right += residual.slopes.transpose() * weighted_px;
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
        split.cost = split.sums(residuals, |left, information, _| left.dot(&(information * left))).iter().sum();
        Some(split)
    }

    /// Sums a term over each group: of the remaining residual, its information and the sample's displacement.
    fn sums(
        &self,
        residuals: &MotionResiduals,
        term: impl Fn(Vector2<f64>, &Matrix2<f64>, Vector2<f64>) -> f64,
    ) -> Vec<f64> {
        let sum = |((from, group), centre): ((usize, &[MotionResidual]), &Vector2<f64>)| {
            let terms = group.iter().zip(&self.is_second[from..]).map(|(residual, is_second)| {
                let moved = residual.slopes * self.motion;
                let left = residual.px - centre - if *is_second { moved } else { Vector2::zeros() };
                term(left, &residual.information, moved)
            });
            terms.sum()
        };
        residuals.groups().zip(&self.centres).map(sum).collect()
    }

    /// `true` for samples beyond a place between their group's centre (0) and the moved centre (1).
    pub(super) fn beyond(&self, residuals: &MotionResiduals, motion: &Motion, place: f64) -> Vec<bool> {
        let mut beyond = Vec::with_capacity(residuals.all.len());
        for ((_, group), centre) in residuals.groups().zip(&self.centres) {
            beyond.extend(group.iter().map(|residual| {
                let moved = residual.slopes * motion;
                (residual.information * moved).dot(&(residual.px - centre - place * moved)) > 0.0
            }));
        }
        beyond
    }

    /// Evidence for this split; `unsplit` has all samples in one cluster.
    pub(super) fn evidence(&self, residuals: &MotionResiduals, unsplit: &Self) -> Evidence {
        let count = residuals.all.len() as f64;
        let second = self.is_second.iter().filter(|is_second| **is_second).count() as f64 / count;
        let differing = (residuals.all.iter().zip(&self.is_second))
            .filter(|(residual, is_second)| self.is_second[residual.nearest] != **is_second)
            .count() as f64;
        let in_direction = Self { motion: self.motion, ..unsplit.clone() };
        let without = in_direction.sums(residuals, along_motion);
        let with = self.sums(residuals, along_motion);
        let mut shares: Vec<f64> = with.iter().zip(&without).map(|(with, without)| with / without).collect();
        let squares = residuals.all.iter().map(|residual| (residual.slopes * self.motion).norm_squared());
        let apart2 = squares.sum::<f64>() / count;
        let freedom = 2.0 * (count - residuals.ends.len() as f64) - MOTION as f64;
        Evidence {
            apart_px: apart2.sqrt(),
            remaining: median(&mut shares).sqrt(),
            second,
            mixed: differing / count / (2.0 * second * (1.0 - second)),
            explained: (unsplit.cost - self.cost) / MOTION as f64 / (self.cost / freedom.max(1.0)),
        }
    }
}

/// Squared remaining residual along the motion, in deviations.
fn along_motion(left: Vector2<f64>, information: &Matrix2<f64>, moved: Vector2<f64>) -> f64 {
    let weighted = information * moved;
    let size = weighted.dot(&moved);
    if size > 0.0 {
        weighted.dot(&left).powi(2) / size
    } else {
        0.0
    }
}
