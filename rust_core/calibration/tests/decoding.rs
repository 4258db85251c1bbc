//! Decoding of simulated scans: completeness, accuracy, and detection of bad scans.

use nalgebra::Vector2;
use rcs_calibration::patterns::{gray_code, shifted_gray_code, Pattern, Stripes};
use rcs_calibration::statistics::median;
use rcs_calibration::{decode, Decoded, Images, ScanProblem};
use rcs_scan_simulator::{seeds, Conditions, Motion, Rig, Room, Scan, View};

const PROJECTOR_PX: [u32; 2] = [1280, 800];

fn view(seed: u64) -> View {
    View::new(&Room::cluttered(seed), &Rig::random(seed))
}

fn decoded(view: &View, conditions: Conditions, patterns: &[Pattern]) -> Decoded {
    decoded_as(view, &Scan::new(view, conditions).capture_all(patterns), patterns, PROJECTOR_PX)
}

fn decoded_as(view: &View, images: &[Vec<u8>], patterns: &[Pattern], projector_px: [u32; 2]) -> Decoded {
    let levels = images.iter().map(Vec::as_slice).collect();
    let decoded = decode(&Images { size_px: view.size_px(), patterns, levels }, projector_px);
    decoded.unwrap_or_else(|error| panic!("{error}"))
}

/// Comparison of a decoded scan with the truth.
struct Score {
    /// Share of lit pixels that are decoded.
    decoded: f64,
    /// Share of decoded pixels that are right within a pixel along both axes.
    right: f64,
    /// RMS error of the right pixels, projector pixels.
    rms_px: f64,
    /// Median of the errors over their standard deviations; 0.67 if these are correct.
    pull: f64,
}

fn score(view: &View, decoded: &Decoded) -> Score {
    let (mut lit, mut count, mut squares, mut pulls) = (0, 0, 0.0, Vec::new());
    for (index, pixel) in decoded.pixels.iter().enumerate() {
        let truth = view.truth(index as u32 % decoded.size_px[0], index as u32 / decoded.size_px[0]);
        lit += usize::from(truth.is_some());
        count += usize::from(pixel.is_decoded() && truth.is_some());
        let Some(truth) = truth.filter(|_| pixel.is_decoded()) else { continue };
        let error = Vector2::new(f64::from(pixel.at[0]) - truth.x, f64::from(pixel.at[1]) - truth.y);
        if error.amax() <= 1.0 {
            squares += error.norm_squared();
            pulls.extend([0, 1].map(|axis| (error[axis] / f64::from(pixel.sigma[axis])).abs()));
        }
    }
    let right = (pulls.len() / 2) as f64;
    Score {
        decoded: f64::from(count as u32) / f64::from(lit as u32),
        right: right / decoded.count() as f64,
        rms_px: (squares / right).sqrt(),
        pull: median(&mut pulls),
    }
}

#[test]
fn cluttered_rooms_are_decoded_whatever_the_seed() {
    for seed in seeds(100, 3, 25) {
        let view = view(seed);
        let decoded = decoded(&view, Conditions::random(seed), &gray_code(PROJECTOR_PX));
        let score = score(&view, &decoded);
        println!(
            "seed {seed}: {:.1} % decoded, {:.2} % of them right, {:.3} px RMS, pull {:.2}",
            100.0 * score.decoded,
            100.0 * score.right,
            score.rms_px,
            score.pull
        );
        assert!(score.decoded > 0.90, "seed {seed}: {:.3} decoded", score.decoded);
        assert!(score.right > 0.99, "seed {seed}: {:.4} right", score.right);
        assert!(score.rms_px < 0.2, "seed {seed}: {:.3} px", score.rms_px);
        // Deviations may be up to three times too large.
        assert!((0.2..1.0).contains(&score.pull), "seed {seed}: pull {:.2}", score.pull);
        assert_eq!(decoded.quality.problems(), [], "seed {seed}");
    }
}

