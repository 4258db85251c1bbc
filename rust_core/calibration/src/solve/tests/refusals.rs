//! Samples that must be refused, and similar ones that must not.

use nalgebra::{Isometry3, Point2, Vector3};

use super::*;
use crate::solve::random::SplitMix64;
use crate::{Lens, Report, Sample, Verdict};

fn refusal(samples: &[Sample], options: &SolveOptions) -> Refusal {
    let refusal = solve(samples, options).unwrap_err();
    let message = refusal.to_string();
    assert!(message.lines().count() == 1 && message.len() > 40, "{message}");
    refusal
}

#[test]
fn values_that_are_not_finite_are_refused() {
    let samples = Simulation::new(0).samples();
    for change in [
        |sample: &mut Sample| sample.pixel.x = f64::NAN,
        |sample: &mut Sample| sample.point.z = f64::INFINITY,
        |sample: &mut Sample| sample.sigma_px = f64::NAN,
        |sample: &mut Sample| sample.sigma_m = f64::NAN,
    ] {
        let mut samples = samples.clone();
        change(&mut samples[17]);
        assert_eq!(refusal(&samples, &options()), Refusal::NotFinite(17));
    }
    let mut negative = samples.clone();
    negative[3].sigma_px = -1.0;
    assert_eq!(refusal(&negative, &options()), Refusal::NegativeDeviation(3));
    let fixed = SolveOptions { fixed: vec![(Parameter::K1, f64::NAN)], ..options() };
    assert_eq!(refusal(&samples, &fixed), Refusal::FixedNotFinite(Parameter::K1));
}

#[test]
fn too_few_samples_are_refused() {
    let simulation = Simulation::new(0);
    let samples = simulation.samples();
    let known = SolveOptions { known_lens: Some(simulation.lens), ..options() };
    let every =
        |count: usize| -> Vec<Sample> { samples.iter().copied().step_by(samples.len() / count).take(count).collect() };
    for (count, options) in [(0, &options()), (11, &options()), (0, &known), (5, &known)] {
        assert!(
            matches!(refusal(&every(count.max(1))[..count], options), Refusal::TooFew { points, .. } if points == count)
        );
    }
    let few = every(8);
    let solution = solve(&few, &known).unwrap();
    assert!(projection_error_px(&simulation, &solution) < 10.0);
}

#[test]
fn a_flat_scene_is_refused_unless_the_lens_is_known() {
    for (seed, gross) in [(0, 0.0), (1, 0.3), (2, 0.0)] {
        for depth_noise_m in [0.0, 0.003] {
            let simulation = Simulation { is_flat: true, gross, depth_noise_m, ..Simulation::new(seed) };
            let samples = simulation.samples();
            assert_eq!(refusal(&samples, &options()), Refusal::Flat);
            let options = SolveOptions { known_lens: Some(simulation.lens), ..options() };
            assert!(solve(&samples, &options).is_ok());
        }
    }
}

#[test]
fn mirrored_images_are_refused() {
    for seed in 0..4 {
        for is_flat in [false, true] {
            let simulation = Simulation { is_flat, gross: 0.2, ..Simulation::new(seed).with_distortion(K1) };
            let known = SolveOptions { known_lens: Some(simulation.lens), ..options() };
            for (axis, size_px) in SIZE_PX.into_iter().enumerate() {
                let mut samples = simulation.samples();
                for sample in &mut samples {
                    sample.pixel[axis] = f64::from(size_px) - 1.0 - sample.pixel[axis];
                }
                if !is_flat {
                    assert_eq!(refusal(&samples, &options()), Refusal::Mirrored);
                }
                assert_eq!(refusal(&samples, &known), Refusal::Mirrored, "{seed} {is_flat} {axis}");
            }
        }
    }
}

#[test]
fn few_mirrored_points_give_no_usable_pose() {
    for seed in 0..8 {
        let simulation = Simulation { noise_px: 0.5, ..Simulation::new(seed) };
        let known = SolveOptions { known_lens: Some(simulation.lens), ..options() };
        let all = simulation.samples();
        for count in [6, 8, 20] {
            let mut few: Vec<Sample> = all.iter().copied().step_by(all.len() / count).take(count).collect();
            few.iter_mut().for_each(|sample| sample.pixel.x = 1279.0 - sample.pixel.x);
            let verdict = solve(&few, &known).map(|solution| Report::new(&few, solution).verdict);
            assert!(matches!(verdict, Err(_) | Ok(Verdict::Again)), "{seed} {count}: {verdict:?}");
        }
    }
}

