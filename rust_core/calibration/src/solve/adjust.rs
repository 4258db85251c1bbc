//! Robust least squares: the Levenberg-Marquardt method between estimates of the noise.

use super::input::Observations;
use super::levenberg_marquardt::{levenberg_marquardt, MOST_STEPS};
use super::model::{Free, SolverState};
use super::noise::{Noise, Weight, LIMIT};
use super::normal_equations::NormalEquations;

/// Minimises the cost of the used samples with fixed weights.
pub(super) fn minimise(
    observations: &Observations,
    weights: &[Weight],
    state: &SolverState,
    free: &Free,
    most_steps: usize,
) -> SolverState {
    let equations = |state: &SolverState| NormalEquations::new(observations, weights, state, free);
    levenberg_marquardt(state.clone(), most_steps, equations, |state, step| state.stepped(free, step))
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
        state = minimise(observations, &weights, &state, free, MOST_STEPS);
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
