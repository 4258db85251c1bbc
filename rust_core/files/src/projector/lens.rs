//! Conversion between a CameraInfo and the lens of calibration.
//!
//! The lens is that of the raw image: K and D. P and R belong to the rectified one, so in a file written here P is K
//! and R the identity.

use nalgebra::Isometry3;
use rcs_calibration::Lens;
use rcs_camera::{CameraInfoFields, LensProblem};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_msgs::Header;

use super::file::ProjectorFile;
use super::frames::StaticFrame;
use super::raw_file::p_from_k;

/// The fields of a CameraInfo that define its projection.
pub fn fields_of(info: &CameraInfo) -> CameraInfoFields<'_> {
    let roi = &info.roi;
    CameraInfoFields {
        width_px: info.width,
        height_px: info.height,
        distortion_model: &info.distortion_model,
        d: &info.D,
        k: &info.K,
        r: &info.R,
        p: &info.P,
        binning: [info.binning_x, info.binning_y],
        region_px: [roi.x_offset, roi.y_offset, roi.width, roi.height],
    }
}

/// The lens by K and D of a CameraInfo.
///
/// # Errors
/// As [`rcs_camera::lens_of`].
pub fn lens_of(info: &CameraInfo) -> Result<Lens, LensProblem> {
    rcs_camera::lens_of(&fields_of(info))
}

impl ProjectorFile {
    /// Optical frame of a calibrated projector.
    pub const FRAME_ID: &str = "proj_view";

    /// The lens by K and D.
    ///
    /// # Errors
    /// As [`lens_of`].
    pub fn lens(&self) -> Result<Lens, LensProblem> {
        lens_of(&self.camera_info)
    }

    /// The lens of a scanning camera, which must not be mirrored: mirrored images of a scan mean a mirror in the
    /// light's path.
    ///
    /// # Errors
    /// As [`lens_of`], and focal lengths that are not positive.
    pub fn camera_lens(&self) -> Result<Lens, LensProblem> {
        let lens = self.lens()?;
        let [fx, fy] = lens.focal_px.into();
        if fx > 0.0 && fy > 0.0 {
            return Ok(lens);
        }
        Err(LensProblem { key: "K", reason: format!("the focal lengths (fx {fx}, fy {fy}) are not positive") })
    }

    /// File of a lens with the optical frame `frame_id`: P is K, R the identity.
    pub fn from_lens(lens: &Lens, frame_id: &str) -> Self {
        let Lens { size_px: [width, height], focal_px, skew_px, center_px, distortion } = *lens;
        let k = [focal_px.x, skew_px.x, center_px.x, skew_px.y, focal_px.y, center_px.y, 0.0, 0.0, 1.0];
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

    /// File of a calibrated projector: its lens, and the pose of its optical frame [`Self::FRAME_ID`] in `parent`.
    pub fn calibrated(lens: &Lens, parent: &str, parent_from_projector: &Isometry3<f64>) -> Self {
        let pose = StaticFrame::new(parent, Self::FRAME_ID, parent_from_projector);
        Self { frames: vec![pose], ..Self::from_lens(lens, Self::FRAME_ID) }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::{Translation3, UnitQuaternion, Vector3};
    use proptest::prelude::*;
    use rcs_calibration::{Distortion, DistortionModel};

    use super::*;

    prop_compose! {
        fn any_lens()(
            size_px in prop::array::uniform2(1..5000_u32),
            focal_px in prop::array::uniform2(1.0..1e4),
            center_px in prop::array::uniform2(-1e4..1e4),
            coefficients in prop::array::uniform5(-0.3..0.3),
            model in 0..4_usize,
            skew_px in prop_oneof![Just([0.0; 2]), prop::array::uniform2(-0.5..0.5)],
        ) -> Lens {
            let distortion = match model {
                0 => Distortion::NONE,
                1 => Distortion::plumb_bob(coefficients),
                2 => Distortion::new(DistortionModel::Equidistant, &coefficients[..4]).unwrap(),
                _ => Distortion::new(DistortionModel::RationalPolynomial, &[0.1; 8]).unwrap(),
            };
            Lens { distortion, skew_px: skew_px.into(), ..Lens::pinhole(size_px, focal_px, center_px) }
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
    fn a_mirrored_lens_is_a_projectors_and_no_cameras() {
        let text = "width: 64\nheight: 48\nK: [-60, 2, 32, 0, 60, 24, 0, 0, 1]\n";
        let file = ProjectorFile::parse(Path::new("camera_info.yaml"), text).unwrap();
        let lens = file.lens().unwrap();
        assert_eq!((lens.focal_px.x, lens.skew_px.x), (-60.0, 2.0));
        let problem = file.camera_lens().unwrap_err().to_string();
        assert_eq!(problem, "K: the focal lengths (fx -60, fy 60) are not positive");
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
                "K: a focal length is 0 (fx 0, fy 60)",
            ),
            ("K: [60, 60, 32, 60, 60, 24, 0, 0, 1]\n", "K: its skews (60, 60) are too large"),
            ("K: [60, 0, 32, 0, 60, 24, 0, 0, -1]\n", "K: its last row is [0.0, 0.0, -1.0]"),
            ("K: [60, 0, 32, 0, 60, 24, 0, 0, 1]\nD: [1, 2]\n", "D: 2 coefficients"),
            ("K: [60, 0, 32, 0, 60, 24, 0, 0, 1]\nD: [1]\ndistortion_model: fov\n", "distortion_model: 'fov'"),
        ] {
            let problem = file(changed).lens().unwrap_err().to_string();
            assert!(problem.starts_with(expected), "{problem}");
        }
    }
}
