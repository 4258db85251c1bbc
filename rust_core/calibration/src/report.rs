//! Calibration report: error figures, a verdict, and reasons.

use nalgebra::Vector2;

use crate::statistics::root_mean_square;
use crate::{keystone, Sample, Solution, SuspectedMotion};

/// Cells of the projector's image along u and v, each covered or not.
const PICTURE_CELLS: [usize; 2] = [8, 6];
/// Minimum samples of a covered cell, as a share of an even distribution; at least one.
const COVERED: f64 = 0.05;
/// Cells along the longer side of the camera's view; samples of one cell are neighbours.
const NEIGHBOUR_CELLS: f64 = 24.0;

/// Maximum held-out RMS error of a good calibration, pixels.
const GOOD_HELD_OUT_PX: f64 = 1.0;
/// Maximum held-out RMS error of a usable calibration, pixels.
const AGAIN_HELD_OUT_PX: f64 = 3.0;
/// Maximum ratio of held-out and expected RMS error of a good calibration.
const GOOD_HELD_OUT_RATIO: f64 = 1.25;
/// Ratio that means overfitting.
const AGAIN_HELD_OUT_RATIO: f64 = 2.0;
/// Maximum ratio of unknowns and equations: a pose by six points, each with two coordinates.
const MOST_TAKEN_UP: f64 = 0.5;
/// Maximum prediction uncertainty of a good calibration, pixels.
const GOOD_PREDICTION_PX: f64 = 0.5;
/// Maximum prediction uncertainty of a good calibration at the farthest points, metres.
const GOOD_PREDICTION_M: f64 = 0.001;
/// Maximum prediction uncertainty of a usable calibration, pixels.
const AGAIN_PREDICTION_PX: f64 = 3.0;
/// Minimum covered share of the image of a good calibration.
const GOOD_PICTURE: f64 = 0.5;
/// Minimum covered share of the image of a usable calibration.
const AGAIN_PICTURE: f64 = 0.2;
/// Minimum ratio of the farthest and the nearest depth of a good calibration.
const GOOD_DEPTH_RATIO: f64 = 1.3;
/// Minimum share of inliers of a good calibration.
const GOOD_INLIERS: f64 = 0.8;
/// Minimum share of inliers of a usable calibration: fewer are hardly a majority.
const AGAIN_INLIERS: f64 = 0.58;
/// Smooth depth error that affects the projection, as a share of the depth.
const NOTABLE_SMOOTH_ERROR: f64 = 0.0007;
/// Number of scans from different camera poses that average the smooth depth error.
const ENOUGH_SCANS: usize = 5;

/// Verdict on a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Accurate.
    Good,
    /// Less accurate; the reasons say what would improve it.
    Usable,
    /// Not usable: scan again.
    Again,
}

impl Verdict {
    /// Word in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Usable => "usable",
            Self::Again => "again",
        }
    }
}

/// Coverage of the image and of depths by the inliers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// Share of the image, in 8×6 cells, with inliers.
    pub picture: f64,
    /// Range of 98 % of the inliers' depths, metres from the projector.
    pub depth_m: [f64; 2],
    /// Number of camera poses.
    pub scans: usize,
}

/// Calibration with its figures and verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Solution.
    pub solution: Solution,
    /// Number of samples.
    pub points: usize,
    /// Coverage by inliers.
    pub coverage: Coverage,
    /// Estimated depth error that neighbouring points share, which averaging neighbours does not remove, metres RMS.
    pub smooth_depth_error_m: f64,
    /// RMS reprojection error of the inliers at their depths, metres.
    pub rms_m: f64,
    /// Verdict.
    pub verdict: Verdict,
    /// Reasons for the verdict; empty if good.
    pub reasons: Vec<String>,
}

impl Report {
    /// Judges a solution of samples.
    pub fn new(samples: &[Sample], solution: Solution) -> Self {
        let inliers = || solution.residuals.iter().filter(|residual| residual.is_inlier);
        let rms_m = root_mean_square(inliers().map(|residual| residual.error_m.norm()));
        let mut report = Self {
            points: samples.len(),
            coverage: coverage(samples, &solution),
            smooth_depth_error_m: smooth_depth_error_m(samples, &solution),
            rms_m,
            verdict: Verdict::Good,
            reasons: Vec::new(),
            solution,
        };
        report.judge();
        report
    }

