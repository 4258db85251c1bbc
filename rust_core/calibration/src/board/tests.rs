//! Calibrations of corners that a camera and a projector see exactly, or with known errors.

use nalgebra::{Isometry3, Point2, Translation3, UnitQuaternion, Vector3};

use super::*;
use crate::solve::random::SplitMix64;
use crate::{Distortion, Lens, Report, SolveOptions, Verdict};

const BOARD: Chessboard = Chessboard { corners: [10, 7], square_m: 0.04 };
const CAMERA_PX: [u32; 2] = [1280, 720];
const PROJECTOR_PX: [u32; 2] = [1280, 800];

struct World {
    camera: Lens,
    projector: Lens,
    projector_from_camera: Isometry3<f64>,
    noise_px: f64,
    /// Length of the board's squares along columns over what it says.
    stretch: f64,
}

impl World {
    fn new() -> Self {
        let camera = Lens {
            distortion: Distortion::plumb_bob([-0.15, 0.04, 5e-4, -3e-4, 0.0]),
            ..Lens::pinhole(CAMERA_PX, [1010.0, 1008.0], [648.0, 352.0])
        };
        let projector = Lens {
            distortion: Distortion::plumb_bob([-0.05, 0.01, 0.0, 0.0, 0.0]),
            ..Lens::pinhole(PROJECTOR_PX, [1500.0, 1495.0], [645.0, 700.0])
        };
        let projector_from_camera = Isometry3::new(Vector3::new(0.2, -0.25, 0.02), Vector3::new(-0.05, -0.12, 0.02));
        Self { camera, projector, projector_from_camera, noise_px: 0.03, stretch: 1.0 }
    }

    /// The corners of a board by its tilts and the place of its middle.
    fn view(&self, index: usize, [about_x, about_y]: [f64; 2], middle_m: [f64; 3]) -> BoardView {
        let turn = UnitQuaternion::from_euler_angles(about_x, about_y, 0.05);
        let half = Vector3::new(4.5 * BOARD.square_m, 3.0 * BOARD.square_m, 0.0);
        let place = Translation3::from(Vector3::from(middle_m) - turn * half);
        let pose = Isometry3::from_parts(place, turn);
        let mut random = SplitMix64::new(index as u64, 0xB0A2);
        let mut noise = || (0..6).map(|_| random.unit() - 0.5).sum::<f64>() * std::f64::consts::SQRT_2 * self.noise_px;
        let corner = |place: [i32; 2]| {
            let corner = BoardCorner { place, pixel: Point2::origin(), lit_by: None };
            let printed = corner.point(BOARD.square_m);
            let point = pose * Point3::new(printed.x, printed.y * self.stretch, 0.0);
            let pixel = self.camera.project(&point)? + nalgebra::Vector2::new(noise(), noise());
            let lit_by = self.projector.project(&(self.projector_from_camera * point))?;
            let lit_by = lit_by + nalgebra::Vector2::new(noise(), noise());
            let lit_by = self.projector.contains(lit_by).then_some(LitPixel { pixel: lit_by, sigma_px: 0.03 });
            self.camera.contains(pixel).then_some(BoardCorner { place, pixel, lit_by })
        };
        let corners = (0..7).flat_map(|row| (0..10).map(move |column| [column, row])).filter_map(corner).collect();
        BoardView { name: format!("pose{index:02}"), corners }
    }

    fn views(&self) -> Vec<BoardView> {
        let poses = [
            ([0.05, 0.0], [0.0, 0.0, 1.1]),
            ([0.1, 0.5], [-0.15, -0.1, 1.0]),
            ([-0.1, -0.5], [0.15, 0.1, 1.0]),
            ([0.5, 0.1], [0.15, -0.1, 1.4]),
            ([-0.5, -0.1], [-0.15, 0.1, 1.5]),
        ];
        poses.iter().enumerate().map(|(index, (tilt, middle_m))| self.view(index, *tilt, *middle_m)).collect()
    }
}

fn options(camera: Option<Lens>) -> BoardSolveOptions {
    BoardSolveOptions { board: BOARD, camera_px: CAMERA_PX, camera, projector: SolveOptions::new(PROJECTOR_PX) }
}

