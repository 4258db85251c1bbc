//! The node's renderer, with the buffers that frames share and the time that each display takes of a frame.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Error, Result};
use rcs_displays::SceneState;
use rcs_render::{Depths, RenderError, Renderer, RendererChoice};
use rcs_scene::{DisplayId, DisplayMask, Image, Scene};

use crate::camera::frame::{DueFrame, FinishedFrame, FrameInFlight, SharedBuffers};
use crate::scene::status_tree::path_text;

/// Duration from which a frame is reported.
const SLOW_AFTER: Duration = Duration::from_secs(1);
/// Share of the duration from which the slowest display is named.
const NAMED_SHARE: f64 = 0.1;

/// Draws the frames of all cameras.
pub(super) struct FrameRenderer {
    renderer: Box<dyn Renderer>,
    buffers: SharedBuffers,
    /// The scene of a version, for all cameras.
    snapshot: Option<(u64, Arc<Scene>)>,
    /// The times of the frame at hand.
    pub(super) costs: Costs,
}

impl FrameRenderer {
    /// Creates the chosen renderer.
    ///
    /// # Errors
    /// It is a GPU, and none works.
    pub(super) fn new(choice: RendererChoice) -> Result<Self> {
        let renderer = rcs_render::create(choice)?;
        Ok(Self { renderer, buffers: SharedBuffers::default(), snapshot: None, costs: Costs::default() })
    }

    /// The renderer's name, for the log.
    pub(super) fn describe(&self) -> String {
        self.renderer.describe()
    }

    /// The number of frames that may be in flight with a gain.
    pub(super) fn frames_at_once(&self) -> usize {
        self.renderer.images_at_once()
    }

    /// `true` if it decodes points by itself.
    pub(super) fn takes_packed_points(&self) -> bool {
        self.renderer.takes_packed_points()
    }

    /// `true` while a GPU draws frames in flight, so that the next scene may be prepared meanwhile.
    pub(super) fn can_upload(&self) -> bool {
        self.renderer.can_upload()
    }

    /// Uploads the clouds of the next scene.
    pub(super) fn upload(&mut self, scene: &Scene, visible: &DisplayMask) {
        self.renderer.upload(scene, visible);
    }

    /// The scene as it is now, for all cameras.
    pub(super) fn snapshot(&mut self, scene: &SceneState) -> Arc<Scene> {
        let current = self.snapshot.take().filter(|(version, _)| *version == scene.version());
        let (_, snapshot) = self.snapshot.insert(current.unwrap_or_else(|| (scene.version(), Arc::new(scene.scene()))));
        Arc::clone(snapshot)
    }

    /// Drops the snapshot before the next message is taken, which can then use the memory of its clouds.
    pub(super) fn forget_snapshot(&mut self) {
        self.snapshot = None;
    }

    pub(super) fn submit(&mut self, frame: DueFrame, scene: &SceneState) -> Result<FrameInFlight> {
        let snapshot = self.snapshot(scene);
        Ok(frame.submit(self.renderer.as_mut(), &snapshot)?)
    }

    /// Finishes the frame that was submitted first, in this memory. `None` if it is lost.
    pub(super) fn finish(&mut self, frame: FrameInFlight, memory: Image) -> Result<Option<FinishedFrame>> {
        Ok(frame.finish(self.renderer.as_mut(), memory, &mut self.buffers)?)
    }

    /// Describes the frame that is finished now, if it was slow.
    pub(super) fn slow_frame(&self, displays: &SceneState) -> Option<String> {
        self.costs.slow_frame(self.renderer.as_ref(), displays)
    }

    /// Gives back the memory for images of sizes that are not drawn any more.
    pub(super) fn forget_sizes(&mut self) {
        self.renderer.forget_sizes();
    }

    /// Gives back the memory of depths.
    pub(super) fn forget_depths(&mut self) {
        self.buffers.depths = Depths::default();
    }
}

/// `true` if a frame is missing because the GPU is lost, hangs or is out of memory: then no frame is in flight any
/// more.
pub(super) fn has_gpu_failed(error: &Error) -> bool {
    matches!(error.downcast_ref(), Some(RenderError::Gpu { .. }))
}

/// The times of one frame, from the messages that it shows to the finished pixels.
#[derive(Debug)]
pub(super) struct Costs {
    begun: Instant,
    /// By display, for its messages and updates.
    displays: HashMap<DisplayId, Duration>,
}

impl Default for Costs {
    fn default() -> Self {
        Self { begun: Instant::now(), displays: HashMap::new() }
    }
}

impl Costs {
    pub(super) fn clear(&mut self) {
        self.begun = Instant::now();
        self.displays.clear();
    }

    pub(super) fn add(&mut self, costs: impl IntoIterator<Item = (DisplayId, Duration)>) {
        for (display, cost) in costs {
            *self.displays.entry(display).or_default() += cost;
        }
    }

    /// Describes the frame that is finished now, if it was slow.
    pub(super) fn slow_frame(&self, renderer: &dyn Renderer, displays: &SceneState) -> Option<String> {
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
    fn a_gpu_that_fails_takes_all_frames_with_it_and_a_image_that_is_too_large_none() {
        let lost = RenderError::Gpu { adapter: "a GPU".into(), reason: "the device was lost".into() };
        let too_large = RenderError::TooLarge { width_px: 9, height_px: 9, limit_px: 8, renderer: "gpu".into() };
        assert!(has_gpu_failed(&lost.into()) && !has_gpu_failed(&too_large.into()));
    }

    #[test]
    fn a_slow_image_names_the_display_that_costs_most() {
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
