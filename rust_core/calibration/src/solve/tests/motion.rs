//! Small motions during a scan: refusals, and no false alarms.

use nalgebra::{Isometry3, Point2, UnitQuaternion, Vector2, Vector3};

use super::synthetic::pose;
use super::*;
use crate::solve::random::SplitMix64;
use crate::Sample;

/// Change of the camera's pose or the projector's zoom.
#[derive(Debug, Clone, Copy)]
struct Change {
    degrees: f64,
    shift_m: f64,
    zoom: f64,
}

const NONE: Change = Change { degrees: 0.0, shift_m: 0.0, zoom: 1.0 };

/// Samples observed after the change.
#[derive(Debug, Clone, Copy)]
enum Which {
    Any(f64),
    Last(f64),
}

fn shuffled(simulation: &Simulation) -> Vec<Sample> {
    let mut samples = simulation.samples();
    let mut random = SplitMix64::new(simulation.seed, 55);
    for i in (1..samples.len()).rev() {
        samples.swap(i, random.below(i + 1));
    }
    samples
}

fn changed(simulation: &Simulation, change: Change, which: Which) -> Vec<Sample> {
    let mut random = SplitMix64::new(simulation.seed, 56);
    let mut direction = || Vector3::from_fn(|_, _| random.unit() - 0.5).normalize();
    // A rotation about the view itself moves pixels less.
    let axis = Vector3::new(1.0, 1.0, 0.0).component_mul(&direction()).normalize();
    let turn = UnitQuaternion::from_scaled_axis(axis * change.degrees.to_radians());
    let moved = Isometry3::from_parts((direction() * change.shift_m).into(), turn);
    let mut samples = shuffled(simulation);
    let count = samples.len() as f64;
    for (index, sample) in samples.iter_mut().enumerate() {
        let is_changed = match which {
            Which::Any(share) => random.unit() < share,
            Which::Last(share) => index as f64 >= (1.0 - share) * count,
        };
        if is_changed {
            sample.point = moved * sample.point;
            let center = Vector2::new(639.5, 399.5);
            sample.pixel = Point2::from(center + (sample.pixel.coords - center) * change.zoom);
        }
    }
    samples.retain(|sample| (-0.5..=1279.5).contains(&sample.pixel.x) && (-0.5..=799.5).contains(&sample.pixel.y));
    samples
}

fn is_motion(refused: &Refusal) -> bool {
    matches!(refused, Refusal::Moved { .. } | Refusal::TwoPoses { .. })
}

#[test]
fn a_distortion_that_is_not_solved_for_is_named() {
    for seed in seeds(0, 1, 2) {
        for k1 in [-0.1, 0.05] {
            let samples =
                Simulation { step_px: 9, ..Simulation::new(seed) }.with_distortion([k1, 0.0, 0.0, 0.0, 0.0]).samples();
            let pinhole = SolveOptions { distortion: DistortionTerms::None, ..options() };
            let fixed = SolveOptions { fixed: vec![(Parameter::K1, 0.0)], ..options() };
            for options in [pinhole, fixed] {
                let result = solve(&samples, &options);
                assert!(!result.as_ref().is_err_and(is_motion), "{seed} {k1}: {:?}", result.err());
            }
        }
    }
    let samples = Simulation::new(0).with_distortion([-0.1, 0.0, 0.0, 0.0, 0.0]).samples();
    let pinhole = SolveOptions { distortion: DistortionTerms::None, ..options() };
    let refused = solve(&samples, &pinhole).unwrap_err();
    assert!(matches!(refused, Refusal::DistortionLeftOut(percent) if percent > 5.0), "{refused}");
}

