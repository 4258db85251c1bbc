//! From a CameraInfo to what is drawn: the intrinsics, and the lens behind them.

use std::sync::Arc;

use nalgebra::Isometry3;
use rcs_scene::{require_finite, Camera, CameraError, Intrinsics, PixelMap};

use crate::through_lens::{is_distorted, Lenses};
use crate::CameraInfoFields;

/// How a CameraInfo's P becomes a projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Projection {
    /// As rviz's CameraPub draws: one focal length for both axes, `P[7]` upwards. Exact if fx = fy and P[7] = 0
    #[default]
    Rviz,
    /// As P says, to the pixel: for a projector
    Exact,
}

/// How a CameraInfo becomes a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CameraModel {
    /// How its P becomes a projection.
    pub projection: Projection,
    /// Where it has a distortion, the picture is bent so that it is right after the lens of K and D. P is taken
    /// [exactly](Projection::Exact) then.
    pub undistort: bool,
}

impl From<Projection> for CameraModel {
    fn from(projection: Projection) -> Self {
        Self { projection, undistort: false }
    }
}

/// What a camera draws, wherever it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Optics {
    /// Those of what is drawn; with a lens, that is the source of its picture.
    pub drawn: Intrinsics,
    /// Between what is drawn and the picture.
    pub lens: Option<Arc<PixelMap>>,
}

impl Optics {
    /// The camera at a pose of its optical frame, see [`Camera::new`].
    pub fn camera(self, fixed_from_optical: &Isometry3<f64>, near_m: f64) -> Camera {
        let camera = Camera::new(self.drawn, fixed_from_optical, near_m);
        match self.lens {
            Some(lens) => camera.with_lens(lens),
            None => camera,
        }
    }
}

/// Checks a CameraInfo and says what is drawn for it. What is wrong with a lens is no error: the picture is drawn
/// without it, and [`Lenses::problem`] tells. `topic` is what `lenses` knows the CameraInfo's lens by.
///
/// # Errors
/// The first field that makes drawing impossible.
pub fn optics(
    info: &CameraInfoFields<'_>,
    topic: &str,
    model: CameraModel,
    lenses: &Lenses,
) -> Result<Optics, CameraError> {
    for (field, values) in [("D", info.d), ("K", &info.k[..]), ("R", &info.r[..])] {
        require_finite(field, values)?;
    }
    let intrinsics = Intrinsics::from_p(info.width_px, info.height_px, info.p)?;
    let through_lens = match model.undistort && is_distorted(info) {
        true => lenses.of(topic, info, &intrinsics).ok(),
        false => None,
    };
    Ok(match (through_lens, model.projection) {
        (Some(lens), _) => Optics { drawn: lens.intrinsics, lens: Some(lens.map) },
        (None, Projection::Rviz) => Optics { drawn: intrinsics.as_rviz_draws(), lens: None },
        (None, Projection::Exact) => Optics { drawn: intrinsics.as_p_means(), lens: None },
    })
}

