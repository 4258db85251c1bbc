//! Depths of a picture: which are wanted, and the way from a depth buffer's steps to metres.

use rcs_camera::see_depth_through;
use rcs_scene::{Camera, DepthPicture, DisplayMask, Flip, PixelMap, FAR_CLIP_M};

/// The depth of the far plane, which a depth buffer is cleared to: the largest of 24 bits.
pub(crate) const FARTHEST: f32 = ((1 << 24) - 1) as f32;

/// Depths that are wanted beside a picture; none by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct DepthRequest<'a> {
    /// True for [`Depths::opaque`].
    pub opaque: bool,
    /// The displays of [`Depths::objects`], where these are wanted.
    pub objects_of: Option<&'a DisplayMask>,
}

/// Metres along the optical axis of what a picture shows. Depths that were not wanted have no pixels.
#[derive(Clone, Debug, Default)]
pub struct Depths {
    /// The first surface that hides what is behind it, of any display, as a depth camera sees it. Translucent faces and
    /// text do not count.
    pub opaque: DepthPicture,
    /// What the displays of [`DepthRequest::objects_of`] light, by translucent faces and text, too: the fragment of
    /// theirs that was drawn last. NaN where they light nothing, as where an opaque fragment of another display is in
    /// front. A translucent one of another display leaves the depth below it, unless its alpha is at least 254/255.
    pub objects: DepthPicture,
}

/// The least alpha, of 255, with which a blended fragment counts for [`Depths::objects`].
pub(crate) const fn least_object_alpha(is_listed: bool) -> u8 {
    if is_listed {
        1
    } else {
        254
    }
}

impl Depths {
    /// Gives those that are wanted a size, empty.
    pub(crate) fn reset(&mut self, request: &DepthRequest<'_>, [width_px, height_px]: [u32; 2]) {
        let is_wanted = [request.opaque, request.objects_of.is_some()];
        for (is_wanted, depth) in is_wanted.into_iter().zip(self.each_mut()) {
            match is_wanted {
                true => depth.reset(width_px, height_px),
                false => depth.clear(),
            }
        }
    }

    /// The depths of a picture that were drawn without its lens, as the lens shows them.
    pub(crate) fn see_through(&mut self, map: &PixelMap, drawn: &Self) {
        for (depth, drawn) in self.each_mut().into_iter().zip([&drawn.opaque, &drawn.objects]) {
            match drawn.depths_m.is_empty() {
                true => depth.clear(),
                false => see_depth_through(map, drawn, depth),
            }
        }
    }

    /// Flips them like their picture.
    pub(crate) fn flip(&mut self, flip: Flip) {
        self.each_mut().into_iter().for_each(|depth| flip.depth(depth));
    }

    /// Both kinds.
    pub(crate) fn each_mut(&mut self) -> [&mut DepthPicture; 2] {
        [&mut self.opaque, &mut self.objects]
    }
}

/// From a camera's depth buffer to metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ToMetres {
    near_m: f32,
    /// Metres for each step of the depth.
    step_m: f32,
}

impl ToMetres {
    pub(crate) fn new(camera: &Camera) -> Self {
        let near_m = camera.near_m();
        Self { near_m: near_m as f32, step_m: ((FAR_CLIP_M - near_m) / f64::from(FARTHEST)) as f32 }
    }

    /// The metres of a depth from 0 to [`FARTHEST`]; what is at the far plane is nowhere.
    #[inline(always)]
    pub(crate) fn metres(self, depth: f32) -> f32 {
        // Exact, as both are whole numbers; the depth itself divided by the farthest would not be.
        let left = FARTHEST - depth;
        if left > 0.0 {
            self.near_m * FAR_CLIP_M as f32 / (self.near_m + left * self.step_m)
        } else {
            f32::NAN
        }
    }
}
