//! Waiting for a board that somebody holds, moves and puts down.

use std::time::{Duration, Instant};

use nalgebra::{Isometry3, Vector3};
use rcs_calibration::board::Chessboard;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::Lens;
use rcs_scan_simulator::{Conditions, Rig, Room, Scan, View};

use crate::devices::{CameraFrame, DepthFrame, ProjectorScreen, ScanCamera, ScanCameraError};
use crate::failure::ScanFailure;
use crate::session::{ScanEvent, ScanOptions, ScanSession};

const BOARD: Chessboard = Chessboard { corners: [8, 6], square_m: 0.045 };
const PERIOD: Duration = Duration::from_millis(100);

/// A screen that shows anything.
struct AnyScreen;

impl ProjectorScreen for AnyScreen {
    fn name(&self) -> String {
        "screen".to_owned()
    }

    fn show(&mut self, image: Vec<u8>) -> anyhow::Result<()> {
        assert!(image.iter().all(|level| *level == 255), "only white is shown");
        Ok(())
    }
}

/// A camera that sees images for some time each.
struct Film {
    lens: Lens,
    start: Instant,
    now: Instant,
    scenes: Vec<(Duration, Vec<u8>)>,
}

impl Film {
    fn elapsed(&self) -> Duration {
        self.now - self.start
    }
}

impl ScanCamera for Film {
    fn now(&self) -> Instant {
        self.now
    }

    fn lens(&self) -> Lens {
        self.lens
    }

    fn frame_id(&self) -> String {
        String::new()
    }

    fn frame(&mut self, after: Instant, _timeout: Duration) -> Result<CameraFrame, ScanCameraError> {
        self.now = after.max(self.now) + PERIOD;
        let mut left = self.elapsed();
        let is_shown = |(lasts, _): &&(Duration, Vec<u8>)| {
            let is_over = left >= *lasts;
            left = left.saturating_sub(*lasts);
            !is_over
        };
        let scene = self.scenes.iter().find(is_shown);
        let grey = scene.map(|(_, grey)| grey.clone()).expect("the board is found before the film ends");
        Ok(CameraFrame { size_px: self.lens.size_px, grey, received: self.now })
    }

    fn has_depth(&self) -> bool {
        false
    }

    fn depth(&mut self) -> Result<Option<DepthFrame>, ScanCameraError> {
        Ok(None)
    }
}

/// The rig's view of the board, shifted and tilted.
fn seen(rig: &Rig, shift_m: f64, tilt: f64) -> Vec<u8> {
    let place = rig.target.coords + Vector3::new(shift_m, 0.0, 0.0);
    let room = Room::wall(1.9, [0.1, 0.1]).with_board(BOARD, &Isometry3::new(place, Vector3::new(0.0, tilt, 0.0)));
    Scan::new(&View::new(&room, rig), Conditions::random(7)).capture(&Pattern::White, 0)
}

#[test]
fn a_board_is_scanned_once_it_rests_in_a_new_pose() {
    let rig = Rig::random(3);
    let (first, moving, second) = (seen(&rig, 0.0, 0.1), seen(&rig, 0.02, 0.2), seen(&rig, 0.05, 0.5));
    let wall = View::new(&Room::wall(1.9, [0.1, 0.1]), &rig);
    let empty = Scan::new(&wall, Conditions::random(7));
    let seconds = Duration::from_secs;
    let start = Instant::now();
    let scenes = vec![
        (seconds(12), empty.capture(&Pattern::White, 0)),
        (seconds(1), moving.clone()),
        (seconds(20), first),
        (seconds(1), moving),
        (seconds(60), second),
    ];
    let mut camera = Film { lens: rig.camera, start, now: start, scenes };
    let options = ScanOptions { projector_px: [1280, 800], step: 1, frames: 1, is_cancelled: &|| false };
    let mut notes = Vec::new();
    let mut observe = |event: ScanEvent<'_>| {
        if let ScanEvent::Note(note) = event {
            notes.push(note.to_owned());
        }
    };
    let mut wait = |camera: &mut Film, last: Option<&[_]>| {
        ScanSession::new(&mut AnyScreen, camera, &options, &mut observe).wait_for_board(&BOARD, last)
    };
    let corners = wait(&mut camera, None).unwrap();
    assert_eq!(corners.len(), BOARD.count());
    let waited = camera.elapsed().as_secs_f64();
    assert!((14.5..16.0).contains(&waited), "after 13 s and 1.5 s of rest: {waited}");
    let again = wait(&mut camera, Some(&corners)).unwrap();
    let waited = camera.elapsed().as_secs_f64();
    assert!((35.5..37.0).contains(&waited), "the first pose is not taken again: {waited}");
    assert!((again[20].pixel - corners[20].pixel).norm() > 5.0);
    assert!(notes[0].contains("corners of a board with 8x6 inner corners"), "{notes:?}");
    assert!(notes.iter().any(|note| note.contains("still where it was")), "{notes:?}");
}

#[test]
fn waiting_for_a_board_can_be_interrupted() {
    let rig = Rig::random(3);
    let start = Instant::now();
    let scenes = vec![(Duration::from_secs(1), vec![20; 640 * 480])];
    let mut camera = Film { lens: rig.camera, start, now: start, scenes };
    let options = ScanOptions { projector_px: [1280, 800], step: 1, frames: 1, is_cancelled: &|| true };
    let mut observe = |_: ScanEvent<'_>| {};
    let mut screen = AnyScreen;
    let mut session = ScanSession::new(&mut screen, &mut camera, &options, &mut observe);
    assert!(matches!(session.wait_for_board(&BOARD, None), Err(ScanFailure::Interrupted)));
}
