//! Robust least squares by reweighted Levenberg-Marquardt (Marquardt 1963; Nielsen's damping, 1999).

use nalgebra::{DMatrix, DVector};

use super::input::Observations;
use super::model::{Free, SolverState};
use super::noise::{Noise, Weight, LIMIT};
use super::normal_equations::NormalEquations;

/// Minimum predicted decrease of the cost: smaller steps would move no unknown by a tenth of its deviation.
const NEGLIGIBLE: f64 = 1e-3;
/// Initial damping, as a share of the second derivatives.
const FIRST_DAMPING: f64 = 1e-4;
/// Damping at which the search ends.
const LAST_DAMPING: f64 = 1e8;

/// Termination criteria.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Effort {
    pub(super) most_steps: usize,
    /// Minimum predicted relative decrease of the cost.
    pub(super) least_gain: f64,
}

impl Effort {
    /// Sufficient to compare solutions.
    pub(super) const ROUGH: Self = Self { most_steps: 5, least_gain: 3e-3 };
    /// Until convergence.
    pub(super) const FULL: Self = Self { most_steps: 15, least_gain: 0.0 };
}

/// Minimises the cost of the used samples with fixed weights.
pub(super) fn minimise(
    observations: &Observations,
    weights: &[Weight],
    state: &SolverState,
    free: &Free,
    effort: Effort,
) -> SolverState {
    let mut state = state.clone();
    let mut equations = NormalEquations::new(observations, weights, &state, free);
    let (mut damping, mut raise) = (FIRST_DAMPING, 2.0);
    for _ in 0..effort.most_steps {
        if damping > LAST_DAMPING {
            break;
        }
        let Some(step) = damped_step(&equations, damping) else {
            damping *= 10.0;
            continue;
        };
        let promised = step.dot(&equations.descent);
        if promised.is_nan() || promised < NEGLIGIBLE.max(effort.least_gain * equations.cost) {
            break;
        }
        let trial = state.stepped(free, &step).map(|trial| {
            let equations = NormalEquations::new(observations, weights, &trial, free);
            (trial, equations)
        });
        match trial {
            Some((trial, trial_equations)) if trial_equations.cost <= equations.cost => {
                (state, equations) = (trial, trial_equations);
                damping = (damping * 0.1).max(1e-12);
                raise = 2.0;
            }
            _ => {
                damping *= raise * 2.0;
                raise *= 2.0;
            }
        }
    }
    state
}

fn damped_step(equations: &NormalEquations, damping: f64) -> Option<DVector<f64>> {
    let mut matrix = equations.hessian.clone();
    for i in 0..matrix.nrows() {
        matrix[(i, i)] *= 1.0 + damping;
    }
    solve_positive(&matrix, &equations.descent)
}

/// Solves a symmetric positive definite system, scaled to a unit diagonal; `None` if it is singular.
pub(crate) fn solve_positive(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = unit_scale(matrix)?;
    let solution = scaled(matrix, &scale).cholesky()?.solve(&right.component_mul(&scale));
    Some(solution.component_mul(&scale))
}

/// Inverse of a symmetric positive definite matrix; `None` if it is singular.
pub(crate) fn inverse_of_positive(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = unit_scale(matrix)?;
    Some(scaled(&scaled(matrix, &scale).cholesky()?.inverse(), &scale))
}

fn unit_scale(matrix: &DMatrix<f64>) -> Option<DVector<f64>> {
    let diagonal = matrix.diagonal();
    diagonal.iter().all(|value| value.is_finite() && *value > 0.0).then(|| diagonal.map(|value| 1.0 / value.sqrt()))
}

fn scaled(matrix: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| scale[row] * matrix[(row, column)] * scale[column])
}

/// Adjusted state with the noise and the weights of all samples.
#[derive(Debug, Clone)]
pub(super) struct Adjusted {
    pub(super) state: SolverState,
    pub(super) noise: Noise,
    pub(super) weights: Vec<Weight>,
}

/// Alternates between adjusting, estimating the noise and dropping outliers.
pub(super) fn robustly(
    observations: &Observations,
    state: &SolverState,
    free: &Free,
    first: Noise,
    rounds: usize,
) -> Adjusted {
    let (mut state, mut noise) = (state.clone(), first);
    let mut weights = noise.weights(observations, &state, LIMIT);
    for _ in 0..rounds {
        state = minimise(observations, &weights, &state, free, Effort::FULL);
        weights = noise.weights(observations, &state, LIMIT);
        let measured = Noise::measured(observations, &state, &weights, free.len());
        if measured.pixel.is_nan() {
            break;
        }
        noise = measured;
        weights = noise.weights(observations, &state, LIMIT);
    }
    Adjusted { state, noise, weights }
}
