//! Calibration by a printed chessboard in simulated rooms: a webcam, no depth, and a board in five poses.
#![expect(clippy::unwrap_used, reason = "a test without its views fails")]

use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion};
use rcs_calibration::board::{
    board_pose, find_chessboard, lit_corners, solve_boards, BoardCorner, BoardRefusal, BoardSolution,
    BoardSolveOptions, BoardView, Chessboard,
};
use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::{decode, Images, Lens, SolveOptions, Verdict};
use rcs_scan_simulator::{seeds, Conditions, Random, Rig, Room, Scan, View};

const PROJECTOR_PX: [u32; 2] = [1280, 800];
/// Fits on a sheet of A3.
const BOARD: Chessboard = Chessboard { corners: [10, 7], square_m: 0.035 };
/// Tilts about x and y, radians, and places: shares of the way from the middle to the edges of what both see.
const POSES: [([f64; 2], [f64; 3]); 5] = [
    ([0.1, -0.1], [0.0, 0.0, 1.15]),
    ([0.1, 0.5], [-0.2, -0.12, 1.0]),
    ([-0.1, -0.5], [0.2, 0.1, 1.0]),
    ([0.5, 0.1], [0.18, -0.12, 1.35]),
    ([-0.5, -0.1], [-0.18, 0.12, 1.4]),
];

/// A pose of the board in the room. All of it is near where camera and projector look.
fn room_from_board(rig: &Rig, pose: usize, random: &mut Random) -> Isometry3<f64> {
    let ([about_x, about_y], [x, y, z]) = POSES[pose];
    let mut near = |value: f64, most: f64| value + random.uniform(-most, most);
    let place = Translation3::new(
        rig.target.x * z / 1.3 + near(x, 0.03),
        rig.target.y * z / 1.3 + near(y, 0.03),
        near(z, 0.05),
    );
    let turn = UnitQuaternion::from_euler_angles(near(about_x, 0.08), near(about_y, 0.08), near(0.0, 0.15));
    Isometry3::from_parts(place, turn)
}

/// Result of the scan of a pose.
fn scanned(rig: &Rig, seed: u64, pose: usize) -> BoardView {
    let random = &mut Random::new(&[seed, pose as u64, 0x424f_4152]);
    let room = Room::wall(1.9, [0.1, -0.1]).with_board(BOARD, &room_from_board(rig, pose, random));
    let view = View::new(&room, rig);
    let patterns = gray_code(PROJECTOR_PX);
    let scan = Scan::new(&view, Conditions { seed: 10 * seed + pose as u64, ..Conditions::random(seed) });
    let images = scan.capture_all(&patterns);
    let levels = images.iter().map(Vec::as_slice).collect();
    let decoded = decode(&Images { size_px: view.size_px(), patterns: &patterns, levels }, PROJECTOR_PX).unwrap();
    assert_eq!(patterns[0], Pattern::White);
    let corners = find_chessboard(&images[0], view.size_px(), &BOARD).unwrap_or_else(|error| panic!("{pose}: {error}"));
    BoardView { name: format!("pose {pose}"), corners: lit_corners(&corners, &decoded) }
}

fn options(rig: &Rig, camera: Option<Lens>) -> BoardSolveOptions {
    BoardSolveOptions {
        board: BOARD,
        camera_px: rig.camera.size_px,
        camera,
        projector: SolveOptions::new(PROJECTOR_PX),
    }
}

