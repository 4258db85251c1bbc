//! Durations of each step of an image, and of all together, over the last hundred images.

use std::time::Duration;

use crate::RollingWindow;

/// Number of images in the statistics.
pub const IMAGES: usize = 100;

/// Durations of `STEPS` consecutive steps, in milliseconds.
#[derive(Clone, Debug)]
pub struct StepTimes<const STEPS: usize> {
    steps_ms: [RollingWindow<IMAGES>; STEPS],
    whole_ms: RollingWindow<IMAGES>,
}

impl<const STEPS: usize> Default for StepTimes<STEPS> {
    fn default() -> Self {
        Self { steps_ms: [const { RollingWindow::new() }; STEPS], whole_ms: RollingWindow::new() }
    }
}

impl<const STEPS: usize> StepTimes<STEPS> {
    /// Adds an image by the durations of its steps and of the whole.
    pub fn push(&mut self, steps: [Duration; STEPS], whole: Duration) {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        for (window, step) in self.steps_ms.iter_mut().zip(steps) {
            window.push(ms(step));
        }
        self.whole_ms.push(ms(whole));
    }

    /// Number of images so far, [`IMAGES`] at most.
    pub fn images(&self) -> usize {
        self.whole_ms.len()
    }

    /// Durations of each step.
    pub fn steps_ms(&self) -> &[RollingWindow<IMAGES>; STEPS] {
        &self.steps_ms
    }

    /// Durations of all steps together.
    pub fn whole_ms(&self) -> &RollingWindow<IMAGES> {
        &self.whole_ms
    }
}
