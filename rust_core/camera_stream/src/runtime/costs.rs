//! What a picture's time was spent on, for pictures that take long.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use rcs_displays::DisplaySet;
use rcs_render::Renderer;
use rcs_scene::DisplayId;

use crate::scene::status_tree::path_text;

/// A picture that took longer is reported.
const SLOW_AFTER: Duration = Duration::from_secs(1);
/// The display that costs most is named if it costs at least this share of the whole.
const NAMED_SHARE: f64 = 0.1;

/// The times of one picture, from the messages that it shows to the finished pixels.
#[derive(Debug)]
pub(crate) struct Costs {
    begun: Instant,
    /// Of each display's messages and updates.
    displays: HashMap<DisplayId, Duration>,
}

impl Default for Costs {
    fn default() -> Self {
        Self { begun: Instant::now(), displays: HashMap::new() }
    }
}

impl Costs {
    /// Begins with the next picture.
    pub(crate) fn clear(&mut self) {
        self.begun = Instant::now();
        self.displays.clear();
    }

    /// Adds what the displays' messages and updates took.
    pub(crate) fn add(&mut self, costs: impl IntoIterator<Item = (DisplayId, Duration)>) {
        for (display, cost) in costs {
            *self.displays.entry(display).or_default() += cost;
        }
    }

    /// What took so long, if the picture that is finished now was slow.
    pub(crate) fn slow_frame(&self, renderer: &dyn Renderer, displays: &DisplaySet) -> Option<String> {
        let took = self.begun.elapsed();
        (took >= SLOW_AFTER).then(|| self.describe(took, renderer.costs(), |id| displays.path(id).map(path_text)))
    }

    fn describe(
        &self,
        took: Duration,
        drawing: Vec<(DisplayId, Duration)>,
        name: impl Fn(DisplayId) -> Option<String>,
    ) -> String {
        let mut costs = self.displays.clone();
        for (display, cost) in drawing {
            *costs.entry(display).or_default() += cost;
        }
        let is_much = |(_, cost): &(DisplayId, Duration)| *cost >= took.mul_f64(NAMED_SHARE);
        let most = costs.into_iter().max_by_key(|(_, cost)| *cost).filter(is_much);
        let took = format!("a picture took {:.1} s", took.as_secs_f64());
        match most.and_then(|(display, cost)| Some((name(display)?, cost))) {
            Some((name, cost)) => format!("{took}, of it {:.1} s for display {name}", cost.as_secs_f64()),
            None => took,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_picture_names_the_display_that_costs_most() {
        let secs = Duration::from_secs_f64;
        let mut costs = Costs::default();
        costs.add([(1, secs(0.3)), (2, secs(0.2))]);
        costs.add([(1, secs(0.3))]);
        let name = |display: DisplayId| Some(format!("d{display}"));
        let drawing = vec![(2, secs(1.04)), (1, secs(0.1))];
        let text = costs.describe(secs(2.0), drawing, name);
        assert_eq!(text, "a picture took 2.0 s, of it 1.2 s for display d2");
        assert_eq!(costs.describe(secs(2.0), Vec::new(), |_| None), "a picture took 2.0 s");
        assert_eq!(costs.describe(secs(9.0), Vec::new(), name), "a picture took 9.0 s", "most is unaccounted for");
        costs.clear();
        assert_eq!(costs.describe(secs(2.0), Vec::new(), name), "a picture took 2.0 s");
    }
}
