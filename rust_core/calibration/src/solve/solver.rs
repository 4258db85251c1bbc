//! Sequence of the solver: check, initialise, adjust, select the distortion, judge.

use nalgebra::{DMatrix, DVector, Matrix3, Point2, Vector3};
use rayon::prelude::*;

use super::adjust::{self, Adjusted};
use super::consensus::{self, Agreed, Score};
use super::covariance::Errors;
use super::held_out::{Blocks, HeldOut};
use super::input::{check_options, Observations};
use super::levenberg_marquardt::MOST_STEPS;
use super::model::{constrained, lens_values, Free, SolverState};
use super::noise::{Noise, LIMIT};
use super::normal_equations::NormalEquations;
use super::{covariance, motion, moved, orientation, skew, spread};
use super::{DistortionTerms, Estimate, Parameter, Refusal, Residual, ScanPose, Skew, Solution, SolveOptions};
use crate::statistics::{median, quantile, root_mean_square};
use crate::{Lens, Sample};

/// Samples of all scans for the first solution.
const FIRST: usize = 4000;
/// Minimum samples of each scan, and maximum of a single one for the first solution.
const OF_EACH: [usize; 2] = [300, 2000];
/// Samples of all scans for the selection of distortion terms and for cross-validation.
const CHOOSING: usize = 12_000;
/// Minimum share of inliers of a scan: fewer could be the minority.
const LEAST_INLIERS: f64 = 0.5;
/// Maximum share of samples behind the projector.
const MOST_BEHIND: f64 = 0.1;
/// Maximum RMS error of the inliers, as a share of the image's width.
const MOST_RMS: f64 = 0.005;
/// Minimum area of the inliers' outline as a share of the image, if the lens is solved for.
const LEAST_OUTLINE: f64 = 0.15;
/// Maximum relative deviation of a focal length.
const MOST_FOCAL_SIGMA: f64 = 0.05;
/// Maximum prediction uncertainty, as a share of the image's width.
const MOST_PREDICTION_SIGMA: f64 = 0.01;
/// Lower bound of the relative deviation of a focal length. Errors that all samples share, such as the rounding of
/// depths, show in no residual, since focal length and distance absorb them.
const LEAST_FOCAL_SHARE: f64 = 6e-6;
/// Lower bounds of the projector's position deviations, as shares of the points' depth, for the same reason.
const LEAST_POSITION_SHARES: [f64; 3] = [2e-6, 2e-6, 6e-6];
/// Maximum held-out RMS error: a factor of the RMS error plus pixels, which double at `FEW` samples.
const HELD_OUT_LIMIT: (f64, f64) = (3.0, 1.0);
const FEW: f64 = 20.0;
/// Number of intrinsics that a single plane determines.
const FLAT_DETERMINES: usize = 2;
/// Throw ratios of initial lenses where no linear solution exists.
const THROWS: [f64; 4] = [0.7, 1.2, 2.0, 3.5];

