//! Small motions during a scan: its samples form two clusters with different poses.
//!
//! `moved` finds a second pose among outliers. A smaller motion has none: the solution lies between both poses, with
//! errors of a pixel or two, as with a noisy depth camera. The clusters differ from noise among neighbours: errors that
//! neighbours share, of depth or lens, are removed (`residuals`), and the rest of two clusters has two narrow modes,
//! whose distance follows one motion all over the image (`split`). `search` finds the clusters by the order of the
//! samples, as in concatenated scans, where even overlapping clusters are separable, or else in any order.
//!
//! A cluster that fills a part of the image alone cannot be distinguished from a smooth error.

use rayon::prelude::*;

use self::residuals::MotionResiduals;
use self::split::{Evidence, Split};
use super::adjust::Adjusted;
use super::input::Observations;
use super::model::SolverState;
use super::Refusal;

mod residuals;
mod search;
mod split;

/// Maximum and minimum number of samples of a scan.
const MOST: usize = 6000;
const LEAST: usize = 150;
/// Maximum RMS distance of the clusters, pixels: the solution is off by half of it. Without this check, a scan that is
/// continued after a turn by 0.05° gives a calibration 0.65 px off without a word.
const MOST_APART_PX: f64 = 0.5;
/// Minimum share of the smaller cluster.
const LEAST_SHARE: f64 = 0.15;
/// Minimum rate of neighbours in different clusters, as a share of that by chance.
const MIXED: f64 = 0.25;
/// Gross error limits relative to the neighbours, pixels. After a zoom by one percent a quarter of the samples exceeds
/// the first, so a second try has a larger one.
const GROSS_PX: [f64; 2] = [4.0, 12.0];
/// Clusters in any order: maximum deviation with two poses, as a share of that with one.
const TWO_MODES: f64 = 0.45;
/// Clusters by order: minimum F statistic of the motion.
const EXPLAINED: f64 = 60.0;

/// Refuses scans with two clusters.
pub(super) fn check(observations: &Observations, adjusted: &Adjusted, seed: u64) -> Result<(), Refusal> {
    let thinned = observations.thinned(MOST, seed);
    let found: Vec<Option<SplitScan>> = (0..observations.scans.len())
        .into_par_iter()
        .map(|scan| {
            let state = SolverState { lens: adjusted.state.lens, poses: vec![adjusted.state.poses[scan]] };
            let few = thinned.only(scan);
            GROSS_PX.into_iter().find_map(|gross_px| {
                let residuals = MotionResiduals::new(&few, &state, &adjusted.noise, gross_px);
                SplitScan::new(&residuals, few.scans[0], few.all.len(), seed)
            })
        })
        .collect();
    let apart_px = |found: &SplitScan| found.evidence.apart_px;
    let farthest = found.into_iter().flatten().max_by(|a, b| apart_px(a).total_cmp(&apart_px(b)));
    let Some(SplitScan { scan, evidence, is_in_order }) = farthest else { return Ok(()) };
    Err(Refusal::TwoPoses { scan, apart_px: evidence.apart_px, second_percent: 100.0 * evidence.second, is_in_order })
}

/// Scan with two clusters.
struct SplitScan {
    scan: u32,
    evidence: Evidence,
    /// `true` if all samples of the second cluster come after those of the first.
    is_in_order: bool,
}

impl SplitScan {
    /// Tests the residuals of `given` samples for two clusters.
    fn new(residuals: &MotionResiduals, scan: u32, given: usize, seed: u64) -> Option<Self> {
        if residuals.all.len() < LEAST {
            return None;
        }
        let unsplit = Split::new(residuals, vec![false; residuals.all.len()])?;
        let evidence = |split: Option<Split>| Some(split?.evidence(residuals, &unsplit)).filter(Evidence::is_refused);
        let in_order = evidence(search::by_order(residuals, given)).filter(|evidence| evidence.explained > EXPLAINED);
        let is_in_order = in_order.is_some();
        let evidence = in_order.or_else(|| {
            evidence(search::in_any_order(residuals, &unsplit, seed)).filter(|evidence| evidence.remaining < TWO_MODES)
        })?;
        Some(Self { scan, evidence, is_in_order })
    }
}

impl Evidence {
    /// `true` if both clusters are large, apart, and mixed all over the image.
    fn is_refused(&self) -> bool {
        self.apart_px > MOST_APART_PX && self.mixed > MIXED && (LEAST_SHARE..=1.0 - LEAST_SHARE).contains(&self.second)
    }
}
