//! Accuracy of solutions.

use proptest::prelude::*;

use super::*;
use crate::Lens;

#[test]
fn lenses_are_found_among_gross_errors_and_auto_takes_the_terms_that_there_are() {
    for (coefficients, terms) in [
        (PINHOLE, DistortionTerms::None),
        (K1, DistortionTerms::K1),
        (K1K2, DistortionTerms::K1K2),
        (PLUMB_BOB, DistortionTerms::PlumbBob),
    ] {
        for (seed, gross) in [(0, 0.0), (1, 0.3), (2, 0.4)] {
            let simulation = Simulation { gross, ..Simulation::new(seed).with_distortion(coefficients) };
            let samples = simulation.samples();
            let solution = solve(&samples, &options()).unwrap();
            assert_eq!(solution.distortion, terms, "{seed}");
            let error_px = projection_error_px(&simulation, &solution);
            assert!(error_px < 0.15, "{terms:?} {seed}: {error_px} px");
            let focal = solution.lens.focal_px.component_div(&simulation.lens.focal_px);
            assert!((focal.x - 1.0).abs() < 1e-3 && (focal.y - 1.0).abs() < 1e-3, "{focal}");
            let share = solution.inliers as f64 / samples.len() as f64;
            assert!((share - (1.0 - gross)).abs() < 0.04, "{share}");
            assert!(solution.held_out_rms_px < 1.05 * solution.rms_px && solution.rms_px < 0.7);
        }
    }
}

#[test]
fn without_errors_the_solution_is_exact() {
    let simulation = Simulation { noise_px: 0.0, depth_noise_m: 0.0, ..Simulation::new(5).with_distortion(PLUMB_BOB) };
    let options = SolveOptions { distortion: DistortionTerms::PlumbBob, ..options() };
    let solution = solve(&simulation.samples(), &options).unwrap();
    assert!(projection_error_px(&simulation, &solution) < 1e-3 && solution.max_px < 1e-3);
}

#[test]
fn a_flat_wall_suffices_for_the_pose_of_a_known_lens() {
    for seed in 0..4 {
        let simulation = Simulation { is_flat: true, gross: 0.3, ..Simulation::new(seed).with_distortion(K1) };
        let options = SolveOptions { known_lens: Some(simulation.lens), ..options() };
        let solution = solve(&simulation.samples(), &options).unwrap();
        assert_eq!(solution.lens, simulation.lens);
        assert!(solution.estimates.iter().all(|estimate| estimate.sigma == 0.0));
        let error_px = projection_error_px(&simulation, &solution);
        assert!(error_px < 0.3, "{seed}: {error_px} px");
    }
}

#[test]
fn several_scans_share_the_lens_and_average_smooth_errors() {
    let mut squares = [0.0; 2];
    let seeds = seeds(0, 3, 6);
    let count = (seeds.end - seeds.start) as f64;
    for seed in seeds {
        let mut simulation =
            Simulation { smooth_depth_m: 0.001, step_px: 10, ..Simulation::new(seed).with_distortion(K1) };
        for (scans, square) in [1, 5].into_iter().zip(&mut squares) {
            simulation.projector_from_camera = (0..scans).map(|scan| pose(seed + 100 * scan)).collect();
            let solution = solve(&simulation.samples(), &options()).unwrap();
            assert_eq!(solution.poses.len() as u64, scans);
            *square += projection_error_px(&simulation, &solution).powi(2) / count;
        }
    }
    assert!(squares[1].sqrt() < 0.3 && squares[1] < 0.8 * squares[0], "{squares:?}");
}

#[test]
fn one_focal_length_and_fixed_parameters_stay() {
    let mut simulation = Simulation::new(3);
    simulation.lens = Lens::pinhole(SIZE_PX, [1400.0; 2], [645.0, 817.0]);
    let options = SolveOptions {
        focal: FocalLengths::One,
        fixed: vec![(Parameter::Cx, 645.0), (Parameter::Cy, 817.0)],
        ..options()
    };
    let solution = solve(&simulation.samples(), &options).unwrap();
    assert_eq!(solution.lens.focal_px.x, solution.lens.focal_px.y);
    assert_eq!(solution.lens.center_px, simulation.lens.center_px);
    assert!(solution.estimates.iter().all(|e| (e.sigma > 0.0) == matches!(e.parameter, Parameter::Fx | Parameter::Fy)));
    assert!(projection_error_px(&simulation, &solution) < 0.15);
}