/// Solves for the projector's lens and its pose in each scan.
///
/// # Errors
/// [`Refusal`]: the samples do not allow a solution.
pub fn solve(samples: &[Sample], options: &SolveOptions) -> Result<Solution, Refusal> {
    check_options(options)?;
    let observations = Observations::new(samples, options.size_px)?;
    let solver = Solver::new(options, &observations);
    observations.check_count(solver.lens_is_known())?;
    if observations.scans.len() == 1 && solver.is_flat(|_| true) {
        return Err(Refusal::Flat);
    }
    if orientation::is_mirrored(&observations) {
        return Err(Refusal::Mirrored);
    }
    let first = solver.first()?;
    let per_scan = (CHOOSING / observations.scans.len()).max(OF_EACH[0]);
    let few = observations.thinned(per_scan, options.seed);
    let ChosenTerms { terms, free, adjusted, in_doubt } = solver.chosen_terms(&few, &first);
    let adjusted = adjust::robustly(&observations, &adjusted.state, &free, adjusted.noise, 2);
    solver.check_fit(&adjusted)?;
    let Judged { covariance, prediction_sigma_px, skew } = solver.judged(&adjusted, &free)?;
    let weights = adjusted.noise.weights(&few, &adjusted.state, LIMIT);
    let blocks = Blocks::new(&few, options.size_px);
    let held_out_rms_px = HeldOut::new(&few, &weights, &blocks, &adjusted.state, &free).rms_px();
    // The effect of terms in doubt adds to the uncertainty of the unknowns, not of the prediction.
    let covariance = covariance + &in_doubt * in_doubt.transpose();
    let solution = solver.solution(&adjusted, &free, &covariance, terms);
    let solution = Solution { held_out_rms_px, prediction_sigma_px, skew, ..solution };
    let (factor, more_px) = HELD_OUT_LIMIT;
    // The unknowns absorb part of the errors of few samples.
    let equations = 2.0 * solution.inliers as f64;
    let absorbed = (equations / (equations - free.len() as f64).max(1.0)).sqrt();
    if held_out_rms_px > factor * absorbed * solution.rms_px + more_px * (1.0 + FEW / solution.inliers as f64) {
        return Err(Refusal::Unpredictive { rms_px: solution.rms_px, held_out_px: held_out_rms_px });
    }
    Ok(solution)
}

/// Solution with the selected distortion terms.
struct ChosenTerms {
    terms: DistortionTerms,
    free: Free,
    adjusted: Adjusted,
    /// Change of the unknowns by terms that improve the prediction insignificantly.
    in_doubt: DVector<f64>,
}

/// Uncertainty of a solution.
struct Judged {
    covariance: DMatrix<f64>,
    prediction_sigma_px: f64,
    skew: Option<Skew>,
}

/// Distortion terms to try. All are tried, because a lens without radial distortion may be mounted askew; k3 last and
/// alone, because few lenses have it and it makes the others uncertain.
fn candidates(options: &SolveOptions) -> Vec<(DistortionTerms, SolveOptions)> {
    let with = |terms: DistortionTerms| (terms, options.clone());
    let mut candidates = vec![with(DistortionTerms::K1), with(DistortionTerms::K1K2)];
    if options.fixed.iter().all(|(parameter, _)| *parameter != Parameter::K3) {
        let (terms, mut without) = with(DistortionTerms::PlumbBob);
        without.fixed.push((Parameter::K3, 0.0));
        candidates.push((terms, without));
    }
    candidates.push(with(DistortionTerms::PlumbBob));
    candidates
}

struct Solver<'a> {
    options: &'a SolveOptions,
    observations: &'a Observations,
    /// Largest set of terms that may be solved for.
    richest: DistortionTerms,
}

impl<'a> Solver<'a> {
    fn new(options: &'a SolveOptions, observations: &'a Observations) -> Self {
        let richest = match options.distortion {
            DistortionTerms::Auto => DistortionTerms::K1K2,
            terms => terms,
        };
        Self { options, observations, richest }
    }

    fn free(&self, terms: DistortionTerms) -> Free {
        Free::new(self.options, terms, self.observations.scans.len())
    }

    fn lens_is_known(&self) -> bool {
        self.free(self.richest).lens.is_empty()
    }

    /// Share of each scan's used points off its largest plane.
    fn relief(&self, is_used: impl Fn(usize) -> bool) -> Vec<f64> {
        let seed = self.options.seed;
        let relief = |scan: usize| {
            let used = self.observations.range(scan).filter(|i| is_used(*i)).map(|i| &self.observations.all[i]);
            let (points, pixels): (Vec<_>, Vec<_>) = used.map(|used| (used.point, used.pixel)).unzip();
            let of_points = spread::off_plane(&points, seed);
            spread::pieces_off_plane(&points, &pixels, seed).map_or(of_points, |of_pieces| of_points.min(of_pieces))
        };
        (0..self.observations.scans.len()).map(relief).collect()
    }

