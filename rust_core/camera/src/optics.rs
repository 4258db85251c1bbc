//! Intrinsics to draw with, and the lens behind them, of a CameraInfo.

use std::sync::Arc;

use nalgebra::Isometry3;
use rcs_scene::{require_finite, Camera, CameraError, Flip, Intrinsics, PixelMap};

use crate::through_lens::{is_distorted, Lenses};
use crate::CameraInfoFields;

/// Projection of a CameraInfo's P.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Projection {
    /// As rviz's CameraPub draws: one focal length for both axes, `P[7]` upwards. Exact if fx = fy > 0, P[7] = 0,
    /// there is no skew and P[10] = 1
    #[default]
    Rviz,
    /// As P says, to the pixel: for a projector
    Exact,
}

/// Camera model of a CameraInfo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CameraModel {
    /// Projection of its P.
    pub projection: Projection,
    /// `true` if the image is warped so that the lens of K and D undoes it, where there is distortion. P is taken
    /// [exactly](Projection::Exact) then.
    pub undistort: bool,
}

impl From<Projection> for CameraModel {
    fn from(projection: Projection) -> Self {
        Self { projection, undistort: false }
    }
}

/// A camera without its pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Optics {
    /// Intrinsics of the drawn image; with a lens, that is the source of the image.
    pub drawn: Intrinsics,
    /// Map from the drawn image to the image.
    pub lens: Option<Arc<PixelMap>>,
    /// Flip of the finished image, where the CameraInfo describes a mirrored one.
    pub flip: Flip,
}

impl Optics {
    /// The camera at a pose of its optical frame, see [`Camera::new`].
    pub fn camera(self, fixed_from_optical: &Isometry3<f64>, near_m: f64) -> Camera {
        let camera = Camera::new(self.drawn, fixed_from_optical, near_m).with_flip(self.flip);
        match self.lens {
            Some(lens) => camera.with_lens(lens),
            None => camera,
        }
    }
}