#[test]
fn a_small_motion_of_any_samples_is_refused() {
    let changes = [
        Change { degrees: 0.1, ..NONE },
        Change { degrees: 0.2, ..NONE },
        Change { degrees: 0.5, ..NONE },
        Change { shift_m: 0.003, ..NONE },
        Change { zoom: 1.01, ..NONE },
    ];
    for seed in 0..2 {
        let simulation = Simulation { depth_noise_m: 0.0004, gross: 0.1, step_px: 9, ..Simulation::new(seed) };
        for change in changes {
            for share in [0.5, 0.25] {
                let refused = solve(&changed(&simulation, change, Which::Any(share)), &options()).err();
                let refused = refused.unwrap_or_else(|| panic!("{seed} {change:?} {share}"));
                let is_named = match &refused {
                    Refusal::Moved { .. } => true,
                    Refusal::TwoPoses { second_percent, is_in_order, apart_px, .. } => {
                        let off =
                            (second_percent - 100.0 * share).abs().min((100.0 - second_percent - 100.0 * share).abs());
                        !is_in_order && *apart_px < 25.0 && off < 10.0
                    }
                    _ => false,
                };
                assert!(is_named, "{seed} {change:?} {share}: {refused}");
                assert_eq!(refused.to_string().lines().count(), 1);
            }
        }
    }
}

#[test]
fn two_scans_in_one_are_refused_even_with_noisy_depth() {
    for seed in 0..3 {
        let changes = [
            (Change { degrees: 0.1, ..NONE }, 0.003),
            (Change { shift_m: 0.002, ..NONE }, 0.003),
            (Change { degrees: 0.05, ..NONE }, 0.0004),
        ];
        for (change, depth_noise_m) in changes {
            let simulation = Simulation { depth_noise_m, ..Simulation::new(seed) };
            let refused = solve(&changed(&simulation, change, Which::Last(0.4)), &options()).unwrap_err();
            let Refusal::TwoPoses { is_in_order: true, second_percent, .. } = refused else {
                panic!("{seed} {change:?}: {refused}");
            };
            assert!((second_percent - 40.0).abs() < 10.0, "{second_percent}");
            assert!(refused.to_string().contains("the last ones"), "{refused}");
        }
    }
}

#[test]
fn errors_of_all_other_kinds_are_no_motion() {
    let still = |seed| Simulation { step_px: 9, ..Simulation::new(seed).with_distortion([-0.02, 0.0, 0.0, 0.0, 0.0]) };
    for seed in seeds(0, 1, 2) {
        let kinds = [
            ("clean", Simulation { noise_px: 0.01, depth_noise_m: 0.0, ..still(seed) }),
            ("noisy", Simulation { noise_px: 0.5, depth_noise_m: 0.006, ..still(seed) }),
            ("smooth", Simulation { smooth_depth_m: 0.002, smooth_px: 90.0, ..still(seed) }),
            ("smooth only", Simulation { smooth_depth_m: 0.002, noise_px: 0.02, depth_noise_m: 0.0, ..still(seed) }),
            ("gross", Simulation { gross: 0.3, smooth_depth_m: 0.001, ..still(seed) }),
            ("scans", Simulation { projector_from_camera: vec![pose(seed), pose(seed + 9)], ..still(seed) }),
        ];
        for (kind, simulation) in kinds {
            for samples in [simulation.samples(), shuffled(&simulation)] {
                assert!(solve(&samples, &options()).is_ok(), "{seed} {kind}: {:?}", solve(&samples, &options()).err());
            }
            // A lens solved for without its distortion.
            let pinhole = SolveOptions { distortion: DistortionTerms::None, ..options() };
            let result = solve(&simulation.samples(), &pinhole);
            assert!(!result.as_ref().is_err_and(is_motion), "{seed} {kind}: {:?}", result.err());
        }
    }
}

#[test]
fn whole_pixels_and_steps_of_depth_are_no_motion() {
    for seed in 0..2 {
        for is_flat in [false, true] {
            let simulation =
                Simulation { is_flat, noise_px: 0.05, depth_noise_m: 0.0005, step_px: 4, ..Simulation::new(seed) };
            let options = SolveOptions { known_lens: is_flat.then_some(simulation.lens), ..options() };
            let mut samples = simulation.samples();
            for sample in &mut samples {
                sample.pixel = sample.pixel.map(f64::round);
                // Steps of 1/8 pixel of a camera with a baseline of 7.5 cm.
                let inverse = (345.0 / sample.point.z).round() / 345.0;
                sample.point *= 1.0 / (inverse * sample.point.z);
            }
            assert!(solve(&samples, &options).is_ok(), "{seed} {is_flat}");
        }
    }
}
