//! Verdicts and reasons of reports.

use super::*;
use crate::{Report, Sample, Verdict};

fn report(simulation: &Simulation, keep: impl Fn(&Sample) -> bool) -> Report {
    let samples: Vec<Sample> = simulation.samples().into_iter().filter(keep).collect();
    let solution = solve(&samples, &options()).unwrap();
    Report::new(&samples, solution)
}

#[test]
fn a_clean_scan_is_good() {
    let report = report(&Simulation::new(0), |_| true);
    assert_eq!((report.verdict, report.reasons.as_slice()), (Verdict::Good, [].as_slice()));
    assert!(report.coverage.image > 0.6 && report.coverage.scans == 1);
    let [near, far] = report.coverage.depth_m;
    assert!(near > 0.5 && far < 2.5 && far > 1.5 * near);
    assert!(report.rms_m < 0.001 && report.smooth_depth_error_m < 0.0004);
}

#[test]
fn a_smooth_error_of_the_depth_is_measured_and_more_scans_are_asked_for() {
    let mut sum = 0.0;
    let seeds = seeds(0, 3, 8);
    let count = (seeds.end - seeds.start) as f64;
    for seed in seeds {
        let mut simulation = Simulation { smooth_depth_m: 0.0015, step_px: 8, ..Simulation::new(seed) };
        let single = report(&simulation, |_| true);
        // The error grows with the square of the distance, so it depends on where things are.
        assert!((0.0005..0.005).contains(&single.smooth_depth_error_m), "{}", single.smooth_depth_error_m);
        sum += single.smooth_depth_error_m;
        let advises = |report: &Report| report.reasons.iter().any(|reason| reason.contains("average 5 scans"));
        assert!(single.verdict != Verdict::Good && advises(&single), "{:?}", single.reasons);
        simulation.projector_from_camera = (0..5).map(|scan| pose(seed + 50 * scan)).collect();
        assert!(!advises(&report(&simulation, |_| true)));
    }
    assert!((0.001..0.004).contains(&(sum / count)), "{}", sum / count);
}

#[test]
fn a_scaled_image_is_named() {
    let mut samples = Simulation { step_px: 4, ..Simulation::new(2) }.samples();
    samples.iter_mut().for_each(|sample| sample.pixel.y *= 0.94);
    let solution = solve(&samples, &options()).unwrap();
    let report = Report::new(&samples, solution);
    let names = |reason: &&String| reason.contains("keystone");
    assert_eq!((report.verdict, report.reasons.iter().filter(names).count()), (Verdict::Usable, 1), "{report:?}");
}

#[test]
fn a_dark_side_of_the_image_is_named() {
    let report = report(&Simulation { step_px: 4, ..Simulation::new(1) }, |sample| sample.pixel.x < 450.0);
    assert!(report.verdict != Verdict::Good);
    assert!(report.reasons.iter().any(|reason| reason.contains("of the picture")), "{:?}", report.reasons);
}

#[test]
fn many_gross_errors_and_large_misses_are_named() {
    let gross = report(&Simulation { gross: 0.35, ..Simulation::new(2) }, |_| true);
    assert!(gross.verdict == Verdict::Usable && gross.reasons[0].contains("% of the points agree"));
    let simulation = Simulation { noise_px: 3.5, step_px: 3, ..Simulation::new(2) };
    let noisy = report(&simulation, |sample| simulation.lens.contains(sample.pixel));
    assert!(noisy.verdict == Verdict::Again && noisy.reasons[0].contains("held-out RMS error"), "{:?}", noisy.reasons);
}
