//! From corners in the camera's and the projector's images to both lenses and the projector's pose.

use super::bundle::{Adjusted, Bundle, Rig, RigidProjector};
use super::camera::{camera, solve_camera, SolvedCamera};
use super::{BoardCorner, BoardPose, BoardRefusal, BoardView, Chessboard, LEAST_POSES};
use crate::solve::lens_values;
use crate::statistics::root_mean_square;
use crate::{solve, Estimate, Lens, Parameter, Report, Sample, Solution, SolveOptions};

/// Minimum number of corners of a pose whose projector pixel is known.
const LEAST_LIT: usize = 12;
/// Maximum RMS error of left-out poses of a good calibration and of a usable one, projector pixels.
const GOOD_LEFT_OUT_PX: f64 = 1.0;
const AGAIN_LEFT_OUT_PX: f64 = 3.0;
/// Number of poses that are enough, whatever the figures are.
const ENOUGH_POSES: usize = 4;
/// Maximum relative deviation of the camera's focal length of a good calibration.
const GOOD_FOCAL_SIGMA: f64 = 0.005;

/// Unknowns and known values.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardSolveOptions {
    /// The board.
    pub board: Chessboard,
    /// Width and height of the camera's images, pixels.
    pub camera_px: [u32; 2],
    /// The camera's lens by its CameraInfo; solved for if there is none.
    pub camera: Option<Lens>,
    /// Unknowns of the projector.
    pub projector: SolveOptions,
}

/// Camera, projector and their errors.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardSolution {
    /// The camera's lens.
    pub camera: Lens,
    /// Its parameters; the deviations are 0 if it is given.
    pub camera_estimates: Vec<Estimate>,
    /// RMS reprojection error in the camera's image, pixels.
    pub camera_rms_px: f64,
    /// RMS error of left-out poses in the projector's image, pixels.
    pub left_out_px: Option<f64>,
    /// Poses of the board, in the order of the views.
    pub poses: Vec<BoardPose>,
    /// The corners as points in the camera's frame with the projector's pixels, all of scan 0.
    pub samples: Vec<Sample>,
    /// The projector, and the verdict on both.
    pub report: Report,
}

/// Solves for the camera's lens, unless it is given, the projector's lens and its pose in the camera's frame.
///
/// # Errors
/// [`BoardRefusal`]: the poses do not allow a solution.
pub fn solve_boards(views: &[BoardView], options: &BoardSolveOptions) -> Result<BoardSolution, BoardRefusal> {
    if views.len() < LEAST_POSES {
        return Err(BoardRefusal::TooFew { poses: views.len() });
    }
    for view in views {
        let corners = view.corners.iter().filter(|corner| corner.lit_by.is_some()).count();
        if corners < LEAST_LIT {
            return Err(BoardRefusal::Unlit { name: view.name.clone(), corners });
        }
    }
    let corners: Vec<&[BoardCorner]> = views.iter().map(|view| view.corners.as_slice()).collect();
    let solved = Solved::new(&corners, options)?;
    let left_out: Vec<Option<f64>> = (0..views.len()).map(|view| left_out_px(&corners, view, options)).collect();
    Ok(solved.into_solution(views, &corners, &left_out, options))
}

/// RMS error at the corners of a pose by a solution without it: the board's pose comes from the camera alone.
fn left_out_px(views: &[&[BoardCorner]], left_out: usize, options: &BoardSolveOptions) -> Option<f64> {
    let mut others = views.to_vec();
    let own = [others.remove(left_out)];
    if others.len() < LEAST_POSES {
        return None;
    }
    let solved = Solved::new(&others, options).ok()?;
    let seen = camera(&own, options.board, &solved.rig.camera, false).ok()?;
    let rig = Rig { boards: seen.rig.boards, ..solved.rig };
    Some(options.bundle(&own, Vec::new()).projector_rms_px(&rig, 0))
}

/// Solution of some views.
struct Solved {
    rig: Rig,
    camera_sigmas: [f64; 9],
    samples: Vec<Sample>,
    solution: Solution,
}