/// Whether rviz's projection of this CameraInfo differs from what P says by more than half a pixel.
///
/// ```
/// use rcs_camera::{rviz_differs, CameraInfoFields};
///
/// // With one focal length and no P[7], both draw the same picture.
/// let mut p = [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// let (none, size) = ([0.0; 9], [1280, 800]);
/// let differs = |p: &[f64; 12]| {
///     let [width_px, height_px] = size;
///     rviz_differs(&CameraInfoFields { width_px, height_px, distortion_model: "", d: &[], k: &none, r: &none, p })
/// };
/// assert!(!differs(&p));
/// p[5] = 2000.0;
/// assert!(differs(&p));
/// ```
pub fn rviz_differs(info: &CameraInfoFields<'_>) -> bool {
    Intrinsics::from_p(info.width_px, info.height_px, info.p).is_ok_and(|intrinsics| !intrinsics.rviz_is_exact())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rcs_scene::{Encoding, Picture, MAX_SIDE_PX};

    use super::*;

    const PROJECTOR: [f64; 12] = [100.0, 0.0, 32.0, 0.0, 0.0, 100.0, 40.0, 0.0, 0.0, 0.0, 1.0, 0.0];

    fn fields<'a>(d: &'a [f64], k: &'a [f64; 9], p: &'a [f64; 12]) -> CameraInfoFields<'a> {
        const NOT_SET: &[f64; 9] = &[0.0; 9];
        CameraInfoFields { width_px: 64, height_px: 48, distortion_model: "plumb_bob", d, k, r: NOT_SET, p }
    }

    #[test]
    fn the_first_field_that_is_no_number_is_named() {
        let k = [100.0, 0.0, 32.0, 0.0, 100.0, 40.0, 0.0, 0.0, 1.0];
        let lenses = Lenses::default();
        let problem = |info: &CameraInfoFields<'_>| {
            optics(info, "", CameraModel::default(), &lenses).err().map(|error| error.to_string())
        };
        assert_eq!(problem(&fields(&[0.1], &k, &PROJECTOR)), None);
        assert_eq!(problem(&fields(&[0.1, f64::NAN], &k, &PROJECTOR)).unwrap(), "D[1] is NaN, not a finite number");
        assert_eq!(problem(&fields(&[], &[f64::INFINITY; 9], &PROJECTOR)).unwrap(), "K[0] is inf, not a finite number");
        let empty = CameraInfoFields { width_px: 0, ..fields(&[], &k, &PROJECTOR) };
        assert_eq!(problem(&empty).unwrap(), "width is 0");
    }

    #[test]
    fn a_lens_that_cannot_be_allowed_for_leaves_the_projection_and_is_told() {
        let (lenses, model) = (Lenses::default(), CameraModel { projection: Projection::Rviz, undistort: true });
        let straight = optics(&fields(&[0.1, 0.0, 0.0, 0.0], &[0.0; 9], &PROJECTOR), "/p", model, &lenses).unwrap();
        assert_eq!((straight.lens, straight.drawn.width_px), (None, 64));
        assert!(lenses.problem("/p").unwrap().to_string().starts_with("K: the focal lengths (fx 0"));
        let k = [100.0, 0.0, 32.0, 0.0, 100.0, 40.0, 0.0, 0.0, 1.0];
        let bent = optics(&fields(&[0.1, 0.0, 0.0, 0.0], &k, &PROJECTOR), "/p", model, &lenses).unwrap();
        assert!(bent.lens.is_some_and(|lens| lens.size_px() == [64, 48]) && lenses.problem("/p").is_none());
    }

    /// Numbers as a CameraInfo has them, and some that none should have.
    fn numbers() -> impl Strategy<Value = f64> {
        prop_oneof![6 => -200.0..200.0, 2 => -1.0..1.0, 1 => Just(0.0), 1 => any::<f64>()]
    }

    proptest! {
        #[test]
        fn whatever_a_camera_info_holds_what_is_drawn_becomes_a_picture(
            d in proptest::collection::vec(prop_oneof![9 => -0.5..0.5, 1 => any::<f64>()], 0..6),
            k in proptest::array::uniform9(numbers()),
            p in proptest::array::uniform12(numbers()),
            is_usual in any::<bool>(),
            undistort in any::<bool>(),
        ) {
            let [fx, _, cx, _, fy, cy, ..] = k;
            let usual = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
            let info = fields(&d, if is_usual { &usual } else { &k }, &p);
            let model = CameraModel { projection: Projection::Exact, undistort };
            if let Ok(Optics { drawn, lens }) = optics(&info, "", model, &Lenses::default()) {
                prop_assert!(drawn.width_px <= MAX_SIDE_PX && drawn.height_px <= MAX_SIDE_PX);
                if let Some(lens) = lens {
                    prop_assert_eq!(lens.source_size_px(), [drawn.width_px, drawn.height_px]);
                    let (mut source, mut picture) = (Picture::default(), Picture::default());
                    source.reset(drawn.width_px, drawn.height_px, Encoding::Rgba8);
                    crate::see_through(&lens, &source, [0; 3], Encoding::Mono8, &mut picture);
                    prop_assert_eq!(picture.data, vec![0; 64 * 48]);
                }
            }
        }
    }
}
