//! The last frame of a camera, and the memory that its next one is drawn into.

use std::sync::Arc;

use rcs_scene::{DepthImage, Image};

use super::frame::{FinishedFrame, FrameSpec};

/// The last frame, and memory for the next.
#[derive(Default)]
pub(super) struct FrameBuffers {
    /// The frame that was published last.
    pub(super) front: Option<FinishedFrame>,
    /// `true` if settings have changed since, during a pause.
    pub(super) is_outdated: bool,
    /// The image before it, which is drawn into again unless an output still holds it.
    pub(super) back: Option<Arc<Image>>,
    /// The depths that it was checked by, which are drawn into again.
    pub(super) back_objects: DepthImage,
    /// The size for which the renderer keeps memory.
    pub(super) drawn_px: Option<[u32; 2]>,
}

impl FrameBuffers {
    pub(super) fn last(&self) -> Option<&FrameSpec> {
        self.front.as_ref().map(|frame| &frame.spec)
    }

    /// Makes the last frame's image the back buffer, unless it is far larger than the next one.
    pub(super) fn retire_front(&mut self, next_px: [u32; 2]) {
        let count = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
        let is_similar = |back: &Arc<Image>| count([back.width_px, back.height_px]) <= 4 * count(next_px);
        self.back = self.front.take().map(|last| last.image.into_memory()).filter(is_similar);
    }

    /// `true` if the last image shows the same before post-processing, so that it need not be drawn again.
    pub(super) fn has_drawn(&self, spec: &FrameSpec, needs_depth: bool) -> bool {
        self.front.as_ref().is_some_and(|last| {
            let has_depth = last.depth.is_some() || !needs_depth;
            has_depth && last.drawn.is_some() && last.spec.content == spec.content
        })
    }
}
