//! Refinements in simulated rooms, of projectors that were bumped.

use std::time::Duration;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use rcs_calibration::RefinementProblem;
use rcs_scan_simulator::{seeds, LightError};

use super::is_refused;
use super::world::{Faults, SimulatedCamera, SimulatedScreen, World, PROJECTOR_PX};
use crate::failure::ScanFailure;
use crate::pose_refinement::Refinement;
use crate::session::{ScanEvent, ScanOptions, ScanSession};

/// Refines the pose of a bumped projector. Returns the images that were shown and the largest error, too, pixels.
fn refine(faults: Faults, bump: Isometry3<f64>) -> (Result<Refinement, ScanFailure>, usize, f64) {
    let world = World::new(faults);
    let (mut screen, mut camera) = (SimulatedScreen(world.clone()), SimulatedCamera(world.clone()));
    let (lens, truth) = (world.borrow().rig().projector, world.borrow().rig().projector_from_camera());
    let options = ScanOptions { projector_px: PROJECTOR_PX, step: 1, frames: 3, is_cancelled: &|| false };
    let mut observe = |_: ScanEvent<'_>| ();
    let result = ScanSession::new(&mut screen, &mut camera, &options, &mut observe).refine(&lens, &(bump * truth));
    let error_px = result.as_ref().map_or(f64::NAN, |refinement| {
        let pose = refinement.refined.solution.poses[0].projector_from_camera;
        LightError::between((&lens, &truth), (&lens, &pose)).max_px
    });
    let shown = world.borrow().shown();
    (result, shown, error_px)
}

/// Two degrees and two centimetres.
fn bump() -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_euler_angles(0.02, -0.02, 0.02);
    Isometry3::from_parts(Translation3::new(0.015, -0.01, 0.01), rotation)
}

#[test]
fn a_bump_is_mended_in_ten_seconds() {
    let (mut slowest, mut worst_px, mut refused, mut rooms) = (Duration::ZERO, 0.0_f64, 0, 0);
    for seed in seeds(1, 4, 100) {
        // At 160×120, some rooms have hardly more places than are needed.
        let (result, shown, error_px) = refine(Faults { seed, camera_px: [320, 240], ..Faults::default() }, bump());
        rooms += 1;
        match result {
            Ok(refinement) => {
                // Black, white, black and white, spots, white, black.
                assert!(shown <= 4 + 8 + 2, "seed {seed}: {shown}");
                assert!(error_px < 1.0, "seed {seed}: {error_px}");
                (slowest, worst_px) = (slowest.max(refinement.elapsed), worst_px.max(error_px));
            }
            Err(ScanFailure::Refinement(RefinementProblem::FewSeen { .. })) => refused += 1,
            Err(failure) => panic!("seed {seed}: {failure}"),
        }
    }
    println!(
        "{rooms} rooms, {refused} refused; slowest {:.1} s, worst error {worst_px:.2} px of 320x200",
        slowest.as_secs_f64()
    );
    assert!(slowest < Duration::from_secs(10) && refused * 20 <= rooms, "{slowest:?} {refused} {rooms}");
}

#[test]
fn a_slow_camera_and_screen_get_ten_seconds_too() {
    let (result, ..) = refine(Faults { lag: Duration::from_millis(400), ..Faults::default() }, bump());
    let elapsed = result.unwrap().elapsed;
    assert!(elapsed < Duration::from_secs(10), "{elapsed:?}");
}

#[test]
fn motion_at_any_time_is_refused() {
    // The first look, white and spots take about 5 s, the last white is shown before that.
    for seed in seeds(1, 8, 100) {
        let after = Duration::from_millis(1600 + 350 * (seed % 8));
        let faults = Faults { seed, moves_after: Some(after), ..Faults::default() };
        let (result, _, error_px) = refine(faults, bump());
        let Err(failure) = result else {
            // It came after the last spots.
            assert!(error_px < 1.0 && after > Duration::from_secs(3), "seed {seed}: {after:?}, {error_px} px");
            continue;
        };
        assert!(is_refused(&failure), "seed {seed}: {failure}");
        let is_motion = matches!(
            failure,
            ScanFailure::Moved(_)
                | ScanFailure::Unsteady(_)
                | ScanFailure::Restless(_)
                | ScanFailure::Refinement(RefinementProblem::Moved { .. } | RefinementProblem::FewSeen { .. })
        );
        assert!(is_motion, "seed {seed}: {failure}");
    }
}

#[test]
fn what_would_refuse_a_scan_refuses_a_refinement() {
    let dark = Faults { is_dark: true, ..Faults::default() };
    let no_depth = Faults { depth_every: None, ..Faults::default() };
    let away = Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_euler_angles(0.0, 1.5, 0.0));
    let failure = |faults, bump| refine(faults, bump).0.err().unwrap();
    assert!(matches!(failure(dark, bump()), ScanFailure::NoLight { .. }));
    assert!(matches!(failure(no_depth, bump()), ScanFailure::NoDepth));
    let few = failure(Faults::default(), away);
    assert!(matches!(few, ScanFailure::Refinement(RefinementProblem::FewPlaces { .. })) && is_refused(&few));
}
