//! How long a cell stays dark after the surface agrees again.
//!
//! Dark comes at once. Light comes back after [`SHORT`] of agreement, or after [`LONG`] where the cell went dark again
//! within [`WINDOW`] of coming back. Noise at an edge goes dark for a moment only: such a cell comes back once within
//! [`WINDOW`]. Disagreement for [`LASTING`], or of all cells around as well, is no noise.

use std::time::Duration;

use fearless_simd::{dispatch, Level};

/// Unit of the times below. A time of n units is over between n − 1 and n of them, so each has one more.
const TICK: Duration = Duration::from_millis(50);
/// 0.3 s.
const SHORT: u8 = 6 + 1;
/// 2 s.
const LONG: u8 = 40 + 1;
/// 10 s.
const WINDOW: u8 = 200 + 1;
/// 1 s.
const LASTING: u8 = 20;

/// Reason for which a cell is dark.
#[derive(Debug)]
pub(crate) struct Disagreement;

impl Disagreement {
    /// The surface agrees, or no listed display lights the cell.
    pub(crate) const NONE: u8 = 0;
    /// The surface is not at the object's depth.
    pub(crate) const SOME: u8 = 1;
    /// The surface is not at the object's depth, nor is it in the cells around.
    pub(crate) const WIDE: u8 = 2;
}

/// Times of all cells, in [`TICK`]s.
#[derive(Debug, Default)]
pub(crate) struct HoldTimes {
    /// Agreement that a cell needs until it is lit.
    waits: Vec<u8>,
    /// Remaining part of [`WINDOW`] since it was lit again.
    recents: Vec<u8>,
    /// Uninterrupted disagreement; at least [`LASTING`] if it was wide.
    runs: Vec<u8>,
    last_tick: Option<u128>,
}

impl HoldTimes {
    /// Forgets everything if the number of cells is another one.
    pub(crate) fn fit(&mut self, count: usize) {
        if self.waits.len() != count {
            *self = Self { waits: vec![0; count], recents: vec![0; count], runs: vec![0; count], last_tick: None };
        }
    }

    /// Takes what keeps each cell dark now, see [`Disagreement`].
    pub(crate) fn update(&mut self, disagreements: &[u8], now: Duration) {
        let tick = now.as_millis() / TICK.as_millis();
        let passed = tick.saturating_sub(self.last_tick.unwrap_or(tick)).min(u8::MAX.into()) as u8;
        self.last_tick = Some(tick);
        dispatch!(Level::new(), _simd => self.pass(disagreements, passed));
    }

    #[inline(always)]
    fn pass(&mut self, disagreements: &[u8], passed: u8) {
        let Self { waits, recents, runs, .. } = self;
        for (((now, wait), recent), run) in disagreements.iter().zip(waits).zip(recents).zip(runs) {
            let is_dark = *now != Disagreement::NONE;
            let left = recent.saturating_sub(passed);
            let least = if *now == Disagreement::WIDE { LASTING } else { 0 };
            let lasted = if is_dark { run.saturating_add(passed).max(least) } else { 0 };
            let again = if lasted < LASTING { left.max(LONG) } else { LONG };
            let hold = if left == 0 { SHORT } else { again };
            let rest = if is_dark { hold } else { wait.saturating_sub(passed) };
            *recent = if *wait != 0 && rest == 0 { WINDOW } else { left };
            (*wait, *run) = (rest, lasted);
        }
    }

    /// Holds all cells back for [`SHORT`]: the surface is unknown.
    pub(crate) fn interrupt(&mut self, now: Duration) {
        self.last_tick = Some(now.as_millis() / TICK.as_millis());
        self.waits.iter_mut().for_each(|wait| *wait = SHORT.max(*wait));
    }