#[test]
fn an_initial_lens_is_only_a_start() {
    let simulation = Simulation::new(4).with_distortion(K1);
    let initial = Lens::pinhole(SIZE_PX, [1300.0, 1350.0], [630.0, 780.0]);
    let solution = solve(&simulation.samples(), &SolveOptions { initial: Some(initial), ..options() }).unwrap();
    assert!(projection_error_px(&simulation, &solution) < 0.15);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let samples = Simulation { gross: 0.2, ..Simulation::new(6) }.samples();
    let with_threads = |count| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        pool.install(|| solve(&samples, &options()).unwrap())
    };
    assert_eq!(with_threads(1), with_threads(3));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    #[test]
    fn lenses_of_all_kinds_are_found(
        seed in 0_u64..1000, throw in 0.9..2.0, aspect in 0.97..1.03, cx in 560.0..720.0, cy in 350.0..850.0,
        k1 in -0.12..0.05,
    ) {
        let mut simulation = Simulation { gross: 0.1, step_px: 8, ..Simulation::new(seed) };
        let focal = 1280.0 * throw;
        simulation.lens = Lens::pinhole(SIZE_PX, [focal, focal * aspect], [cx, cy]);
        let simulation = simulation.with_distortion([k1, 0.0, 0.0, 0.0, 0.0]);
        let samples = simulation.samples();
        // Some of these hardly light the observed scene.
        let lit: Vec<_> = samples.iter().map(|sample| sample.pixel).collect();
        prop_assume!(samples.len() > 1000 && super::super::spread::outline_share(&lit, SIZE_PX) > 0.5);
        let solution = solve(&samples, &options()).unwrap();
        prop_assert!(is_found(&simulation, &solution));
    }
}

/// `true` if the projection error is below half a pixel, or, where points in a part of the volume leave the rest open,
/// every unknown is right within its stated deviation.
fn is_found(simulation: &Simulation, solution: &Solution) -> bool {
    let errors = super::uncertainty::normalised_errors(simulation, solution);
    projection_error_px(simulation, solution) < 0.5 || errors.iter().all(|error| error.abs() < 4.0)
}

/// The projection error is 0.6 pixels where there are no points, and the focal length, 0.8 ± 0.8 pixels off, says so.
#[test]
fn errors_beside_the_points_are_within_the_deviations() {
    let mut simulation = Simulation { gross: 0.1, step_px: 8, ..Simulation::new(232) };
    simulation.lens = Lens::pinhole(SIZE_PX, [1894.952, 1838.104], [704.456, 638.025]);
    let solution = solve(&simulation.samples(), &options()).unwrap();
    let errors = super::uncertainty::normalised_errors(&simulation, &solution);
    assert!(errors.iter().all(|error| error.abs() < 3.0), "{errors:?}");
    assert!(projection_error_px(&simulation, &solution) > 0.3, "the case has become an easy one");
}

#[test]
fn walls_at_several_angles_determine_a_lens_without_bias() {
    for seed in seeds(0, 2, 4) {
        let mut simulation = Simulation { is_flat: true, ..Simulation::new(seed) };
        simulation.projector_from_camera = (0..6).map(|scan| pose(seed + 100 * scan)).collect();
        let solution = solve(&simulation.samples(), &options()).unwrap();
        let errors = super::uncertainty::normalised_errors(&simulation, &solution);
        // With slopes at the observed points, these are up to 7.
        assert!(errors.iter().all(|error| error.abs() < 4.0), "{seed}: {errors:?}");
        assert!(projection_error_px(&simulation, &solution) < 0.8);
    }
}
