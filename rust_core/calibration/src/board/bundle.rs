//! Bundle adjustment of board poses, a camera and, if there is one, a projector (Triggs et al., "Bundle adjustment: a
//! modern synthesis", 2000), by Levenberg-Marquardt with Cauchy's loss.
//!
//! Coefficients of the camera's distortion have weak priors: a few poses do not determine all of them, and free ones
//! run away in the corners of the image, where no board was.

use nalgebra::{DVector, Isometry3, Matrix2x3, Point2, SMatrix, Vector2};

use super::{BoardCorner, Chessboard};
use crate::solve::{cauchy_loss, cauchy_weight, inverse_of_positive, lens_of, lens_values, levenberg_marquardt};
use crate::solve::{moved_pose, NormalEquations, SolverState, LENS, MOST_STEPS};
use crate::statistics::{median, root_mean_square};
use crate::Lens;

/// Rounds of adjusting and measuring the deviations.
const ROUNDS: usize = 3;
/// Deviations of the priors of k1, k2, p1, p2 and k3, and those of fy / fx and of the principal point as a share of the
/// width.
const PRIORS: [f64; 5] = [0.5, 0.5, 0.01, 0.01, 0.1];
const RATIO_PRIOR: f64 = 0.05;
const CENTER_PRIOR: f64 = 0.1;
/// First deviation of corners in the camera's image, and lower bounds of all deviations, pixels.
const FIRST_SIGMA_PX: f64 = 1.0;
const LEAST_SIGMA_PX: f64 = 0.01;
/// Error of an outlier, in deviations, and at least, pixels.
const OUTLIER: f64 = 5.0;
const LEAST_OUTLIER_PX: f64 = 0.2;
/// Squared residual, in deviations, of a corner that cannot be projected.
const LOST: f64 = 1e4;
/// Median of the squared length of a two-dimensional normal vector.
const MEDIAN_OF_SQUARE: f64 = 1.386_294;

/// Projector with its pose in the camera's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct RigidProjector {
    pub(super) lens: Lens,
    pub(super) projector_from_camera: Isometry3<f64>,
}

/// Everything that is adjusted.
#[derive(Debug, Clone)]
pub(super) struct Rig {
    pub(super) camera: Lens,
    pub(super) projector: Option<RigidProjector>,
    /// Poses `camera_from_board`.
    pub(super) boards: Vec<Isometry3<f64>>,
}

/// The problem: what is seen, and what is free.
pub(super) struct Bundle<'a> {
    pub(super) board: Chessboard,
    pub(super) views: Vec<&'a [BoardCorner]>,
    /// Solve for the camera's lens.
    pub(super) is_camera_free: bool,
    /// Parameters of the projector's lens to solve for, by [`crate::Parameter`]'s number.
    pub(super) projector_terms: Vec<usize>,
}

/// Deviations in the camera's and the projector's image; of the projector's pixels a factor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Deviations {
    pub(super) camera_px: f64,
    pub(super) projector: f64,
}

/// Result of an adjustment.
pub(super) struct Adjusted {
    pub(super) rig: Rig,
    /// Standard deviations of the camera's lens parameters; 0 if they are known.
    pub(super) camera_sigmas: [f64; 9],
}

/// A predicted pixel with its derivatives, by column of the unknowns.
struct Row {
    error: Vector2<f64>,
    slopes: Vec<(usize, Vector2<f64>)>,
}

