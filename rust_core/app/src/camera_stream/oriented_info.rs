//! The CameraInfo that is published beside a picture: one whose K, D, R and P lead a point to where it is in it.
//!
//! The picture is the whole one, whatever binning and region of interest the CameraInfo had that it was drawn for.
//! A picture that is turned by quarters is what a camera sees that is turned about its optical axis. So its CameraInfo
//! has a frame of its own, `FRAME_rotated_90` for a quarter to the right, which [`turned_frame`] places in the camera's
//! frame; sizes, focal lengths and principal point change places, and all is positive as before. Mirroring is no
//! rotation: it makes a focal length negative in K and P, which everything that multiplies with them takes as it is
//! meant. D is about coordinates before the focal lengths and so knows no mirroring; its tangential parts turn with the
//! axes.

use std::sync::Arc;

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Rotation3, UnitQuaternion};
use rcs_messages::geometry_msgs::{Quaternion, Transform, TransformStamped};
use rcs_messages::sensor_msgs::{CameraInfo, RegionOfInterest};
use rcs_render::Orientation;

/// The frame of a turned picture's CameraInfo.
pub(crate) fn frame_of(frame: &str, orientation: Orientation) -> String {
    match orientation.degrees() {
        0 => frame.to_owned(),
        degrees => format!("{frame}_rotated_{degrees}"),
    }
}

/// Where that frame is in the camera's own; none where it is the same.
pub(crate) fn turned_frame(frame: &str, orientation: Orientation) -> Option<TransformStamped> {
    if orientation.degrees() == 0 || frame.is_empty() {
        return None;
    }
    let rotation = Rotation3::from_matrix_unchecked(turned_from_own(orientation).transpose());
    let [x, y, z, w] = UnitQuaternion::from_rotation_matrix(&rotation).coords.into();
    let mut placed = TransformStamped::default();
    frame.clone_into(&mut placed.header.frame_id);
    placed.child_frame_id = frame_of(frame, orientation);
    placed.transform = Transform { rotation: Quaternion { x, y, z, w }, ..Transform::default() };
    Some(placed)
}

/// The CameraInfo of the whole picture of this one when it is turned.
pub(crate) fn oriented(info: &CameraInfo, orientation: Orientation) -> CameraInfo {
    let info = &CameraInfo { binning_x: 0, binning_y: 0, roi: RegionOfInterest::default(), ..info.clone() };
    if orientation == Orientation::default() {
        return info.clone();
    }
    let axes = turned_from_own(orientation);
    let pixels = turned_from_own_pixels(info, orientation);
    let [width, height] = orientation.size_px([info.width, info.height]);
    let mut turned = CameraInfo { width, height, ..info.clone() };
    turned.header.frame_id = frame_of(&info.header.frame_id, orientation);
    turned.K = rows_3(&(pixels * Matrix3::from_row_slice(&info.K) * axes.transpose()));
    if info.R.iter().any(|number| *number != 0.0) {
        turned.R = rows_3(&(axes * Matrix3::from_row_slice(&info.R) * axes.transpose()));
    }
    let mut points = Matrix4::identity();
    points.fixed_view_mut::<3, 3>(0, 0).copy_from(&axes.transpose());
    let p = pixels * Matrix3x4::from_row_slice(&info.P) * points;
    for (to, from) in turned.P.iter_mut().zip(p.transpose().iter()) {
        *to = *from;
    }
    turn_distortion(&mut turned.D, &info.distortion_model, orientation);
    turned
}

/// The CameraInfo of a camera's pictures, made again only when the one that they are drawn for changes.
#[derive(Debug, Default)]
pub(crate) struct TurnedInfo {
    last: Option<(Arc<CameraInfo>, Orientation, Arc<CameraInfo>)>,
}

