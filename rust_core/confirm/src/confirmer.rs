//! Confirms the light of one camera.

use std::sync::Arc;
use std::time::Duration;

use nalgebra::Isometry3;
use rcs_render::LightMask;
use rcs_scene::Camera;

use crate::{ConfirmSettings, PointGrid};

/// Depths of what the listed displays light in an image that is about to be shown.
#[derive(Clone, Copy, Debug)]
pub struct ObjectDepths<'a> {
    /// Width and height of the finished image: after lens and flip, before its orientation.
    pub size_px: [u32; 2],
    /// Metres along the optical axis for each pixel, row by row; NaN where no listed display lights.
    pub depths_m: &'a [f32],
    /// A pixel without depth stays dark.
    pub is_strict: bool,
}

/// Light that is confirmed.
#[derive(Clone, Debug)]
pub struct Confirmation {
    /// 255 where light is allowed, 0 where it is not; of the image's size. `None` for an image without pixels.
    pub mask: Option<Arc<LightMask>>,
    /// Shares of the pixels that the listed displays light.
    pub shares: Shares,
}

/// Shares of the pixels that the listed displays light, 0 to 1; all 0 if they light none. A pixel counts by what the
/// surface says, whether or not its light is still held back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shares {
    /// The surface is at the object's depth.
    pub confirmed: f64,
    /// A surface is nearer than the object.
    pub blocked: f64,
    /// The surface is farther than the object.
    pub gone: f64,
    /// No surface was measured there.
    pub unseen: f64,
}

/// Confirms a camera's light by measured surfaces. One for each camera.
#[derive(Debug)]
pub struct Confirmer {
    settings: ConfirmSettings,
}

impl Confirmer {
    /// A confirmer that knows no surface yet: all light of listed displays is dark.
    pub fn new(settings: ConfirmSettings) -> Self {
        Self { settings }
    }

    /// Takes a depth image: the closed surface as seen from the projector. `camera` is the projector's exact camera
    /// with lens and flip; its pose plays no part. `projector_from_sensor` maps the grid's points to the projector's
    /// optical frame at the depth image's stamp.
    pub fn observe(&mut self, camera: &Camera, projector_from_sensor: &Isometry3<f64>, grid: &PointGrid) {
        let _ = (camera, projector_from_sensor, grid, &self.settings);
    }

    /// Forgets the surface because it is stale: all light of listed displays is dark until the next one.
    pub fn forget(&mut self) {}

    /// Compares the depths of the image that is to be shown with the surface. `now` is monotonic.
    pub fn confirm(&mut self, objects: &ObjectDepths<'_>, now: Duration) -> Confirmation {
        let _ = now;
        let level = |depth: &f32| if depth.is_nan() && !objects.is_strict { 255 } else { 0 };
        let levels: Vec<u8> = objects.depths_m.iter().map(level).collect();
        let is_any = objects.depths_m.iter().any(|depth| !depth.is_nan());
        Confirmation {
            mask: LightMask::new(objects.size_px, levels).map(Arc::new),
            shares: Shares { unseen: f64::from(u8::from(is_any)), ..Shares::default() },
        }
    }
}