impl Bundle<'_> {
    /// Adjusts from a first state; `None` if it cannot be.
    pub(super) fn adjusted(&self, mut rig: Rig) -> Option<Adjusted> {
        let mut deviations = Deviations { camera_px: FIRST_SIGMA_PX, projector: FIRST_SIGMA_PX };
        for _ in 0..ROUNDS {
            rig = self.minimised(rig, deviations);
            deviations = self.deviations(&rig);
        }
        let rig = self.minimised(rig, deviations);
        let covariance = inverse_of_positive(&self.equations(&rig, deviations).hessian)?;
        let mut camera_sigmas = [0.0; 9];
        if self.is_camera_free {
            camera_sigmas.iter_mut().enumerate().for_each(|(i, sigma)| *sigma = covariance[(i, i)].max(0.0).sqrt());
        }
        Some(Adjusted { rig, camera_sigmas })
    }

    /// RMS error of a view's corners in the camera's image, pixels, without outliers, such as corners of curled paper.
    pub(super) fn camera_rms_px(&self, rig: &Rig, view: usize) -> f64 {
        let most_px = (OUTLIER * self.deviations(rig).camera_px).max(LEAST_OUTLIER_PX);
        let errors = self.views[view].iter().filter_map(|corner| self.camera_error(rig, view, corner));
        root_mean_square(errors.map(|error| error.norm()).filter(|error| *error <= most_px))
    }

    /// RMS error of a view's corners in the projector's image, pixels.
    pub(super) fn projector_rms_px(&self, rig: &Rig, view: usize) -> f64 {
        let errors = self.views[view].iter().filter_map(|corner| self.projector_error(rig, view, corner));
        root_mean_square(errors.map(|error| error.norm()))
    }

    fn camera_error(&self, rig: &Rig, view: usize, corner: &BoardCorner) -> Option<Vector2<f64>> {
        let point = rig.boards[view] * corner.point(self.board.square_m);
        Some(corner.pixel - rig.camera.project(&point)?)
    }

    fn projector_error(&self, rig: &Rig, view: usize, corner: &BoardCorner) -> Option<Vector2<f64>> {
        let point = rig.boards[view] * corner.point(self.board.square_m);
        let RigidProjector { lens, projector_from_camera } = rig.projector.as_ref()?;
        Some(corner.lit_by?.pixel - lens.project(&(projector_from_camera * point))?)
    }

    /// Robust estimates of the deviations.
    fn deviations(&self, rig: &Rig) -> Deviations {
        let (mut camera, mut projector) = (Vec::new(), Vec::new());
        for (view, corner) in self.corners() {
            camera.extend(self.camera_error(rig, view, corner).map(|error| error.norm_squared()));
            let squared = self.projector_error(rig, view, corner).map(|error| error.norm_squared());
            projector.extend(squared.zip(corner.lit_by).map(|(squared, lit)| squared / lit.sigma_px.powi(2)));
        }
        let sigma = |squares: &mut Vec<f64>| (median(squares) / MEDIAN_OF_SQUARE).sqrt().max(LEAST_SIGMA_PX);
        Deviations { camera_px: sigma(&mut camera), projector: sigma(&mut projector) }
    }

    fn corners(&self) -> impl Iterator<Item = (usize, &BoardCorner)> {
        self.views.iter().enumerate().flat_map(|(view, corners)| corners.iter().map(move |corner| (view, corner)))
    }

    fn camera_count(&self) -> usize {
        if self.is_camera_free {
            9
        } else {
            0
        }
    }

    /// First column of the projector: its lens, then its pose.
    fn projector_count(&self, rig: &Rig) -> usize {
        rig.projector.map_or(0, |_| self.projector_terms.len() + 6)
    }

    fn board_column(&self, rig: &Rig, view: usize) -> usize {
        self.camera_count() + self.projector_count(rig) + 6 * view
    }

    fn minimised(&self, rig: Rig, deviations: Deviations) -> Rig {
        let equations = |rig: &Rig| self.equations(rig, deviations);
        levenberg_marquardt(rig, MOST_STEPS, equations, |rig, step| self.stepped(rig, step))
    }

    fn equations(&self, rig: &Rig, deviations: Deviations) -> NormalEquations {
        let mut sums = NormalEquations::zeros(self.board_column(rig, self.views.len()));
        for (view, corner) in self.corners() {
            sums.add(self.camera_row(rig, view, corner), deviations.camera_px);
            if let (Some(lit), true) = (corner.lit_by, rig.projector.is_some()) {
                sums.add(self.projector_row(rig, view, corner), deviations.projector * lit.sigma_px);
            }
        }
        if self.is_camera_free {
            sums.add_priors(&rig.camera);
        }
        sums
    }

    fn camera_row(&self, rig: &Rig, view: usize, corner: &BoardCorner) -> Option<Row> {
        let state = SolverState { lens: rig.camera, poses: vec![rig.boards[view]] };
        let predicted = state.predict(0, &corner.point(self.board.square_m))?;
        let column = |i: usize| predicted.jacobian.column(i).into_owned();
        let at = self.board_column(rig, view);
        let lens = (0..self.camera_count()).map(|i| (i, column(i)));
        let slopes = lens.chain((0..6).map(|i| (at + i, column(LENS + i)))).collect();
        Some(Row { error: corner.pixel - predicted.pixel, slopes })
    }

    fn projector_row(&self, rig: &Rig, view: usize, corner: &BoardCorner) -> Option<Row> {
        let RigidProjector { lens, projector_from_camera } = rig.projector?;
        let point = rig.boards[view] * corner.point(self.board.square_m);
        let state = SolverState { lens, poses: vec![projector_from_camera] };
        let predicted = state.predict(0, &point)?;
        let first = self.camera_count();
        let pose = first + self.projector_terms.len();
        let by_point: Matrix2x3<f64> =
            predicted.by_point * projector_from_camera.rotation.to_rotation_matrix().into_inner();
        // A rotation of the board moves the point by w × point.
        let by_turn: SMatrix<f64, 2, 3> = -by_point * point.coords.cross_matrix();
        let board = self.board_column(rig, view);
        let column = |i: usize| predicted.jacobian.column(i).into_owned();
        let terms = self.projector_terms.iter().enumerate().map(|(i, term)| (first + i, column(*term)));
        let poses = (0..6).map(|i| (pose + i, column(LENS + i)));
        let turns = (0..3).map(|i| (board + i, by_turn.column(i).into_owned()));
        let shifts = (0..3).map(|i| (board + 3 + i, by_point.column(i).into_owned()));
        let slopes = terms.chain(poses).chain(turns).chain(shifts).collect();
        Some(Row { error: corner.lit_by?.pixel - predicted.pixel, slopes })
    }

    /// State after a step; `None` if it is invalid.
    fn stepped(&self, rig: &Rig, step: &DVector<f64>) -> Option<Rig> {
        let with = |lens: &Lens, terms: &mut dyn Iterator<Item = (usize, usize)>| {
            let mut values = lens_values(lens);
            terms.for_each(|(column, term)| values[term] += step[column]);
            lens_of(lens.size_px, values)
        };
        let mut next = rig.clone();
        if self.is_camera_free {
            next.camera = with(&rig.camera, &mut (0..9).map(|i| (i, i)))?;
        }
        let first = self.camera_count();
        if let Some(projector) = &mut next.projector {
            if !self.projector_terms.is_empty() {
                let terms = self.projector_terms.iter().enumerate();
                projector.lens = with(&projector.lens, &mut terms.map(|(i, term)| (first + i, *term)))?;
            }
            let at = first + self.projector_terms.len();
            projector.projector_from_camera = moved_pose(&projector.projector_from_camera, step, at);
        }
        for (view, pose) in next.boards.iter_mut().enumerate() {
            *pose = moved_pose(pose, step, self.board_column(rig, view));
        }
        Some(next)
    }
}

