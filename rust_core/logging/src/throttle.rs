//! Rate limit of the log: one line a second for each cause, with the number of suppressed ones.
//!
//! Two lines have the same cause if the same place in the program logged them and they differ in numbers only, see
//! [`without_numbers`]. Other lines of one call site are limited to [`MOST_OF_A_SITE`] a second, because names can be
//! made up.

use std::collections::hash_map::DefaultHasher;
use std::collections::HashMap;
use std::hash::{Hash, Hasher};
use std::time::{Duration, Instant};

/// Minimum time between two lines of a cause.
const PERIOD: Duration = Duration::from_secs(1);
/// Different lines of a call site in that time.
const MOST_OF_A_SITE: u32 = 50;
/// Bound of both tables.
const MOST_CAUSES: usize = 1000;

/// A cause that was logged, and what was suppressed since.
#[derive(Debug)]
struct LoggedCause<T> {
    logged: Instant,
    suppressed: u64,
    /// The newest suppressed line.
    last: Option<T>,
}

/// Lines that a call site logged since `begun`.
#[derive(Debug)]
struct CallSite {
    begun: Instant,
    logged: u32,
}

/// Suppressed lines of a cause, to be reported.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Suppressed<T> {
    /// The newest one.
    pub(crate) last: T,
    /// Their number.
    pub(crate) count: u64,
}

/// Decides which lines are logged; `T` is a suppressed line.
#[derive(Debug)]
pub(crate) struct Throttle<T> {
    causes: HashMap<u64, LoggedCause<T>>,
    sites: HashMap<u64, CallSite>,
}

fn hash(value: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// A line without its numbers.
pub fn without_numbers(text: &str) -> String {
    text.chars().filter(|letter| !letter.is_ascii_digit()).collect()
}

impl<T> Throttle<T> {
    pub(crate) fn new() -> Self {
        Self { causes: HashMap::new(), sites: HashMap::new() }
    }

    /// Number of lines suppressed before, if this one is logged; `None` suppresses it. `site` is the line of the
    /// program,
    /// `keep` makes what [`Self::take_suppressed`] returns later.
    pub(crate) fn admit(
        &mut self,
        site: (&str, u32),
        cause: &str,
        now: Instant,
        keep: impl FnOnce() -> T,
    ) -> Option<u64> {
        let site = hash(site);
        let cause = hash((site, cause));
        let is_recent = |since: Instant| now.saturating_duration_since(since) < PERIOD;
        if let Some(known) = self.causes.get_mut(&cause) {
            if is_recent(known.logged) {
                known.suppressed += 1;
                known.last = Some(keep());
                return None;
            }
            known.logged = now;
            known.last = None;
            return Some(std::mem::take(&mut known.suppressed));
        }
        if self.sites.len() >= MOST_CAUSES {
            self.sites.retain(|_, site| is_recent(site.begun));
        }
        let of_site = self.sites.entry(site).or_insert(CallSite { begun: now, logged: 0 });
        if !is_recent(of_site.begun) {
            *of_site = CallSite { begun: now, logged: 0 };
        }
        let is_admitted = of_site.logged < MOST_OF_A_SITE;
        of_site.logged += u32::from(is_admitted);
        // All others of the call site count as one cause.
        let cause = if is_admitted { cause } else { site };
        if self.causes.len() >= MOST_CAUSES {
            self.causes.retain(|_, cause| cause.suppressed > 0 || is_recent(cause.logged));
        }
        if !is_admitted {
            let others = self.causes.entry(cause).or_insert(LoggedCause { logged: now, suppressed: 0, last: None });
            others.suppressed += 1;
            others.last = Some(keep());
            return None;
        }
        if self.causes.len() < MOST_CAUSES {
            self.causes.insert(cause, LoggedCause { logged: now, suppressed: 0, last: None });
        }
        Some(0)
    }

    /// Suppressed lines after which no line of their cause was logged for a period.
    pub(crate) fn take_suppressed(&mut self, now: Instant) -> Vec<Suppressed<T>> {
        let is_over = |cause: &LoggedCause<T>| now.saturating_duration_since(cause.logged) >= PERIOD;
        let due = self.causes.values_mut().filter(|cause| cause.suppressed > 0 && is_over(cause));
        due.filter_map(|cause| {
            // Counts as logged again.
            cause.logged = now;
            let (last, count) = (cause.last.take()?, std::mem::take(&mut cause.suppressed));
            Some(Suppressed { last, count })
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
            self.throttle.admit(("a.rs", line), &without_numbers(text), at, || text.to_owned())
        }

        fn suppressed(&mut self, secs: f64) -> Vec<(String, u64)> {
            let at = self.at(secs);
            let mut suppressed: Vec<_> =
                self.throttle.take_suppressed(at).into_iter().map(|left| (left.last, left.count)).collect();
            suppressed.sort();
            suppressed
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
        assert_eq!(bench.suppressed(1.9), []);
        assert_eq!(bench.suppressed(2.1), [("bad message 201".to_owned(), 1)]);
        assert_eq!(bench.suppressed(9.0), []);
        assert_eq!(bench.log(10.0, 1, "bad message 5"), Some(0));
    }

    #[test]
    fn made_up_names_are_limited_at_each_call_site() {
        let mut bench = Bench::new();
        let name = |i: u32| char::from_u32(0x4e00 + i).map(String::from).unwrap_or_default();
        let logged = |bench: &mut Bench, secs: f64, line: u32| {
            (0..500).filter(|i| bench.log(secs + f64::from(*i) / 1000.0, line, &name(*i)).is_some()).count()
        };
        assert_eq!(logged(&mut bench, 0.0, 1), 50);
        assert_eq!(logged(&mut bench, 0.0, 2), 50);
        assert_eq!(bench.suppressed(1.6).iter().map(|(_, count)| *count).collect::<Vec<_>>(), [450, 450]);
    }

    #[test]
    fn memory_is_bounded() {
        let mut bench = Bench::new();
        for i in 0..20_000 {
            bench.log(f64::from(i) / 100.0, i, "text");
        }
        assert!(bench.throttle.causes.len() <= MOST_CAUSES && bench.throttle.sites.len() <= MOST_CAUSES);
    }
}