    fn judge(&mut self) {
        self.judge_fit();
        self.judge_motion();
        self.judge_lens();
        self.judge_certainty();
        self.judge_coverage();
        self.judge_depth();
    }

    /// Adds a reason; the verdict is the worst of all reasons'.
    fn say(&mut self, verdict: Verdict, reason: String) {
        if self.verdict == Verdict::Good || verdict == Verdict::Again {
            self.verdict = verdict;
        }
        self.reasons.push(reason);
    }

    fn judge_fit(&mut self) {
        let (rms_px, held_out_px) = (self.solution.rms_px, self.solution.held_out_rms_px);
        if held_out_px > GOOD_HELD_OUT_PX {
            let verdict = if held_out_px > AGAIN_HELD_OUT_PX { Verdict::Again } else { Verdict::Usable };
            self.say(
                verdict,
                format!(
                    "the held-out RMS error is {held_out_px:.2} px: keep camera, projector and scene at rest, and check \
                    that the depth is registered to the image"
                ),
            );
        }
        let expected_px = self.expected_held_out_px();
        // The ratio says nothing about nearly exact data.
        if held_out_px > GOOD_HELD_OUT_RATIO * expected_px + 0.02 {
            let is_too_much = held_out_px > AGAIN_HELD_OUT_RATIO * expected_px && held_out_px > GOOD_HELD_OUT_PX;
            self.say(
                if is_too_much { Verdict::Again } else { Verdict::Usable },
                format!(
                    "the held-out RMS error is {held_out_px:.2} px, that of the other points {rms_px:.2} px: scan more \
                    points over more of the picture"
                ),
            );
        }
        let share = self.solution.inliers as f64 / self.points.max(1) as f64;
        if share < GOOD_INLIERS {
            self.say(
                if share < AGAIN_INLIERS { Verdict::Again } else { Verdict::Usable },
                format!(
                    "only {:.0} % of the points agree with the solution: remove mirrors and glossy objects, darken the \
                    room",
                    100.0 * share
                ),
            );
        }
    }

    fn judge_motion(&mut self) {
        if let Some(SuspectedMotion { scan, apart_px }) = self.solution.motion {
            self.say(
                Verdict::Usable,
                format!(
                    "the camera may have moved: some samples of scan {scan} are {apart_px:.2} px off the others: scan \
                    again with everything at rest"
                ),
            );
        }
    }

    /// Expected held-out RMS error, given that of the fitted points: larger, since the unknowns absorb part of their
    /// errors, which matters for few points only.
    fn expected_held_out_px(&self) -> f64 {
        let solution = &self.solution;
        let adjusted = solution.estimates.iter().filter(|estimate| estimate.sigma > 0.0).count();
        let unknowns = (adjusted + 6 * solution.poses.len()) as f64;
        let taken_up = (unknowns / (2 * solution.inliers).max(1) as f64).min(MOST_TAKEN_UP);
        solution.rms_px * ((1.0 + taken_up) / (1.0 - taken_up)).sqrt()
    }

    fn judge_lens(&mut self) {
        if let Some(reason) = keystone::skewed(&self.solution) {
            self.say(Verdict::Again, reason);
        }
        if let Some(reason) = keystone::stretched(&self.solution) {
            self.say(Verdict::Usable, reason);
        }
    }

    fn judge_certainty(&mut self) {
        let sigma_px = self.solution.prediction_sigma_px;
        let focal_px = self.solution.lens.focal_px.min();
        let sigma_m = sigma_px / focal_px * self.coverage.depth_m[1];
        if sigma_px < GOOD_PREDICTION_PX && sigma_m < GOOD_PREDICTION_M {
            return;
        }
        self.say(
            if sigma_px < AGAIN_PREDICTION_PX { Verdict::Usable } else { Verdict::Again },
            format!(
                "the prediction uncertainty is {sigma_px:.2} px ({:.1} mm at {:.1} m): add scans of objects at more \
                different depths, from other camera poses",
                1000.0 * sigma_m,
                self.coverage.depth_m[1]
            ),
        );
    }

