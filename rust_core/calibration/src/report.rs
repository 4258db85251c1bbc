//! Calibration report: error figures, a verdict, and reasons.

use nalgebra::Vector2;

use crate::statistics::{quantile, root_mean_square};
use crate::{keystone, Sample, Solution};

/// Cells of the projector's image along u and v, each covered or not.
const IMAGE_CELLS: [usize; 2] = [8, 6];
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
const MOST_ABSORBED: f64 = 0.5;
/// Maximum prediction uncertainty of a good calibration, pixels.
const GOOD_PREDICTION_PX: f64 = 0.5;
/// Maximum prediction uncertainty of a good calibration at the farthest points, metres.
const GOOD_PREDICTION_M: f64 = 0.001;
/// Maximum prediction uncertainty of a usable calibration, pixels.
const AGAIN_PREDICTION_PX: f64 = 3.0;
/// Minimum covered share of the image of a good calibration.
const GOOD_IMAGE: f64 = 0.5;
/// Minimum covered share of the image of a usable calibration.
const AGAIN_IMAGE: f64 = 0.2;
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

/// What improves a calibration, in words for the person who scans.
struct Advice {
    fit: &'static str,
    inliers: &'static str,
    certainty: &'static str,
    image: &'static str,
    depth: &'static str,
    /// `None` where no depth camera measures.
    smooth_depth: Option<&'static str>,
}

const SCAN_ADVICE: Advice = Advice {
    fit: "keep camera, projector and scene at rest, and check that the depth is registered to the image",
    inliers: "remove mirrors and glossy objects, darken the room",
    certainty: "add scans of objects at more different depths, from other camera poses",
    image: "move the camera, or put objects at the dark sides",
    depth: "put objects nearer to the projector and farther off",
    smooth_depth: Some("average 5 scans from different places"),
};

