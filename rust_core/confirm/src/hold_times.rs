//! How long a cell stays dark after the surface agrees again.
//!
//! Dark comes at once. Light comes back with a depth image: at the earliest with the third in a row that agrees, and
//! [`SHORT`] after the first of these, or [`LONG`] where the cell went dark again within [`WINDOW`] of coming back. So
//! light comes on at most once in [`LONG`], whatever is measured and at whatever rate.
//!
//! Noise at an edge goes dark for a moment only: such a cell comes back once within [`WINDOW`]. Disagreement for
//! [`LASTING`], or of all cells around as well, is no noise. A time without depth images is disagreement everywhere.

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
/// Depth images in a row that agree before a cell is lit.
const IMAGES: u8 = 3;

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
#[derive(Debug)]
pub(crate) struct HoldTimes {
    /// Agreement that a cell needs until it is lit; 0 if it is lit.
    waits: Vec<u8>,
    /// Depth images in a row that agree.
    images: Vec<u8>,
    /// Remaining part of [`WINDOW`] since it was lit again.
    recents: Vec<u8>,
    /// Uninterrupted disagreement; at least [`LASTING`] if it was wide.
    runs: Vec<u8>,
    /// Time of the last depth image.
    last: Option<Duration>,
    /// `true` if the surface was unknown since the last depth image.
    is_interrupted: bool,
}

impl HoldTimes {
    /// Cells that are dark.
    pub(crate) fn new(count: usize) -> Self {
        let [waits, images, recents, runs] = [(); 4].map(|()| vec![0; count]);
        Self { waits, images, recents, runs, last: None, is_interrupted: true }
    }

    /// Forgets everything if the number of cells is another one.
    pub(crate) fn fit(&mut self, count: usize) {
        if self.waits.len() != count {
            *self = Self::new(count);
        }
    }

    /// Takes what keeps each cell dark now, see [`Disagreement`]. `image` is the time of the depth image if this is its
    /// first comparison. Depth images more than `max_gap` apart are not in a row.
    pub(crate) fn update(&mut self, disagreements: &[u8], image: Option<Duration>, max_gap: Duration) {
        let mut passed = 0;
        if let Some(at) = image {
            let last = self.last.unwrap_or(at);
            self.is_interrupted |= at.saturating_sub(last) > max_gap;
            passed = ticks(at).saturating_sub(ticks(last)).min(u8::MAX.into()) as u8;
            self.last = Some(at.max(last));
        }
        if std::mem::take(&mut self.is_interrupted) {
            self.pass(std::iter::repeat(&Disagreement::WIDE), passed, 0);
            passed = 0;
        }
        let step = u8::from(image.is_some());
        dispatch!(Level::new(), _simd => self.pass(disagreements.iter(), passed, step));
    }

    /// Lets a time pass. `step` is 1 for a new depth image, and 0 for another comparison with the same.
    #[inline(always)]
    fn pass<'a>(&mut self, disagreements: impl Iterator<Item = &'a u8>, passed: u8, step: u8) {
        let Self { waits, images, recents, runs, .. } = self;
        for ((((now, wait), images), recent), run) in disagreements.zip(waits).zip(images).zip(recents).zip(runs) {
            let is_dark = *now != Disagreement::NONE;
            let left = recent.saturating_sub(passed);
            let least = if *now == Disagreement::WIDE { LASTING } else { 0 };
            let lasted = if is_dark { run.saturating_add(passed).max(least) } else { 0 };
            let again = if lasted < LASTING { left.max(LONG) } else { LONG };
            let hold = if left == 0 { SHORT } else { again };
            let agreeing = if is_dark { 0 } else { images.saturating_add(step) };
            // Before the first image that agrees, nothing did.
            let agreed = if agreeing > 1 { passed } else { 0 };
            let due = wait.saturating_sub(agreed).max(u8::from(agreeing < IMAGES));
            let rest = if is_dark { hold } else { due };
            *recent = if *wait != 0 && rest == 0 { WINDOW } else { left };
            (*wait, *images, *run) = (rest, agreeing, lasted);
        }
    }

    /// Makes all cells dark until enough new depth images agree: the surface is unknown.
    pub(crate) fn interrupt(&mut self) {
        self.is_interrupted = true;
    }

    /// For each cell, 0 if it is lit.
    pub(crate) fn waits(&self) -> &[u8] {
        &self.waits
    }
}

