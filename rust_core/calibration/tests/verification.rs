//! Verifying projectors in simulated rooms: true files, and files that are off by a known amount.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{
    ErrorStatistics, LightMap, VerificationPlan, VerificationProblem, VerificationResult, VerificationScene,
    VerifiedPoint,
};
use rcs_scan_simulator::{Conditions, DepthCamera, Rig, Room, Scan, View};

/// Room with a camera and a projector.
struct World {
    view: View,
    conditions: Conditions,
    depth_m: Vec<f32>,
}

impl World {
    fn new(seed: u64, room: &Room) -> Self {
        let view = View::new(room, &Rig::random(seed));
        let depth_m = DepthCamera { frames: 10, ..DepthCamera::kinect(seed) }.capture(&view);
        Self { view, conditions: Conditions::random(seed), depth_m }
    }

    /// Verifies a file's pose.
    fn verify(&self, projector_from_camera: &Isometry3<f64>) -> Result<VerificationResult, VerificationProblem> {
        let scan = Scan::new(&self.view, self.conditions.clone());
        let rig = self.view.rig();
        let (white, black) = (scan.capture(&Pattern::White, 0), scan.capture(&Pattern::Black, 1));
        let scene = VerificationScene {
            camera: &rig.camera,
            projector: &rig.projector,
            projector_from_camera,
            depth_m: &self.depth_m,
            light: &LightMap::new(&white, &black, rig.camera.size_px[0], 2.0),
        };
        let plan = VerificationPlan::new(&scene)?;
        let images = plan.images();
        let seen: Vec<Vec<u8>> =
            (2..).zip(&images).map(|(number, shown)| scan.expose(&scan.light_of(shown), number)).collect();
        plan.measure(&seen)
    }

    /// True error of a target under a file's pose, pixels.
    fn true_error_px(&self, target: &VerifiedPoint, projector_from_camera: &Isometry3<f64>) -> Option<f64> {
        let [u, v] = [target.expected.x, target.expected.y].map(|at| at.round() as u32);
        let sight = self.view.sight(u, v)?;
        let pixel = self.view.rig().projector.project(&(projector_from_camera * sight.point))?;
        Some((pixel - sight.lit_by?).norm())
    }
}

/// Five millimetres to the side and half a degree.
fn bump() -> Isometry3<f64> {
    let turned = UnitQuaternion::new(Vector3::new(0.3, 0.9, 0.1).normalize() * 0.5_f64.to_radians());
    Isometry3::from_parts(Translation3::new(0.005, 0.0, 0.0), turned)
}

/// Verifies a true file, and measures the error of a bumped one.
fn check_room(seed: u64) {
    let world = World::new(seed, &Room::cluttered(seed));
    let file = world.view.rig().projector_from_camera();
    let verified = world.verify(&file).unwrap();
    let (spots, edges) = (ErrorStatistics::of(&verified.spots), ErrorStatistics::of(&verified.edges));
    assert!(spots.count * 10 >= 9 * verified.spots_shown && spots.count >= 30, "seed {seed}: {spots:?}");
    assert!(spots.median[0] < 0.15 && spots.rms[0] < 0.3, "seed {seed}: {spots:?}");
    assert!(edges.count >= 20 && edges.median[0] < 0.4 && edges.rms[0] < 0.6, "seed {seed}: {edges:?}");
    assert!(verified.all().rms[0] < 0.5 && verified.all().rms[1] < 0.001, "seed {seed}: {:?}", verified.all());

    let file = bump() * file;
    let verified = world.verify(&file).unwrap();
    let errors: Vec<[f64; 2]> =
        verified.spots.iter().filter_map(|spot| Some([spot.px, world.true_error_px(spot, &file)?])).collect();
    let near = errors.iter().filter(|[px, truth]| (px - truth).abs() < 0.8).count();
    let (spots, edges) = (ErrorStatistics::of(&verified.spots), ErrorStatistics::of(&verified.edges));
    assert!(errors.len() > 40 && near * 10 > 8 * errors.len(), "seed {seed}: {near} of {errors:?}");
    assert!((10.0..30.0).contains(&spots.median[0]) && spots.median[1] > 0.008, "seed {seed}: {spots:?}");
    assert!(edges.count > 10 && edges.median[0] > 5.0 && edges.worst[0] < 40.0, "seed {seed}: {edges:?}");
}

#[test]
fn a_projector_is_verified_in_a_cluttered_room() {
    check_room(1);
}

#[test]
fn a_projector_is_verified_in_another_room() {
    check_room(3);
}

#[test]
fn where_nothing_is_seen_nothing_is_said() {
    let rig = Rig::random(0);
    let pose = rig.projector_from_camera();
    let count = 640 * 480;
    let (depth_m, dark) = (vec![1.2_f32; count], LightMap::new(&vec![40; count], &vec![38; count], 640, 1.0));
    let scene = |light| VerificationScene {
        camera: &rig.camera,
        projector: &rig.projector,
        projector_from_camera: &pose,
        depth_m: &depth_m,
        light,
    };
    let problem = VerificationPlan::new(&scene(&dark)).unwrap_err();
    assert_eq!(problem, VerificationProblem::FewPlaces { spots: 0 });
    let lit = LightMap::new(&vec![140; count], &vec![20; count], 640, 1.0);
    let plan = VerificationPlan::new(&scene(&lit)).unwrap();
    let [spots, edges] = plan.counts();
    assert!(spots > 30 && edges == 0, "a wall has no edges: {spots} {edges}");
    let black = vec![vec![20; count]; plan.images().len()];
    assert_eq!(plan.measure(&black), Err(VerificationProblem::FewSeen { seen: 0, shown: spots }));
    let problem = VerificationPlan::new(&VerificationScene { depth_m: &vec![0.0; count], ..scene(&lit) }).unwrap_err();
    assert!(problem.to_string().lines().count() == 1);
}
