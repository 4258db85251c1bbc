//! A camera's light as the last measured surface confirms it.
//!
//! A frame that is drawn is checked when it is finished ([`super::frame`]). When the next depth image arrives, the
//! depths of what the camera drew last are checked again, also while something else is shown in its place.

use std::sync::Arc;

use rcs_confirm::{Confirmation, Shares};
use rcs_light::{Content, Grant};
use rcs_render::LightMask;
use rcs_scene::{Camera, DepthImage};

use crate::safety::surface::SurfaceCheck;

/// Depths that a frame lights, with the mask of the surface that they were compared with.
pub(crate) struct CheckedLight {
    /// Depths of what the listed displays light.
    objects: DepthImage,
    /// The camera that they were drawn with.
    camera: Arc<Camera>,
    /// The depth image that it was compared with.
    version: u64,
    mask: Option<Arc<LightMask>>,
    pub(crate) shares: Shares,
}

impl CheckedLight {
    /// Compares the depths of what an image lights with the surface.
    pub(super) fn new(objects: DepthImage, camera: Arc<Camera>, surface: &SurfaceCheck) -> Self {
        let Confirmation { mask, shares } = surface.confirm(&objects);
        Self { objects, camera, version: surface.version, mask, shares }
    }

    /// The pixels that may be lit.
    pub(super) fn mask(&self) -> Option<Arc<LightMask>> {
        self.mask.clone()
    }

    /// The memory of the depths, for the next frame.
    pub(super) fn into_memory(self) -> DepthImage {
        self.objects
    }
}

/// The last check of a camera's light.
#[derive(Default)]
pub(super) struct LastCheck {
    checked: Option<CheckedLight>,
    /// `true` if the projector has moved since: it is for the next frame of the scene only, which is checked itself.
    has_moved: bool,
}

impl LastCheck {
    /// Takes the check of a new frame. Returns the depths of the one before, for their memory.
    pub(super) fn set(&mut self, checked: CheckedLight) -> DepthImage {
        self.has_moved = false;
        self.checked.replace(checked).map(CheckedLight::into_memory).unwrap_or_default()
    }

    /// Compares again if another depth image has arrived. Without a surface nothing is confirmed.
    pub(super) fn update(&mut self, camera: &Camera, surface: Option<&SurfaceCheck>) {
        let (Some(surface), Some(checked)) = (surface, self.checked.as_mut()) else {
            self.checked = None;
            return;
        };
        self.has_moved = *checked.camera != *camera;
        if checked.version != surface.version {
            let Confirmation { mask, shares } = surface.confirm(&checked.objects);
            (checked.version, checked.shares) = (surface.version, shares);
            // An equal one keeps the image.
            if checked.mask != mask {
                checked.mask = mask;
            }
        }
    }

    /// `true` if there is one.
    pub(super) fn is_some(&self) -> bool {
        self.checked.is_some()
    }

    /// `true` if it holds for what was drawn before, and for other contents.
    pub(super) fn is_of_present_pose(&self) -> bool {
        !self.has_moved
    }

    /// The shares of the light, for statuses.
    pub(super) fn shares(&self) -> Option<&Shares> {
        self.checked.as_ref().map(|checked| &checked.shares)
    }

    /// The grant with the light that was confirmed last, if it must be confirmed.
    pub(super) fn confirm(&self, content: Content, grant: Grant) -> Grant {
        let is_valid = content == Content::Scene || self.is_of_present_pose();
        grant.confirm(self.checked.as_ref().filter(|_| is_valid).and_then(CheckedLight::mask))
    }
}
