//! The Levenberg-Marquardt method (Marquardt 1963; Nielsen's damping, 1999).

use nalgebra::{DMatrix, DVector};

use super::normal_equations::NormalEquations;

/// Minimum predicted decrease of the cost: smaller steps would move no unknown by a tenth of its deviation.
const NEGLIGIBLE: f64 = 1e-3;
/// Initial damping, as a share of the second derivatives.
const FIRST_DAMPING: f64 = 1e-4;
/// Damping at which the search ends.
const LAST_DAMPING: f64 = 1e8;

/// Maximum number of steps that suffices for convergence.
pub(crate) const MOST_STEPS: usize = 15;

/// Minimises a cost from a first state, by its equations at a state and the state after a step, if that is valid.
pub(crate) fn levenberg_marquardt<State>(
    mut state: State,
    most_steps: usize,
    equations_at: impl Fn(&State) -> NormalEquations,
    stepped: impl Fn(&State, &DVector<f64>) -> Option<State>,
) -> State {
    let mut equations = equations_at(&state);
    let (mut damping, mut raise) = (FIRST_DAMPING, 2.0);
    for _ in 0..most_steps {
        if damping > LAST_DAMPING {
            break;
        }
        let Some(step) = damped_step(&equations, damping) else {
            damping *= 10.0;
            continue;
        };
        let promised = step.dot(&equations.descent);
        if promised.is_nan() || promised < NEGLIGIBLE {
            break;
        }
        let trial = stepped(&state, &step).map(|trial| {
            let equations = equations_at(&trial);
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
pub(super) fn solve_positive(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
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