/// Checks a CameraInfo and returns its camera. An invalid lens is no error: the image is drawn without it, and
/// [`Lenses::problem`] returns the reason. `topic` is the key of the CameraInfo's lens in `lenses`.
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
    let through_lens = match model.undistort && is_distorted(info) {
        true => lenses.of(topic, info)?.ok(),
        false => None,
    };
    let (size, p) = ([info.width_px, info.height_px], info.p);
    Ok(match (through_lens, model.projection) {
        (Some(lens), _) => Optics { drawn: lens.intrinsics, lens: Some(lens.map), flip: lens.flip },
        (None, Projection::Rviz) => {
            let drawn = Intrinsics::from_p(size[0], size[1], p)?.as_rviz_draws();
            Optics { drawn, lens: None, flip: Flip::NONE }
        }
        (None, Projection::Exact) => {
            let (drawn, flip) = Intrinsics::exactly(size[0], size[1], p)?;
            Optics { drawn, lens: None, flip }
        }
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rcs_scene::{Encoding, Image, MAX_SIDE_PX};

    use super::*;

    const PROJECTOR: [f64; 12] = [100.0, 0.0, 32.0, 0.0, 0.0, 100.0, 40.0, 0.0, 0.0, 0.0, 1.0, 0.0];

    fn fields<'a>(d: &'a [f64], k: &'a [f64; 9], p: &'a [f64; 12]) -> CameraInfoFields<'a> {
        const NOT_SET: &[f64; 9] = &[0.0; 9];
        CameraInfoFields {
            width_px: 64,
            height_px: 48,
            distortion_model: "plumb_bob",
            d,
            k,
            r: NOT_SET,
            p,
            binning: [0; 2],
            region_px: [0; 4],
        }
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
        assert!(lenses.problem("/p").unwrap().to_string().starts_with("K: its last row is [0.0, 0.0, 0.0]"));
        let k = [100.0, 0.0, 32.0, 0.0, 100.0, 40.0, 0.0, 0.0, 1.0];
        let bent = optics(&fields(&[0.1, 0.0, 0.0, 0.0], &k, &PROJECTOR), "/p", model, &lenses).unwrap();
        assert!(bent.lens.is_some_and(|lens| lens.size_px() == [64, 48]) && lenses.problem("/p").is_none());
    }

    #[test]
    fn only_rvizs_projection_draws_a_third_row_that_is_no_scale() {
        let mut p = PROJECTOR;
        p[10] = 0.0;
        let k = [100.0, 0.0, 32.0, 0.0, 100.0, 40.0, 0.0, 0.0, 1.0];
        let drawn = |projection, undistort| {
            let model = CameraModel { projection, undistort };
            optics(&fields(&[0.1, 0.0, 0.0, 0.0], &k, &p), "", model, &Lenses::default())
        };
        assert!(drawn(Projection::Rviz, false).is_ok());
        for refused in [drawn(Projection::Exact, false), drawn(Projection::Rviz, true), drawn(Projection::Exact, true)]
        {
            assert_eq!(refused.unwrap_err(), CameraError::ThirdRow([0.0; 4]));
        }
    }

    #[test]
    fn a_mirror_of_k_is_the_images_and_one_of_p_that_of_what_nobody_sees() {
        let model = CameraModel { projection: Projection::Rviz, undistort: true };
        let k = [100.0, 2.0, 30.0, 0.0, 100.0, 40.0, 0.0, 0.0, 1.0];
        let d = [0.1, 0.0, 0.002, 0.0];
        let of = |k: &[f64; 9], p: &[f64; 12]| optics(&fields(&d, k, p), "", model, &Lenses::default()).unwrap();
        let straight = of(&k, &PROJECTOR);
        // P's first row mirrored: its principal point is at column 63 - 32.
        let mut mirrored_p = PROJECTOR;
        (mirrored_p[0], mirrored_p[2]) = (-100.0, 31.0);
        assert_eq!(of(&k, &mirrored_p), straight);
        let mirrored_k = [-100.0, -2.0, 33.0, 0.0, 100.0, 40.0, 0.0, 0.0, 1.0];
        let flip = Flip { is_left_right: true, is_up_down: false };
        assert_eq!(of(&mirrored_k, &mirrored_p), Optics { flip, ..straight.clone() });
        let turned_k = [-100.0, -2.0, 33.0, 0.0, -100.0, 7.0, 0.0, 0.0, 1.0];
        let flip = Flip { is_left_right: true, is_up_down: true };
        assert_eq!(of(&turned_k, &PROJECTOR), Optics { flip, ..straight.clone() });
        // K counts up to scale.
        assert_eq!(of(&k.map(|value| value * 2.0), &PROJECTOR), straight);
    }

    /// Numbers as a CameraInfo has them, and some that none should have.
    fn numbers() -> impl Strategy<Value = f64> {
        prop_oneof![6 => -200.0..200.0, 2 => -1.0..1.0, 1 => Just(0.0), 1 => any::<f64>()]
    }

    proptest! {
        #[test]
        fn whatever_a_camera_info_holds_what_is_drawn_becomes_a_image(
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
            if let Ok(Optics { drawn, lens, .. }) = optics(&info, "", model, &Lenses::default()) {
                prop_assert!(drawn.width_px <= MAX_SIDE_PX && drawn.height_px <= MAX_SIDE_PX);
                if let Some(lens) = lens {
                    prop_assert_eq!(lens.source_size_px(), [drawn.width_px, drawn.height_px]);
                    let (mut source, mut image) = (Image::default(), Image::default());
                    source.reset(drawn.width_px, drawn.height_px, Encoding::Rgba8);
                    crate::see_through(&lens, &source, [0; 3], Encoding::Mono8, &mut image);
                    prop_assert_eq!(image.data, vec![0; 64 * 48]);
                }
            }
        }
    }
}
