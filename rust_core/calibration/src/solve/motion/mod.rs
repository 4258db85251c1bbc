//! Whether something moved a little during a scan, so that its samples are of two lots, each with a pose of its own.
//!
//! `moved` finds a second pose among the samples that the solution leaves out. Of a smaller motion it leaves nothing
//! out: it lies between both poses, and both lots miss it by a pixel or two, as they would with a noisy depth camera.
//! What tells them apart are neighbours: what neighbours share is the depth's smooth error or the lens's, and is taken
//! away (`groups`). What is then left over of two lots are two narrow heaps, whose distance follows a motion all over
//! the picture (`misses`, `split`); that of noise is one heap. `search` finds the lots by the order of the samples, as
//! when scans were put one after the other, where even heaps that overlap are told apart, or else in any order.
//!
//! A lot that fills a part of the picture by itself cannot be told from a smooth error and is not found here.

use rayon::prelude::*;

use self::misses::Misses;
use self::split::{Evidence, Split};
use super::adjust::Adjusted;
use super::input::Observations;
use super::model::State;
use super::{Refusal, SuspectedMotion};

mod groups;
mod misses;
mod search;
mod split;

/// Samples of a scan that are looked at, at most, and at least.
const MOST: usize = 6000;
const LEAST: usize = 150;
/// Lots whose light is farther apart are refused, root of the mean square in pixels: the solution is off by half of it.
const REFUSED_PX: f64 = 0.5;
/// If they are farther apart than this, there is a warning.
const NOTABLE_PX: f64 = 0.25;
/// The share of the samples in the smaller lot.
const LEAST_SHARE: f64 = 0.15;
/// Neighbours are of different lots at least so often, as a share of how often they would be by chance.
const MIXED: f64 = 0.25;
/// Samples that are farther beside their neighbours are gross errors, pixels. After a zoom of one percent a quarter of
/// the samples may be there, too; so a second try has more of them.
const GROSS_PX: [f64; 2] = [4.0, 12.0];
/// Lots in any order: the deviation that two poses leave over, as a share of that of one pose.
const TWO_HEAPS: f64 = 0.45;
/// Lots by order: how much better two poses explain them than chance does (Fisher's F).
const EXPLAINED: f64 = 60.0;

/// Refuses scans whose samples are of two lots; a motion that is too small for that is suspected.
pub(super) fn check(
    observations: &Observations,
    adjusted: &Adjusted,
    seed: u64,
) -> Result<Option<SuspectedMotion>, Refusal> {
    let thinned = observations.thinned(MOST, seed);
    let found: Vec<Option<Found>> = (0..observations.scans.len())
        .into_par_iter()
        .map(|scan| {
            let state = State { lens: adjusted.state.lens, poses: vec![adjusted.state.poses[scan]] };
            let few = thinned.only(scan);
            GROSS_PX.into_iter().find_map(|gross_px| {
                let misses = Misses::new(&few, &state, &adjusted.noise, gross_px);
                Found::new(&misses, few.scans[0], few.all.len(), seed)
            })
        })
        .collect();
    let apart_px = |found: &Found| found.evidence.apart_px;
    let farthest = found.into_iter().flatten().max_by(|a, b| apart_px(a).total_cmp(&apart_px(b)));
    let Some(Found { scan, evidence, is_in_order }) = farthest else { return Ok(None) };
    if evidence.apart_px > REFUSED_PX {
        return Err(Refusal::TwoPoses {
            scan,
            apart_px: evidence.apart_px,
            second_percent: 100.0 * evidence.second,
            is_in_order,
        });
    }
    Ok(Some(SuspectedMotion { scan, apart_px: evidence.apart_px }))
}

/// A scan of two lots.
struct Found {
    scan: u32,
    evidence: Evidence,
    /// Whether all samples of the second lot come after those of the first.
    is_in_order: bool,
}

impl Found {
    /// Two lots of a scan that are surely two, by what is left over of so many samples.
    fn new(misses: &Misses, scan: u32, given: usize, seed: u64) -> Option<Self> {
        if misses.all.len() < LEAST {
            return None;
        }
        let unsplit = Split::new(misses, vec![false; misses.all.len()])?;
        let evidence = |split: Option<Split>| Some(split?.evidence(misses, &unsplit)).filter(Evidence::is_notable);
        let in_order = evidence(search::by_order(misses, given)).filter(|evidence| evidence.explained > EXPLAINED);
        let is_in_order = in_order.is_some();
        let evidence = in_order.or_else(|| {
            evidence(search::in_any_order(misses, &unsplit, seed)).filter(|evidence| evidence.left_over < TWO_HEAPS)
        })?;
        Some(Self { scan, evidence, is_in_order })
    }
}

impl Evidence {
    /// Whether both lots are large, apart, and everywhere.
    fn is_notable(&self) -> bool {
        self.apart_px > NOTABLE_PX && self.mixed > MIXED && (LEAST_SHARE..=1.0 - LEAST_SHARE).contains(&self.second)
    }
}
