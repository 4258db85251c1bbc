//! Whether a keystone correction is noticed.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rayon::prelude::*;

use super::*;
use crate::{Report, Verdict};

/// A correction for a wall that is turned by these angles about the picture's rows and columns, degrees, by electronics
/// that know the throw but not where the principal point is.
fn turned(about_rows: f64, about_columns: f64) -> Matrix3<f64> {
    let lens = Matrix3::new(1400.0, 0.0, 639.5, 0.0, 1400.0, 399.5, 0.0, 0.0, 1.0);
    let [about_rows, about_columns] = [about_rows, about_columns].map(f64::to_radians);
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), about_rows)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), about_columns);
    lens * turn.into_inner() * lens.try_inverse().unwrap()
}

/// A correction that narrows one edge of the picture to this share and keeps the opposite one.
fn trapezoid(share: f64) -> Matrix3<f64> {
    let left = 0.5 * (1.0 - share) * 1279.0;
    let corrected = Matrix3::new(share, -left / 799.0, left, 0.0, share, 0.0, 0.0, (share - 1.0) / 799.0, 1.0);
    corrected.try_inverse().unwrap()
}

/// The verdict on a simulated scan whose picture was distorted like this, and its reasons.
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
        ("5° horizontally", turned(0.0, 5.0), Verdict::Again),
        ("10° horizontally", turned(0.0, -10.0), Verdict::Again),
        ("20° horizontally", turned(0.0, 20.0), Verdict::Again),
        ("5° both ways", turned(5.0, 5.0), Verdict::Again),
        ("10° both ways", turned(-10.0, 10.0), Verdict::Again),
        // Vertically the picture is stretched, but not skewed.
        ("5° vertically", turned(5.0, 0.0), Verdict::Usable),
        ("10° vertically", turned(10.0, 0.0), Verdict::Usable),
        ("20° vertically", turned(20.0, 0.0), Verdict::Usable),
        ("a trapezoid", trapezoid(0.9), Verdict::Usable),
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
