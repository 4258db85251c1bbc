//! The lens of a CameraInfo: between the picture that P projects and the one that the projector has to show.
//!
//! P, R, D and K together say where a point lands, as `image_geometry`'s `unrectifyPoint` does: P projects it to the
//! rectified picture; from there R, D and K lead to the raw one, which is what a projector shows or a camera takes.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::{Matrix3, Point2};
use rcs_calibration::Lens;
use rcs_files::projector::{lens_of, LensProblem};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_scene::{Intrinsics, PixelMap};

/// What a picture is drawn with when its lens is to be allowed for.
#[derive(Clone, Debug)]
pub(crate) struct DrawnThroughLens {
    /// Draws the source of the map.
    pub(crate) intrinsics: Intrinsics,
    pub(crate) map: Arc<PixelMap>,
}

/// Why the lens of a CameraInfo cannot be allowed for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum NoLens {
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
pub(crate) fn is_distorted(info: &CameraInfo) -> bool {
    info.D.iter().any(|coefficient| *coefficient != 0.0)
}

/// The drawing for a CameraInfo's lens, by the intrinsics of its P.
///
/// # Errors
/// See [`NoLens`].
fn drawn_through_lens(info: &CameraInfo, p: &Intrinsics) -> Result<DrawnThroughLens, NoLens> {
    let lens = lens_of(info)?;
    let rectified_from_raw = rectification(info)?;
    let map = PixelMap::new(lens.size_px, |pixel| rectified_pixel(&lens, &rectified_from_raw, p, pixel));
    let map = map.ok_or(NoLens::Outside)?;
    let ([left, top], [width_px, height_px]) = (map.source_origin_px(), map.source_size_px());
    let p = p.as_p_means();
    let (cx_px, cy_px) = (p.cx_px - f64::from(left), p.cy_px - f64::from(top));
    Ok(DrawnThroughLens { intrinsics: Intrinsics { width_px, height_px, cx_px, cy_px, ..p }, map: Arc::new(map) })
}

/// R, which turns what the lens sees into what P projects; the identity where it is not set.
///
/// # Errors
/// [`NoLens::NoRotation`].
pub(crate) fn rectification(info: &CameraInfo) -> Result<Matrix3<f64>, NoLens> {
    const TOLERANCE: f64 = 1e-3;
    if info.R.iter().all(|number| *number == 0.0) {
        return Ok(Matrix3::identity());
    }
    let rotation = Matrix3::from_row_slice(&info.R);
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
    (direction.z > 0.0)
        .then(|| [p.fx_px * direction.x / direction.z + p.cx_px, p.fy_px * direction.y / direction.z + p.cy_px])
}

/// A lens, or why there is none, and the CameraInfo that it was made of.
type KnownLens = (CameraInfo, Result<DrawnThroughLens, NoLens>);

/// The lenses of the CameraInfos that were received last, by topic. A lens takes some hundredths of a second, so that
/// it is made again only when its CameraInfo changes.
#[derive(Debug, Default)]
pub(crate) struct Lenses {
    known: RefCell<HashMap<String, KnownLens>>,
}

impl Lenses {
    /// The drawing for the lens of a topic's CameraInfo, whose P has these intrinsics.
    ///
    /// # Errors
    /// See [`NoLens`].
    pub(crate) fn of(&self, topic: &str, info: &CameraInfo, p: &Intrinsics) -> Result<DrawnThroughLens, NoLens> {
        let mut known = self.known.borrow_mut();
        if let Some((_, lens)) = known.get(topic).filter(|(known, _)| is_same_lens(known, info)) {
            return lens.clone();
        }
        let lens = drawn_through_lens(info, p);
        known.insert(topic.to_owned(), (info.clone(), lens.clone()));
        lens
    }

    /// What is wrong with a topic's lens, if it was asked for.
    pub(crate) fn problem(&self, topic: &str) -> Option<NoLens> {
        self.known.borrow().get(topic).and_then(|(_, lens)| lens.as_ref().err().cloned())
    }

    /// Forgets the lenses of other topics than these.
    pub(crate) fn keep(&self, is_kept: impl Fn(&str) -> bool) {
        self.known.borrow_mut().retain(|topic, _| is_kept(topic));
    }
}

fn is_same_lens(a: &CameraInfo, b: &CameraInfo) -> bool {
    (a.width, a.height, &a.distortion_model, &a.D, a.K, a.R, a.P)
        == (b.width, b.height, &b.distortion_model, &b.D, b.K, b.R, b.P)
}
