//! When the heap is trimmed.
//!
//! Returned memory costs a quarter of a millisecond a megabyte when it is needed again. So it must have been unused at
//! two checks in a row, [`PERIOD`] apart, and be [`LEAST_BYTES`] more than was left after the last trim (stacks, free
//! chunks of less than a page). Where all of it is needed again soon, as by a scene of many markers that is sent anew
//! each second, the pause between trims doubles up to [`LONGEST_PAUSE`].

use std::time::Duration;

/// Time between two checks.
pub(crate) const PERIOD: Duration = Duration::from_secs(5);

/// Least unused memory that is worth a trim.
pub(crate) const LEAST_BYTES: u64 = 8 << 20;

/// Longest pause, in checks: ten minutes.
const LONGEST_PAUSE: u32 = 120;

/// Shortest pause, in checks.
const SHORTEST_PAUSE: u32 = 2;

/// Decides when to trim, by what earlier checks found.
#[derive(Debug)]
pub(crate) struct TrimPolicy {
    /// Least unused bytes since the last trim.
    floor: u64,
    /// Checks in a row that found more.
    found: u32,
    /// Checks in a row that have to.
    pause: u32,
}

impl TrimPolicy {
    /// The policy at the program's start.
    pub(crate) const fn new(unused_bytes: u64) -> Self {
        Self { floor: unused_bytes, found: 0, pause: SHORTEST_PAUSE }
    }

    /// `true` if the heap is to be trimmed now; [`Self::trimmed`] is next then. `in_use` is called only where it
    /// matters.
    pub(crate) fn is_due(&mut self, bytes: u64, in_use: impl FnOnce() -> u64) -> bool {
        let least = self.floor.saturating_add(LEAST_BYTES);
        let unused_bytes = if bytes < least { self.floor } else { bytes.saturating_sub(in_use()) };
        if unused_bytes < least {
            self.floor = self.floor.min(unused_bytes);
            self.found = 0;
            self.pause = (self.pause / 2).max(SHORTEST_PAUSE);
            return false;
        }
        self.found += 1;
        self.found >= self.pause
    }

    /// Notes the bytes that a trim has left unused.
    pub(crate) fn trimmed(&mut self, unused_bytes: u64) {
        self.floor = unused_bytes;
        self.found = 0;
        self.pause = (2 * self.pause).min(LONGEST_PAUSE);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const MB: u64 = 1 << 20;

    /// Checks of `unused_mb` at which the heap is trimmed, after which `left_mb` are unused.
    fn trims(unused_mb: impl IntoIterator<Item = u64>, left_mb: u64) -> Vec<usize> {
        let mut policy = TrimPolicy::new(8 * MB);
        let mut checks = Vec::new();
        for (check, unused_mb) in unused_mb.into_iter().enumerate() {
            if policy.is_due((unused_mb + 50) * MB, || 50 * MB) {
                policy.trimmed(left_mb * MB);
                checks.push(check);
            }
        }
        checks
    }

    #[test]
    fn what_stays_unused_is_given_back_once() {
        assert_eq!(trims([8, 8, 100, 100, 12, 12, 12, 12], 12), [3]);
        // And again when more has come and gone.
        assert_eq!(trims([8, 100, 100, 12, 3, 9, 100, 100, 12, 12], 12), [2, 7]);
        // Less is not worth it.
        assert_eq!(trims([8, 15, 15, 15, 15, 15], 12), [0; 0]);
    }

    #[test]
    fn what_cannot_be_given_back_is_not_tried_again() {
        assert_eq!(trims([100; 500], 100), [1]);
    }

    #[test]
    fn what_is_used_again_at_once_is_given_back_ever_less_often() {
        // All of it was taken again before the next look.
        let checks = trims([100; 500], 12);
        assert_eq!(checks[..5], [1, 5, 13, 29, 61]);
        assert!(checks.windows(2).all(|pair| pair[1] - pair[0] <= LONGEST_PAUSE as usize), "{checks:?}");
        // Used at each second look, it never is.
        assert_eq!(trims((0..500).map(|check| if check % 2 == 0 { 100 } else { 10 }), 12), [0; 0]);
    }

    #[test]
    fn after_a_busy_time_it_goes_back_as_soon_as_before() {
        let busy = [100; 100];
        let quiet = [12; 6];
        let checks = trims(busy.into_iter().chain(quiet).chain([100, 100, 12]), 12);
        assert_eq!(checks.last(), Some(&107), "{checks:?}");
    }

    #[test]
    fn nothing_is_counted_while_the_process_is_small() {
        let mut policy = TrimPolicy::new(8 * MB);
        assert!(!policy.is_due(15 * MB, || panic!("that locks the allocator")));
        let mut is_counted = false;
        policy.is_due(16 * MB, || {
            is_counted = true;
            0
        });
        assert!(is_counted);
    }

    proptest! {
        #[test]
        fn it_is_never_given_back_without_enough_of_it(unused in prop::collection::vec(0_u64..200, 0..100)) {
            let mut policy = TrimPolicy::new(8 * MB);
            let mut least = 8;
            for mb in unused {
                least = least.min(mb);
                if policy.is_due((mb + 3) * MB, || 3 * MB) {
                    prop_assert!(mb >= least + 8, "{mb} {least}");
                    policy.trimmed(mb * MB);
                    least = mb;
                }
            }
        }
    }
}