impl Solved {
    fn new(views: &[&[BoardCorner]], options: &BoardSolveOptions) -> Result<Self, BoardRefusal> {
        let SolvedCamera { rig, sigmas, .. } =
            solve_camera(views, options.board, options.camera_px, options.camera.as_ref())?;
        let samples = samples(views, &rig, options.board);
        let solution = solve(&samples, &options.projector)?;
        let mut solved = Self { rig, camera_sigmas: sigmas, samples, solution };
        solved.rig.projector = projector_of(&solved.solution);
        let free = solved.solution.estimates.iter().filter(|estimate| estimate.sigma > 0.0);
        let terms = free.map(|estimate| estimate.parameter as usize).collect();
        if let Some(Adjusted { rig, camera_sigmas }) = options.bundle(views, terms).adjusted(solved.rig.clone()) {
            let samples = self::samples(views, &rig, options.board);
            let solution = solve(&samples, &options.projector)?;
            let projector = projector_of(&solution);
            solved = Self { rig: Rig { projector, ..rig }, camera_sigmas, samples, solution };
        }
        Ok(solved)
    }

    fn into_solution(
        self,
        views: &[BoardView],
        corners: &[&[BoardCorner]],
        left_out: &[Option<f64>],
        options: &BoardSolveOptions,
    ) -> BoardSolution {
        let bundle = options.bundle(corners, Vec::new());
        let rig = &self.rig;
        let poses: Vec<BoardPose> = (views.iter().enumerate())
            .map(|(index, view)| BoardPose {
                name: view.name.clone(),
                camera_from_board: rig.boards[index],
                camera_rms_px: bundle.camera_rms_px(rig, index),
                projector_rms_px: bundle.projector_rms_px(rig, index),
                left_out_px: left_out[index],
            })
            .collect();
        let known: Vec<f64> = left_out.iter().copied().flatten().collect();
        let values = lens_values(&rig.camera);
        let estimate = |parameter: Parameter| {
            let index = parameter as usize;
            Estimate { parameter, value: values[index], sigma: self.camera_sigmas[index] }
        };
        let mut solution = BoardSolution {
            camera: rig.camera,
            camera_estimates: Parameter::ALL.map(estimate).to_vec(),
            camera_rms_px: root_mean_square(poses.iter().map(|pose| pose.camera_rms_px)),
            left_out_px: (!known.is_empty()).then(|| root_mean_square(known.into_iter())),
            poses,
            report: Report::of_boards(&self.samples, self.solution),
            samples: self.samples,
        };
        solution.judge();
        solution
    }
}

impl BoardSolution {
    /// Adds the reasons that only boards know to the verdict.
    fn judge(&mut self) {
        let poses = self.poses.len();
        match self.left_out_px {
            Some(left_out_px) if left_out_px > GOOD_LEFT_OUT_PX => self.report.say(
                left_out_px > AGAIN_LEFT_OUT_PX,
                format!("poses that are left out are {left_out_px:.2} px off: use a flat board, and add poses"),
            ),
            None => self.report.say(false, format!("{poses} poses cannot be checked: add at least {ENOUGH_POSES}")),
            Some(_) => {}
        }
        let sigma = self.camera_estimates.iter().find(|estimate| estimate.parameter == Parameter::Fx);
        let share = sigma.map_or(0.0, |focal| focal.sigma / focal.value);
        if share > GOOD_FOCAL_SIGMA {
            let percent = 100.0 * share;
            self.report.say(
                false,
                format!("the camera's focal length is uncertain by {percent:.1} %: tilt the board by 30 degrees to each side"),
            );
        }
    }
}

impl BoardSolveOptions {
    fn bundle<'a>(&self, views: &[&'a [BoardCorner]], projector_terms: Vec<usize>) -> Bundle<'a> {
        Bundle { board: self.board, views: views.to_vec(), is_camera_free: self.camera.is_none(), projector_terms }
    }
}

/// The projector of a solution of one scan.
fn projector_of(solution: &Solution) -> Option<RigidProjector> {
    let projector_from_camera = solution.poses.first()?.projector_from_camera;
    Some(RigidProjector { lens: solution.lens, projector_from_camera })
}

/// The corners as points in the camera's frame.
fn samples(views: &[&[BoardCorner]], rig: &Rig, board: Chessboard) -> Vec<Sample> {
    let of_view = |(corners, pose): (&&[BoardCorner], &nalgebra::Isometry3<f64>)| {
        let sample = |corner: &BoardCorner| {
            let lit = corner.lit_by?;
            Some(Sample { sigma_px: lit.sigma_px, ..Sample::new(lit.pixel, pose * corner.point(board.square_m)) })
        };
        corners.iter().filter_map(sample).collect::<Vec<_>>()
    };
    views.iter().zip(&rig.boards).flat_map(of_view).collect()
}
