//! Unknowns of the solver: the free lens parameters, and a pose for each scan.
//!
//! Poses change by increments of SO(3) × R³ in the projector's optical frame: q' = exp(w) q + d. So w is a rotation
//! about the projector's own axes, and d moves its position by -Rᵀ d in the camera's frame, independently of w.

use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix2x3, Point2, Point3, SMatrix, Translation3, UnitQuaternion, Vector3,
};

use super::{DistortionTerms, FocalLengths, Parameter, SolveOptions};
use crate::{Distortion, DistortionModel, Lens};

/// Number of lens parameters: [`Parameter::ALL`], then the skew.
pub(crate) const LENS: usize = 10;
/// Index of the skew, pixels of u per distorted y. A state has none; only its estimate is asked for.
pub(crate) const SKEW: usize = 9;
/// Number of parameters of a sample: the lens's, then its scan's rotation and translation.
pub(crate) const LOCAL: usize = LENS + 6;

/// Derivatives of a pixel by the parameters of its sample.
pub(crate) type Jacobian = SMatrix<f64, 2, LOCAL>;

/// Matrix over the parameters of a sample.
pub(super) type Block = SMatrix<f64, LOCAL, LOCAL>;

/// Lens, and a pose `projector_from_camera` for each scan.
#[derive(Debug, Clone)]
pub(crate) struct SolverState {
    pub(crate) lens: Lens,
    pub(crate) poses: Vec<Isometry3<f64>>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct PredictedPixel {
    pub(crate) pixel: Point2<f64>,
    /// Derivatives by the point in the projector's optical frame, pixels per metre.
    pub(crate) by_point: Matrix2x3<f64>,
    pub(crate) jacobian: Jacobian,
}

impl SolverState {
    /// Predicted pixel of a point; `None` where the lens cannot project it.
    pub(super) fn project(&self, scan: usize, point: &Point3<f64>) -> Option<Point2<f64>> {
        self.lens.project(&(self.poses[scan] * point))
    }

    /// [`Self::project`] with derivatives.
    pub(crate) fn predict(&self, scan: usize, point: &Point3<f64>) -> Option<PredictedPixel> {
        let pose = &self.poses[scan];
        let q = pose * point;
        let projected = self.lens.project_with_jacobian(&q)?;
        let (u, v) = (projected.by_point.row(0), projected.by_point.row(1));
        let mut jacobian = Jacobian::zeros();
        let (x, y) = (q.x / q.z, q.y / q.z);
        let distorted = (projected.pixel - self.lens.center_px).component_div(&self.lens.focal_px);
        let focal = self.lens.focal_px;
        let r2 = x * x + y * y;
        jacobian[(0, 0)] = distorted.x;
        jacobian[(1, 1)] = distorted.y;
        jacobian[(0, 2)] = 1.0;
        jacobian[(1, 3)] = 1.0;
        jacobian[(0, SKEW)] = distorted.y;
        let (fx_x, fy_y) = (focal.x * x, focal.y * y);
        for (column, power) in [(4, r2), (5, r2 * r2), (8, r2 * r2 * r2)] {
            jacobian[(0, column)] = fx_x * power;
            jacobian[(1, column)] = fy_y * power;
        }
        jacobian[(0, 6)] = 2.0 * fx_x * y;
        jacobian[(1, 6)] = focal.y * (r2 + 2.0 * y * y);
        jacobian[(0, 7)] = focal.x * (r2 + 2.0 * x * x);
        jacobian[(1, 7)] = 2.0 * fy_y * x;
        for (row, by) in [(0, u), (1, v)] {
            // by · (axis × q)
            jacobian[(row, LENS)] = by[2] * q.y - by[1] * q.z;
            jacobian[(row, LENS + 1)] = by[0] * q.z - by[2] * q.x;
            jacobian[(row, LENS + 2)] = by[1] * q.x - by[0] * q.y;
            for axis in 0..3 {
                jacobian[(row, LENS + 3 + axis)] = by[axis];
            }
        }
        Some(PredictedPixel { pixel: projected.pixel, by_point: projected.by_point, jacobian })
    }

    /// Step of the unknowns towards another state.
    pub(super) fn step_to(&self, other: &Self, free: &Free) -> DVector<f64> {
        let (values, others) = (lens_values(&self.lens), lens_values(&other.lens));
        let mut step = DVector::zeros(free.len());
        for (column, raw) in free.lens.iter().enumerate() {
            let known = raw.iter().filter(|parameter| **parameter < SKEW);
            step[column] =
                known.map(|parameter| others[*parameter] - values[*parameter]).sum::<f64>() / raw.len() as f64;
        }
        for (scan, (pose, other)) in self.poses.iter().zip(&other.poses).enumerate() {
            let turn = other.rotation * pose.rotation.inverse();
            let shift = other.translation.vector - turn * pose.translation.vector;
            let at = free.pose_column(scan);
            step.fixed_rows_mut::<3>(at).copy_from(&turn.scaled_axis());
            step.fixed_rows_mut::<3>(at + 3).copy_from(&shift);
        }
        step
    }