    /// `true` if a lens is solved for and the used points of each scan are a plane. Several planes may determine it.
    fn is_flat(&self, is_used: impl Fn(usize) -> bool) -> bool {
        // A single plane determines few intrinsics.
        let needs_relief = self.free(DistortionTerms::None).lens.len() > FLAT_DETERMINES;
        needs_relief && self.relief(is_used).iter().all(|relief| spread::is_flat(*relief))
    }

    fn first(&self) -> Result<Agreed, Refusal> {
        let [least, most] = OF_EACH;
        let few =
            self.observations.thinned((FIRST / self.observations.scans.len()).clamp(least, most), self.options.seed);
        let relief = self.relief(|_| true);
        let best = (0..relief.len()).max_by(|a, b| relief[*a].total_cmp(&relief[*b])).unwrap_or(0);
        let agreed = self.agreed(&few, best, spread::is_flat(relief[best]));
        agreed.ok_or(Refusal::NoSolution(self.observations.scans[best]))
    }

    /// Lens and poses by consensus; the lens comes from the scan `best`.
    fn agreed(&self, few: &Observations, best: usize, is_flat: bool) -> Option<Agreed> {
        let seed = self.options.seed;
        if let Some(lens) = self.options.known_lens.or(self.options.initial) {
            return self.agreed_from(few, &lens, None);
        }
        if is_flat {
            let [width, height] = self.options.size_px.map(f64::from);
            let guesses: Vec<Lens> = THROWS
                .iter()
                .map(|throw| Lens::pinhole(self.options.size_px, [throw * width; 2], [0.5 * width, 0.5 * height]))
                .collect();
            let agreed = guesses.par_iter().map(|lens| self.agreed_from(few, lens, None)).collect::<Vec<_>>();
            return agreed.into_iter().flatten().min_by(|a, b| a.score.mean.total_cmp(&b.score.mean));
        }
        let everything = SolveOptions::new(self.options.size_px);
        let mut frees = vec![Free::new(&everything, DistortionTerms::None, 1)];
        if self.richest != DistortionTerms::None {
            frees.push(Free::new(&everything, DistortionTerms::K1, 1));
        }
        let linear = consensus::lens_and_pose(&few.only(best), self.options.size_px, &frees, seed)?;
        self.agreed_from(few, &linear.state.lens, Some((best, &linear.state)))
    }

    /// Poses for a lens, then both adjusted together. One scan's pose may be known.
    fn agreed_from(&self, few: &Observations, lens: &Lens, known: Option<(usize, &SolverState)>) -> Option<Agreed> {
        let (options, seed) = (self.options, self.options.seed);
        let scans = few.scans.len();
        let lens = constrained(lens, options, self.richest)?;
        let mut buffer = Vec::new();
        let mut poses = Vec::new();
        for scan in 0..scans {
            let single = few.only(scan);
            let mut found = consensus::pose(&single, &lens, seed);
            if let Some((_, state)) = known.filter(|(known, _)| *known == scan) {
                let state = SolverState { lens, poses: state.poses.clone() };
                let score = Score::new(&single.all, &state, &mut buffer);
                if found.as_ref().is_none_or(|found| score.mean < found.score.mean) {
                    found = Some(Agreed { state, score });
                }
            }
            poses.push(found?.state.poses[0]);
        }
        let mut state = SolverState { lens, poses };
        let mut score = Score::new(&few.all, &state, &mut buffer);
        let free = Free::new(options, self.richest, scans);
        for _ in 0..4 {
            let weights = Noise::first(score.near, few.all.len() / scans).weights(few, &state, LIMIT);
            let trial = adjust::minimise(few, &weights, &state, &free, MOST_STEPS);
            let trial_score = Score::new(&few.all, &trial, &mut buffer);
            if trial_score.mean.is_nan() || trial_score.mean >= score.mean {
                break;
            }
            let gain = trial_score.mean / score.mean;
            (state, score) = (trial, trial_score);
            if gain > 0.99 {
                break;
            }
        }
        score.mean.is_finite().then_some(Agreed { state, score })
    }