impl NormalEquations {
    /// Adds a corner with the deviation of its pixel.
    fn add(&mut self, row: Option<Row>, sigma_px: f64) {
        let Some(Row { error, slopes }) = row else {
            self.cost += cauchy_loss(LOST);
            return;
        };
        let squared = error.norm_squared() / (sigma_px * sigma_px);
        let weight = cauchy_weight(squared) / (sigma_px * sigma_px);
        self.cost += cauchy_loss(squared);
        for (row, slope) in &slopes {
            for (column, other) in &slopes {
                self.hessian[(*row, *column)] += weight * slope.dot(other);
            }
            self.descent[*row] += weight * slope.dot(&error);
        }
    }

    /// Adds the priors of a camera's lens.
    fn add_priors(&mut self, lens: &Lens) {
        let values = lens_values(lens);
        let width = f64::from(lens.size_px[0].max(lens.size_px[1]));
        let middle = Point2::from(lens.size_px.map(|side| 0.5 * (f64::from(side) - 1.0)));
        let mut add = |slopes: &[(usize, f64)], off: f64, sigma: f64| {
            let weight = 1.0 / (sigma * sigma);
            self.cost += weight * off * off;
            for (row, slope) in slopes {
                for (column, other) in slopes {
                    self.hessian[(*row, *column)] += weight * slope * other;
                }
                self.descent[*row] -= weight * slope * off;
            }
        };
        add(&[(0, 1.0), (1, -1.0)], values[0] - values[1], RATIO_PRIOR * values[0]);
        for axis in 0..2 {
            add(&[(2 + axis, 1.0)], values[2 + axis] - middle[axis], CENTER_PRIOR * width);
        }
        for (i, sigma) in PRIORS.into_iter().enumerate() {
            add(&[(4 + i, 1.0)], values[4 + i], sigma);
        }
    }
}