fn ticks(time: Duration) -> u128 {
    time.as_millis() / TICK.as_millis()
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use proptest::prelude::*;

    use super::*;

    /// As of the settings' default.
    const MAX_GAP: Duration = Duration::from_millis(500);
    /// Agreement before the cases below, after which the start does not matter: more than [`WINDOW`], ms.
    const BEFORE_MS: u64 = 12_000;

    fn ms(at: u64) -> Duration {
        Duration::from_millis(at)
    }

    /// One cell.
    struct Cell(HoldTimes);

    impl Cell {
        fn new() -> Self {
            Self(HoldTimes::new(1))
        }

        /// Whether it is lit after a comparison.
        fn is_lit(&mut self, disagreement: u8, image_ms: Option<u64>) -> bool {
            self.0.update(&[disagreement], image_ms.map(ms), MAX_GAP);
            self.0.waits() == [0]
        }

        /// Whether it is lit after each of these depth images, which agree.
        fn sees(&mut self, images_ms: &[u64]) -> Vec<bool> {
            images_ms.iter().map(|at| self.is_lit(Disagreement::NONE, Some(*at))).collect()
        }

        /// A cell that is lit, and was for more than [`WINDOW`] at 0.
        fn lit() -> Self {
            let mut cell = Self::new();
            cell.0.last = Some(Duration::ZERO);
            cell.0.is_interrupted = false;
            cell.0.images = vec![IMAGES];
            cell
        }
    }

    /// One cell, with a depth image every 10 ms while `disagreement` of the time in ms is what keeps it dark, after
    /// [`BEFORE_MS`] of agreement.
    fn lit(until_ms: u64, disagreement: impl Fn(u64) -> u8) -> Vec<(u64, bool)> {
        let mut cell = Cell::new();
        (0..BEFORE_MS).step_by(10).for_each(|at| {
            cell.is_lit(Disagreement::NONE, Some(at));
        });
        (0..until_ms).step_by(10).map(|at| (at, cell.is_lit(disagreement(at), Some(BEFORE_MS + at)))).collect()
    }

    /// Times at which a cell is lit again, ms.
    fn relit(lit: &[(u64, bool)]) -> Vec<u64> {
        lit.windows(2).filter(|pair| !pair[0].1 && pair[1].1).map(|pair| pair[1].0).collect()
    }

    /// Disagreement within these ranges of ms.
    fn during(disagreement: u8, ranges: &[Range<u64>]) -> impl Fn(u64) -> u8 + '_ {
        move |ms| if ranges.iter().any(|range| range.contains(&ms)) { disagreement } else { Disagreement::NONE }
    }

    #[test]
    fn a_cell_is_dark_at_once_and_lit_again_after_300_ms_of_agreement() {
        for begin in [1000, 1013, 1037] {
            let lit = lit(3000, during(Disagreement::SOME, std::slice::from_ref(&(begin..1200))));
            let first_dark = lit.iter().find(|(_, is_lit)| !is_lit).unwrap().0;
            assert_eq!(first_dark, begin.div_ceil(10) * 10);
            let relit = relit(&lit);
            assert!(relit.len() == 1 && (1500..=1560).contains(&relit[0]), "{relit:?}");
        }
    }

    #[test]
    fn a_cell_that_was_covered_twice_is_lit_again_after_2_s() {
        let hand = relit(&lit(9000, during(Disagreement::WIDE, &[1000..1100, 2000..2100])));
        assert!(hand.len() == 2 && (4100..=4160).contains(&hand[1]), "{hand:?}");
        let gone = relit(&lit(9000, during(Disagreement::SOME, &[1000..1100, 2000..3200])));
        assert!(gone.len() == 2 && (5200..=5260).contains(&gone[1]), "{gone:?}");
    }

    #[test]
    fn a_hand_that_leaves_with_its_edge_is_still_a_hand() {
        let twice = |ms: u64| match ms {
            1000..1100 | 2000..2050 => Disagreement::WIDE,
            2050..2100 => Disagreement::SOME,
            _ => Disagreement::NONE,
        };
        let relit = relit(&lit(9000, twice));
        assert!(relit.len() == 2 && (4100..=4160).contains(&relit[1]), "{relit:?}");
    }

    #[test]
    fn a_cell_that_flickers_is_lit_again_once_in_10_s() {
        let relit = relit(&lit(40_000, |ms| u8::from(ms % 3000 < 30)));
        assert!(relit.windows(2).all(|pair| pair[1] - pair[0] >= 10_000), "{relit:?}");
        assert!(relit.len() >= 2, "{relit:?}");
    }

    #[test]
    fn disagreement_of_almost_1_s_is_noise() {
        let relit = relit(&lit(15_000, during(Disagreement::SOME, &[1000..1100, 2000..2900])));
        assert!(relit.len() == 2 && (11_400..=11_600).contains(&relit[1]), "{relit:?}");
    }

    #[test]
    fn after_10_s_without_flips_a_cell_is_as_fast_as_at_first() {
        let relit = relit(&lit(15_000, during(Disagreement::SOME, &[1000..1100, 12_000..12_100])));
        assert!(relit.len() == 2 && (12_400..=12_460).contains(&relit[1]), "{relit:?}");
    }

    #[test]
    fn no_cell_is_lit_before_the_third_depth_image_and_300_ms() {
        assert_eq!(Cell::new().sees(&[0, 200, 400, 600]), [false, false, true, true]);
        assert_eq!(Cell::new().sees(&[0, 500, 1000]), [false, false, true], "the largest gap");
        assert_eq!(Cell::new().sees(&[0, 10, 20, 290, 299, 350]), [false, false, false, false, false, true]);
        assert_eq!(Cell::new().sees(&[49, 200, 348, 350]), [false, false, false, true], "299 and 301 ms");
        let mut cell = Cell::lit();
        assert!(!cell.is_lit(Disagreement::SOME, Some(100)));
        assert_eq!(
            cell.sees(&[500, 600, 750, 850]),
            [false, false, false, true],
            "the time before the first is none of agreement"
        );
    }

    #[test]
    fn a_gap_makes_all_cells_dark_until_three_more_depth_images() {
        assert_eq!(Cell::lit().sees(&[500, 1001, 1200, 1400]), [true, false, false, true]);
        // A hand, then nothing for 1.5 s, then a depth image without it.
        let mut cell = Cell::lit();
        assert!(!cell.is_lit(Disagreement::WIDE, Some(100)));
        assert_eq!(cell.sees(&[1600, 1800, 1990, 2000]), [false, false, true, true]);
    }

    #[test]
    fn a_second_gap_within_10_s_holds_light_back_for_2_s() {
        let mut cell = Cell::lit();
        assert_eq!(cell.sees(&[600, 800, 1000]), [false, false, true]);
        let again: Vec<u64> = (0..=11).map(|image| 1600 + 200 * image).collect();
        assert_eq!(cell.sees(&again), [vec![false; 11], vec![true]].concat());
    }

    #[test]
    fn a_flip_10_s_after_light_came_on_holds_it_back_for_2_s_and_a_later_one_does_not() {
        for (flip_ms, images) in [(10_400, 12), (10_500, 3)] {
            let mut cell = Cell::new();
            assert_eq!(cell.sees(&[0, 200, 400]), [false, false, true]);
            assert!(!cell.sees(&(1..=20).map(|image| 400 + 490 * image).collect::<Vec<_>>()).contains(&false));
            assert!(!cell.is_lit(Disagreement::SOME, Some(flip_ms)));
            let after: Vec<u64> = (0..images).map(|image| flip_ms + 100 + 200 * image).collect();
            assert_eq!(cell.sees(&after), [vec![false; after.len() - 1], vec![true]].concat(), "{flip_ms}");
        }
    }

    #[test]
    fn a_cell_whose_surface_was_unknown_needs_three_more_depth_images() {
        let mut cell = Cell::lit();
        assert_eq!(cell.sees(&[100]), [true]);
        cell.0.interrupt();
        // Compared again, though no depth image arrived.
        assert!(!cell.is_lit(Disagreement::NONE, None));
        assert_eq!(cell.sees(&[200, 400, 600]), [false, false, true]);
    }

    #[test]
    fn comparisons_with_the_same_depth_image_count_once_and_any_of_them_makes_dark() {
        let mut cell = Cell::new();
        for at in [0, 200] {
            assert_eq!(cell.sees(&[at]), [false]);
            assert_eq!([(); 5].map(|()| cell.is_lit(Disagreement::NONE, None)), [false; 5]);
        }
        assert_eq!(cell.sees(&[400]), [true]);
        assert!(cell.is_lit(Disagreement::NONE, None));
        assert!(!cell.is_lit(Disagreement::SOME, None));
        assert!(!cell.is_lit(Disagreement::NONE, None));
    }

    #[test]
    fn depth_images_in_a_wrong_order_do_not_count_a_time_twice() {
        assert_eq!(Cell::new().sees(&[100, 0, 100, 0, 100, 0, 100, 200]), [false; 8]);
    }

    #[test]
    fn cells_are_forgotten_when_their_number_changes() {
        let mut cell = Cell::lit();
        cell.0.fit(1);
        assert_eq!(cell.sees(&[100]), [true]);
        cell.0.fit(2);
        cell.0.update(&[Disagreement::NONE; 2], None, MAX_GAP);
        assert!(cell.0.waits().iter().all(|wait| *wait > 0));
    }

    /// What happens with one depth image.
    #[derive(Clone, Debug)]
    struct Event {
        gap_ms: u64,
        disagreement: u8,
        /// The disagreement of another frame that is compared with the same depth image.
        again: Option<u8>,
        is_interrupted: bool,
    }

    /// Depth images of a camera of 0.2 to 60 Hz, with gaps, and stretches of agreement and disagreement.
    fn events() -> impl Strategy<Value = Vec<Event>> {
        let period_ms = prop_oneof![3 => 16..150_u64, 2 => 150..520_u64, 1 => 500..5000_u64];
        let disagreement = || prop_oneof![3 => Just(0), 1 => Just(1), 1 => Just(2_u8)];
        let stretch = (disagreement(), 1..40_usize, prop::option::weighted(0.1, disagreement()));
        let stretches = prop::collection::vec((stretch, prop::bool::weighted(0.1), 0..2000_u64), 1..40);
        (period_ms, stretches).prop_map(|(period_ms, stretches)| {
            let events = |((disagreement, count, again), is_interrupted, gap_ms): (_, bool, u64)| {
                let event = Event { gap_ms: period_ms, disagreement, again: None, is_interrupted: false };
                let gap_ms = if gap_ms < 300 { gap_ms * 4 } else { period_ms };
                let first = Event { gap_ms, again, is_interrupted, ..event.clone() };
                std::iter::once(first).chain(std::iter::repeat_n(event, count - 1))
            };
            stretches.into_iter().flat_map(events).collect()
        })
    }

    proptest! {
        #[test]
        fn a_cell_is_lit_after_three_agreeing_images_in_a_row_only_and_comes_on_at_most_once_in_2_s(events in events()) {
            let mut cell = Cell::new();
            // Times of the depth images in a row that agree up to now.
            let mut row = Vec::new();
            let (mut at, mut last_on, mut was_lit) = (0, None, false);
            for Event { gap_ms, disagreement, again, is_interrupted } in events {
                at += gap_ms;
                if is_interrupted {
                    cell.0.interrupt();
                }
                if is_interrupted || ms(gap_ms) > MAX_GAP || disagreement != 0 {
                    row.clear();
                }
                row.extend((disagreement == 0).then_some(at));
                let mut is_lit = cell.is_lit(disagreement, Some(at));
                let agreed_ms = row.first().map_or(0, |first| at - first);
                prop_assert!(!is_lit || row.len() >= 3 && agreed_ms > 300, "{at}: {row:?}");
                prop_assert!(is_lit || row.len() < 3 || agreed_ms <= 10_100, "{at}: dark for {agreed_ms} ms");
                if let Some(again) = again {
                    row.truncate(if again == 0 { row.len() } else { 0 });
                    let stays = is_lit && again == 0;
                    is_lit = cell.is_lit(again, None);
                    prop_assert_eq!(is_lit, stays);
                }
                if is_lit && !was_lit {
                    prop_assert!(last_on.is_none_or(|last| at - last > 2000), "{at}: on at {last_on:?}");
                    last_on = Some(at);
                }
                was_lit = is_lit;
            }
        }

        #[test]
        fn a_camera_slower_than_the_largest_gap_lights_nothing(periods_ms in prop::collection::vec(501..5000_u64, 50)) {
            let at = periods_ms.iter().scan(0, |at, period_ms| { *at += period_ms; Some(*at) });
            prop_assert!(!Cell::new().sees(&at.collect::<Vec<_>>()).contains(&true));
        }
    }
}