    /// Selects the distortion terms that improve the prediction of held-out samples.
    fn chosen_terms(&self, few: &Observations, first: &Agreed) -> ChosenTerms {
        let options = self.options;
        let noise = Noise::first(first.score.near, few.all.len() / few.scans.len());
        let free = self.free(self.richest);
        let rich = adjust::robustly(few, &first.state, &free, noise, 3);
        let in_doubt = DVector::zeros(free.len());
        if options.known_lens.is_some() {
            return ChosenTerms { terms: DistortionTerms::None, free, adjusted: rich, in_doubt };
        }
        if options.distortion != DistortionTerms::Auto {
            return ChosenTerms { terms: options.distortion, free, adjusted: rich, in_doubt };
        }
        let blocks = Blocks::new(few, options.size_px);
        let with = |terms: DistortionTerms, options: &SolveOptions| {
            let lens = constrained(&rich.state.lens, options, terms).unwrap_or(rich.state.lens);
            let start = SolverState { lens, poses: rich.state.poses.clone() };
            let free = Free::new(options, terms, few.scans.len());
            let state = adjust::minimise(few, &rich.weights, &start, &free, MOST_STEPS);
            let held_out = HeldOut::new(few, &rich.weights, &blocks, &state, &free);
            (terms, free, state, held_out)
        };
        let mut chosen = with(DistortionTerms::None, options);
        let mut rejected: Option<(SolverState, HeldOut)> = None;
        for (terms, options) in candidates(options) {
            let trial = with(terms, &options);
            if trial.3.is_better_than(&chosen.3, &rich.weights, &blocks) {
                (chosen, rejected) = (trial, None);
            } else if rejected.as_ref().is_none_or(|(_, rejected)| trial.3.rms_px() < rejected.rms_px()) {
                rejected = Some((trial.2, trial.3));
            }
        }
        let (terms, free, state, held_out) = chosen;
        let in_doubt = rejected.filter(|(_, rejected)| rejected.rms_px() < held_out.rms_px());
        let in_doubt =
            in_doubt.map_or_else(|| DVector::zeros(free.len()), |(rejected, _)| state.step_to(&rejected, &free));
        ChosenTerms { terms, free, adjusted: Adjusted { state, ..rich }, in_doubt }
    }

    /// Refuses fits that many samples contradict.
    fn check_fit(&self, adjusted: &Adjusted) -> Result<(), Refusal> {
        let observations = self.observations;
        motion::check(observations, adjusted, self.options.seed)?;
        moved::check(observations, adjusted, self.options.seed).map_err(|moved| self.distorted_or(moved, adjusted))?;
        let depth_of = |i: usize| {
            let observation = &observations.all[i];
            (adjusted.state.poses[observation.scan] * observation.point).z
        };
        let behind = (0..observations.all.len()).filter(|i| depth_of(*i) <= 0.0).count();
        let behind = behind as f64 / observations.all.len() as f64;
        if behind > MOST_BEHIND {
            return Err(Refusal::BehindProjector(100.0 * behind));
        }
        for (scan, number) in observations.scans.iter().enumerate() {
            let range = observations.range(scan);
            let total = range.len() as f64;
            let share = range.filter(|i| adjusted.weights[*i].is_used()).count() as f64 / total;
            if share < LEAST_INLIERS {
                return Err(Refusal::FewInliers { percent: 100.0 * share, scan: *number });
            }
        }
        let (sum, count) = (observations.all.iter().zip(&adjusted.weights))
            .filter(|(_, weight)| weight.is_used())
            .filter_map(|(o, _)| Some((o.pixel - adjusted.state.project(o.scan, &o.point)?).norm_squared()))
            .fold((0.0, 0.0), |(sum, count), squared| (sum + squared, count + 1.0));
        let typical_px = (sum / count).sqrt();
        if typical_px.is_nan() || typical_px > MOST_RMS * f64::from(self.options.size_px[0]) {
            return Err(Refusal::Inconsistent(typical_px));
        }
        Ok(())
    }

