//! The lens of a CameraInfo: map from the rectified image of P to the raw one that the projector shows.
//!
//! A point is projected as by `image_geometry`'s `unrectifyPoint`: by P to the rectified image, and from there by R,
//! D and K to the raw one, which a projector shows or a camera takes.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::{Matrix3, Point2, Vector2};
use rcs_calibration::{Distortion, Lens};
use rcs_scene::{CameraError, Flip, Intrinsics, PixelMap};

use crate::{lens_of, CameraInfoFields, LensProblem};

/// Camera of an image whose distortion is undone.
#[derive(Clone, Debug)]
pub struct DrawnThroughLens {
    /// Intrinsics of the map's source.
    pub intrinsics: Intrinsics,
    /// Map from the drawn image to the image.
    pub map: Arc<PixelMap>,
    /// Flip of the image after the map, where K has negative focal lengths.
    pub flip: Flip,
}

/// Reason why the distortion of a CameraInfo cannot be undone.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoLens {
    /// K or D are invalid.
    #[error("{0}")]
    Unknown(#[from] LensProblem),
    /// R is no rotation.
    #[error("R is not a rotation")]
    NoRotation,
    /// No pixel of the image is near the view of P.
    #[error("no pixel of K and D is in the view of P")]
    Outside,
}

/// `true` if a CameraInfo has distortion.
pub fn is_distorted(info: &CameraInfoFields<'_>) -> bool {
    Distortion::bends(info.distortion_model, info.d)
}

/// The camera for a CameraInfo's lens, by its P [exactly](Intrinsics::exactly), without a mirror: one of P concerns the
/// rectified image, which nobody sees; one of K the image that comes out.
fn drawn_through_lens(info: &CameraInfoFields<'_>, p: &Intrinsics) -> Result<DrawnThroughLens, NoLens> {
    let (lens, flip) = without_mirror(lens_of(info)?);
    let rectified_from_raw = rectification(info)?;
    let map = PixelMap::new(lens.size_px, |pixel| rectified_pixel(&lens, &rectified_from_raw, p, pixel));
    let map = map.ok_or(NoLens::Outside)?;
    let ([left, top], [width_px, height_px]) = (map.source_origin_px(), map.source_size_px());
    let (cx_px, cy_px) = (p.cx_px - f64::from(left), p.cy_px - f64::from(top));
    let intrinsics = Intrinsics { width_px, height_px, cx_px, cy_px, ..*p };
    Ok(DrawnThroughLens { intrinsics, map: Arc::new(map), flip })
}

/// The lens with positive focal lengths whose flipped image is this one's.
fn without_mirror(lens: Lens) -> (Lens, Flip) {
    let flip = Flip { is_left_right: lens.focal_px.x < 0.0, is_up_down: lens.focal_px.y < 0.0 };
    let signs = lens.focal_px.map(f64::signum);
    let center_px = flip.pixel(lens.size_px, lens.center_px.into()).into();
    let (focal_px, skew_px): (Vector2<_>, Vector2<_>) =
        (lens.focal_px.component_mul(&signs), lens.skew_px.component_mul(&signs));
    (Lens { focal_px, skew_px, center_px, ..lens }, flip)
}

/// R, the rotation from the raw frame to that of P; the identity where it is not set.
///
/// # Errors
/// [`NoLens::NoRotation`].
pub fn rectification(info: &CameraInfoFields<'_>) -> Result<Matrix3<f64>, NoLens> {
    const TOLERANCE: f64 = 1e-3;
    if info.r.iter().all(|number| *number == 0.0) {
        return Ok(Matrix3::identity());
    }
    let rotation = Matrix3::from_row_slice(info.r);
    let is_rotation = (rotation * rotation.transpose() - Matrix3::identity()).norm() < TOLERANCE;
    if is_rotation && rotation.determinant() > 0.0 {
        Ok(rotation)
    } else {
        Err(NoLens::NoRotation)
    }
}

/// Place in the rectified image of a raw pixel; `None` outside of the view.
fn rectified_pixel(
    lens: &Lens,
    rectified_from_raw: &Matrix3<f64>,
    p: &Intrinsics,
    [u, v]: [f64; 2],
) -> Option<[f64; 2]> {
    let direction = rectified_from_raw * lens.ray(Point2::new(u, v))?;
    // The map counts from a pixel's centre, what is drawn from its edge.
    (direction.z > 0.0)
        .then(|| p.place([direction.x / direction.z, direction.y / direction.z]).map(|place| place - 0.5))
}

/// A lens, or the reason why there is none, and the fields that it was made of.
#[derive(Debug)]
struct KnownLens {
    size_px: [u32; 2],
    distortion_model: String,
    d: Vec<f64>,
    k: [f64; 9],
    r: [f64; 9],
    p: [f64; 12],
    lens: Result<DrawnThroughLens, NoLens>,
}

impl KnownLens {
    fn new(info: &CameraInfoFields<'_>, p: &Intrinsics) -> Self {
        let CameraInfoFields { width_px, height_px, distortion_model, d, .. } = *info;
        Self {
            size_px: [width_px, height_px],
            distortion_model: distortion_model.to_owned(),
            d: d.to_vec(),
            k: *info.k,
            r: *info.r,
            p: *info.p,
            lens: drawn_through_lens(info, p),
        }
    }

    fn is_of(&self, info: &CameraInfoFields<'_>) -> bool {
        let Self { size_px: [width_px, height_px], distortion_model, d, k, r, p, .. } = self;
        *info == CameraInfoFields { width_px: *width_px, height_px: *height_px, distortion_model, d, k, r, p, ..*info }
    }
}

/// Cache of the lenses of the last CameraInfos, by topic: making one takes some hundredths of a second.
#[derive(Debug, Default)]
pub struct Lenses {
    known: RefCell<HashMap<String, KnownLens>>,
}

impl Lenses {
    /// The camera for the lens of a topic's CameraInfo, or the reason why it has to be drawn without one.
    ///
    /// # Errors
    /// P is invalid.
    pub fn of(
        &self,
        topic: &str,
        info: &CameraInfoFields<'_>,
    ) -> Result<Result<DrawnThroughLens, NoLens>, CameraError> {
        let (p, _) = Intrinsics::exactly(info.width_px, info.height_px, info.p)?;
        let mut known = self.known.borrow_mut();
        if let Some(known) = known.get(topic).filter(|known| known.is_of(info)) {
            return Ok(known.lens.clone());
        }
        let new = KnownLens::new(info, &p);
        let lens = new.lens.clone();
        known.insert(topic.to_owned(), new);
        Ok(lens)
    }

    /// The problem of a topic's lens, if it was asked for.
    pub fn problem(&self, topic: &str) -> Option<NoLens> {
        self.known.borrow().get(topic).and_then(|known| known.lens.as_ref().err().cloned())
    }

    /// Removes the lenses of other topics than these.
    pub fn keep(&self, is_kept: impl Fn(&str) -> bool) {
        self.known.borrow_mut().retain(|topic, _| is_kept(topic));
    }
}
