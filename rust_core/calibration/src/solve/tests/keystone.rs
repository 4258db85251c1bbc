//! Detection of keystone corrections.

use nalgebra::Matrix3;
use rayon::prelude::*;
use rcs_scan_simulator::Conditions;

use super::*;
use crate::{Report, Verdict};

/// Verdict on a simulated scan with a distorted image, and its reasons.
fn verdict(simulation: &Simulation, keystone: &Matrix3<f64>) -> Result<(Verdict, Vec<String>), Refusal> {
    let mut samples = simulation.samples();
    for sample in &mut samples {
        sample.pixel = keystone.transform_point(&sample.pixel);
    }
    samples.retain(|sample| simulation.lens.contains(sample.pixel));
    let report = Report::new(&samples, solve(&samples, &options())?);
    Ok((report.verdict, report.reasons))
}

#[test]
fn a_keystone_correction_is_named() {
    let corrections = [
        ("5° horizontally", Conditions::keystone(0.0, 5.0), Verdict::Again),
        ("10° horizontally", Conditions::keystone(0.0, -10.0), Verdict::Again),
        ("20° horizontally", Conditions::keystone(0.0, 20.0), Verdict::Again),
        ("5° both ways", Conditions::keystone(5.0, 5.0), Verdict::Again),
        ("10° both ways", Conditions::keystone(-10.0, 10.0), Verdict::Again),
        // Vertically the image is stretched, but not skewed.
        ("5° vertically", Conditions::keystone(5.0, 0.0), Verdict::Usable),
        ("10° vertically", Conditions::keystone(10.0, 0.0), Verdict::Usable),
        ("20° vertically", Conditions::keystone(20.0, 0.0), Verdict::Usable),
        ("a trapezoid", Conditions::trapezoid(SIZE_PX, 0.9), Verdict::Usable),
    ];
    corrections.into_par_iter().for_each(|(name, correction, least)| {
        for (seed, noise_px) in [(0, 0.1), (1, 0.3)] {
            let simulation = Simulation { noise_px, step_px: 8, ..Simulation::new(seed).with_distortion(K1) };
            match verdict(&simulation, &correction) {
                Ok((verdict, reasons)) => {
                    let is_named = reasons.iter().any(|reason| reason.contains("keystone"));
                    assert!(
                        is_named && (verdict == least || verdict == Verdict::Again),
                        "{name}: {verdict:?} {reasons:?}"
                    );
                }
                Err(refusal) => assert!(refusal.to_string().contains("keystone"), "{name}: {refusal}"),
            }
        }
    });
}

#[test]
fn true_lenses_are_not_skewed() {
    // Twelve have each noise, error of the depth and distortion together.
    seeds(0, 12, 40).into_par_iter().for_each(|seed| {
        let mut simulation = Simulation {
            noise_px: [0.1, 0.3][seed as usize % 2],
            smooth_depth_m: [0.0, 0.001, 0.002][seed as usize % 3],
            step_px: 10,
            ..Simulation::new(seed).with_distortion([PINHOLE, K1, K1K2, PLUMB_BOB][seed as usize % 4])
        };
        simulation.projector_from_camera = (0..1 + seed % 3).map(|scan| pose(seed + 100 * scan)).collect();
        let (_, reasons) = verdict(&simulation, &Matrix3::identity()).unwrap();
        assert!(!reasons.iter().any(|reason| reason.contains("keystone")), "{seed}: {reasons:?}");
    });
}
