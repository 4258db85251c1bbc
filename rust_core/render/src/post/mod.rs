//! The last step of an image: everything that is done to it after it was drawn and seen through the lens.
//!
//! ```text
//! drawn image ─► blend weights, black lift ─► light masks, keep-out ─► orientation ─► outputs
//! ```
//!
//! It works on the finished bytes, whatever renderer drew them and in every encoding. What forbids light comes after
//! what may add some. Rows are altered in parallel and in place; only a change of orientation needs a second image.
//! With nothing to do, nothing is touched.

mod blend;
mod brightness;
mod factors;
mod keep_out;
mod light_mask;
mod orientation;

use std::sync::Arc;

use rayon::prelude::*;
use rcs_scene::Image;

pub use self::blend::{Blend, BlendError};
pub use self::brightness::Brightness;
use self::factors::{scale_row, ONE};
pub use self::keep_out::{KeepOut, Sphere};
pub use self::light_mask::LightMask;
pub use self::orientation::Orientation;

/// Post-processing of a finished image.
///
/// ```
/// use rcs_render::{PostProcess, Orientation};
/// use rcs_scene::{Encoding, Image};
///
/// let mut image = Image::default();
/// image.reset(3, 1, Encoding::Mono8);
/// image.data = vec![1, 2, 3];
/// let step = PostProcess { orientation: "90".parse()?, ..PostProcess::default() };
/// step.apply(&mut image, &mut Image::default());
/// assert_eq!(((image.width_px, image.height_px), image.data), ((1, 3), vec![1, 2, 3]));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PostProcess {
    /// The share that this projector has of the light where several overlap.
    pub blend: Option<Arc<Blend>>,
    /// Pixels by which the projector may light its surface at all.
    pub painted_mask: Option<Arc<LightMask>>,
    /// Pixels that may be lit at present, by each of several masks: the darkest counts.
    pub masks: Vec<Arc<LightMask>>,
    /// Directions that must not be lit because of something in space.
    pub keep_out: Option<KeepOut>,
    /// Pixels whose light a measured surface confirms at present.
    pub confirmed: Option<Arc<LightMask>>,
    /// How the image is turned.
    pub orientation: Orientation,
}

impl PostProcess {
    /// True if images stay as they are.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }

    /// Does it to an image; `spare` is memory, and has the image's own of before afterwards if that was turned.
    pub fn apply(&self, image: &mut Image, spare: &mut Image) {
        self.dim(image);
        if self.orientation != Orientation::default() {
            self.orientation.turn(image, spare);
            std::mem::swap(image, spare);
        }
    }

    /// Takes away, and lifts, light.
    fn dim(&self, image: &mut Image) {
        let size_px = [image.width_px, image.height_px];
        let (width, step, encoding) = (image.width_px as usize, image.step(), image.encoding);
        let masks = [&self.painted_mask, &self.confirmed].into_iter().flatten().chain(&self.masks);
        let masks: Vec<&LightMask> = masks.map(Arc::as_ref).collect();
        let forbids_light = !masks.is_empty() || self.keep_out.is_some();
        if step == 0 || (self.blend.is_none() && !forbids_light) {
            return;
        }
        let rows = image.data.par_chunks_mut(step).enumerate();
        rows.for_each_init(
            || vec![ONE; width],
            |factors, (row, bytes)| {
                if let Some(blend) = &self.blend {
                    blend.apply(size_px, row, encoding, factors, bytes);
                }
                if !forbids_light {
                    return;
                }
                factors.fill(ONE);
                masks.iter().for_each(|mask| mask.write(size_px, row, factors));
                if let Some(keep_out) = &self.keep_out {
                    keep_out.write(row, factors);
                }
                scale_row(encoding, factors, bytes);
            },
        );
    }
}

#[cfg(test)]
mod tests;
