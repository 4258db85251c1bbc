//! Between a CameraInfo and the lens that calibration solves for and decoding uses.
//!
//! The lens is that of the raw picture: K and D. P and R belong to the rectified one; a file written here has none to
//! tell, so its P is K and its R the identity.

use nalgebra::{Isometry3, Point2, UnitQuaternion, Vector2};
use rcs_calibration::{Distortion, Lens};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_msgs::Header;

use super::{p_from_k, ProjectorFile, StaticFrame};

/// Why a CameraInfo describes no lens that can be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {reason}")]
pub struct LensProblem {
    /// The key of the file that is wrong.
    pub key: &'static str,
    /// What is wrong with it.
    pub reason: String,
}

/// The lens that K and D of a CameraInfo describe.
///
/// # Errors
/// [`LensProblem`]: focal lengths that are not positive, a skew, a last row of K that is not 0 0 1, a distortion that
/// no lens model has.
pub fn lens_of(info: &CameraInfo) -> Result<Lens, LensProblem> {
    let CameraInfo { width, height, distortion_model, D, K, .. } = info;
    let [fx, skew, cx, below_fx, fy, cy, last_row @ ..] = *K;
    let wrong = |key, reason| Err(LensProblem { key, reason });
    if K.iter().any(|value| !value.is_finite()) {
        return wrong("K", "not all are finite numbers".to_owned());
    }
    if fx <= 0.0 || fy <= 0.0 {
        return wrong("K", format!("the focal lengths (fx {fx}, fy {fy}) are not positive"));
    }
    if skew != 0.0 || below_fx != 0.0 {
        return wrong("K", format!("a skew ({skew}, {below_fx}) is not known to the lens model"));
    }
    if last_row != [0.0, 0.0, 1.0] {
        return wrong("K", format!("its last row is {last_row:?} where [0, 0, 1] is needed"));
    }
    let distortion = Distortion::from_message(distortion_model, D)
        .map_err(|problem| LensProblem { key: problem.key(), reason: problem.to_string() })?;
    let (focal_px, center_px) = (Vector2::new(fx, fy), Point2::new(cx, cy));
    Ok(Lens { size_px: [*width, *height], focal_px, center_px, distortion })
}

impl ProjectorFile {
    /// The optical frame that a calibrated projector's file places.
    pub const FRAME_ID: &str = "proj_view";

    /// The lens that K and D describe.
    ///
    /// # Errors
    /// Those of [`lens_of`].
    pub fn lens(&self) -> Result<Lens, LensProblem> {
        lens_of(&self.camera_info)
    }

    /// The file of a lens whose optical frame is `frame_id`: P is K, R the identity.
    pub fn from_lens(lens: &Lens, frame_id: &str) -> Self {
        let Lens { size_px: [width, height], focal_px, center_px, distortion } = *lens;
        let k = [focal_px.x, 0.0, center_px.x, 0.0, focal_px.y, center_px.y, 0.0, 0.0, 1.0];
        let camera_info = CameraInfo {
            header: Header { frame_id: frame_id.to_owned(), ..Header::default() },
            width,
            height,
            distortion_model: distortion.model().name().to_owned(),
            D: distortion.coefficients().to_vec(),
            K: k,
            R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            P: p_from_k(k),
            ..CameraInfo::default()
        };
        Self { camera_info, camera_info_topic: None, frames: Vec::new(), ignored_keys: Vec::new() }
    }

