//! A camera's light as the last measured surface confirms it, between two frames.
//!
//! A frame that is drawn is checked when it is finished ([`super::frame`]). When the next depth image arrives first,
//! the same frame is checked again, and post-processed again if that changes what may be lit.

use std::sync::Arc;

use rcs_confirm::{Confirmation, Shares};
use rcs_render::{LastStep, LightMask};
use rcs_scene::DepthPicture;

use crate::safety::surface::SurfaceCheck;
use crate::safety::FramePolicy;

/// Depths that a frame lights, with the mask of the surface that they were compared with.
pub(crate) struct CheckedLight {
    /// Depths of what the listed displays light.
    objects: DepthPicture,
    /// The depth image that it was compared with.
    version: u64,
    mask: Option<Arc<LightMask>>,
    pub(crate) shares: Shares,
}

impl CheckedLight {
    /// Compares the depths of what an image lights with the surface.
    pub(super) fn new(objects: DepthPicture, surface: &SurfaceCheck) -> Self {
        let Confirmation { mask, shares } = surface.confirm(&objects);
        Self { objects, version: surface.version, mask, shares }
    }

    /// Compares again if another depth image has arrived.
    fn update(&mut self, surface: &SurfaceCheck) {
        if self.version != surface.version {
            let Confirmation { mask, shares } = surface.confirm(&self.objects);
            (self.version, self.shares) = (surface.version, shares);
            // An equal one keeps the image.
            if self.mask != mask {
                self.mask = mask;
            }
        }
    }

    /// The pixels that may be lit.
    pub(super) fn mask(&self) -> Option<Arc<LightMask>> {
        self.mask.clone()
    }

    /// The memory of the depths, for the next frame.
    pub(super) fn into_memory(self) -> DepthPicture {
        self.objects
    }
}

/// The last check of a camera's light. It holds in test pictures as well.
#[derive(Default)]
pub(super) struct LastCheck {
    mask: Option<Arc<LightMask>>,
}

impl LastCheck {
    /// Checks the frame that is shown again if another depth image has arrived, and takes over its mask.
    pub(super) fn update(&mut self, shown: Option<&mut CheckedLight>, surface: Option<&SurfaceCheck>) {
        match (shown, surface) {
            (Some(shown), Some(surface)) => {
                shown.update(surface);
                self.mask = shown.mask();
            }
            (None, Some(_)) => {}
            (_, None) => self.mask = None,
        }
    }

    /// Post-processing of an image of this size, with the mask of the last check.
    pub(super) fn post(&self, policy: &FramePolicy, size_px: [u32; 2]) -> Arc<LastStep> {
        let mask = self.mask.as_ref().filter(|mask| policy.surface.is_some() && mask.size_px() == size_px);
        mask.map_or_else(|| Arc::clone(&policy.post), |mask| confirmed(&policy.post, Some(Arc::clone(mask))))
    }
}

/// Post-processing that leaves light only where it is confirmed.
pub(super) fn confirmed(post: &LastStep, mask: Option<Arc<LightMask>>) -> Arc<LastStep> {
    Arc::new(LastStep { confirmed: mask, ..post.clone() })
}