#[test]
fn a_projector_that_hangs_upside_down_is_not_mirrored() {
    let mut simulation = Simulation::new(1);
    simulation.lens = Lens::pinhole(SIZE_PX, [1400.0, 1400.0], [639.5, 399.5]);
    let mut samples = simulation.samples();
    for sample in &mut samples {
        sample.pixel = (nalgebra::Vector2::new(1279.0, 799.0) - sample.pixel.coords).into();
    }
    assert!(solve(&samples, &options()).is_ok());
}

#[test]
fn a_camera_that_moved_is_refused() {
    for seed in 0..4 {
        let simulation = Simulation { gross: 0.05, ..Simulation::new(seed) };
        for (share, by) in [(0.5, 0.02), (0.4, 0.02), (0.2, 0.02), (0.15, 0.1), (0.5, 0.008)] {
            let mut samples = simulation.samples();
            let moved = Isometry3::new(Vector3::new(by, -0.5 * by, 0.2 * by), Vector3::new(0.3 * by, 0.5 * by, 0.0));
            let count = (samples.len() as f64 * share) as usize;
            for sample in &mut samples[..count] {
                sample.point = moved * sample.point;
            }
            let refusal = refusal(&samples, &options());
            assert!(
                matches!(refusal, Refusal::Moved { .. } | Refusal::FewInliers { .. } | Refusal::Inconsistent(_)),
                "{seed} {share} {by}: {refusal}"
            );
        }
    }
}

#[test]
fn samples_that_do_not_belong_together_are_refused() {
    for seed in seeds(0, 1, 3) {
        let simulation = Simulation { gross: 0.7, ..Simulation::new(seed) };
        let refused = refusal(&simulation.samples(), &options());
        assert!(
            matches!(refused, Refusal::FewInliers { .. } | Refusal::Inconsistent(_) | Refusal::NoSolution(_)),
            "{refused}"
        );
        let simulation = Simulation { gross: 1.0, ..simulation };
        refusal(&simulation.samples(), &options());
    }
}

#[test]
fn points_behind_are_refused() {
    let simulation = Simulation::new(0);
    let mut samples = simulation.samples();
    samples[9].point.z = -1.0;
    assert_eq!(refusal(&samples, &options()), Refusal::BehindCamera(9));
}

#[test]
fn points_behind_the_projector_are_refused() {
    // The projector stands half a metre before the camera, which sees objects between both at every fifth sample.
    let mut simulation = Simulation::new(0);
    simulation.projector_from_camera[0].translation.z = -0.5;
    let (pose, known) =
        (simulation.projector_from_camera[0], SolveOptions { known_lens: Some(simulation.lens), ..options() });
    let mut samples = simulation.samples();
    let mut random = SplitMix64::new(0, 1);
    for sample in samples.iter_mut().step_by(5) {
        let ray = sample.point / sample.point.z;
        sample.point = ray * (0.1 + 0.2 * random.unit());
        sample.pixel = Point2::new(1280.0 * random.unit() - 0.5, 800.0 * random.unit() - 0.5);
        assert!(sample.point.z > 0.0 && (pose * sample.point).z < 0.0);
    }
    for options in [options(), known] {
        let Refusal::BehindProjector(percent) = refusal(&samples, &options) else {
            panic!("{:?}", refusal(&samples, &options));
        };
        assert!((percent - 20.0).abs() < 1.0, "{percent}");
    }
}

#[test]
fn another_projectors_size_is_refused() {
    let samples = Simulation::new(0).samples();
    let smaller = refusal(&samples, &SolveOptions::new([1024, 768]));
    assert!(matches!(smaller, Refusal::OtherSize { size_px: [1024, 768], .. }));
    let lens = Lens::pinhole([1920, 1080], [2000.0; 2], [960.0, 540.0]);
    let known = SolveOptions { known_lens: Some(lens), ..options() };
    assert_eq!(refusal(&samples, &known), Refusal::OtherLens { lens_px: [1920, 1080], size_px: SIZE_PX });
}

