//! The lens of a CameraInfo: between the picture that P projects and the one that the projector has to show.
//!
//! P, R, D and K together say where a point lands, as `image_geometry`'s `unrectifyPoint` does: P projects it to the
//! rectified picture; from there R, D and K lead to the raw one, which is what a projector shows or a camera takes.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::{Matrix3, Point2, Vector2};
use rcs_calibration::{Distortion, Lens};
use rcs_scene::{CameraError, Flip, Intrinsics, PixelMap};

use crate::{lens_of, CameraInfoFields, LensProblem};

/// What a picture is drawn with when its lens is to be allowed for.
#[derive(Clone, Debug)]
pub struct DrawnThroughLens {
    /// Draws the source of the map.
    pub intrinsics: Intrinsics,
    /// From what was drawn to the picture.
    pub map: Arc<PixelMap>,
    /// Flip of the picture after the map, where K has negative focal lengths.
    pub flip: Flip,
}

/// Why the lens of a CameraInfo cannot be allowed for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoLens {
    /// K or D are not those of a lens.
    #[error("{0}")]
    Unknown(#[from] LensProblem),
    /// R is no rotation.
    #[error("R is not a rotation")]
    NoRotation,
    /// No pixel of the picture looks anywhere near what P projects.
    #[error("K and D lead outside of what P projects")]
    Outside,
}

/// Whether a CameraInfo has distortion.
pub fn is_distorted(info: &CameraInfoFields<'_>) -> bool {
    Distortion::bends(info.distortion_model, info.d)
}

/// The drawing for a CameraInfo's lens, by what its P [means](Intrinsics::exactly), without a mirror.
///
/// A mirror of P is that of a picture which nobody sees; one of K is that of the picture that comes out.
///
/// # Errors
/// See [`NoLens`].
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

/// The lens whose flipped picture is this one's, with positive focal lengths.
fn without_mirror(lens: Lens) -> (Lens, Flip) {
    let flip = Flip { is_left_right: lens.focal_px.x < 0.0, is_up_down: lens.focal_px.y < 0.0 };
    let signs = lens.focal_px.map(f64::signum);
    let center_px = flip.pixel(lens.size_px, lens.center_px.into()).into();
    let (focal_px, skew_px): (Vector2<_>, Vector2<_>) =
        (lens.focal_px.component_mul(&signs), lens.skew_px.component_mul(&signs));
    (Lens { focal_px, skew_px, center_px, ..lens }, flip)
}

/// R, which turns what the lens sees into what P projects; the identity where it is not set.
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

/// Where P projects what a raw pixel shows; none for what no light of that pixel goes to, or that is beside the view.
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

/// A lens, or why there is none, and the fields that it was made of.
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

/// The lenses of the CameraInfos that were received last, by topic. A lens takes some hundredths of a second, so that
/// it is made again only when its CameraInfo changes.
#[derive(Debug, Default)]
pub struct Lenses {
    known: RefCell<HashMap<String, KnownLens>>,
}

impl Lenses {
    /// The drawing for the lens of a topic's CameraInfo.
    ///
    /// # Errors
    /// What is wrong with P. What is wrong with the lens is in the result: then it is drawn without one.
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

    /// What is wrong with a topic's lens, if it was asked for.
    pub fn problem(&self, topic: &str) -> Option<NoLens> {
        self.known.borrow().get(topic).and_then(|known| known.lens.as_ref().err().cloned())
    }

    /// Forgets the lenses of other topics than these.
    pub fn keep(&self, is_kept: impl Fn(&str) -> bool) {
        self.known.borrow_mut().retain(|topic, _| is_kept(topic));
    }
}