    /// State after a step of the unknowns; `None` if it is invalid. A distortion of another model than Brown and
    /// Conrady's stays.
    pub(super) fn stepped(&self, free: &Free, step: &DVector<f64>) -> Option<Self> {
        let mut values = lens_values(&self.lens);
        for (column, raw) in free.lens.iter().enumerate() {
            for parameter in raw.iter().filter(|parameter| **parameter != SKEW) {
                values[*parameter] += step[column];
            }
        }
        let mut lens = if free.lens.is_empty() { self.lens } else { lens_of(self.lens.size_px, values)? };
        if self.lens.distortion.model() != DistortionModel::PlumbBob {
            lens.distortion = self.lens.distortion;
        }
        let mut poses = self.poses.clone();
        for (scan, pose) in poses.iter_mut().enumerate() {
            *pose = moved_pose(pose, step, free.pose_column(scan));
        }
        Some(Self { lens, poses })
    }
}

/// Pose after a step, in which its six unknowns begin at an index: q' = exp(w) q + d.
pub(crate) fn moved_pose(pose: &Isometry3<f64>, step: &DVector<f64>, at: usize) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(step[at], step[at + 1], step[at + 2]));
    let shift = Vector3::new(step[at + 3], step[at + 4], step[at + 5]);
    let rotation = UnitQuaternion::new_normalize((turn * pose.rotation).into_inner());
    Isometry3::from_parts(Translation3::from(turn * pose.translation.vector + shift), rotation)
}

/// Values of a lens's parameters; zeros for distortions of other models than Brown and Conrady's.
pub(crate) fn lens_values(lens: &Lens) -> [f64; SKEW] {
    let mut k = [0.0; 5];
    if lens.distortion.model() == DistortionModel::PlumbBob {
        k.copy_from_slice(&lens.distortion.coefficients()[..5]);
    }
    [lens.focal_px.x, lens.focal_px.y, lens.center_px.x, lens.center_px.y, k[0], k[1], k[2], k[3], k[4]]
}

/// Lens of parameter values; `None` if they are not finite or a focal length is not positive.
pub(crate) fn lens_of(size_px: [u32; 2], values: [f64; SKEW]) -> Option<Lens> {
    let [fx, fy, cx, cy, k1, k2, p1, p2, k3] = values;
    let is_sound = values.iter().all(|value| value.is_finite()) && fx > 0.0 && fy > 0.0;
    is_sound.then(|| {
        let pinhole = Lens::pinhole(size_px, [fx, fy], [cx, cy]);
        if [k1, k2, p1, p2, k3] == [0.0; 5] {
            return pinhole;
        }
        Lens { distortion: Distortion::plumb_bob([k1, k2, p1, p2, k3]), ..pinhole }
    })
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Free {
    /// Parameters of each unknown of the lens.
    pub(super) lens: Vec<Vec<usize>>,
    scans: usize,
}

impl Free {
    pub(super) fn poses(scans: usize) -> Self {
        Self { lens: Vec::new(), scans }
    }

    /// Frees one focal length and one pose.
    pub(super) fn zoom() -> Self {
        Self { lens: vec![vec![Parameter::Fx as usize, Parameter::Fy as usize]], scans: 1 }
    }

    /// Frees what the options leave open, with these distortion terms.
    pub(super) fn new(options: &SolveOptions, terms: DistortionTerms, scans: usize) -> Self {
        if options.known_lens.is_some() {
            return Self::poses(scans);
        }
        let is_fixed = |parameter: Parameter| options.fixed.iter().any(|(fixed, _)| *fixed == parameter);
        let mut lens = Vec::new();
        if options.focal == FocalLengths::One {
            if !is_fixed(Parameter::Fx) && !is_fixed(Parameter::Fy) {
                lens.push(vec![0, 1]);
            }
        } else {
            lens.extend([Parameter::Fx, Parameter::Fy].into_iter().filter(|p| !is_fixed(*p)).map(|p| vec![p as usize]));
        }
        let others = [Parameter::Cx, Parameter::Cy].iter().chain(solved_terms(terms));
        lens.extend(others.filter(|parameter| !is_fixed(**parameter)).map(|parameter| vec![*parameter as usize]));
        Self { lens, scans }
    }

    /// Adds the skew as the lens's last unknown.
    pub(super) fn with_skew(&self) -> Self {
        let mut free = self.clone();
        free.lens.push(vec![SKEW]);
        free
    }

    pub(super) fn len(&self) -> usize {
        self.lens.len() + 6 * self.scans
    }

    /// First unknown of a scan's pose.
    pub(super) fn pose_column(&self, scan: usize) -> usize {
        self.lens.len() + 6 * scan
    }

    /// Pairs of the parameters of a scan's samples and their unknowns.
    pub(super) fn columns(&self, scan: usize) -> Vec<(usize, usize)> {
        let lens = self.lens.iter().enumerate().flat_map(|(column, raw)| raw.iter().map(move |p| (*p, column)));
        lens.chain((0..6).map(|i| (LENS + i, self.pose_column(scan) + i))).collect()
    }

    /// Adds a scan's block to a matrix of all unknowns.
    pub(super) fn add_block(&self, matrix: &mut DMatrix<f64>, scan: usize, block: &Block) {
        let columns = self.columns(scan);
        for (parameter, unknown) in &columns {
            for (other_parameter, other) in &columns {
                matrix[(*unknown, *other)] += block[(*parameter, *other_parameter)];
            }
        }
    }

    /// Block of a scan in a matrix of all unknowns.
    pub(super) fn block(&self, matrix: &DMatrix<f64>, scan: usize) -> Block {
        let columns = self.columns(scan);
        let mut block = Block::zeros();
        for (parameter, unknown) in &columns {
            for (other_parameter, other) in &columns {
                block[(*parameter, *other_parameter)] = matrix[(*unknown, *other)];
            }
        }
        block
    }
}

/// Free distortion parameters.
pub(super) fn solved_terms(terms: DistortionTerms) -> &'static [Parameter] {
    match terms {
        DistortionTerms::Auto | DistortionTerms::None => &[],
        DistortionTerms::K1 => &[Parameter::K1],
        DistortionTerms::K1K2 => &[Parameter::K1, Parameter::K2],
        DistortionTerms::PlumbBob => &[Parameter::K1, Parameter::K2, Parameter::P1, Parameter::P2, Parameter::K3],
    }
}

