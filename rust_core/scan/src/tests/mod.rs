//! Scans of a simulated room, and what goes wrong in them.

mod board;
mod pose_refinement;
mod recording;
mod verification;
mod world;

use std::time::Duration;

use nalgebra::{Matrix3, Rotation3};
use rcs_calibration::Decoded;
use rcs_files::capture::Capture;
use rcs_scan_simulator::Conditions;

use crate::devices::ScanCameraError;
use crate::failure::ScanFailure;
use crate::finish::ScanResult;
use crate::light::Delay;
use crate::session::{ScanEvent, ScanOptions, ScanSession};
use world::{Faults, SimulatedCamera, SimulatedScreen, World, PERIOD, PROJECTOR_PX};

/// The result of a scan, and what it took.
struct Outcome {
    result: Result<ScanResult, ScanFailure>,
    delay: Option<Delay>,
    warnings: Vec<String>,
    /// Number of images that were shown, black and white at the beginning among them.
    shown: usize,
    took: Duration,
    world: std::rc::Rc<std::cell::RefCell<World>>,
}

impl Outcome {
    fn of(faults: Faults) -> Self {
        Self::until(faults, usize::MAX)
    }

    /// Interrupts the scan after this number of images.
    fn until(faults: Faults, most_shown: usize) -> Self {
        let projector_px = faults.assumed_px;
        let world = World::new(faults);
        let (mut screen, mut camera) = (SimulatedScreen(world.clone()), SimulatedCamera(world.clone()));
        let is_cancelled = || world.borrow().shown() > most_shown;
        let options = ScanOptions { projector_px, step: 1, frames: 3, is_cancelled: &is_cancelled };
        let (mut delay, mut warnings) = (None, Vec::new());
        let mut observe = |event: ScanEvent<'_>| match event {
            ScanEvent::Delay(measured, _) => delay = Some(measured),
            ScanEvent::Warning(warning) => warnings.push(warning.to_owned()),
            ScanEvent::Note(_) => {}
            ScanEvent::Captured { readable, .. } => assert!((0.0..=1.0).contains(&readable)),
        };
        let result = ScanSession::new(&mut screen, &mut camera, &options, &mut observe).scan();
        let (shown, took) = (world.borrow().shown(), world.borrow().elapsed());
        Self { result, delay, warnings, shown, took, world }
    }

    fn failure(self) -> ScanFailure {
        match self.result {
            Ok(_) => panic!("the scan was accepted, with {:?}", self.warnings),
            Err(failure) => {
                assert!(!failure.to_string().contains('\n'));
                failure
            }
        }
    }

    fn shares(&self) -> (f64, f64) {
        shares(&self.result.as_ref().unwrap().decoded, &self.world.borrow())
    }
}

/// The share of decoded pixels among the lit ones, and of right ones among the decoded.
fn shares(decoded: &Decoded, world: &World) -> (f64, f64) {
    let (mut count, mut right) = (0, 0);
    for (pixel, place) in decoded.pixels.iter().enumerate().filter(|(_, place)| place.is_decoded()) {
        count += 1;
        let is_right = |truth: [f64; 2]| (0..2).all(|axis| (truth[axis] - f64::from(place.at[axis])).abs() < 1.0);
        right += usize::from(world.truth(pixel).is_some_and(is_right));
    }
    (f64::from(count) / decoded.lit as f64, right as f64 / f64::from(count))
}

fn is_refused(failure: &ScanFailure) -> bool {
    failure.is_refusal()
}

#[test]
fn a_scan_is_decoded_however_late_its_images_are_seen() {
    for lag_frames in [1, 15, 40] {
        let lag = lag_frames * PERIOD;
        let outcome = Outcome::of(Faults { lag, ..Faults::default() });
        let scanned = outcome.result.as_ref().unwrap();
        assert!(scanned.ended.is_none() && outcome.warnings.is_empty(), "{:?}", outcome.warnings);
        let Delay { seen, settled } = outcome.delay.unwrap();
        assert!(seen + PERIOD >= lag && seen <= lag + PERIOD, "{seen:?} {lag:?}");
        assert!(settled >= seen && settled <= lag + 2 * PERIOD, "{settled:?} {lag:?}");
        let (decoded, right) = outcome.shares();
        assert!(decoded > 0.8 && right > 0.99, "{lag:?}: {decoded} {right}");
        let depth_m = scanned.capture.depth_m.as_ref().unwrap();
        assert!(depth_m.iter().filter(|depth| **depth > 0.5).count() * 2 > depth_m.len());
        let images = scanned.capture.images.len() as u32;
        assert!(outcome.took < Duration::from_secs(8) + images * (2 * lag + 6 * PERIOD), "{:?}", outcome.took);
    }
}

