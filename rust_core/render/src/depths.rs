//! Depths of an image: which are wanted, and the way from a depth buffer's steps to metres.

use rcs_camera::{see_depth_through, see_through};
use rcs_scene::{Camera, DepthImage, DisplayMask, Encoding, Flip, Image, PixelMap, FAR_CLIP_M};

/// The depth of the far plane, which a depth buffer is cleared to: the largest of 24 bits.
pub(crate) const FARTHEST: f32 = ((1 << 24) - 1) as f32;

/// Depths that are wanted beside an image; none by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct DepthRequest<'a> {
    /// True for [`Depths::opaque`].
    pub opaque: bool,
    /// The displays of [`Depths::objects`], where these are wanted.
    pub objects_of: Option<&'a DisplayMask>,
}

/// Metres along the optical axis of what an image shows. Depths that were not wanted have no pixels.
#[derive(Clone, Debug, Default)]
pub struct Depths {
    /// The first surface that hides what is behind it, of any display, as a depth camera sees it. Translucent faces and
    /// text do not count.
    pub opaque: DepthImage,
    /// Depths that the displays of [`DepthRequest::objects_of`] light, translucent and text included: the fragment of
    /// theirs that was drawn last. NaN where they light nothing, as where an opaque fragment of another display is in
    /// front. A translucent one of another display leaves the depth below it, unless its alpha is at least 254/255.
    pub objects: DepthImage,
}

/// The least alpha, of 255, with which a blended fragment counts for [`Depths::objects`].
pub(crate) const fn least_object_alpha(is_listed: bool) -> u8 {
    if is_listed {
        1
    } else {
        254
    }
}

impl DepthRequest<'_> {
    /// Which are wanted, in the order of [`Depths::each_mut`].
    pub(crate) fn wanted(&self) -> [bool; 2] {
        [self.opaque, self.objects_of.is_some()]
    }
}

impl Depths {
    /// Gives those that are wanted a size, empty.
    pub(crate) fn reset(&mut self, wanted: [bool; 2], [width_px, height_px]: [u32; 2]) {
        for (is_wanted, depth) in wanted.into_iter().zip(self.each_mut()) {
            if is_wanted {
                depth.reset(width_px, height_px);
            } else {
                depth.clear();
            }
        }
    }

    /// Both kinds.
    pub(crate) fn each_mut(&mut self) -> [&mut DepthImage; 2] {
        [&mut self.opaque, &mut self.objects]
    }
}

/// An image with its depths.
#[derive(Debug, Default)]
pub(crate) struct Drawn {
    pub(crate) image: Image,
    pub(crate) depths: Depths,
}

impl Drawn {
    /// Takes the memory of an image and of depths.
    pub(crate) fn in_memory_of(image: &mut Image, depths: &mut Depths) -> Self {
        Self { image: std::mem::take(image), depths: std::mem::take(depths) }
    }

    /// Exchanges it for what is there, whose memory it takes.
    pub(crate) fn swap(&mut self, image: &mut Image, depths: &mut Depths) {
        std::mem::swap(&mut self.image, image);
        std::mem::swap(&mut self.depths, depths);
    }

    /// Becomes what was drawn without a lens, an [`Encoding::Rgba8`] image, as the lens shows it.
    pub(crate) fn see_through(&mut self, map: &PixelMap, straight: &Self, background: [u8; 3], encoding: Encoding) {
        see_through(map, &straight.image, background, encoding, &mut self.image);
        let drawn = [&straight.depths.opaque, &straight.depths.objects];
        for (depth, drawn) in self.depths.each_mut().into_iter().zip(drawn) {
            if drawn.depths_m.is_empty() {
                depth.clear();
            } else {
                see_depth_through(map, drawn, depth);
            }
        }
    }

    /// Flips the image with its depths.
    pub(crate) fn flip(&mut self, flip: Flip) {
        flip.image(&mut self.image);
        self.depths.each_mut().into_iter().for_each(|depth| flip.depth(depth));
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