const BOARD_ADVICE: Advice = Advice {
    fit: "keep camera and projector fixed to each other, and the board flat and at rest",
    inliers: "use a flat board, avoid reflections on it, darken the room",
    certainty: "add poses of the board at more different distances and tilts",
    image: "hold the board at the dark sides, too",
    depth: "hold the board nearer to the projector and farther off, too",
    smooth_depth: None,
};

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
    pub image: f64,
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
    /// Judges a solution of samples of a depth camera.
    pub fn new(samples: &[Sample], solution: Solution) -> Self {
        Self::judged(samples, solution, &SCAN_ADVICE)
    }

    /// Judges a solution of the corners of printed boards.
    pub(crate) fn of_boards(samples: &[Sample], solution: Solution) -> Self {
        Self::judged(samples, solution, &BOARD_ADVICE)
    }

    fn judged(samples: &[Sample], solution: Solution, advice: &Advice) -> Self {
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
        report.judge_fit(advice);
        report.judge_lens();
        report.judge_certainty(advice);
        report.judge_coverage(advice);
        report.judge_depth(advice);
        report
    }

    /// Adds a reason for a calibration that is only usable, or not even that. The verdict is the worst of all reasons'.
    pub(crate) fn say(&mut self, is_unusable: bool, reason: String) {
        if self.verdict != Verdict::Again {
            self.verdict = if is_unusable { Verdict::Again } else { Verdict::Usable };
        }
        self.reasons.push(reason);
    }

    fn judge_fit(&mut self, advice: &Advice) {
        let (rms_px, held_out_px) = (self.solution.rms_px, self.solution.held_out_rms_px);
        let held_out = format!("the held-out RMS error is {held_out_px:.2} px");
        if held_out_px > GOOD_HELD_OUT_PX {
            self.say(held_out_px > AGAIN_HELD_OUT_PX, format!("{held_out}: {}", advice.fit));
        }
        let expected_px = self.expected_held_out_px();
        // The ratio says nothing about nearly exact data.
        if held_out_px > GOOD_HELD_OUT_RATIO * expected_px + 0.02 {
            let is_overfitted = held_out_px > AGAIN_HELD_OUT_RATIO * expected_px && held_out_px > GOOD_HELD_OUT_PX;
            let advice = "scan more points over more of the picture";
            self.say(is_overfitted, format!("{held_out}, that of the other points {rms_px:.2} px: {advice}"));
        }
        let share = self.solution.inliers as f64 / self.points.max(1) as f64;
        if share < GOOD_INLIERS {
            let agreeing = format!("only {:.0} % of the points agree with the solution", 100.0 * share);
            self.say(share < AGAIN_INLIERS, format!("{agreeing}: {}", advice.inliers));
        }
    }

    /// Expected held-out RMS error, given that of the fitted points: larger, since the unknowns absorb part of their
    /// errors, which matters for few points only.
    fn expected_held_out_px(&self) -> f64 {
        let solution = &self.solution;
        let adjusted = solution.estimates.iter().filter(|estimate| estimate.sigma > 0.0).count();
        let unknowns = (adjusted + 6 * solution.poses.len()) as f64;
        let absorbed = (unknowns / (2 * solution.inliers).max(1) as f64).min(MOST_ABSORBED);
        solution.rms_px * ((1.0 + absorbed) / (1.0 - absorbed)).sqrt()
    }

    fn judge_lens(&mut self) {
        if let Some(reason) = keystone::skewed(&self.solution) {
            self.say(true, reason);
        }
        if let Some(reason) = keystone::stretched(&self.solution) {
            self.say(false, reason);
        }
    }

    fn judge_certainty(&mut self, advice: &Advice) {
        let (sigma_px, far_m) = (self.solution.prediction_sigma_px, self.coverage.depth_m[1]);
        let sigma_m = sigma_px / self.solution.lens.focal_px.min() * far_m;
        if sigma_px < GOOD_PREDICTION_PX && sigma_m < GOOD_PREDICTION_M {
            return;
        }
        let sigma = format!("{sigma_px:.2} px ({:.1} mm at {far_m:.1} m)", 1000.0 * sigma_m);
        let is_certain = sigma_px < AGAIN_PREDICTION_PX;
        self.say(!is_certain, format!("the prediction uncertainty is {sigma}: {}", advice.certainty));
    }

    fn judge_coverage(&mut self, advice: &Advice) {
        // The pose of a known lens needs no coverage.
        if self.solution.estimates.iter().all(|estimate| estimate.sigma == 0.0) {
            return;
        }
        let Coverage { image, depth_m: [near, far], .. } = self.coverage;
        if image < GOOD_IMAGE {
            let covered = format!("points cover {:.0} % of the picture", 100.0 * image);
            self.say(image < AGAIN_IMAGE, format!("{covered}: {}", advice.image));
        }
        if far < GOOD_DEPTH_RATIO * near {
            self.say(false, format!("points lie between {near:.2} m and {far:.2} m only: {}", advice.depth));
        }
    }

    fn judge_depth(&mut self, advice: &Advice) {
        let Some(advice) = advice.smooth_depth else { return };
        let [near, far] = self.coverage.depth_m;
        let (error_m, error_mm) = (self.smooth_depth_error_m, 1000.0 * self.smooth_depth_error_m);
        if error_m > NOTABLE_SMOOTH_ERROR * (near * far).sqrt() && self.coverage.scans < ENOUGH_SCANS {
            self.say(false, format!("the depth camera's smooth error seems to be {error_mm:.1} mm RMS: {advice}"));
        }
    }
}

fn coverage(samples: &[Sample], solution: &Solution) -> Coverage {
    let [columns, rows] = IMAGE_CELLS;
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
    let depth_m = if depths.is_empty() { [0.0; 2] } else { [0.01, 0.99].map(|share| quantile(&mut depths, share)) };
    Coverage { image: covered as f64 / cells.len() as f64, depth_m, scans: solution.poses.len() }
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
            let projected = solution.lens.project_with_jacobian(&(pose * sample.point))?;
            let by_depth = projected.by_point * (pose.rotation * ray);
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
