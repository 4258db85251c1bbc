//! How long each step of a picture takes, and all together, over the last hundred pictures.

use std::time::Duration;

use crate::RollingWindow;

/// How many pictures the figures cover.
pub const PICTURES: usize = 100;

/// The times of `STEPS` steps that follow one another, in milliseconds.
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
    /// Adds a picture by how long each of its steps took, and all of them.
    pub fn push(&mut self, steps: [Duration; STEPS], whole: Duration) {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        for (window, step) in self.steps_ms.iter_mut().zip(steps) {
            window.push(ms(step));
        }
        self.whole_ms.push(ms(whole));
    }

    /// How many pictures the figures are of.
    pub fn pictures(&self) -> usize {
        self.whole_ms.len()
    }

    /// The times of each step.
    pub fn steps_ms(&self) -> &[RollingWindow<PICTURES>; STEPS] {
        &self.steps_ms
    }

    /// The times of all steps together.
    pub fn whole_ms(&self) -> &RollingWindow<PICTURES> {
        &self.whole_ms
    }
}