    /// Distinguishes a motion from unmodelled distortion, whose residuals in the image's corners agree with another
    /// pose: with all distortion terms they vanish.
    fn distorted_or(&self, moved: Refusal, adjusted: &Adjusted) -> Refusal {
        let all_terms = self.options.with_all_terms();
        if self.lens_is_known() || all_terms == *self.options {
            return moved;
        }
        let scans = self.observations.scans.len();
        let few = self.observations.thinned((CHOOSING / scans).max(OF_EACH[0]), self.options.seed);
        let free = Free::new(&all_terms, DistortionTerms::PlumbBob, scans);
        let distorted = adjust::robustly(&few, &adjusted.state, &free, adjusted.noise, 3);
        let used = distorted.weights.iter().filter(|weight| weight.is_used()).count() as f64;
        let used_before = adjusted.weights.iter().filter(|weight| weight.is_used()).count() as f64;
        let more = used / few.all.len() as f64 - used_before / self.observations.all.len() as f64;
        match moved::check(&few, &distorted, self.options.seed) {
            Ok(()) if more > 0.0 => Refusal::DistortionLeftOut(100.0 * more),
            _ => moved,
        }
    }

    /// Estimates the uncertainty and refuses solutions that are too uncertain.
    fn judged(&self, adjusted: &Adjusted, free: &Free) -> Result<Judged, Refusal> {
        let (observations, size_px) = (self.observations, self.options.size_px);
        let is_used = |i: usize| adjusted.weights[i].is_used();
        let is_flat = self.is_flat(is_used);
        if is_flat && observations.scans.len() == 1 {
            return Err(Refusal::Flat);
        }
        if !free.lens.is_empty() {
            let pixels: Vec<Point2<f64>> =
                (0..observations.all.len()).filter(|i| is_used(*i)).map(|i| observations.all[i].pixel).collect();
            let outline = spread::outline_share(&pixels, size_px);
            if outline < LEAST_OUTLINE {
                return Err(Refusal::BadlySpread(100.0 * outline));
            }
        }
        let undetermined = |what, sigma, unit| {
            if is_flat {
                Refusal::Flat
            } else {
                Refusal::Undetermined { what, sigma, unit }
            }
        };
        let equations = NormalEquations::new(observations, &adjusted.weights, &adjusted.state, free);
        let errors = Errors::new(observations, adjusted);
        let unknown = || undetermined("the solution", f64::INFINITY, "pixels");
        let correlations = errors.correlations(&equations, free).ok_or_else(unknown)?;
        let covariance = errors.covariance(&equations, free, &correlations).ok_or_else(unknown)?;
        let focal = adjusted.state.lens.focal_px;
        for (column, raw) in free.lens.iter().enumerate() {
            let sigma = covariance[(column, column)].sqrt() / focal.x.min(focal.y);
            if raw[0] < 2 && (sigma.is_nan() || sigma > MOST_FOCAL_SIGMA) {
                return Err(undetermined("the focal length", 100.0 * sigma, "%"));
            }
        }
        let mut depths: Vec<f64> = (observations.all.iter().zip(&adjusted.weights))
            .filter(|(_, weight)| weight.is_used())
            .map(|(o, _)| (adjusted.state.poses[o.scan] * o.point).z)
            .collect();
        let depth_m = [0.01, 0.99].map(|share| quantile(&mut depths, share));
        let sigma_px = covariance::prediction_sigma_px(&adjusted.state, free, &covariance, depth_m);
        if sigma_px.is_nan() || sigma_px > MOST_PREDICTION_SIGMA * f64::from(size_px[0]) {
            return Err(undetermined("the projection", sigma_px, "pixels"));
        }
        let skew = skew::skew(observations, adjusted, free, &errors, &correlations);
        Ok(Judged { covariance, prediction_sigma_px: sigma_px, skew })
    }