#[test]
fn focal_lengths_must_be_positive_and_agree_without_skew() {
    let samples = Simulation::new(0).samples();
    let fixed = SolveOptions { fixed: vec![(Parameter::Fx, -1400.0)], ..options() };
    assert_eq!(refusal(&samples, &fixed), Refusal::NegativeFocal(-1400.0, Parameter::Fx));
    let initial = Some(Lens::pinhole(SIZE_PX, [1400.0, -1400.0], [640.0, 400.0]));
    let initial = SolveOptions { initial, ..options() };
    assert_eq!(refusal(&samples, &initial), Refusal::NegativeFocal(-1400.0, Parameter::Fy));
    let skewed = Lens { skew_px: [-4.0, 0.0].into(), ..Lens::pinhole(SIZE_PX, [1400.0; 2], [640.0, 400.0]) };
    let known = SolveOptions { known_lens: Some(skewed), ..options() };
    assert_eq!(refusal(&samples, &known), Refusal::Skewed { skew_px: [-4.0, 0.0] });
    let fixed = vec![(Parameter::Fx, 1400.0), (Parameter::Fy, 1500.0)];
    let fixed = SolveOptions { fixed, focal: FocalLengths::One, ..options() };
    assert_eq!(refusal(&samples, &fixed), Refusal::Contradiction(Parameter::Fx, Parameter::Fy));
}

#[test]
fn points_in_a_corner_or_at_one_depth_are_refused() {
    for seed in 0..4 {
        let samples = Simulation { step_px: 4, ..Simulation::new(seed) }.samples();
        let corner: Vec<Sample> =
            samples.iter().copied().filter(|sample| sample.pixel.x < 400.0 && sample.pixel.y > 500.0).collect();
        let refused = refusal(&corner, &options());
        assert!(
            matches!(
                refused,
                Refusal::BadlySpread(_) | Refusal::Flat | Refusal::Undetermined { .. } | Refusal::TooFew { .. }
            ),
            "{refused}"
        );
        let nearest = samples.iter().map(|sample| sample.point.z).fold(f64::INFINITY, f64::min);
        let mut thin = samples.clone();
        thin.retain(|sample| sample.point.z > 1.4 * nearest && sample.point.z < 1.415 * nearest);
        if thin.len() > 50 {
            refusal(&thin, &options());
        }
    }
}

#[test]
fn another_lens_is_noticed() {
    let simulation = Simulation::new(2);
    let known_lens = Some(Lens::pinhole(SIZE_PX, [1700.0, 1700.0], [640.0, 400.0]));
    let refused = refusal(&simulation.samples(), &SolveOptions { known_lens, ..options() });
    assert!(
        matches!(refused, Refusal::Inconsistent(_) | Refusal::FewInliers { .. } | Refusal::Moved { .. }),
        "{refused}"
    );
}

#[test]
fn few_points_give_a_pose_and_their_deviations_say_how_well() {
    let mut good = 0;
    for seed in 0..12 {
        let simulation = Simulation { noise_px: 0.5, ..Simulation::new(seed) };
        let known = SolveOptions { known_lens: Some(simulation.lens), ..options() };
        let samples = simulation.samples();
        let few: Vec<Sample> = samples.iter().copied().step_by(samples.len() / 10 + 7).collect();
        match solve(&few, &known) {
            Ok(solution) => {
                let miss = projection_error_px(&simulation, &solution) / solution.prediction_sigma_px;
                good += 1;
                assert!(miss < 8.0, "{seed}: {miss} deviations");
            }
            Err(refused) => assert!(
                matches!(
                    refused,
                    Refusal::Unpredictive { .. } | Refusal::Undetermined { .. } | Refusal::FewInliers { .. }
                ),
                "{refused}"
            ),
        }
    }
    assert!(good >= 8, "{good} of 12");
}

#[test]
fn six_points_that_a_crosshair_was_steered_onto_give_a_pose() {
    let (mut good, mut worst) = (0, 0.0_f64);
    for seed in 0..20 {
        let simulation = Simulation { noise_px: 0.8, depth_noise_m: 0.001, ..Simulation::new(seed) };
        let known = SolveOptions { known_lens: Some(simulation.lens), ..options() };
        let all = simulation.samples();
        // The nearest to places all over the image.
        let places = [[200, 150], [640, 120], [1080, 150], [200, 650], [640, 680], [1080, 650]];
        let nearest = |place: [i32; 2]| {
            let place = Point2::from(place.map(f64::from));
            let distance = |sample: &&Sample| (sample.pixel - place).norm();
            *all.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
        };
        let six = places.map(nearest).map(|sample| Sample { sigma_px: 1.0, sigma_m: 0.0, ..sample });
        if let Ok(solution) = solve(&six, &known) {
            good += usize::from(solution.inliers == 6);
            worst = worst.max(projection_error_px(&simulation, &solution));
        }
    }
    assert!(good >= 18 && worst < 12.0, "{good} of 20, {worst} px");
}
