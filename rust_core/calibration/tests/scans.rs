//! Whole calibrations of simulated scans: decoding, points, solving, judged by the projection error.

use nalgebra::Isometry3;
use rcs_calibration::patterns::gray_code;
use rcs_calibration::{decode, points, solve, Images, Lens, Report, Sample, SolveOptions, Verdict};
use rcs_scan_simulator::{
    has_many_seeds, seeds, Conditions, DepthCamera, LightError, Rig, Room, Scan, SmoothError, View,
};

const PROJECTOR_PX: [u32; 2] = [1280, 800];

/// Samples of a scan with its number.
fn scan(room: &Room, rig: &Rig, depth_camera: &DepthCamera, number: u32) -> Vec<Sample> {
    let view = View::new(room, rig);
    let patterns = gray_code(PROJECTOR_PX);
    let images = Scan::new(&view, Conditions::random(rig.seed + 1000 * u64::from(number))).capture_all(&patterns);
    let levels = images.iter().map(Vec::as_slice).collect();
    let decoded = decode(&Images { size_px: view.size_px(), patterns: &patterns, levels }, PROJECTOR_PX);
    let decoded = decoded.unwrap_or_else(|error| panic!("{error}"));
    let samples = points(&decoded, &depth_camera.capture(&view), &rig.camera).unwrap_or_else(|error| panic!("{error}"));
    samples.into_iter().map(|sample| Sample { scan: number, ..sample }).collect()
}

fn light_error(rig: &Rig, lens: &Lens, pose: &Isometry3<f64>) -> LightError {
    LightError::between((&rig.projector, &rig.projector_from_camera()), (lens, pose))
}

/// Angle between two orientations, degrees, and distance of the positions in the camera's frame, metres.
fn pose_error(a: &Isometry3<f64>, b: &Isometry3<f64>) -> (f64, f64) {
    let (a, b) = (a.inverse(), b.inverse());
    (a.rotation.angle_to(&b.rotation).to_degrees(), (a.translation.vector - b.translation.vector).norm())
}

#[test]
fn light_lands_where_it_should_after_one_scan() {
    for seed in seeds(200, 2, 6) {
        let (room, rig) = (Room::cluttered(seed), Rig::random(seed));
        let depth_camera = DepthCamera { frames: 10, ..DepthCamera::kinect(seed) };
        let samples = scan(&room, &rig, &depth_camera, 0);
        let solution = solve(&samples, &SolveOptions::new(PROJECTOR_PX)).unwrap();
        let pose = solution.poses[0].projector_from_camera;
        let error = light_error(&rig, &solution.lens, &pose);
        let (degrees, metres) = pose_error(&pose, &rig.projector_from_camera());
        let focal =
            (solution.lens.focal_px.component_div(&rig.projector.focal_px)).map(|ratio| (ratio - 1.0).abs()).max();
        let report = Report::new(&samples, solution);
        println!(
            "seed {seed}: {} points, light {:.3} px {:.3} mm, f {:.3} %, {:.2} mm, {:.3}°, RMS {:.2}, held out {:.2}, {:?} {:?}",
            samples.len(), error.rms_px, 1e3 * error.rms_m, 100.0 * focal, 1e3 * metres, degrees,
            report.solution.rms_px, report.solution.held_out_rms_px, report.verdict, report.reasons
        );
        assert_eq!(error.lost, 0);
        assert!(
            error.rms_px < 0.3 && error.rms_m < 0.3e-3,
            "seed {seed}: {:.3} px, {:.3} mm",
            error.rms_px,
            1e3 * error.rms_m
        );
        assert!(focal < 1e-3 && metres < 1e-3 && degrees < 0.05, "seed {seed}: {focal:.5} {metres:.5} m {degrees:.3}°");
        assert_ne!(report.verdict, Verdict::Again, "{:?}", report.reasons);
    }
}

#[test]
fn several_scans_average_a_depth_cameras_smooth_error() {
    let count = if has_many_seeds() { 5 } else { 3 };
    let seed = 210;
    let (room, rig) = (Room::cluttered(seed), Rig::random(seed));
    let depth_camera = |place: u32| DepthCamera {
        frames: 10,
        smooth_error: Some(SmoothError { rms_m: 1e-3, seed: seed + u64::from(place) }),
        ..DepthCamera::kinect(seed)
    };
    let scans: Vec<Vec<Sample>> =
        (0..count).map(|place| scan(&room, &rig.at_place(place), &depth_camera(place), place)).collect();
    let errors = |samples: &[Sample]| {
        let solution = solve(samples, &SolveOptions::new(PROJECTOR_PX)).unwrap();
        let error = light_error(&rig, &solution.lens, &solution.poses[0].projector_from_camera);
        (error.rms_px, Report::new(samples, solution))
    };
    let (one, report_of_one) = errors(&scans[0]);
    let (several, report_of_several) = errors(&scans.concat());
    println!(
        "one scan {one:.3} px, {count} {several:.3} px; smooth error {:.2} mm",
        1e3 * report_of_several.smooth_depth_error_m
    );
    println!("{:?} {:?}", report_of_one.verdict, report_of_one.reasons);
    assert!(several < 0.3 && several < one, "{several:.3} px of {one:.3}");
    let seems = report_of_several.smooth_depth_error_m;
    assert!((0.4e-3..2.5e-3).contains(&seems), "it seems to be {:.2} mm", 1e3 * seems);
}

#[test]
fn a_flat_wall_gives_the_pose_of_a_known_lens() {
    let rig = Rig::random(220);
    let samples =
        scan(&Room::wall(1.4, [0.1, -0.05]), &rig, &DepthCamera { frames: 10, ..DepthCamera::kinect(220) }, 0);
    let refusal = solve(&samples, &SolveOptions::new(PROJECTOR_PX)).unwrap_err().to_string();
    assert!(refusal.contains("flat"), "{refusal}");
    let options = SolveOptions { known_lens: Some(rig.projector), ..SolveOptions::new(PROJECTOR_PX) };
    let solution = solve(&samples, &options).unwrap();
    assert_eq!(solution.lens, rig.projector);
    let (degrees, metres) = pose_error(&solution.poses[0].projector_from_camera, &rig.projector_from_camera());
    println!("{degrees:.3}°, {:.2} mm", 1e3 * metres);
    assert!(metres < 3e-3 && degrees < 0.1, "{metres:.5} m {degrees:.3}°");
}

#[test]
fn a_mirrored_image_is_refused() {
    let (room, rig) = (Room::cluttered(230), Rig::random(230));
    let view = View::new(&room, &rig);
    let patterns = gray_code(PROJECTOR_PX);
    let conditions = Conditions { image_from_panel: Conditions::mirrored(PROJECTOR_PX[0]), ..Conditions::random(230) };
    let images = Scan::new(&view, conditions).capture_all(&patterns);
    let levels = images.iter().map(Vec::as_slice).collect();
    let decoded = decode(&Images { size_px: view.size_px(), patterns: &patterns, levels }, PROJECTOR_PX).unwrap();
    let samples = points(&decoded, &DepthCamera::kinect(230).capture(&view), &rig.camera).unwrap();
    let refusal = solve(&samples, &SolveOptions::new(PROJECTOR_PX)).unwrap_err().to_string();
    assert!(refusal.contains("mirrored"), "{refusal}");
}
