//! Durations of each step of a picture, and of all together, over the last hundred pictures.

use std::time::Duration;

use crate::RollingWindow;

/// Number of pictures in the statistics.
pub const PICTURES: usize = 100;

/// Durations of `STEPS` consecutive steps, in milliseconds.
#[derive(Clone, Debug)]
pub struct StepTimes<const STEPS: usize> {
    steps_ms: [RollingWindow<PICTURES>; STEPS],
    whole_ms: RollingWindow<PICTURES>,
}

impl<const STEPS: usize> Default for StepTimes<STEPS> {
    fn default() -> Self {
        Self { steps_ms: [const { RollingWindow::new() }; STEPS], whole_ms: RollingWindow::new() }
    }
}

impl<const STEPS: usize> StepTimes<STEPS> {
    /// Adds a picture by the durations of its steps and of the whole.
    pub fn push(&mut self, steps: [Duration; STEPS], whole: Duration) {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        for (window, step) in self.steps_ms.iter_mut().zip(steps) {
            window.push(ms(step));
        }
        self.whole_ms.push(ms(whole));
    }

    /// Number of pictures so far, [`PICTURES`] at most.
    pub fn pictures(&self) -> usize {
        self.whole_ms.len()
    }

    /// Durations of each step.
    pub fn steps_ms(&self) -> &[RollingWindow<PICTURES>; STEPS] {
        &self.steps_ms
    }

    /// Durations of all steps together.
    pub fn whole_ms(&self) -> &RollingWindow<PICTURES> {
        &self.whole_ms
    }
}