impl TurnedInfo {
    /// The [`oriented`] CameraInfo.
    pub(crate) fn of(&mut self, info: &Arc<CameraInfo>, orientation: Orientation) -> Arc<CameraInfo> {
        let known = self.last.take().filter(|(own, how, _)| Arc::ptr_eq(own, info) && *how == orientation);
        let made = || (Arc::clone(info), orientation, Arc::new(oriented(info, orientation)));
        let (_, _, turned) = self.last.insert(known.unwrap_or_else(made));
        Arc::clone(turned)
    }
}

/// From the axes of the camera's optical frame to those of the turned picture's.
fn turned_from_own(orientation: Orientation) -> Matrix3<f64> {
    // By a quarter to the right: what points up points to the right then.
    let quarter = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    (0..orientation.degrees() / 90).fold(Matrix3::identity(), |axes, _| quarter * axes)
}

/// From the pixels of the picture to those of the turned one; an integer is a pixel's centre.
fn turned_from_own_pixels(info: &CameraInfo, orientation: Orientation) -> Matrix3<f64> {
    let (mut last_column, mut last_row) = (f64::from(info.width) - 1.0, f64::from(info.height) - 1.0);
    let mut pixels = Matrix3::identity();
    if orientation.is_mirrored {
        pixels = Matrix3::new(-1.0, 0.0, last_column, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    }
    for _ in 0..orientation.degrees() / 90 {
        pixels = Matrix3::new(0.0, -1.0, last_row, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0) * pixels;
        (last_column, last_row) = (last_row, last_column);
    }
    pixels
}

/// Turns what of D depends on the axes: p1 and p2, and a thin prism's s1 to s4.
fn turn_distortion(d: &mut [f64], model: &str, orientation: Orientation) {
    if !matches!(model, "plumb_bob" | "rational_polynomial" | "") {
        return;
    }
    for _ in 0..orientation.degrees() / 90 {
        if let [_, _, p1, p2, ..] = d {
            (*p1, *p2) = (*p2, -*p1);
        }
        if let Some([s1, s2, s3, s4]) = d.get_mut(8..12) {
            (*s1, *s2, *s3, *s4) = (-*s3, -*s4, *s1, *s2);
        }
    }
}

fn rows_3(matrix: &Matrix3<f64>) -> [f64; 9] {
    matrix.transpose().as_slice().try_into().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector2, Vector4};
    use proptest::prelude::*;
    use rcs_files::projector::lens_of;

    use super::*;

    const ALL: [&str; 8] = ["0", "90", "180", "270", "mirrored", "mirrored-90", "mirrored-180", "mirrored-270"];

    fn info(d: &[f64]) -> CameraInfo {
        let mut info = CameraInfo { width: 1280, height: 800, ..CameraInfo::default() };
        info.header.frame_id = "lens".to_owned();
        info.K = [1400.0, 0.0, 630.0, 0.0, 1390.0, 780.0, 0.0, 0.0, 1.0];
        info.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        info.P = [1400.0, 0.0, 630.0, -70.0, 0.0, 1390.0, 780.0, 20.0, 0.0, 0.0, 1.0, 0.0];
        info.distortion_model = if d.len() == 8 { "rational_polynomial" } else { "plumb_bob" }.to_owned();
        info.D = d.to_vec();
        info
    }

    /// Where a pixel of the picture is in the turned one, by the orientation's words.
    fn turned(text: &str, [u, v]: [f64; 2]) -> Vector2<f64> {
        let (width, height) = (1279.0, 799.0);
        let u = if text.starts_with("mirrored") { width - u } else { u };
        match text.trim_start_matches("mirrored").trim_start_matches('-') {
            "90" => Vector2::new(height - v, u),
            "180" => Vector2::new(width - u, height - v),
            "270" => Vector2::new(v, width - u),
            _ => Vector2::new(u, v),
        }
    }

    fn by_p(info: &CameraInfo, point: &Point3<f64>) -> Vector2<f64> {
        let pixel = Matrix3x4::from_row_slice(&info.P) * Vector4::new(point.x, point.y, point.z, 1.0);
        Vector2::new(pixel.x / pixel.z, pixel.y / pixel.z)
    }

    /// A point of the camera's frame in the frame of a turned picture's CameraInfo.
    fn in_frame(info: &CameraInfo, text: &str, point: &Point3<f64>) -> Point3<f64> {
        let Some(placed) = turned_frame("lens", text.parse().unwrap()) else {
            assert_eq!(info.header.frame_id, "lens");
            return *point;
        };
        assert_eq!((placed.header.frame_id.as_str(), &placed.child_frame_id), ("lens", &info.header.frame_id));
        let Quaternion { x, y, z, w } = placed.transform.rotation;
        UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z)).inverse() * point
    }

    proptest! {
        /// P alone, and K with D, lead a point to its pixel in the turned picture.
        #[test]
        fn a_point_lands_where_it_is_in_the_turned_picture(
            x in -0.4..0.4, y in -0.5..0.1, z in 0.8..3.0, which in 0_usize..8, rational: bool,
        ) {
            let text = ALL[which];
            let d: &[f64] = if rational {
                &[-0.1, 0.02, 0.002, -0.001, 0.003, 0.01, -0.002, 0.001]
            } else {
                &[-0.12, 0.03, 0.001, -0.0015, 0.002]
            };
            let (own, point) = (info(d), Point3::new(x * z, y * z, z));
            let after = oriented(&own, text.parse().unwrap());
            let point_there = in_frame(&after, text, &point);
            let expected = turned(text, by_p(&own, &point).into());
            prop_assert!((by_p(&after, &point_there) - expected).norm() < 1e-9, "{}", text);
            // Focal lengths stand where they are looked for, and are positive unless the picture is mirrored.
            prop_assert!(after.P[1].abs() + after.P[4].abs() + after.K[1].abs() + after.K[3].abs() < 1e-9);
            prop_assert_eq!(after.P[0] * after.P[5] > 0.0, !text.starts_with("mirrored"));
            let lens = lens_of(&own).unwrap();
            let Some(raw) = lens.project(&point) else { return Ok(()) };
            let there = lens_of(&after).unwrap().project(&point_there).unwrap();
            let off = (there.coords - turned(text, [raw.x, raw.y])).norm();
            prop_assert!(off < 1e-6, "{}: {} {}", text, there, raw);
        }
    }

    #[test]
    fn the_published_camera_info_is_that_of_the_whole_picture() {
        let mut own = info(&[]);
        (own.binning_x, own.binning_y) = (4, 2);
        own.roi = RegionOfInterest { x_offset: 10, y_offset: 20, width: 300, height: 40, do_rectify: true };
        let mut turned = TurnedInfo::default();
        let own = Arc::new(own);
        for text in ALL {
            let published = turned.of(&own, text.parse().unwrap());
            assert_eq!((published.binning_x, published.binning_y), (0, 0), "{text}");
            assert_eq!(published.roi, RegionOfInterest::default(), "{text}");
            let is_turned = text.ends_with("90") || text.ends_with("270");
            let size = if is_turned { (800, 1280) } else { (1280, 800) };
            assert_eq!((published.width, published.height), size, "{text}");
            assert!(Arc::ptr_eq(&published, &turned.of(&own, text.parse().unwrap())), "{text}");
        }
        assert_eq!(oriented(&own, Orientation::default()).P, own.P);
    }

    #[test]
    fn a_skewed_lens_is_one_in_each_orientation() {
        let mut own = info(&[-0.12, 0.03, 0.001, -0.0015, 0.002]);
        own.K[1] = 12.0;
        let (lens, point) = (lens_of(&own).unwrap(), Point3::new(0.3, -0.4, 1.5));
        let raw = lens.project(&point).unwrap();
        for text in ALL {
            let after = oriented(&own, text.parse().unwrap());
            let there = lens_of(&after).unwrap().project(&in_frame(&after, text, &point)).unwrap();
            assert!((there.coords - turned(text, raw.into())).norm() < 1e-6, "{text}: {there} {raw}");
        }
    }
}