/// Applies the options' known values to a lens and drops terms that are not solved for; `None` if invalid.
pub(super) fn constrained(lens: &Lens, options: &SolveOptions, terms: DistortionTerms) -> Option<Lens> {
    if options.known_lens.is_some() {
        return options.known_lens;
    }
    let mut values = lens_values(lens);
    for parameter in &Parameter::ALL[4..] {
        if !solved_terms(terms).contains(parameter) {
            values[*parameter as usize] = 0.0;
        }
    }
    if options.focal == FocalLengths::One {
        let both = 0.5 * (values[0] + values[1]);
        [values[0], values[1]] = [both, both];
    }
    for (parameter, value) in &options.fixed {
        values[*parameter as usize] = *value;
        if options.focal == FocalLengths::One && matches!(parameter, Parameter::Fx | Parameter::Fy) {
            [values[0], values[1]] = [*value, *value];
        }
    }
    lens_of(lens.size_px, values)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn state() -> SolverState {
        let lens = lens_of([1280, 800], [1410.0, 1395.0, 640.0, 817.0, -0.1, 0.02, 0.001, -0.002, 0.003]).unwrap();
        SolverState { lens, poses: vec![Isometry3::new(Vector3::new(0.2, -0.1, 0.05), Vector3::new(0.1, 0.2, -0.05))] }
    }

    fn all_free() -> Free {
        let options = SolveOptions { distortion: DistortionTerms::PlumbBob, ..SolveOptions::new([1280, 800]) };
        Free::new(&options, options.distortion, 1)
    }

    proptest! {
        #[test]
        fn derivatives_are_the_differences(x in -0.3..0.3, y in -0.3..0.1, z in 0.7..2.0) {
            let (state, free) = (state(), all_free());
            let point = Point3::new(x * z, y * z, z);
            let prediction = state.predict(0, &point).unwrap();
            for (parameter, column) in free.columns(0) {
                let mut step = DVector::zeros(free.len());
                step[column] = 1e-6;
                let [after, before] = [1.0, -1.0].map(|sign| {
                    state.stepped(&free, &(&step * sign)).unwrap().project(0, &point).unwrap()
                });
                let difference = (after - before) / 2e-6;
                let derivative = prediction.jacobian.column(parameter);
                prop_assert!((difference - derivative).norm() < 1e-4 * (1.0 + derivative.norm()), "{parameter}");
            }
        }
    }

    #[test]
    fn a_shift_moves_the_position_whatever_the_turn() {
        let (state, free) = (state(), all_free());
        let mut step = DVector::zeros(free.len());
        let at = free.pose_column(0);
        (step[at], step[at + 1], step[at + 3]) = (0.02, -0.01, 0.003);
        let stepped = state.stepped(&free, &step).unwrap();
        let position = |state: &SolverState| state.poses[0].inverse().translation.vector;
        let moved = position(&stepped) - position(&state);
        assert!((moved.norm() - 0.003).abs() < 1e-12);
    }

    #[test]
    fn one_focal_length_and_fixed_parameters_leave_fewer_unknowns() {
        let options = SolveOptions {
            focal: FocalLengths::One,
            fixed: vec![(Parameter::Cx, 640.0), (Parameter::K2, 0.1)],
            ..SolveOptions::new([1280, 800])
        };
        let free = Free::new(&options, DistortionTerms::K1, 2);
        assert_eq!(free.lens, [vec![0, 1], vec![3], vec![4]]);
        assert_eq!(free.len(), 15);
        let lens = constrained(&state().lens, &options, DistortionTerms::K1).unwrap();
        assert_eq!(lens_values(&lens), [1402.5, 1402.5, 640.0, 817.0, -0.1, 0.1, 0.0, 0.0, 0.0]);
    }
}