#[test]
fn wide_stripes_that_are_shifted_are_decoded_too() {
    let view = view(31);
    let score = score(&view, &decoded(&view, Conditions::random(31), &shifted_gray_code(PROJECTOR_PX, 4)));
    assert!(score.decoded > 0.90 && score.right > 0.99, "{:.3} {:.4}", score.decoded, score.right);
    assert!(score.rms_px < 0.2, "{:.3} px", score.rms_px);
}

#[test]
fn the_cameras_gamma_is_found() {
    let view = view(32);
    for gamma in [1.0, 1.6, 2.2] {
        let conditions = Conditions { gamma, ..Conditions::random(32) };
        let found = decoded(&view, conditions, &gray_code(PROJECTOR_PX)).quality.gamma;
        assert!((found - gamma).abs() < 0.12, "{found:.2} instead of {gamma}");
    }
}

#[test]
fn a_camera_that_moves_is_noticed() {
    let view = view(33);
    for shift_px in [Vector2::new(1.0, 0.3), Vector2::new(-0.2, 2.5), Vector2::new(6.0, -4.0)] {
        let motion = Some(Motion { from_image: 20, shift_px });
        let conditions = Conditions { motion, ..Conditions::random(33) };
        let problems = decoded(&view, conditions, &gray_code(PROJECTOR_PX)).quality.problems();
        assert!(matches!(problems[..], [ScanProblem::Moved(_), ..]), "{shift_px:?}: {problems:?}");
        assert!(problems[0].is_fatal() && problems[0].to_string().contains("at rest"));
    }
}

#[test]
fn an_exposure_that_drifts_is_noticed() {
    let view = view(34);
    let conditions = Conditions { drift_per_image: 0.004, ..Conditions::random(34) };
    let problems = decoded(&view, conditions, &gray_code(PROJECTOR_PX)).quality.problems();
    assert!(matches!(problems[..], [ScanProblem::Exposure(change)] if (0.08..0.25).contains(&change)), "{problems:?}");
    assert!(problems[0].to_string().contains("automatic exposure"));
}

#[test]
fn too_long_an_exposure_is_noticed() {
    let view = view(35);
    let conditions = Conditions { exposure: 2.0, ..Conditions::random(35) };
    let problems = decoded(&view, conditions, &gray_code(PROJECTOR_PX)).quality.problems();
    assert!(problems.iter().any(|problem| matches!(problem, ScanProblem::Clipped(_))), "{problems:?}");
    assert!(problems.iter().all(|problem| !problem.is_fatal()), "{problems:?}");
}

#[test]
fn patterns_of_another_projector_are_noticed() {
    let view = view(8);
    let patterns = gray_code(PROJECTOR_PX);
    let images = Scan::new(&view, Conditions::random(8)).capture_all(&patterns);
    let beyond = |patterns: &[Pattern], projector_px| {
        let problems = decoded_as(&view, &images, patterns, projector_px).quality.problems();
        problems.first().is_some_and(|problem| matches!(problem, ScanProblem::Beyond { .. }) && problem.is_fatal())
    };
    assert!(!beyond(&patterns, PROJECTOR_PX) && beyond(&patterns, [1024, 768]));
    let doubled = patterns.iter().map(|pattern| match *pattern {
        Pattern::GrayCode(stripes) => Pattern::GrayCode(Stripes { step: 2, ..stripes }),
        other => other,
    });
    assert!(beyond(&doubled.collect::<Vec<_>>(), PROJECTOR_PX));
}

#[test]
fn dark_pixels_are_not_decoded() {
    let view = view(36);
    let patterns = gray_code(PROJECTOR_PX);
    let black = vec![Pattern::Black; patterns.len()];
    let images = Scan::new(&view, Conditions::random(36)).capture_all(&black);
    let levels = images.iter().map(Vec::as_slice).collect();
    let decoded = decode(&Images { size_px: view.size_px(), patterns: &patterns, levels }, PROJECTOR_PX).unwrap();
    assert!(decoded.lit < 300 && decoded.count() == 0, "{} lit, {} decoded", decoded.lit, decoded.count());
}