    fn judge_coverage(&mut self) {
        // The pose of a known lens needs no coverage.
        if self.solution.estimates.iter().all(|estimate| estimate.sigma == 0.0) {
            return;
        }
        let Coverage { picture, depth_m: [near, far], .. } = self.coverage;
        if picture < GOOD_PICTURE {
            self.say(
                if picture < AGAIN_PICTURE { Verdict::Again } else { Verdict::Usable },
                format!(
                    "points cover {:.0} % of the picture: move the camera, or put objects at the dark sides",
                    100.0 * picture
                ),
            );
        }
        if far < GOOD_DEPTH_RATIO * near {
            self.say(
                Verdict::Usable,
                format!(
                    "points lie between {near:.2} m and {far:.2} m only: put objects nearer to the projector and \
                    farther off"
                ),
            );
        }
    }

    fn judge_depth(&mut self) {
        let [near, far] = self.coverage.depth_m;
        let error_m = self.smooth_depth_error_m;
        if error_m > NOTABLE_SMOOTH_ERROR * (near * far).sqrt() && self.coverage.scans < ENOUGH_SCANS {
            self.say(
                Verdict::Usable,
                format!(
                    "the depth camera's smooth error seems to be {:.1} mm RMS: average {ENOUGH_SCANS} scans from \
                    different places",
                    1000.0 * error_m
                ),
            );
        }
    }
}

fn coverage(samples: &[Sample], solution: &Solution) -> Coverage {
    let [columns, rows] = PICTURE_CELLS;
    let mut cells = vec![0_usize; columns * rows];
    let mut depths = Vec::new();
    for residual in solution.residuals.iter().filter(|residual| residual.is_inlier) {
        let Some(sample) = samples.get(residual.sample) else { continue };
        let cell = |axis: usize, count: usize| {
            let share = (sample.pixel[axis] + 0.5) / f64::from(solution.lens.size_px[axis]);
            ((share * count as f64).max(0.0) as usize).min(count - 1)
        };
        cells[cell(1, rows) * columns + cell(0, columns)] += 1;
        depths.push(residual.depth_m);
    }
    let needed = ((COVERED * depths.len() as f64 / cells.len() as f64) as usize).max(1);
    let covered = cells.iter().filter(|count| **count >= needed).count();
    depths.sort_by(f64::total_cmp);
    let depth_at = |share: f64| depths.get((share * depths.len() as f64) as usize).copied().unwrap_or(0.0);
    Coverage {
        picture: covered as f64 / cells.len() as f64,
        depth_m: [depth_at(0.01), depth_at(0.99)],
        scans: solution.poses.len(),
    }
}