#[test]
fn rooms_and_lights_of_all_kinds_are_accepted() {
    for seed in 0..4 {
        let conditions = Conditions::random(seed);
        let outcome = Outcome::of(Faults { seed, conditions, ..Faults::default() });
        assert!(outcome.result.is_ok(), "seed {seed}: {:?}", outcome.result.err());
        let (decoded, right) = outcome.shares();
        assert!(decoded > 0.6 && right > 0.95, "seed {seed}: {decoded} {right}");
    }
}

#[test]
fn what_was_scanned_is_written_and_read_again() {
    let outcome = Outcome::of(Faults::default());
    let capture = outcome.result.unwrap().capture;
    let folder = tempfile::tempdir().unwrap();
    capture.write(folder.path()).unwrap();
    let read = Capture::read(folder.path()).unwrap();
    assert_eq!((&read.images, read.camera, read.warnings.len()), (&capture.images, capture.camera, 0));
    assert_eq!((read.projector_size_px, read.camera_frame_id.as_str()), (PROJECTOR_PX, "camera_optical"));
}

#[test]
fn a_projector_that_hangs_upside_down_is_fine() {
    let [right, bottom] = PROJECTOR_PX.map(|side| f64::from(side) - 1.0);
    let turned = Matrix3::new(-1.0, 0.0, right, 0.0, -1.0, bottom, 0.0, 0.0, 1.0);
    let conditions = Conditions { image_from_panel: turned, ..Faults::default().conditions };
    let outcome = Outcome::of(Faults { conditions, ..Faults::default() });
    assert!(outcome.result.unwrap().ended.is_none() && outcome.warnings.is_empty());
}

#[test]
fn a_mirrored_image_is_refused_early() {
    let image_from_panel = Conditions::mirrored(PROJECTOR_PX[0]);
    let conditions = Conditions { image_from_panel, ..Faults::default().conditions };
    let outcome = Outcome::of(Faults { conditions, ..Faults::default() });
    assert!(outcome.shown < 30, "{}", outcome.shown);
    let failure = outcome.failure();
    assert!(matches!(failure, ScanFailure::Mirrored) && is_refused(&failure));
}

/// The image is corrected for a wall that is turned by some degrees both ways.
fn keystone(degrees: f64) -> Matrix3<f64> {
    let lens = Matrix3::new(340.0, 0.0, 159.5, 0.0, 340.0, 99.5, 0.0, 0.0, 1.0);
    let turn = Rotation3::from_euler_angles(degrees.to_radians(), degrees.to_radians(), 0.0);
    lens * turn.into_inner() * lens.try_inverse().unwrap()
}

#[test]
fn a_keystone_correction_is_refused_early() {
    for degrees in [-6.0, 10.0] {
        let image_from_panel = keystone(degrees);
        let conditions = Conditions { image_from_panel, ..Faults::default().conditions };
        let outcome = Outcome::of(Faults { conditions, ..Faults::default() });
        assert!(outcome.shown < 34, "{degrees}: {}", outcome.shown);
        let failure = outcome.failure();
        assert!(matches!(&failure, ScanFailure::Keystone(reason) if reason.contains("keystone")), "{failure:?}");
        assert!(is_refused(&failure));
    }
}

#[test]
fn a_camera_that_adapts_its_exposure_is_refused() {
    for millis in [80, 300, 900] {
        let adapts_within = Some(Duration::from_millis(millis));
        let failure = Outcome::of(Faults { adapts_within, ..Faults::default() }).failure();
        assert!(
            matches!(failure, ScanFailure::Unsteady { .. } | ScanFailure::Restless { .. }),
            "{millis}: {failure:?}"
        );
        assert!(is_refused(&failure));
    }
}

#[test]
fn brightness_that_drifts_is_refused() {
    let failure = Outcome::of(Faults { drift: 0.008, ..Faults::default() }).failure();
    assert!(matches!(failure, ScanFailure::Unsteady { .. }), "{failure:?}");
}

