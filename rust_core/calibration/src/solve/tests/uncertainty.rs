//! Correctness of standard deviations.

use rayon::prelude::*;

use super::super::model::lens_values;
use super::*;

/// Errors of lens and pose divided by their deviations.
pub(super) fn normalised_errors(simulation: &Simulation, solution: &Solution) -> Vec<f64> {
    let truth = lens_values(&simulation.lens);
    let mut errors: Vec<f64> = (solution.estimates.iter().filter(|estimate| estimate.sigma > 0.0))
        .map(|estimate| (estimate.value - truth[estimate.parameter as usize]) / estimate.sigma)
        .collect();
    let (pose, true_pose) = (&solution.poses[0], simulation.projector_from_camera[0]);
    let found = pose.projector_from_camera;
    let shift = found.inverse().translation.vector - true_pose.inverse().translation.vector;
    let turn = (found.rotation * true_pose.rotation.inverse()).scaled_axis();
    for axis in 0..3 {
        errors.push(shift[axis] / pose.position_sigma_m[axis]);
        errors.push(turn[axis] / pose.orientation_sigma_rad[axis]);
    }
    errors
}

/// RMS of all normalised errors, and minimum and maximum RMS of one unknown's.
fn spread(smooth_depth_m: f64, smooth_px: f64, scans: u64, terms: DistortionTerms) -> (f64, [f64; 2]) {
    let errors: Vec<Vec<f64>> = (0..100_u64)
        .into_par_iter()
        .map(|seed| {
            let k1 = if terms == DistortionTerms::None { PINHOLE } else { K1 };
            let mut simulation =
                Simulation { smooth_depth_m, smooth_px, step_px: 12, ..Simulation::new(seed).with_distortion(k1) };
            simulation.projector_from_camera = (0..scans).map(|scan| pose(seed + 1000 * scan)).collect();
            let solution = solve(&simulation.samples(), &SolveOptions { distortion: terms, ..options() })
                .unwrap_or_else(|refusal| panic!("{seed} {scans} {smooth_px}: {refusal}"));
            normalised_errors(&simulation, &solution)
        })
        .collect();
    let count = errors.len() as f64;
    let mean_squares: Vec<f64> =
        (0..errors[0].len()).map(|i| errors.iter().map(|errors| errors[i] * errors[i]).sum::<f64>() / count).collect();
    let all = (mean_squares.iter().sum::<f64>() / mean_squares.len() as f64).sqrt();
    let least = mean_squares.iter().copied().fold(f64::INFINITY, f64::min).sqrt();
    (all, [least, mean_squares.iter().copied().fold(0.0, f64::max).sqrt()])
}

#[test]
fn deviations_are_true_for_independent_errors() {
    let (all, [least, most]) = spread(0.0, 50.0, 1, DistortionTerms::K1);
    // The RMS of a hundred normal numbers varies by 7 %; these are the limits of twelve unknowns.
    assert!((0.9..1.1).contains(&all) && least > 0.8 && most < 1.25, "{all} {least} {most}");
}

#[test]
fn deviations_are_true_for_errors_that_neighbours_share() {
    let kinds = [
        (0.001, 50.0, 1, DistortionTerms::K1),
        (0.002, 30.0, 1, DistortionTerms::None),
        (0.001, 50.0, 2, DistortionTerms::K1),
    ];
    for (smooth_m, smooth_px, scans, terms) in kinds.into_iter().take(if has_many_seeds() { 3 } else { 1 }) {
        let (all, [least, most]) = spread(smooth_m, smooth_px, scans, terms);
        assert!(
            (0.85..1.15).contains(&all) && least > 0.75 && most < 1.3,
            "{smooth_m} {smooth_px}: {all} {least} {most}"
        );
    }
}
