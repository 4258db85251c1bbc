//! The light of one pixel, by the projector's CameraInfo.
//!
//! A projector without distortion shows what P projects. With distortion, its image is bent for the lens
//! (`camera_stream --undistort`), so that its pixels light what K and D say, and R turns that into P's frame.

use std::str::FromStr;

use nalgebra::{Point2, Point3, Unit, Vector3};
use rcs_camera::{is_distorted, rectification};
use rcs_files::projector::{fields_of, lens_of};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_robot::Beam;
use rcs_scene::Intrinsics;

/// A pixel of the image; an integer is a pixel's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum AimPixel {
    /// The middle of the image.
    Center,
    /// u to the right and v down.
    At([f64; 2]),
}

impl FromStr for AimPixel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "center" {
            return Ok(Self::Center);
        }
        let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([u, v]) if u.is_finite() && v.is_finite() => Ok(Self::At([*u, *v])),
            _ => Err("neither 'center' nor two numbers U,V".to_owned()),
        }
    }
}

/// The light of a pixel in the frame of the CameraInfo.
///
/// # Errors
/// Why the CameraInfo is not that of a lens.
pub(super) fn beam(info: &CameraInfo, pixel: AimPixel) -> Result<Beam, String> {
    let [u, v] = match pixel {
        AimPixel::Center => [info.width, info.height].map(|size| (f64::from(size) - 1.0) / 2.0),
        AimPixel::At(pixel) => pixel,
    };
    if is_distorted(&fields_of(info)) {
        let lens = lens_of(info).map_err(|problem| problem.to_string())?;
        let ray = lens.ray(Point2::new(u, v)).ok_or_else(|| format!("no light goes through pixel {u}, {v}"))?;
        let rectified_from_raw = rectification(&fields_of(info)).map_err(|problem| problem.to_string())?;
        return Ok(Beam { origin: Point3::origin(), direction: Unit::new_normalize(rectified_from_raw * ray) });
    }
    let (p, flip) = Intrinsics::exactly(info.width, info.height, &info.P).map_err(|error| error.to_string())?;
    let [u, v] = flip.pixel([info.width, info.height], [u, v]);
    let ([x, y], [eye_x, eye_y]) = (p.plane([u + 0.5, v + 0.5]), p.eye_m());
    // The light of all pixels meets where the eye is.
    Ok(Beam { origin: Point3::new(eye_x, eye_y, 0.0), direction: Unit::new_normalize(Vector3::new(x, y, 1.0)) })
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3x4;

    use super::*;

    fn info() -> CameraInfo {
        let (mut info, f) = (CameraInfo { width: 1280, height: 800, ..CameraInfo::default() }, 1900.0);
        info.K = [f, 0.0, 639.5, 0.0, f, 750.0, 0.0, 0.0, 1.0];
        info.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        info.P = [f, 0.0, 639.5, 0.0, 0.0, f, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        info
    }

    #[test]
    fn the_middle_of_a_image_with_lens_shift_is_above_the_axis() {
        let light = beam(&info(), AimPixel::Center).unwrap();
        let expected = Vector3::new(0.0, (399.5 - 750.0) / 1900.0, 1.0).normalize();
        assert!((light.direction.into_inner() - expected).norm() < 1e-12 && light.origin == Point3::origin());
    }

    #[test]
    fn a_given_pixel_is_projected_back_by_p() {
        let mut info = info();
        (info.P[3], info.P[7]) = (-190.0, 38.0);
        // With a skew, mirrored, and up to scale.
        for [sign, skew, scale] in [[1.0, 0.0, 1.0], [1.0, 50.0, 2.0], [-1.0, 50.0, 1.0]] {
            let mut info = info.clone();
            (info.P[0], info.P[1]) = (sign * info.P[0], sign * skew);
            info.P = info.P.map(|value| value * scale);
            let light = beam(&info, "100, 200".parse::<AimPixel>().unwrap()).unwrap();
            let point = (light.origin + light.direction.into_inner() * 2.5).to_homogeneous();
            let pixel = Matrix3x4::from_row_slice(&info.P) * point;
            let pixel = [pixel.x / pixel.z, pixel.y / pixel.z];
            assert!((pixel[0] - 100.0).abs() < 1e-9 && (pixel[1] - 200.0).abs() < 1e-9, "{pixel:?}");
        }
    }

    #[test]
    fn distortion_bends_the_light_as_the_lens_does() {
        let mut info = info();
        (info.distortion_model, info.D) = ("plumb_bob".to_owned(), vec![-0.2, 0.05, 0.001, 0.0, 0.0]);
        let light = beam(&info, AimPixel::At([50.0, 60.0])).unwrap();
        let landed = lens_of(&info).unwrap().project(&Point3::from(light.direction.into_inner() * 3.0)).unwrap();
        assert!((landed - Point2::new(50.0, 60.0)).norm() < 1e-6, "{landed}");
    }

    #[test]
    fn what_is_no_pixel_or_no_lens_is_refused() {
        assert_eq!("center".parse::<AimPixel>(), Ok(AimPixel::Center));
        for text in ["", "1", "1,2,3", "1,x", "nan,1"] {
            assert!(text.parse::<AimPixel>().is_err(), "{text}");
        }
        let mut info = info();
        info.P[0] = 0.0;
        assert_eq!(beam(&info, AimPixel::Center).unwrap_err(), "P[0] (a focal length) is 0");
    }
}
