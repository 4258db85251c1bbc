//! What drawing each display took.
//!
//! Each worker adds up the time of each job, in both steps, from one reading of the clock to the next. A job belongs to
//! one display, or, where several small ones share it, counts as the first one's.

use std::time::{Duration, Instant};

use rcs_scene::DisplayId;

/// The times of one worker.
#[derive(Debug, Default)]
pub(in crate::cpu) struct WorkerCosts {
    by_job: Vec<Duration>,
    last: Option<Instant>,
}

impl WorkerCosts {
    /// Begins an image with this number of jobs.
    pub(in crate::cpu) fn reset(&mut self, jobs: usize) {
        self.by_job.clear();
        self.by_job.resize(jobs, Duration::ZERO);
        self.last = None;
    }

    /// The time of all jobs.
    pub(in crate::cpu) fn sum(&self) -> Duration {
        self.by_job.iter().sum()
    }

    /// What follows is measured.
    #[inline]
    pub(in crate::cpu) fn begin(&mut self) {
        self.last = Some(Instant::now());
    }

    /// Adds the time since [`Self::begin`], or since the last call, to these jobs together.
    #[inline]
    pub(in crate::cpu) fn add(&mut self, jobs: std::ops::Range<usize>) {
        let now = Instant::now();
        let took = self.last.replace(now).map_or(Duration::ZERO, |last| now.saturating_duration_since(last));
        let share = took / u32::try_from(jobs.len()).unwrap_or(u32::MAX).max(1);
        for cost in self.by_job.get_mut(jobs).unwrap_or(&mut []) {
            *cost += share;
        }
    }
}

/// The share of each display in the time of an image that the workers draw together.
pub(in crate::cpu) fn by_display<'w>(
    displays: &[DisplayId],
    workers: impl ExactSizeIterator<Item = &'w WorkerCosts>,
) -> Vec<(DisplayId, Duration)> {
    let together = u32::try_from(workers.len()).unwrap_or(u32::MAX).max(1);
    let mut sums: Vec<(DisplayId, Duration)> = Vec::new();
    for (display, cost) in workers.flat_map(|worker| displays.iter().zip(&worker.by_job)) {
        match sums.iter_mut().find(|(known, _)| known == display) {
            Some((_, sum)) => *sum += *cost / together,
            None => sums.push((*display, *cost / together)),
        }
    }
    sums
}
