//! Detection of keystone corrections by the first stripes of a scan, without false alarms.

use nalgebra::Matrix3;
use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::{Images, Keystone};
use rcs_scan_simulator::{seeds, Conditions, DepthCamera, Rig, Room, Scan, SmoothError, View};

const PROJECTOR_PX: [u32; 2] = [1280, 800];

/// Keystone by the first stripes of a scan of a room, with a Kinect's depth and a smooth error.
fn first_stripes(room: &Room, seed: u64, image_from_panel: Matrix3<f64>) -> Option<Keystone> {
    let rig = Rig::random(seed);
    let view = View::new(room, &rig);
    let is_coarse = |pattern: &Pattern| !matches!(pattern, Pattern::GrayCode(stripes) if stripes.bit >= 5);
    let patterns: Vec<Pattern> = gray_code(PROJECTOR_PX).into_iter().filter(is_coarse).collect();
    let conditions = Conditions { image_from_panel, ..Conditions::random(seed) };
    let images = Scan::new(&view, conditions).capture_all(&patterns);
    let levels = images.iter().map(Vec::as_slice).collect();
    let images = Images { size_px: view.size_px(), patterns: &patterns, levels };
    let smooth_error = Some(SmoothError { rms_m: 0.001, seed });
    let depth_m = DepthCamera { frames: 10, smooth_error, ..DepthCamera::kinect(seed) }.capture(&view);
    Keystone::find(&images, &depth_m, &rig.camera, PROJECTOR_PX)
}

#[test]
fn a_image_that_is_not_corrected_raises_no_alarm() {
    for seed in seeds(300, 2, 4) {
        assert_eq!(first_stripes(&Room::cluttered(seed), seed, Matrix3::identity()), None, "room {seed}");
    }
}

/// More than half of each kind; the example `keystone` counts over more rooms. With few crossings, the whole scan
/// decides.
#[test]
fn most_corrections_are_found() {
    let rooms = seeds(300, 2, 4);
    let count = |about_rows: f64, about_columns: f64, is_found: fn(&Keystone) -> bool| {
        let found = |seed| first_stripes(&Room::cluttered(seed), seed, Conditions::keystone(about_rows, about_columns));
        rooms.clone().filter_map(found).filter(is_found).count()
    };
    let is_skewed = |found: &Keystone| matches!(found, Keystone::Skewed(_));
    let skewed = [count(0.0, 8.0, is_skewed), count(5.0, -8.0, is_skewed)];
    let stretched = count(15.0, 0.0, |_| true);
    let half = rooms.clone().count() / 2;
    assert!(skewed[0] + skewed[1] > 2 * half && stretched > half, "{skewed:?} and {stretched} of {rooms:?}");
}

#[test]
fn a_flat_wall_tells_nothing() {
    assert_eq!(first_stripes(&Room::wall(1.4, [0.1, -0.05]), 310, Conditions::keystone(0.0, 8.0)), None);
}
