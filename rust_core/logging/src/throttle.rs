//! At most one line a second for each cause, with a count of those that were left out.
//!
//! Two lines have the same cause if the same place in the program logged them and they differ in numbers only, see
//! [`cause_of`]. Lines of one place that differ in more are limited, too, to [`MOST_OF_A_PLACE`] a second: names can be
//! made up.

use std::collections::hash_map::DefaultHasher;
use std::collections::HashMap;
use std::hash::{Hash, Hasher};
use std::time::{Duration, Instant};

/// How long a cause is not logged again.
const SILENCE: Duration = Duration::from_secs(1);
/// How many different lines a place may log in that time.
const MOST_OF_A_PLACE: u32 = 50;
/// How many causes are remembered.
const MOST_CAUSES: usize = 1000;

/// A line that was logged, and those like it since.
#[derive(Debug)]
struct Cause<T> {
    logged: Instant,
    left_out: u64,
    /// The newest of them.
    last: Option<T>,
}

/// Lines of one place.
#[derive(Debug)]
struct Place {
    begun: Instant,
    logged: u32,
}

/// Lines that were left out, to be reported.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct LeftOut<T> {
    /// The newest of them.
    pub(crate) last: T,
    /// How many there were.
    pub(crate) count: u64,
}

/// Decides which lines are logged. `T` is what is kept of a line.
#[derive(Debug)]
pub(crate) struct Throttle<T> {
    causes: HashMap<u64, Cause<T>>,
    places: HashMap<u64, Place>,
}

fn hash(value: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// A line without its numbers.
pub(crate) fn cause_of(text: &str) -> String {
    text.chars().filter(|letter| !letter.is_ascii_digit()).collect()
}

impl<T> Throttle<T> {
    pub(crate) fn new() -> Self {
        Self { causes: HashMap::new(), places: HashMap::new() }
    }

    /// Whether a line of this cause is logged now, and how many of it were left out before. `place` is the line of the
    /// program, `keep` makes what [`Self::take_left_out`] returns later.
    pub(crate) fn admit(
        &mut self,
        place: (&str, u32),
        cause: &str,
        now: Instant,
        keep: impl FnOnce() -> T,
    ) -> Option<u64> {
        let place = hash(place);
        let cause = hash((place, cause));
        let is_silent = |since: Instant| now.saturating_duration_since(since) < SILENCE;
        if let Some(known) = self.causes.get_mut(&cause) {
            if is_silent(known.logged) {
                known.left_out += 1;
                known.last = Some(keep());
                return None;
            }
            known.logged = now;
            known.last = None;
            return Some(std::mem::take(&mut known.left_out));
        }
        if self.places.len() >= MOST_CAUSES {
            self.places.retain(|_, place| is_silent(place.begun));
        }
        let of_place = self.places.entry(place).or_insert(Place { begun: now, logged: 0 });
        if !is_silent(of_place.begun) {
            *of_place = Place { begun: now, logged: 0 };
        }
        let is_admitted = of_place.logged < MOST_OF_A_PLACE;
        of_place.logged += u32::from(is_admitted);
        // All others of the place count as one cause.
        let cause = if is_admitted { cause } else { place };
        if self.causes.len() >= MOST_CAUSES {
            self.causes.retain(|_, cause| cause.left_out > 0 || is_silent(cause.logged));
        }
        if !is_admitted {
            let others = self.causes.entry(cause).or_insert(Cause { logged: now, left_out: 0, last: None });
            others.left_out += 1;
            others.last = Some(keep());
            return None;
        }
        if self.causes.len() < MOST_CAUSES {
            self.causes.insert(cause, Cause { logged: now, left_out: 0, last: None });
        }
        Some(0)
    }

    /// What was left out and is to be reported now, because nothing like it was logged since.
    pub(crate) fn take_left_out(&mut self, now: Instant) -> Vec<LeftOut<T>> {
        let is_over = |cause: &Cause<T>| now.saturating_duration_since(cause.logged) >= SILENCE;
        let due = self.causes.values_mut().filter(|cause| cause.left_out > 0 && is_over(cause));
        due.filter_map(|cause| {
            // Counts as logged again.
            cause.logged = now;
            let (last, count) = (cause.last.take()?, std::mem::take(&mut cause.left_out));
            Some(LeftOut { last, count })
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Bench {
        throttle: Throttle<String>,
        start: Instant,
    }

    impl Bench {
        fn new() -> Self {
            Self { throttle: Throttle::new(), start: Instant::now() }
        }

        fn at(&self, secs: f64) -> Instant {
            self.start + Duration::from_secs_f64(secs)
        }

        fn log(&mut self, secs: f64, line: u32, text: &str) -> Option<u64> {
            let at = self.at(secs);
            self.throttle.admit(("a.rs", line), &cause_of(text), at, || text.to_owned())
        }

        fn left_out(&mut self, secs: f64) -> Vec<(String, u64)> {
            let at = self.at(secs);
            let mut left_out: Vec<_> =
                self.throttle.take_left_out(at).into_iter().map(|left| (left.last, left.count)).collect();
            left_out.sort();
            left_out
        }
    }

    #[test]
    fn a_cause_is_logged_once_a_second_with_a_count() {
        let mut bench = Bench::new();
        assert_eq!(bench.log(0.0, 1, "bad message 1"), Some(0));
        assert_eq!((1..=99).filter_map(|i| bench.log(f64::from(i) / 100.0, 1, &format!("bad message {i}"))).count(), 0);
        assert_eq!(bench.log(0.5, 1, "worse message 1"), Some(0));
        assert_eq!(bench.log(1.0, 1, "bad message 200"), Some(99));
        assert_eq!(bench.log(1.1, 1, "bad message 201"), None);
        assert_eq!(bench.left_out(1.9), []);
        assert_eq!(bench.left_out(2.1), [("bad message 201".to_owned(), 1)]);
        assert_eq!(bench.left_out(9.0), []);
        assert_eq!(bench.log(10.0, 1, "bad message 5"), Some(0));
    }

    #[test]
    fn made_up_names_are_limited_for_each_place() {
        let mut bench = Bench::new();
        let name = |i: u32| char::from_u32(0x4e00 + i).map(String::from).unwrap_or_default();
        let logged = |bench: &mut Bench, secs: f64, line: u32| {
            (0..500).filter(|i| bench.log(secs + f64::from(*i) / 1000.0, line, &name(*i)).is_some()).count()
        };
        assert_eq!(logged(&mut bench, 0.0, 1), 50);
        assert_eq!(logged(&mut bench, 0.0, 2), 50);
        assert_eq!(bench.left_out(1.6).iter().map(|(_, count)| *count).collect::<Vec<_>>(), [450, 450]);
    }

    #[test]
    fn memory_is_bounded() {
        let mut bench = Bench::new();
        for i in 0..20_000 {
            bench.log(f64::from(i) / 100.0, i, "text");
        }
        assert!(bench.throttle.causes.len() <= MOST_CAUSES && bench.throttle.places.len() <= MOST_CAUSES);
    }
}