    /// The file of a calibrated projector: its lens, and where its optical frame [`Self::FRAME_ID`] is in `parent`.
    pub fn calibrated(lens: &Lens, parent: &str, parent_from_projector: &Isometry3<f64>) -> Self {
        let pose = StaticFrame {
            parent: parent.to_owned(),
            child: Self::FRAME_ID.to_owned(),
            translation_m: parent_from_projector.translation.vector.into(),
            // Composed rotations drift from the norm 1, which the file needs.
            rotation: UnitQuaternion::new_normalize(parent_from_projector.rotation.into_inner()),
        };
        Self { frames: vec![pose], ..Self::from_lens(lens, Self::FRAME_ID) }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::{Translation3, Vector3};
    use proptest::prelude::*;
    use rcs_calibration::DistortionModel;

    use super::*;

    prop_compose! {
        fn any_lens()(
            size_px in prop::array::uniform2(1..5000_u32),
            focal_px in prop::array::uniform2(1.0..1e4),
            center_px in prop::array::uniform2(-1e4..1e4),
            coefficients in prop::array::uniform5(-0.3..0.3),
            model in 0..4_usize,
        ) -> Lens {
            let distortion = match model {
                0 => Distortion::NONE,
                1 => Distortion::plumb_bob(coefficients),
                2 => Distortion::new(DistortionModel::Equidistant, &coefficients[..4]).unwrap(),
                _ => Distortion::new(DistortionModel::RationalPolynomial, &[0.1; 8]).unwrap(),
            };
            Lens { distortion, ..Lens::pinhole(size_px, focal_px, center_px) }
        }
    }

    proptest! {
        #[test]
        fn a_calibrated_projector_is_read_back(
            lens in any_lens(),
            translation in prop::array::uniform3(-10.0..10.0),
            turn in prop::array::uniform3(-3.0..3.0),
        ) {
            let turn = Vector3::from(turn);
            let mut pose = Isometry3::from_parts(Translation3::from(translation), UnitQuaternion::new(turn));
            // As many compositions leave it.
            pose.rotation = UnitQuaternion::new_unchecked(pose.rotation.into_inner() * (1.0 + 1e-9));
            let file = ProjectorFile::calibrated(&lens, "head_camera_rgb_optical_frame", &pose);
            let path = Path::new("projector.yaml");
            let read = ProjectorFile::parse(path, &file.to_yaml(path).unwrap()).unwrap();
            prop_assert_eq!(&read, &file);
            prop_assert_eq!(read.lens().unwrap(), lens);
            prop_assert!(read.warnings().is_empty());
        }
    }

    #[test]
    fn a_calibrated_projector_is_what_the_projector_program_publishes() {
        let lens = Lens::pinhole([1280, 800], [1900.0, 1890.0], [640.0, 817.0]);
        let file = ProjectorFile::calibrated(&lens, "camera", &Isometry3::translation(0.1, 0.2, 0.3));
        let info = &file.camera_info;
        assert_eq!(info.P, [1900.0, 0.0, 640.0, 0.0, 0.0, 1890.0, 817.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert_eq!((info.distortion_model.as_str(), info.D.as_slice()), ("plumb_bob", [0.0; 5].as_slice()));
        assert_eq!(info.header.frame_id, "proj_view");
        assert_eq!((file.frames[0].parent.as_str(), file.frames[0].child.as_str()), ("camera", "proj_view"));
        assert_eq!(file.frames[0].translation_m, [0.1, 0.2, 0.3]);
    }

    #[test]
    fn what_is_no_lens_is_refused_by_its_key() {
        let file = |changed: &str| {
            let text = format!("width: 64\nheight: 48\n{changed}");
            ProjectorFile::parse(Path::new("camera_info.yaml"), &text).unwrap()
        };
        for (changed, expected) in [
            (
                "K: [0, 0, 32, 0, 60, 24, 0, 0, 1]\nP: [60, 0, 32, 0, 0, 60, 24, 0, 0, 0, 1, 0]\n",
                "K: the focal lengths (fx 0",
            ),
            ("K: [-60, 0, 32, 0, 60, 24, 0, 0, 1]\n", "K: the focal lengths (fx -60"),
            ("K: [60, 2, 32, 0, 60, 24, 0, 0, 1]\n", "K: a skew (2, 0)"),
            ("K: [60, 0, 32, 0, 60, 24, 0, 0, 2]\n", "K: its last row is [0.0, 0.0, 2.0]"),
            ("K: [60, 0, 32, 0, 60, 24, 0, 0, 1]\nD: [1, 2]\n", "D: 2 coefficients"),
            ("K: [60, 0, 32, 0, 60, 24, 0, 0, 1]\nD: [1]\ndistortion_model: fov\n", "distortion_model: 'fov'"),
        ] {
            let problem = file(changed).lens().unwrap_err().to_string();
            assert!(problem.starts_with(expected), "{problem}");
        }
    }
}