/// Errors of a calibration at the corners of boards all over the volume of the scanned ones, projector pixels: a camera
/// sees each of them as it is, and says where it is.
fn errors_px(rig: &Rig, seed: u64, solution: &BoardSolution) -> Vec<f64> {
    let random = &mut Random::new(&[seed, 0x4845_4c44]);
    let mut errors = Vec::new();
    let pose = solution.report.solution.poses[0].projector_from_camera;
    for index in 0..20 {
        let board = rig.room_from_camera.inv_mul(&room_from_board(rig, index % POSES.len(), random));
        let places = (0..BOARD.corners[1]).flat_map(|y| (0..BOARD.corners[0]).map(move |x| [x, y]));
        let seen: Vec<(BoardCorner, Point3<f64>)> = places
            .filter_map(|[x, y]| {
                let [half_x, half_y] = BOARD.corners.map(|count| 0.5 * (f64::from(count) - 1.0));
                let place = Point3::new(f64::from(x) - half_x, f64::from(y) - half_y, 0.0);
                let point = board * (place * BOARD.square_m);
                let pixel = rig.camera.project(&point).filter(|pixel| rig.camera.contains(*pixel))?;
                Some((BoardCorner { place: [x as i32, y as i32], pixel, lit_by: None }, point))
            })
            .collect();
        let corners: Vec<BoardCorner> = seen.iter().map(|(corner, _)| *corner).collect();
        let found = board_pose(&corners, BOARD, &solution.camera).unwrap();
        for (corner, point) in &seen {
            let Some(truth) = rig.projector.project(&(rig.projector_from_camera() * point)) else { continue };
            if rig.projector.contains(truth) {
                let [x, y] = corner.place.map(|at| f64::from(at) * BOARD.square_m);
                let found = solution.report.solution.lens.project(&(pose * (found * Point3::new(x, y, 0.0))));
                errors.push(found.map_or(1e3, |found: Point2<f64>| (found - truth).norm()));
            }
        }
    }
    errors
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn five_poses_of_a_board_calibrate_a_projector_and_a_webcam() {
    for seed in seeds(700, 2, 20) {
        let rig = Rig::webcam(seed);
        let views: Vec<BoardView> = (0..POSES.len()).map(|pose| scanned(&rig, seed, pose)).collect();
        let solution = solve_boards(&views, &options(&rig, None)).unwrap_or_else(|error| panic!("{seed}: {error}"));
        let errors = errors_px(&rig, seed, &solution);
        let worst = errors.iter().copied().fold(0.0, f64::max);
        let left_out = solution.left_out_px.unwrap();
        let (report, focal) = (&solution.report, solution.camera.focal_px.x / rig.camera.focal_px.x - 1.0);
        println!(
            "room {seed}: {:.3} px RMS, worst {worst:.2}, of {} corners; left out {left_out:.3}; fitted {:.3}, camera \
             {:.3}, its focal length {:+.2} %; {:?} {:?}",
            rms(&errors),
            errors.len(),
            report.solution.rms_px,
            solution.camera_rms_px,
            100.0 * focal,
            report.verdict,
            report.reasons,
        );
        assert!(rms(&errors) < 0.3 && worst < 1.0, "room {seed}: {} {worst}", rms(&errors));
        assert!(left_out < 0.5 && focal.abs() < 0.01, "room {seed}: {left_out} {focal}");
        assert!(report.verdict != Verdict::Again, "room {seed}: {:?}", report.reasons);
    }
}

/// White as a webcam sees it in a room with the board in this pose.
fn white(rig: &Rig, room: &Room) -> Vec<u8> {
    let view = View::new(room, rig);
    Scan::new(&view, Conditions::random(rig.seed)).capture(&Pattern::White, 0)
}

#[test]
fn a_board_is_found_in_a_cluttered_room_and_nowhere_else() {
    for seed in seeds(800, 4, 30) {
        let rig = Rig::webcam(seed);
        let size_px = rig.camera.size_px;
        let cluttered = Room::cluttered(seed).without_checkers();
        let nothing = find_chessboard(&white(&rig, &cluttered), size_px, &BOARD);
        assert!(matches!(nothing, Err(BoardRefusal::NoBoard { .. })), "seed {seed}");
        // Nearer than what stands about.
        let pose = Isometry3::new(rig.target.coords * 0.6, nalgebra::Vector3::new(0.3, -0.4, 0.1));
        let grey = white(&rig, &cluttered.with_board(BOARD, &pose));
        let corners = find_chessboard(&grey, size_px, &BOARD).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let camera_from_board = rig.room_from_camera.inv_mul(&pose);
        // The corners are the board's, to a fraction of a pixel, but for those beside what covers it in part.
        let truth: Vec<Point2<f64>> = (0..7)
            .flat_map(|y| (0..10).map(move |x| Point3::new(f64::from(x) - 4.5, f64::from(y) - 3.0, 0.0)))
            .filter_map(|place| rig.camera.project(&(camera_from_board * (place * BOARD.square_m))))
            .collect();
        let off = |corner: &BoardCorner| {
            truth.iter().map(|pixel| (pixel - corner.pixel).norm()).fold(f64::INFINITY, f64::min)
        };
        let wrong: Vec<_> = corners.iter().map(off).filter(|off| *off >= 0.3).collect();
        println!("seed {seed}: {} corners, of these off, px: {wrong:.2?}", corners.len());
        assert!(20 * wrong.len() <= corners.len(), "seed {seed}: {wrong:?} of {}", corners.len());
        let other = Chessboard { corners: [14, 11], ..BOARD };
        assert!(find_chessboard(&grey, size_px, &other).is_err(), "seed {seed}");
        // Seen as a whole, a board with more corners is another one.
        let smaller = Chessboard { corners: [6, 5], ..BOARD };
        let larger = find_chessboard(&grey, size_px, &smaller);
        assert!(matches!(larger, Err(BoardRefusal::LargerGrid { corners: 36.., .. })), "seed {seed}: {larger:?}");
    }
}
