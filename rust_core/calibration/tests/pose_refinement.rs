//! Refining the poses of bumped projectors in simulated rooms.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2, Vector3};
use rcs_calibration::patterns::Pattern;
use rcs_calibration::statistics::median;
use rcs_calibration::{Lens, LightMap, PoseRefinement, RefinedPose, RefinementProblem, VerificationScene, Zoom};
use rcs_scan_simulator::{
    seeds, Conditions, DepthCamera, LightError, Motion, Random, Rig, Room, Scan, SmoothError, View,
};

/// Room with a camera and a projector.
struct World {
    view: View,
    depth_m: Vec<f32>,
    conditions: Conditions,
}

impl World {
    fn new(seed: u64, room: &Room) -> Self {
        Self::with_camera(seed, room, &DepthCamera::kinect(seed))
    }

    /// World whose depth image is the mean of ten by a camera.
    fn with_camera(seed: u64, room: &Room, camera: &DepthCamera) -> Self {
        let view = View::new(room, &Rig::random(seed));
        let depth_m = DepthCamera { frames: 10, ..camera.clone() }.capture(&view);
        Self { view, depth_m, conditions: Conditions::random(seed) }
    }

    /// Refines a file with a lens and a pose.
    fn refine(&self, lens: &Lens, file: &Isometry3<f64>) -> Result<RefinedPose, RefinementProblem> {
        self.refine_with(lens, file, |_, _, _| ())
    }

    /// Like [`Self::refine`], with a change of the camera's images of spots: each with its light and its number.
    fn refine_with(
        &self,
        lens: &Lens,
        file: &Isometry3<f64>,
        change: impl Fn(&mut [u8], &[f32], u32),
    ) -> Result<RefinedPose, RefinementProblem> {
        let scan = Scan::new(&self.view, self.conditions.clone());
        let camera = &self.view.rig().camera;
        let (white, black) = (scan.capture(&Pattern::White, 0), scan.capture(&Pattern::Black, 1));
        let refinement = PoseRefinement::new(&VerificationScene {
            camera,
            projector: lens,
            projector_from_camera: file,
            depth_m: &self.depth_m,
            light: &LightMap::new(&white, &black, camera.size_px[0], 2.0),
        })?;
        let images = refinement.images();
        assert!(images.len() <= 8);
        let seen = |(number, shown): (u32, &Vec<u8>)| {
            let light = scan.light_of(shown);
            let mut grey = scan.expose(&light, number);
            change(&mut grey, &light, number);
            grey
        };
        let images: Vec<Vec<u8>> = (2..).zip(&images).map(seen).collect();
        refinement.refine(&images, &self.depth_m)
    }

    /// The file's pose before a bump.
    fn before(&self, bump: &Isometry3<f64>) -> Isometry3<f64> {
        bump * self.view.rig().projector_from_camera()
    }

    /// RMS and maximum error of a pose over the working volume, projector pixels.
    fn error_px(&self, pose: &Isometry3<f64>) -> LightError {
        let rig = self.view.rig();
        LightError::between((&rig.projector, &rig.projector_from_camera()), (&rig.projector, pose))
    }
}