/// Depth error that neighbours share. A wrong depth moves a point along the camera's ray, and so its pixel along the
/// epipolar line, the more the larger the baseline. The mean product of two samples of a cell of the camera's view is
/// the square of the shared error.
fn smooth_depth_error_m(samples: &[Sample], solution: &Solution) -> f64 {
    let used: Vec<(usize, Vector2<f64>, f64, f64)> = solution
        .residuals
        .iter()
        .filter(|residual| residual.is_inlier)
        .filter_map(|residual| {
            let sample = samples.get(residual.sample)?;
            let scan = solution.poses.binary_search_by_key(&sample.scan, |pose| pose.scan).ok()?;
            let pose = solution.poses[scan].projector_from_camera;
            let ray = sample.point.coords / sample.point.z;
            let landing = solution.lens.project_with_jacobian(&(pose * sample.point))?;
            let by_depth = landing.by_point * (pose.rotation * ray);
            Some((scan, ray.xy(), by_depth.dot(&residual.error_px), by_depth.norm_squared()))
        })
        .collect();
    let (mut least, mut most) = (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
    for (_, ray, ..) in &used {
        (least, most) = (least.inf(ray), most.sup(ray));
    }
    let size = (most - least).max().max(1e-9) / NEIGHBOUR_CELLS * (1.0 + 1e-9);
    let side = NEIGHBOUR_CELLS as usize + 1;
    let mut cells = vec![[0.0; 4]; side * side * solution.poses.len()];
    for (scan, ray, moment, weight) in &used {
        let place = (ray - least) / size;
        let cell = &mut cells[(scan * side + place.y as usize) * side + place.x as usize];
        for (sum, term) in cell.iter_mut().zip([*moment, moment * moment, *weight, weight * weight]) {
            *sum += term;
        }
    }
    let (mut product, mut pairs) = (0.0, 0.0);
    for [moments, moments_squared, weights, weights_squared] in cells {
        if weights > 0.0 {
            product += (moments * moments - moments_squared) / weights;
            pairs += (weights * weights - weights_squared) / weights;
        }
    }
    if pairs > 0.0 && product > 0.0 {
        (product / pairs).sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use rcs_scan_simulator::seeds;

    use super::*;
    use crate::solve::tests::synthetic::{pose, Simulation};
    use crate::{solve, SolveOptions};

    fn report(simulation: &Simulation, keep: impl Fn(&Sample) -> bool) -> Report {
        let samples: Vec<Sample> = simulation.samples().into_iter().filter(keep).collect();
        let solution = solve(&samples, &SolveOptions::new([1280, 800])).unwrap();
        Report::new(&samples, solution)
    }

    #[test]
    fn a_clean_scan_is_good() {
        let report = report(&Simulation::new(0), |_| true);
        assert_eq!((report.verdict, report.reasons.as_slice()), (Verdict::Good, [].as_slice()));
        assert!(report.coverage.picture > 0.6 && report.coverage.scans == 1);
        let [near, far] = report.coverage.depth_m;
        assert!(near > 0.5 && far < 2.5 && far > 1.5 * near);
        assert!(report.rms_m < 0.001 && report.smooth_depth_error_m < 0.0004);
    }

    #[test]
    fn a_smooth_error_of_the_depth_is_measured_and_more_scans_are_asked_for() {
        let mut sum = 0.0;
        let seeds = seeds(0, 3, 8);
        let count = (seeds.end - seeds.start) as f64;
        for seed in seeds {
            let mut simulation = Simulation { smooth_depth_m: 0.0015, step_px: 8, ..Simulation::new(seed) };
            let single = report(&simulation, |_| true);
            // The error grows with the square of the distance, so it depends on where things are.
            assert!((0.0005..0.005).contains(&single.smooth_depth_error_m), "{}", single.smooth_depth_error_m);
            sum += single.smooth_depth_error_m;
            let advises = |report: &Report| report.reasons.iter().any(|reason| reason.contains("average 5 scans"));
            assert!(single.verdict != Verdict::Good && advises(&single), "{:?}", single.reasons);
            simulation.projector_from_camera = (0..5).map(|scan| pose(seed + 50 * scan)).collect();
            assert!(!advises(&report(&simulation, |_| true)));
        }
        assert!((0.001..0.004).contains(&(sum / count)), "{}", sum / count);
    }

    #[test]
    fn a_scaled_picture_is_named() {
        let mut samples = Simulation { step_px: 4, ..Simulation::new(2) }.samples();
        samples.iter_mut().for_each(|sample| sample.pixel.y *= 0.94);
        let solution = solve(&samples, &SolveOptions::new([1280, 800])).unwrap();
        let report = Report::new(&samples, solution);
        let names = |reason: &&String| reason.contains("keystone");
        assert_eq!((report.verdict, report.reasons.iter().filter(names).count()), (Verdict::Usable, 1), "{report:?}");
    }

    #[test]
    fn a_dark_side_of_the_picture_is_named() {
        let report = report(&Simulation { step_px: 4, ..Simulation::new(1) }, |sample| sample.pixel.x < 450.0);
        assert!(report.verdict != Verdict::Good);
        assert!(report.reasons.iter().any(|reason| reason.contains("of the picture")), "{:?}", report.reasons);
    }

    #[test]
    fn many_gross_errors_and_large_misses_are_named() {
        let gross = report(&Simulation { gross: 0.35, ..Simulation::new(2) }, |_| true);
        assert!(gross.verdict == Verdict::Usable && gross.reasons[0].contains("% of the points agree"));
        let simulation = Simulation { noise_px: 3.5, step_px: 3, ..Simulation::new(2) };
        let noisy = report(&simulation, |sample| simulation.lens.contains(sample.pixel));
        assert!(
            noisy.verdict == Verdict::Again && noisy.reasons[0].contains("held-out RMS error"),
            "{:?}",
            noisy.reasons
        );
    }
}