    /// For each cell, 0 if it is lit.
    pub(crate) fn waits(&self) -> &[u8] {
        &self.waits
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// One cell, asked every 10 ms whether it is lit while `disagreement` of the time in ms is what keeps it dark.
    fn lit(until_ms: u64, disagreement: impl Fn(u64) -> u8) -> Vec<(u64, bool)> {
        let mut times = HoldTimes::default();
        times.fit(1);
        let at = |ms: u64| {
            times.update(&[disagreement(ms)], Duration::from_millis(ms));
            (ms, times.waits() == [0])
        };
        (0..until_ms).step_by(10).map(at).collect()
    }

    /// Times at which a cell is lit again, ms.
    fn relit(lit: &[(u64, bool)]) -> Vec<u64> {
        lit.windows(2).filter(|pair| !pair[0].1 && pair[1].1).map(|pair| pair[1].0).collect()
    }

    /// Disagreement within these ranges of ms.
    fn during(disagreement: u8, ranges: &[std::ops::Range<u64>]) -> impl Fn(u64) -> u8 + '_ {
        move |ms| if ranges.iter().any(|range| range.contains(&ms)) { disagreement } else { Disagreement::NONE }
    }

    #[test]
    fn a_cell_is_dark_at_once_and_lit_again_after_300_ms_of_agreement() {
        for begin in [1000, 1013, 1037] {
            let lit = lit(3000, during(Disagreement::SOME, std::slice::from_ref(&(begin..1200))));
            let first_dark = lit.iter().find(|(_, is_lit)| !is_lit).unwrap().0;
            assert_eq!(first_dark, begin.div_ceil(10) * 10);
            let relit = relit(&lit);
            assert!(relit.len() == 1 && (1490..=1560).contains(&relit[0]), "{relit:?}");
        }
    }

    #[test]
    fn a_cell_that_was_covered_twice_is_lit_again_after_2_s() {
        let hand = relit(&lit(9000, during(Disagreement::WIDE, &[1000..1100, 2000..2100])));
        assert!(hand.len() == 2 && (4080..=4160).contains(&hand[1]), "{hand:?}");
        let gone = relit(&lit(9000, during(Disagreement::SOME, &[1000..1100, 2000..3200])));
        assert!(gone.len() == 2 && (5180..=5260).contains(&gone[1]), "{gone:?}");
    }

    #[test]
    fn a_hand_that_leaves_with_its_edge_is_still_a_hand() {
        let twice = |ms: u64| match ms {
            1000..1100 | 2000..2050 => Disagreement::WIDE,
            2050..2100 => Disagreement::SOME,
            _ => Disagreement::NONE,
        };
        let relit = relit(&lit(9000, twice));
        assert!(relit.len() == 2 && (4080..=4160).contains(&relit[1]), "{relit:?}");
    }

    #[test]
    fn a_cell_that_flickers_is_lit_again_once_in_10_s() {
        let relit = relit(&lit(40_000, |ms| u8::from(ms % 3000 < 30)));
        assert!(relit.windows(2).all(|pair| pair[1] - pair[0] >= 10_000), "{relit:?}");
        assert!(relit.len() >= 2, "{relit:?}");
    }

    #[test]
    fn after_10_s_without_flips_a_cell_is_as_fast_as_at_first() {
        let relit = relit(&lit(15_000, during(Disagreement::SOME, &[1000..1100, 12_000..12_100])));
        assert!(relit.len() == 2 && (12_390..=12_460).contains(&relit[1]), "{relit:?}");
    }

    proptest! {
        #[test]
        fn a_cell_is_dark_whenever_the_surface_disagrees(seed in any::<u64>(), step_ms in 1..400_u64) {
            let mut times = HoldTimes::default();
            times.fit(2);
            for frame in 0..64 {
                let disagreements = [(seed >> frame & 1) as u8, (seed >> frame & 1) as u8 * 2];
                times.update(&disagreements, Duration::from_millis(frame * step_ms));
                for (wait, now) in times.waits().iter().zip(disagreements) {
                    prop_assert!(now == 0 || *wait > 0);
                }
            }
        }
    }
}