#[test]
fn a_camera_that_moves_is_refused() {
    for secs in [5, 8, 11, 14] {
        let moves_after = Some(Duration::from_secs(secs));
        let failure = Outcome::of(Faults { moves_after, ..Faults::default() }).failure();
        let has_moved = matches!(failure, ScanFailure::Moved { .. } | ScanFailure::Problem(_));
        assert!(has_moved && failure.to_string().contains("moved"), "{secs}: {failure:?}");
        assert!(is_refused(&failure));
    }
}

#[test]
fn overexposed_pixels_are_warned_of_once_and_judged_as_by_decoding() {
    for exposure in [1.6, 6.0] {
        let conditions = Conditions { exposure, ..Faults::default().conditions };
        let outcome = Outcome::of(Faults { conditions, ..Faults::default() });
        let count = outcome.warnings.iter().filter(|warning| warning.contains("overexposed")).count();
        assert!(outcome.result.is_ok() && count == 1, "{exposure}: {:?} {:?}", outcome.warnings, outcome.result.err());
        let (_, right) = outcome.shares();
        assert!(right > 0.95, "{exposure}: {right}");
    }
}

#[test]
fn a_projector_that_is_off_is_refused() {
    let outcome = Outcome::of(Faults { is_dark: true, ..Faults::default() });
    assert!(outcome.took < Duration::from_secs(15), "{:?}", outcome.took);
    let failure = outcome.failure();
    assert!(matches!(failure, ScanFailure::NoLight { .. }) && failure.to_string().contains("the simulated projector"));
    assert!(is_refused(&failure));
}

#[test]
fn a_silent_camera_is_named() {
    for secs in [1, 3] {
        let failure =
            Outcome::of(Faults { silent_after: Some(Duration::from_secs(secs)), ..Faults::default() }).failure();
        assert!(matches!(&failure, ScanFailure::Camera(ScanCameraError::Silent { .. })), "{failure:?}");
        assert!(failure.to_string().contains("/camera/image") && !is_refused(&failure));
    }
}

#[test]
fn images_of_another_size_than_the_camera_info_says_cannot_be_used() {
    let failure = Outcome::of(Faults { frame_px: Some([120, 160]), ..Faults::default() }).failure();
    assert!(failure.to_string().contains("120x160") && !is_refused(&failure));
}

#[test]
fn a_image_that_is_cut_off_is_warned_of() {
    // An image for a larger projector, of which the panel shows the upper left part.
    let outcome = Outcome::of(Faults { assumed_px: [500, 200], ..Faults::default() });
    assert!(outcome.result.is_ok());
    assert!(outcome.warnings.iter().any(|warning| warning.contains("columns")), "{:?}", outcome.warnings);
}

#[test]
fn a_scan_without_depth_has_none() {
    let scanned = Outcome::of(Faults { depth_every: None, ..Faults::default() }).result.unwrap();
    assert_eq!(scanned.capture.depth_m, None);
}

#[test]
fn an_interrupted_scan_is_kept_if_it_saw_enough() {
    let outcome = Outcome::until(Faults::default(), 33);
    let scanned = outcome.result.as_ref().unwrap();
    let images = scanned.capture.images.len();
    assert!(matches!(scanned.ended, Some(ScanFailure::Interrupted)));
    assert!((20..33).contains(&images) && images.is_multiple_of(2), "{images}");
    let (_, right) = outcome.shares();
    assert!(right > 0.8, "{right}");
    let folder = tempfile::tempdir().unwrap();
    scanned.capture.write(folder.path()).unwrap();
    assert_eq!(Capture::read(folder.path()).unwrap().images.len(), images);
    for most_shown in [0, 3, 7, 9] {
        let failure = Outcome::until(Faults::default(), most_shown).failure();
        assert!(matches!(failure, ScanFailure::Interrupted), "{most_shown}: {failure:?}");
        assert!(is_refused(&failure));
    }
}

#[test]
fn what_was_seen_before_the_camera_fell_silent_is_kept() {
    let took = Outcome::of(Faults::default()).took;
    let outcome = Outcome::of(Faults { silent_after: Some(took.mul_f64(0.8)), ..Faults::default() });
    let scanned = outcome.result.as_ref().unwrap();
    assert!(matches!(scanned.ended, Some(ScanFailure::Camera(ScanCameraError::Silent { .. }))), "{:?}", scanned.ended);
    assert!(scanned.capture.images.len() < 36, "{}", scanned.capture.images.len());
    let (_, right) = outcome.shares();
    assert!(right > 0.8, "{right}");
}