#[test]
fn both_lenses_and_the_pose_are_found() {
    let world = World::new();
    for camera in [None, Some(world.camera)] {
        let solution = solve_boards(&world.views(), &options(camera)).unwrap();
        let focal =
            |found: &Lens, truth: &Lens| (found.focal_px.component_div(&truth.focal_px)).add_scalar(-1.0).amax();
        let Report { solution: projector, verdict, reasons, .. } = &solution.report;
        assert!(focal(&solution.camera, &world.camera) < 2e-3 && focal(&projector.lens, &world.projector) < 2e-3);
        let pose = projector.poses[0].projector_from_camera;
        let off = pose.inverse().translation.vector - world.projector_from_camera.inverse().translation.vector;
        assert!(off.norm() < 4e-3, "{off}");
        assert!(solution.left_out_px.unwrap() < 0.15 && solution.camera_rms_px < 0.08, "{solution:?}");
        assert!(*verdict != Verdict::Again, "{reasons:?}");
        assert!(solution.camera_estimates.iter().all(|estimate| (estimate.sigma > 0.0) == camera.is_none()));
        assert!((solution.poses[4].camera_from_board.translation.vector.norm() - 1.5).abs() < 0.1);
    }
}

#[test]
fn a_curled_corner_of_the_paper_does_no_harm() {
    let world = World::new();
    let mut views = world.views();
    for corner in views[1].corners.iter_mut().filter(|corner| corner.place[0] + corner.place[1] >= 14) {
        corner.pixel += nalgebra::Vector2::new(2.5, -1.5);
    }
    let solution = solve_boards(&views, &options(None)).unwrap();
    let clean = solve_boards(&world.views(), &options(None)).unwrap();
    assert!((solution.camera.focal_px - clean.camera.focal_px).amax() < 1.0);
    assert!(solution.camera_rms_px < 0.1 && solution.left_out_px.unwrap() < 0.2, "{solution:?}");
}

#[test]
fn a_term_that_the_boards_do_not_tell_stays_small() {
    // A long lens, whose image has a radius of 0.2: r⁶ is nothing.
    let world = World { camera: Lens::pinhole(CAMERA_PX, [3400.0; 2], [640.0, 360.0]), ..World::new() };
    let tilts = [[0.05, 0.0], [0.1, 0.5], [-0.1, -0.5], [0.5, 0.1], [-0.5, -0.1]];
    let view = |(index, tilt): (usize, &[f64; 2])| world.view(index, *tilt, [0.0, 0.0, 3.2]).corners;
    let corners: Vec<Vec<BoardCorner>> = tilts.iter().enumerate().map(view).collect();
    let views: Vec<&[BoardCorner]> = corners.iter().map(Vec::as_slice).collect();
    let solved = camera::camera(&views, BOARD, &zhang::first_lens(&views, CAMERA_PX), true).unwrap();
    let [k1, k2, .., k3] = solved.rig.camera.distortion.coefficients()[..5] else { panic!("five terms") };
    assert!(k1.abs() < 0.1 && k2.abs() < 1.0 && k3.abs() < 0.3, "{k1} {k2} {k3}");
}

#[test]
fn what_does_not_allow_a_calibration_is_refused() {
    let world = World::new();
    let views = world.views();
    let refusal = |views: &[BoardView], camera| solve_boards(views, &options(camera)).unwrap_err();
    assert_eq!(refusal(&views[..2], None), BoardRefusal::TooFew { poses: 2 });
    let other = Lens { focal_px: world.camera.focal_px * 1.2, ..world.camera };
    assert!(matches!(refusal(&views, Some(other)), BoardRefusal::WrongCameraInfo { .. }));
    let mut unlit = views.clone();
    unlit[3].corners.iter_mut().skip(5).for_each(|corner| corner.lit_by = None);
    assert_eq!(refusal(&unlit, None), BoardRefusal::Unlit { name: "pose03".to_owned(), corners: 5 });
    // Boards that face the camera say nothing about its focal length.
    let facing: Vec<BoardView> = [1.0, 1.1, 1.2, 1.3]
        .iter()
        .enumerate()
        .map(|(index, z)| world.view(index, [0.0, 0.0], [0.1 - 0.05 * index as f64, 0.0, *z]))
        .collect();
    let undetermined = refusal(&facing, None);
    assert!(matches!(undetermined, BoardRefusal::CameraUndetermined { .. }), "{undetermined}");
    let mut mirrored = views;
    for lit in mirrored.iter_mut().flat_map(|view| &mut view.corners).filter_map(|corner| corner.lit_by.as_mut()) {
        lit.pixel.x = f64::from(PROJECTOR_PX[0]) - 1.0 - lit.pixel.x;
    }
    assert_eq!(refusal(&mirrored, None), BoardRefusal::Projector(Refusal::Mirrored));
}

