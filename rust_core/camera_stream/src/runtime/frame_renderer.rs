//! The node's renderer, with the buffers that frames share and the times that they take.

use std::sync::Arc;

use anyhow::{Error, Result};
use rcs_displays::DisplaySet;
use rcs_render::{CpuRenderer, RenderError, Renderer, RendererChoice};
use rcs_scene::{DepthPicture, Picture, Scene};

use super::costs::Costs;
use crate::camera::frame::{DueFrame, FinishedFrame, FrameInFlight, SharedBuffers};

/// Draws the frames of all cameras.
pub(super) struct FrameRenderer {
    renderer: Box<dyn Renderer>,
    choice: RendererChoice,
    buffers: SharedBuffers,
    /// The times of the frame at hand.
    pub(super) costs: Costs,
}

impl FrameRenderer {
    /// # Errors
    /// There is no renderer as it is chosen.
    pub(super) fn new(choice: RendererChoice) -> Result<Self> {
        let renderer = rcs_render::create(choice)?;
        Ok(Self { renderer, choice, buffers: SharedBuffers::default(), costs: Costs::default() })
    }

    /// The renderer's name, for the log.
    pub(super) fn describe(&self) -> String {
        self.renderer.describe()
    }

    /// The number of frames that may be in flight with a gain.
    pub(super) fn frames_at_once(&self) -> usize {
        self.renderer.pictures_at_once()
    }

    pub(super) fn submit(&mut self, frame: DueFrame, scene: &Arc<Scene>) -> Result<FrameInFlight> {
        Ok(frame.submit(self.renderer.as_mut(), scene, &mut self.buffers)?)
    }

    /// Finishes the frame that was submitted first, in this memory. `None` if it is lost.
    pub(super) fn finish(&mut self, frame: FrameInFlight, memory: Picture) -> Result<Option<FinishedFrame>> {
        Ok(frame.finish(self.renderer.as_mut(), memory, &mut self.buffers)?)
    }

    /// What took so long, if the frame that is finished now was slow.
    pub(super) fn slow_frame(&self, displays: &DisplaySet) -> Option<String> {
        self.costs.slow_frame(self.renderer.as_ref(), displays)
    }

    /// Gives back the memory for images of sizes that are not drawn any more.
    pub(super) fn forget_sizes(&mut self) {
        self.renderer.forget_sizes();
    }

    /// Gives back the memory of depths.
    pub(super) fn forget_depths(&mut self) {
        self.buffers.depth = DepthPicture::default();
    }

    /// Replaces a GPU that fails, and that `auto` chose, by the CPU. Returns `true` if the GPU failed: then no frame is
    /// in flight any more.
    pub(super) fn handle_failure(&mut self, error: &Error) -> bool {
        let has_failed = has_gpu_failed(error);
        if has_failed && self.choice == RendererChoice::Auto {
            self.renderer = Box::new(CpuRenderer::new());
            log::warn!("drawing with {} from now on", self.describe());
        }
        has_failed
    }
}

/// `true` if a frame is missing because the GPU is lost, hangs or is out of memory.
fn has_gpu_failed(error: &Error) -> bool {
    matches!(error.downcast_ref(), Some(RenderError::Gpu { .. }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gpu_that_fails_is_replaced_by_the_cpu_where_auto_had_chosen_it() {
        let lost = || RenderError::Gpu { adapter: "a GPU".into(), reason: "the device was lost".into() }.into();
        let too_large =
            RenderError::TooLarge { width_px: 9, height_px: 9, limit_px: 8, renderer: "gpu (a GPU)".into() }.into();
        let mut renderer = FrameRenderer::new(RendererChoice::Cpu).unwrap();
        assert!(!renderer.handle_failure(&too_large) && renderer.handle_failure(&lost()));
        renderer.renderer = Box::new(OtherRenderer);
        assert!(renderer.handle_failure(&lost()) && renderer.describe() == "other", "cpu and gpu are kept");
        renderer.choice = RendererChoice::Auto;
        assert!(!renderer.handle_failure(&too_large) && renderer.describe() == "other");
        assert!(renderer.handle_failure(&lost()) && renderer.describe().starts_with("cpu"));
    }

    struct OtherRenderer;

    impl Renderer for OtherRenderer {
        fn describe(&self) -> String {
            "other".to_owned()
        }

        fn submit(&mut self, _: &rcs_render::View<'_>) -> Result<(), RenderError> {
            Ok(())
        }

        fn submit_with_depth(&mut self, _: &rcs_render::View<'_>, _: &mut DepthPicture) -> Result<(), RenderError> {
            Ok(())
        }

        fn finish(&mut self, _: &mut Picture) -> Result<rcs_render::Finished, RenderError> {
            Ok(rcs_render::Finished::NoneInFlight)
        }
    }
}
