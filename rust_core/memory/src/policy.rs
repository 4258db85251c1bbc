//! When unused memory is given back.
//!
//! Memory that was given back has to be taken from the system again when it is needed, which costs a quarter of a
//! millisecond for each megabyte. So:
//! - it must have been unused at two looks in turn, [`PERIOD`] apart, and be [`LEAST_BYTES`] more than what was left
//!   when it was given back the last time (stacks, free pieces of less than a page);
//! - where all of it is taken again soon, as by a scene of many markers that is sent anew each second, it is given back
//!   less and less often: the pause doubles up to [`LONGEST_PAUSE`].

use std::time::Duration;

/// From one look to the next.
pub(crate) const PERIOD: Duration = Duration::from_secs(5);

/// Less is not worth it.
pub(crate) const LEAST_BYTES: u64 = 8 << 20;

/// Looks between two times in vain: ten minutes.
const LONGEST_PAUSE: u32 = 120;

/// How many looks in turn must have found unused memory, at least.
const SHORTEST_PAUSE: u32 = 2;

/// What is known from the last looks.
#[derive(Debug)]
pub(crate) struct Policy {
    /// The least that was unused since it was given back the last time, in bytes.
    floor: u64,
    /// How many looks in turn have found more.
    found: u32,
    /// How many must.
    patience: u32,
}

impl Policy {
    /// At the program's start, when so many bytes are unused.
    pub(crate) const fn new(unused_bytes: u64) -> Self {
        Self { floor: unused_bytes, found: 0, patience: SHORTEST_PAUSE }
    }

    /// A look: of so many bytes, so many are in use, which is asked for only where it matters. Whether the others are
    /// to be given back now; if so, [`Self::given_back`] is next.
    pub(crate) fn look(&mut self, bytes: u64, in_use: impl FnOnce() -> u64) -> bool {
        let least = self.floor.saturating_add(LEAST_BYTES);
        let unused_bytes = if bytes < least { self.floor } else { bytes.saturating_sub(in_use()) };
        if unused_bytes < least {
            self.floor = self.floor.min(unused_bytes);
            self.found = 0;
            self.patience = (self.patience / 2).max(SHORTEST_PAUSE);
            return false;
        }
        self.found += 1;
        self.found >= self.patience
    }

    /// So many bytes are still unused after all that can be was given back.
    pub(crate) fn given_back(&mut self, unused_bytes: u64) {
        self.floor = unused_bytes;
        self.found = 0;
        self.patience = (2 * self.patience).min(LONGEST_PAUSE);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const MB: u64 = 1 << 20;

    /// At which of these looks memory is given back, after which `left` megabytes are unused.
    fn given_back(unused_mb: impl IntoIterator<Item = u64>, left_mb: u64) -> Vec<usize> {
        let mut policy = Policy::new(8 * MB);
        let mut looks = Vec::new();
        for (look, unused_mb) in unused_mb.into_iter().enumerate() {
            if policy.look((unused_mb + 50) * MB, || 50 * MB) {
                policy.given_back(left_mb * MB);
                looks.push(look);
            }
        }
        looks
    }

    #[test]
    fn what_stays_unused_is_given_back_once() {
        assert_eq!(given_back([8, 8, 100, 100, 12, 12, 12, 12], 12), [3]);
        // And again when more has come and gone.
        assert_eq!(given_back([8, 100, 100, 12, 3, 9, 100, 100, 12, 12], 12), [2, 7]);
        // Less is not worth it.
        assert_eq!(given_back([8, 15, 15, 15, 15, 15], 12), [0; 0]);
    }

    #[test]
    fn what_cannot_be_given_back_is_not_tried_again() {
        assert_eq!(given_back([100; 500], 100), [1]);
    }

    #[test]
    fn what_is_used_again_at_once_is_given_back_ever_less_often() {
        // All of it was taken again before the next look.
        let looks = given_back([100; 500], 12);
        assert_eq!(looks[..5], [1, 5, 13, 29, 61]);
        assert!(looks.windows(2).all(|pair| pair[1] - pair[0] <= LONGEST_PAUSE as usize), "{looks:?}");
        // Used at each second look, it never is.
        assert_eq!(given_back((0..500).map(|look| if look % 2 == 0 { 100 } else { 10 }), 12), [0; 0]);
    }

    #[test]
    fn after_a_busy_time_it_goes_back_as_soon_as_before() {
        let busy = [100; 100];
        let quiet = [12; 6];
        let looks = given_back(busy.into_iter().chain(quiet).chain([100, 100, 12]), 12);
        assert_eq!(looks.last(), Some(&107), "{looks:?}");
    }

    #[test]
    fn nothing_is_counted_while_the_process_is_small() {
        let mut policy = Policy::new(8 * MB);
        assert!(!policy.look(15 * MB, || panic!("that locks the allocator")));
        let mut is_counted = false;
        policy.look(16 * MB, || {
            is_counted = true;
            0
        });
        assert!(is_counted);
    }

    proptest! {
        #[test]
        fn it_is_never_given_back_without_enough_of_it(unused in prop::collection::vec(0_u64..200, 0..100)) {
            let mut policy = Policy::new(8 * MB);
            let mut least = 8;
            for mb in unused {
                least = least.min(mb);
                if policy.look((mb + 3) * MB, || 3 * MB) {
                    prop_assert!(mb >= least + 8, "{mb} {least}");
                    policy.given_back(mb * MB);
                    least = mb;
                }
            }
        }
    }
}