    fn solution(
        &self,
        adjusted: &Adjusted,
        free: &Free,
        covariance: &DMatrix<f64>,
        terms: DistortionTerms,
    ) -> Solution {
        let observations = self.observations;
        let lens = adjusted.state.lens;
        let sigma_at = |unknown: usize| covariance[(unknown, unknown)].max(0.0).sqrt();
        let sigma_of = |parameter: Parameter| {
            let sigma = free.lens.iter().position(|raw| raw.contains(&(parameter as usize))).map(sigma_at);
            let floor = match parameter {
                Parameter::Fx | Parameter::Fy => LEAST_FOCAL_SHARE * lens.focal_px.min(),
                _ => 0.0,
            };
            sigma.map_or(0.0, |sigma| sigma.hypot(floor))
        };
        let values = lens_values(&lens);
        let estimates = Parameter::ALL
            .map(|parameter| Estimate { parameter, value: values[parameter as usize], sigma: sigma_of(parameter) })
            .to_vec();
        let scans = 0..observations.scans.len();
        let poses = scans.map(|scan| self.scan_pose(adjusted, free, covariance, scan)).collect();
        let mut residuals: Vec<Residual> = (observations.all.par_iter().zip(&adjusted.weights))
            .filter_map(|(observation, weight)| {
                let q = adjusted.state.poses[observation.scan] * observation.point;
                let error_px = observation.pixel - lens.project(&q)?;
                Some(Residual {
                    sample: observation.sample,
                    error_px,
                    error_m: error_px.component_div(&lens.focal_px) * q.z,
                    depth_m: q.z,
                    is_inlier: weight.is_used(),
                })
            })
            .collect();
        residuals.sort_unstable_by_key(|residual| residual.sample);
        let used = || residuals.iter().filter(|residual| residual.is_inlier).map(|residual| residual.error_px.norm());
        let inliers = used().count();
        let (rms_px, max_px) = (root_mean_square(used()), used().fold(0.0, f64::max));
        Solution {
            lens,
            estimates,
            distortion: terms,
            poses,
            residuals,
            rms_px,
            held_out_rms_px: 0.0,
            max_px,
            inliers,
            prediction_sigma_px: 0.0,
            skew: None,
        }
    }

    /// Pose of a scan with its deviations.
    fn scan_pose(&self, adjusted: &Adjusted, free: &Free, covariance: &DMatrix<f64>, scan: usize) -> ScanPose {
        let observations = self.observations;
        let pose = adjusted.state.poses[scan];
        let at = free.pose_column(scan);
        let depth_m = median(&mut observations.depths(scan));
        let least_m2 = Vector3::from(LEAST_POSITION_SHARES).map(|share| (share * depth_m).powi(2));
        let shift = covariance.fixed_view::<3, 3>(at + 3, at + 3) + Matrix3::from_diagonal(&least_m2);
        let rotation = pose.rotation.to_rotation_matrix().into_inner();
        let in_camera = rotation.transpose() * shift * rotation;
        ScanPose {
            scan: observations.scans[scan],
            projector_from_camera: pose,
            position_sigma_m: [0, 1, 2].map(|axis| in_camera[(axis, axis)].max(0.0).sqrt()),
            orientation_sigma_rad: [0, 1, 2].map(|axis| covariance[(at + axis, at + axis)].max(0.0).sqrt()),
            inliers: observations.range(scan).filter(|i| adjusted.weights[*i].is_used()).count(),
        }
    }
}
