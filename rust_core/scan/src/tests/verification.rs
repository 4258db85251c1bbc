//! Verifications in a simulated room, of true and false files.

use std::time::Duration;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use rcs_calibration::{ErrorStatistics, VerificationProblem};

use super::is_refused;
use super::world::{Faults, SimulatedCamera, SimulatedScreen, World, PROJECTOR_PX};
use crate::failure::ScanFailure;
use crate::session::{ScanEvent, ScanOptions, ScanSession};
use crate::verification::Verification;

/// Verifies a pose that is `off`, and returns the number of images that were shown.
fn verify(faults: Faults, off: Isometry3<f64>) -> (Result<Verification, ScanFailure>, usize) {
    let world = World::new(faults);
    let (mut screen, mut camera) = (SimulatedScreen(world.clone()), SimulatedCamera(world.clone()));
    let (lens, pose) = (world.borrow().rig().projector, off * world.borrow().rig().projector_from_camera());
    let options = ScanOptions { projector_px: PROJECTOR_PX, step: 1, frames: 2, is_cancelled: &|| false };
    let mut observe = |_: ScanEvent<'_>| ();
    let result = ScanSession::new(&mut screen, &mut camera, &options, &mut observe).verify(&lens, &pose);
    let shown = world.borrow().shown();
    (result, shown)
}

/// Half a degree about the vertical.
fn turned() -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_euler_angles(0.0, 0.5_f64.to_radians(), 0.0);
    Isometry3::from_parts(Translation3::identity(), rotation)
}

#[test]
fn a_true_file_is_verified_and_spots_stay_shown() {
    let (verification, shown) = verify(Faults::default(), Isometry3::identity());
    let Verification { result, white, camera_px } = verification.unwrap();
    let spots = ErrorStatistics::of(&result.spots);
    assert!(spots.count * 10 > 9 * result.spots_shown && spots.count >= 10, "{spots:?} of {}", result.spots_shown);
    assert!(spots.median[0] < 0.3 && result.all().rms[0] < 0.5, "{spots:?} {:?}", result.all());
    assert_eq!((white.len(), camera_px), (160 * 120, [160, 120]));
    // Six to measure the light, white and black, spots, outlines, white again, and all at once.
    let spots = if result.spots_shown > 20 { 8 } else { 6 };
    assert_eq!(shown, 6 + 2 + spots + 1 + 1 + 1);
}

#[test]
fn a_turned_projector_is_off_by_its_angle() {
    let (verification, _) = verify(Faults::default(), turned());
    let spots = ErrorStatistics::of(&verification.unwrap().result.spots);
    // 340 pixels times the angle, and a little more beside the middle.
    assert!((2.8..3.8).contains(&spots.median[0]), "{spots:?}");
}

#[test]
fn what_would_refuse_a_scan_refuses_a_verification() {
    let moves = Faults { moves_after: Some(Duration::from_secs(9)), ..Faults::default() };
    let dark = Faults { is_dark: true, ..Faults::default() };
    let no_depth = Faults { depth_every: None, ..Faults::default() };
    let away = Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_euler_angles(0.0, 1.5, 0.0));
    let failure = |faults, off| verify(faults, off).0.err().unwrap();
    let moved = failure(moves, Isometry3::identity());
    assert!(matches!(moved, ScanFailure::Moved { .. }) && is_refused(&moved));
    assert!(matches!(failure(dark, Isometry3::identity()), ScanFailure::NoLight { .. }));
    assert!(matches!(failure(no_depth, Isometry3::identity()), ScanFailure::NoDepth));
    let few = failure(Faults::default(), away);
    assert!(matches!(few, ScanFailure::Verification(VerificationProblem::FewPlaces { .. })) && is_refused(&few));
}