#[test]
fn a_board_whose_squares_are_not_square_is_refused_for_that() {
    for (stretch, is_refused) in [(1.005, false), (0.97, true), (1.03, true), (1.4, true)] {
        // The board is as long as it says along one side only.
        let world = World { stretch, ..World::new() };
        for camera in [None, Some(world.camera)] {
            let refusal = solve_boards(&world.views(), &options(camera)).err();
            let is_named = matches!(refusal, Some(BoardRefusal::NotSquare { .. }));
            assert!(is_named == is_refused, "{stretch} {}: {refusal:?}", camera.is_some());
        }
    }
}

#[test]
fn corners_at_the_sheets_edge_are_not_the_boards() {
    let board = Chessboard { corners: [3, 3], square_m: 0.05 };
    for background in [10.0, 90.0, 128.0, 170.0, 240.0] {
        for (turn, margin) in [(0.05, 0.0), (0.4, 0.0), (-0.6, 0.1), (0.3, 0.5)] {
            // Squares of 40 pixels, foreshortened, each pixel the mean of 16.
            let level = |x: f64, y: f64| {
                let (x, y) = ((x - 160.0) / 40.0, (y - 120.0) / 40.0);
                let far = 1.0 + 0.05 * x;
                let (x, y) = (x * f64::cos(turn) + y * f64::sin(turn), y * f64::cos(turn) - x * f64::sin(turn));
                let (x, y) = (x / far + 2.0, y / far + 2.0);
                let is_in = |edge: f64| (-edge..4.0 + edge).contains(&x) && (-edge..4.0 + edge).contains(&y);
                match ((x.floor() + y.floor()).rem_euclid(2.0) == 0.0, is_in(0.0), is_in(margin)) {
                    (true, true, _) => 30.0,
                    (_, _, true) => 210.0,
                    _ => background,
                }
            };
            let mean = |x: i32, y: i32| {
                let parts = (0..16).map(|part| [part % 4, part / 4].map(|part| 0.25 * f64::from(part) - 0.375));
                parts.map(|[right, down]| level(f64::from(x) + right, f64::from(y) + down)).sum::<f64>() / 16.0
            };
            let grey: Vec<u8> = (0..240).flat_map(|y| (0..320).map(move |x| mean(x, y) as u8)).collect();
            let count = find_chessboard(&grey, [320, 240], &board).map(|corners| corners.len());
            assert_eq!(count, Ok(9), "{background} {turn} {margin}");
        }
    }
}

#[test]
fn advice_asks_for_what_is_missing() {
    let world = World::new();
    let pose = |tilt: [f64; 2], z: f64| {
        let view = world.view(0, tilt, [0.0, 0.0, z]);
        board_pose(&view.corners, BOARD, &world.camera).unwrap()
    };
    assert_eq!(advice(&[]), BoardAdvice::Face);
    let mut poses = vec![pose([0.0, 0.0], 1.0)];
    assert_eq!(advice(&poses), BoardAdvice::TiltLeft);
    // About y, which points down: the left side goes away from the camera.
    poses.push(pose([0.0, 0.5], 1.0));
    assert_eq!(advice(&poses), BoardAdvice::TiltRight);
    poses.push(pose([0.0, -0.5], 1.0));
    assert_eq!(advice(&poses), BoardAdvice::TiltBack);
    poses.push(pose([-0.5, 0.0], 1.0));
    assert_eq!(advice(&poses), BoardAdvice::TiltForward);
    poses.push(pose([0.5, 0.0], 1.0));
    assert!(matches!(advice(&poses), BoardAdvice::Farther | BoardAdvice::Nearer));
    poses.push(pose([0.0, 0.0], 1.4));
    assert_eq!(advice(&poses), BoardAdvice::Elsewhere);
}
