//! From the depths of bands to metres.

use rcs_scene::{Camera, DepthPicture, FAR_CLIP_M};

use super::screen::FARTHEST;

/// The depths of a picture, if they are wanted.
pub(in crate::cpu) struct Depths<'a> {
    depth: Option<&'a mut DepthPicture>,
    to_metres: ToMetres,
}

/// The camera's depths in metres.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct ToMetres {
    near_m: f32,
    /// Metres for each step of the depth.
    step_m: f32,
}

impl<'a> Depths<'a> {
    /// The depths of a picture of this camera, cleared.
    pub(in crate::cpu) fn new(camera: &Camera, mut depth: Option<&'a mut DepthPicture>) -> Self {
        if let Some(depth) = &mut depth {
            depth.reset(camera.width_px(), camera.height_px());
        }
        let near_m = camera.near_m();
        let to_metres =
            ToMetres { near_m: near_m as f32, step_m: ((FAR_CLIP_M - near_m) / f64::from(FARTHEST)) as f32 };
        Self { depth, to_metres }
    }

    /// From depths to metres.
    pub(in crate::cpu) fn to_metres(&self) -> ToMetres {
        self.to_metres
    }

    /// The depths band by band, of so many pixels each; none where they are not wanted, without end.
    pub(in crate::cpu) fn into_bands(self, pixels: usize) -> impl Iterator<Item = Option<&'a mut [f32]>> {
        let wanted = self.depth.into_iter().flat_map(move |depth| depth.depths_m.chunks_mut(pixels.max(1)));
        wanted.map(Some).chain(std::iter::repeat_with(|| None))
    }
}

impl ToMetres {
    /// Writes rows of depths as metres; what is at the far plane is nowhere.
    pub(in crate::cpu) fn write<'d>(self, rows: impl Iterator<Item = &'d [f32]>, width: usize, metres: &mut [f32]) {
        for (row, metres) in rows.zip(metres.chunks_mut(width.max(1))) {
            for (depth, metres) in row.iter().zip(metres) {
                // Exact, as both are whole numbers; the depth itself divided by the farthest would not be.
                let left = FARTHEST - depth;
                *metres = if left > 0.0 {
                    self.near_m * FAR_CLIP_M as f32 / (self.near_m + left * self.step_m)
                } else {
                    f32::NAN
                };
            }
        }
    }
}