/// A random bump of up to 3° and 3 cm.
fn bump(seed: u64) -> Isometry3<f64> {
    let random = &mut Random::new(&[seed, 0x6275_6d70]);
    let mut direction = || loop {
        let axis = Vector3::new(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
        if (0.1..1.0).contains(&axis.norm()) {
            return axis.normalize() * random.uniform(0.3, 1.0);
        }
    };
    let (shift_m, turn) = (direction() * 0.03, direction() * 3.0_f64.to_radians());
    Isometry3::from_parts(Translation3::from(shift_m), UnitQuaternion::new(turn))
}

/// A lens with another zoom.
fn zoomed(lens: &Lens, by: f64) -> Lens {
    Lens { focal_px: lens.focal_px * by, ..*lens }
}

#[test]
fn a_bump_is_mended() {
    let (mut rms, mut most, mut before) = (Vec::new(), Vec::new(), Vec::new());
    for seed in seeds(0, 5, 100) {
        let world = World::new(seed, &Room::cluttered(seed));
        let file = world.before(&bump(seed));
        let refined = world.refine(&world.view.rig().projector, &file).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        assert!(matches!(refined.zoom, Zoom::Unchanged { .. }), "seed {seed}: {:?}", refined.zoom);
        let error = world.error_px(&refined.solution.poses[0].projector_from_camera);
        assert!(error.max_px < 1.0 && error.lost == 0, "seed {seed}: {error:?}");
        // The deviations are honest.
        let sigma_px = refined.solution.prediction_sigma_px;
        assert!(error.rms_px < 6.0 * sigma_px && sigma_px < 0.5, "seed {seed}: {error:?} {sigma_px}");
        rms.push(error.rms_px);
        most.push(error.max_px);
        before.push(world.error_px(&file).rms_px);
    }
    let worst = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    println!(
        "{} rooms: RMS error before: median {:.1} px; after: median {:.3} px, worst {:.3} px; largest error in a room: \
         median {:.3} px, worst {:.3} px",
        rms.len(),
        median(&mut before),
        median(&mut rms.clone()),
        worst(&rms),
        median(&mut most.clone()),
        worst(&most)
    );
    assert!(median(&mut rms) < 0.3);
}

#[test]
fn a_changed_zoom_is_refused_where_depths_vary() {
    let [mut named, mut inconsistent, mut undecidable] = [0; 3];
    for seed in seeds(200, 4, 100) {
        let world = World::new(seed, &Room::cluttered(seed));
        let by = if seed % 2 == 0 { 1.02 } else { 0.97 };
        let lens = zoomed(&world.view.rig().projector, by);
        match world.refine(&lens, &world.before(&bump(seed))) {
            Err(RefinementProblem::ZoomChanged { change, sigma }) => {
                assert!((change - (1.0 / by - 1.0)).abs() < 0.002 + 4.0 * sigma, "seed {seed}: {change} {sigma}");
                named += 1;
            }
            // Its text names the zoom, too.
            Err(RefinementProblem::Inconsistent(percent)) => {
                println!("seed {seed}: {percent:.0} % agree");
                inconsistent += 1;
            }
            Ok(RefinedPose { zoom: Zoom::Undecidable { variation }, .. }) => {
                println!("seed {seed}: depths vary by {:.1} %", 100.0 * variation);
                assert!(variation < 0.15, "seed {seed}: {variation}");
                undecidable += 1;
            }
            Err(problem) => panic!("seed {seed}: {problem}"),
            Ok(refined) => panic!("seed {seed}: {:?}", refined.zoom),
        }
    }
    println!(
        "a changed zoom: {named} rooms refused as such, {inconsistent} as inconsistent, {undecidable} undecidable"
    );
    assert!(named >= 9 * (inconsistent + undecidable));
}

#[test]
fn a_changed_zoom_is_refused_before_a_slanted_wall_and_undecidable_before_others() {
    let [mut flat, mut decided, mut undecided] = [0; 3];
    for seed in seeds(300, 6, 100) {
        // Every second depth camera errs smoothly, too.
        let smooth_error = (seed % 2 == 1).then_some(SmoothError { rms_m: 0.001, seed });
        let random = &mut Random::new(&[seed, 0x736c_616e]);
        let (angle, tilt) = (random.uniform(0.0, std::f64::consts::TAU), random.uniform(0.0, 0.5));
        let room = Room::wall(1.3, [tilt * angle.cos(), tilt * angle.sin()]);
        let world = World::with_camera(seed, &room, &DepthCamera { smooth_error, ..DepthCamera::kinect(seed) });
        let refine = |by: f64| {
            let lens = zoomed(&world.view.rig().projector, by);
            world.refine(&lens, &world.before(&bump(seed))).map(|refined| refined.zoom)
        };
        let zooms = (refine(1.0), refine(if seed % 3 == 0 { 0.97 } else { 1.04 }));
        match &zooms {
            (Ok(Zoom::Undecidable { variation }), Ok(Zoom::Undecidable { .. })) if *variation < 0.15 => flat += 1,
            (Ok(Zoom::Unchanged { .. }), Err(RefinementProblem::ZoomChanged { .. })) => decided += 1,
            (
                Ok(Zoom::Unchanged { .. } | Zoom::Undecidable { .. }),
                Ok(Zoom::Undecidable { .. }) | Err(RefinementProblem::ZoomChanged { .. }),
            ) => {
                println!("seed {seed}: {zooms:?}");
                undecided += 1;
            }
            zooms => panic!("seed {seed}: {zooms:?}"),
        }
    }
    println!("zoom before walls: {flat} too flat; {decided} slanted ones decided, {undecided} not");
    assert!(decided > 4 * undecided);
}

/// Refines in a room whose camera moves, or only what is in the left part of its image. Returns the largest error.
fn refine_moving(seed: u64, motion: Motion, moving_columns: usize) -> Result<f64, RefinementProblem> {
    let mut world = World::new(seed, &Room::cluttered(seed));
    let (lens, file) = (world.view.rig().projector, world.before(&bump(seed)));
    let (still, moving) = (world.conditions.clone(), Conditions { motion: Some(motion), ..world.conditions.clone() });
    world.conditions = still;
    let moved = Scan::new(&world.view, moving);
    let refined = world.refine_with(&lens, &file, |grey, light, number| {
        let other = moved.expose(light, number);
        for (row, other) in grey.chunks_mut(640).zip(other.chunks(640)) {
            row[..moving_columns].copy_from_slice(&other[..moving_columns]);
        }
    });
    refined.map(|refined| world.error_px(&refined.solution.poses[0].projector_from_camera).max_px)
}

/// A motion between two of the images of spots, by a distance in this range, camera pixels.
fn motion(seed: u64, [least_px, most_px]: [f64; 2]) -> Motion {
    let random = &mut Random::new(&[seed, 0x6d6f_7665]);
    let angle = random.uniform(0.0, std::f64::consts::TAU);
    let shift_px = Vector2::new(angle.cos(), angle.sin()) * random.uniform(least_px, most_px);
    // The second of eight images is the fourth of all.
    Motion { from_image: 3 + (seed % 7) as u32, shift_px }
}

#[test]
fn a_motion_of_less_than_a_pixel_is_refused_or_harmless() {
    let (mut most, mut refused) = (Vec::new(), 0);
    for seed in seeds(500, 4, 100) {
        let motion = motion(seed, [0.1, 1.0]);
        for moving_columns in [640, 320] {
            match refine_moving(seed, motion, moving_columns) {
                Err(RefinementProblem::Moved { .. }) => refused += 1,
                Ok(error_px) => {
                    println!(
                        "seed {seed}, {:.2} px of {moving_columns} columns: {error_px:.2} px",
                        motion.shift_px.norm()
                    );
                    most.push(error_px);
                }
                Err(problem) => panic!("seed {seed}, {motion:?}: {problem}"),
            }
        }
    }
    let worst_px = most.iter().copied().fold(0.0, f64::max);
    println!(
        "small motions: {refused} refused, {} accepted; largest error in a room: median {:.2} px, worst {worst_px:.2} px",
        most.len(),
        median(&mut most)
    );
    assert!(worst_px < 1.0);
}

#[test]
fn motion_while_spots_are_shown_is_refused() {
    let (mut refused_parts, mut rooms) = (0, 0);
    for seed in seeds(400, 4, 100) {
        let motion = motion(seed, [1.0, 3.0]);
        let refused = refine_moving(seed, motion, 640);
        assert!(matches!(refused, Err(RefinementProblem::Moved { .. })), "seed {seed}, {motion:?}: {refused:?}");
        // A part that moves is refused, or has so few spots that they do no harm.
        match refine_moving(seed, motion, 320) {
            Err(RefinementProblem::Moved { .. }) => refused_parts += 1,
            Ok(error_px) => assert!(error_px < 1.0, "seed {seed}, {motion:?}: {error_px}"),
            Err(problem) => panic!("seed {seed}, {motion:?}: {problem}"),
        }
        rooms += 1;
    }
    println!("motion is refused in {rooms} rooms, that of the left half in {refused_parts}");
    assert!(refused_parts * 10 >= 8 * rooms);
}

#[test]
fn where_nothing_is_seen_nothing_is_refined() {
    let rig = Rig::random(0);
    let pose = rig.projector_from_camera();
    let count = 640 * 480;
    let (depth_m, lit) = (vec![1.2_f32; count], LightMap::new(&vec![140; count], &vec![20; count], 640, 1.0));
    let scene = VerificationScene {
        camera: &rig.camera,
        projector: &rig.projector,
        projector_from_camera: &pose,
        depth_m: &depth_m,
        light: &lit,
    };
    let refinement = PoseRefinement::new(&scene).unwrap();
    let black = vec![vec![20; count]; refinement.images().len()];
    let problem = refinement.refine(&black, &depth_m).unwrap_err();
    assert!(matches!(problem, RefinementProblem::FewSeen { seen: 0, shown } if shown > 30), "{problem}");
    let dark = VerificationScene { depth_m: &vec![0.0; count], ..scene };
    assert_eq!(PoseRefinement::new(&dark).unwrap_err(), RefinementProblem::FewPlaces { spots: 0 });
}
