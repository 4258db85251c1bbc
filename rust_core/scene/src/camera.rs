//! The virtual camera: a CameraInfo's projection matrix P at a pose in the fixed frame.
//!
//! A projector is a camera run backwards, so this is the projector too. Offers both the projection of rviz's CameraPub
//! display and the exact one of P.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3, Translation3, UnitQuaternion, Vector3};
use thiserror::Error;

use crate::{Flip, PixelMap, MAX_SIDE_PX};

/// Far clip distance of a CameraPub camera, in metres.
pub const FAR_CLIP_M: f64 = 100.0;

/// Invalid field of a CameraInfo; the caller names the topic.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CameraError {
    /// A field, such as `P[2]`, is NaN or infinite.
    #[error("{0} is {1}, not a finite number")]
    NotFinite(String, f64),
    /// `width` or `height` is zero.
    #[error("{0} is 0")]
    ZeroSize(&'static str),
    /// `width` or `height` is past [`MAX_SIDE_PX`], pixels.
    #[error("{0} is {1}, larger than {MAX_SIDE_PX}")]
    TooLarge(&'static str, u32),
    /// A focal length, `P[0]` or `P[5]`, is zero.
    #[error("{0} (a focal length) is 0")]
    ZeroFocalLength(&'static str),
    /// The third row of P is not a positive multiple of (0, 0, 1, 0).
    #[error("the third row of P, P[8] to P[11], is {0:?} where [0, 0, s, 0] with s > 0 is needed")]
    ThirdRow([f64; 4]),
    /// The skews of P, `P[1]` and `P[4]`, turn the image inside out, or flatten it.
    #[error("P[1] and P[4] (skews, {} and {}) are too large for the focal lengths P[0] and P[5]", .0[0], .0[1])]
    TooSkewed([f64; 2]),
}

/// A pinhole camera, from a CameraInfo's size and its row-major 3×4 matrix
/// `P = [fx s cx Tx; t fy cy Ty; 0 0 1 0]` (K, R and D play no part). Pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Image width.
    pub width_px: u32,
    /// Image height.
    pub height_px: u32,
    /// Focal length along a row.
    pub fx_px: f64,
    /// Focal length along a column.
    pub fy_px: f64,
    /// `P[1]` and `P[4]`, mostly 0: shift along a row per y, and along a column per x.
    pub skew_px: [f64; 2],
    /// Principal point from the left; may lie outside of the image.
    pub cx_px: f64,
    /// Principal point from the top; with the lens shift of a projector it may lie far below the image.
    pub cy_px: f64,
    /// `P[3]`: −fx times the camera's offset in metres along the optical frame's x.
    pub tx: f64,
    /// `P[7]`: −fy times the camera's offset in metres along the optical frame's y.
    pub ty: f64,
}

impl Intrinsics {
    /// Checks a CameraInfo's size and reads its P as rviz does, without the third row; see also
    /// [`exactly`](Self::exactly).
    ///
    /// # Errors
    /// The first field that makes drawing impossible, see [`CameraError`].
    pub fn from_p(width_px: u32, height_px: u32, p: &[f64; 12]) -> Result<Self, CameraError> {
        for (field, value) in [("width", width_px), ("height", height_px)] {
            if value == 0 {
                return Err(CameraError::ZeroSize(field));
            }
            if value > MAX_SIDE_PX {
                return Err(CameraError::TooLarge(field, value));
            }
        }
        require_finite("P", p)?;
        for (field, value) in [("P[0]", p[0]), ("P[5]", p[5])] {
            if value == 0.0 {
                return Err(CameraError::ZeroFocalLength(field));
            }
        }
        let [fx_px, s, cx_px, tx, t, fy_px, cy_px, ty, ..] = *p;
        Ok(Self { width_px, height_px, fx_px, fy_px, skew_px: [s, t], cx_px, cy_px, tx, ty })
    }

    /// Intrinsics that draw a point at `P · [X Y Z 1]'`, P up to scale, and the flip that the finished image needs: a
    /// P with negative focal lengths is drawn without its mirror.
    ///
    /// ```
    /// use rcs_scene::{Flip, Intrinsics};
    ///
    /// let mirrored = [-500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    /// let (drawn, flip) = Intrinsics::exactly(640, 480, &mirrored)?;
    /// // The mirror image of column 320 of 640 is column 319; its centre is half a pixel from its edge.
    /// assert_eq!((drawn.fx_px, drawn.cx_px), (500.0, 319.5));
    /// assert_eq!(flip, Flip { is_left_right: true, is_up_down: false });
    /// # Ok::<(), rcs_scene::CameraError>(())
    /// ```
    ///
    /// # Errors
    /// The first field that makes drawing impossible, see [`CameraError`].
    pub fn exactly(width_px: u32, height_px: u32, p: &[f64; 12]) -> Result<(Self, Flip), CameraError> {
        let given = Self::from_p(width_px, height_px, p)?;
        let [.., below_x, below_y, scale, below_w] = *p;
        if !(scale > 0.0 && [below_x, below_y, below_w] == [0.0; 3]) {
            return Err(CameraError::ThirdRow([below_x, below_y, scale, below_w]));
        }
        let drawn = match scale == 1.0 {
            true => given,
            false => Self::from_p(width_px, height_px, &p.map(|value| value / scale))?,
        };
        let flip = Flip { is_left_right: drawn.fx_px < 0.0, is_up_down: drawn.fy_px < 0.0 };
        let drawn = drawn.flipped(flip);
        let [s, t] = drawn.skew_px;
        if drawn.fx_px * drawn.fy_px <= s * t {
            return Err(CameraError::TooSkewed(given.skew_px));
        }
        Ok((drawn.as_p_means(), flip))
    }

    /// Intrinsics of the flipped image, where an integer is a pixel's centre.
    fn flipped(self, flip: Flip) -> Self {
        let [cx_px, cy_px] = flip.pixel([self.width_px, self.height_px], [self.cx_px, self.cy_px]);
        let Self { fx_px, fy_px, skew_px: [s, t], tx, ty, .. } = self;
        let (fx_px, s, tx) = if flip.is_left_right { (-fx_px, -s, -tx) } else { (fx_px, s, tx) };
        let (fy_px, t, ty) = if flip.is_up_down { (-fy_px, -t, -ty) } else { (fy_px, t, ty) };
        Self { fx_px, fy_px, skew_px: [s, t], cx_px, cy_px, tx, ty, ..self }
    }

    /// Direction (x, y, 1) in the optical frame that is projected to a place in the image.
    pub fn plane(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        self.solve([u - self.cx_px, v - self.cy_px])
    }

    /// Place in the image to which the direction (x, y, 1) of the optical frame is projected; inverse of
    /// [`Self::plane`].
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [s, t] = self.skew_px;
        [self.fx_px * x + s * y + self.cx_px, t * x + self.fy_px * y + self.cy_px]
    }

    /// The eye's x and y in the CameraInfo's optical frame, metres; not 0 where P has Tx or Ty.
    pub fn eye_m(&self) -> [f64; 2] {
        self.solve([-self.tx, -self.ty])
    }

    /// Solves for the x and y whose products with focal lengths and skews are these pixels.
    fn solve(&self, [du, dv]: [f64; 2]) -> [f64; 2] {
        let [s, t] = self.skew_px;
        let y = (dv - t * du / self.fx_px) / (self.fy_px - t * s / self.fx_px);
        [(du - s * y) / self.fx_px, y]
    }

    /// Counts pixels from the first one's edge, as a renderer does, instead of from its centre, as ROS and OpenCV do.
    /// rviz leaves that half pixel out.
    pub fn as_p_means(&self) -> Self {
        Self { cx_px: self.cx_px + 0.5, cy_px: self.cy_px + 0.5, ..*self }
    }

    /// Factors by which rviz's CameraPub shrinks the image along each axis, so that its angles fit its shape. In 32
    /// bits, as there, because pixels at the edges of lines depend on it.
    fn rviz_zoom(&self) -> (f64, f64) {
        if self.fx_px == self.fy_px {
            return (1.0, 1.0);
        }
        let (width, height) = (f64::from(self.width_px), f64::from(self.height_px));
        let of_angles = ((width / self.fx_px) / (height / self.fy_px)) as f32;
        let of_image = self.width_px as f32 / self.height_px as f32;
        let (zoom_x, zoom_y) = if of_angles > of_image {
            (1.0, f64::from(1.0 / of_angles * of_image))
        } else {
            (f64::from(1.0 / of_image * of_angles), 1.0)
        };
        // Focal lengths of absurd sizes leave the range of 32 bits.
        let is_usable = |zoom: f64| zoom.is_finite() && zoom != 0.0;
        if is_usable(zoom_x) && is_usable(zoom_y) {
            return (zoom_x, zoom_y);
        }
        ((self.fy_px / self.fx_px).min(1.0), (self.fx_px / self.fy_px).min(1.0))
    }

    /// Intrinsics that rviz's CameraPub in effect draws with. It shrinks the longer focal length (and the principal
    /// point's offset from the centre along that axis) to the shorter one, gives both the same sign, leaves out skews,
    /// and moves the camera up where `P[7]` means down.
    pub fn as_rviz_draws(&self) -> Self {
        let (zoom_x, zoom_y) = self.rviz_zoom();
        let (half_width, half_height) = (f64::from(self.width_px) / 2.0, f64::from(self.height_px) / 2.0);
        Self {
            fx_px: self.fx_px * zoom_x,
            fy_px: self.fy_px * zoom_y,
            skew_px: [0.0; 2],
            cx_px: half_width + (self.cx_px - half_width) * zoom_x,
            cy_px: half_height + (self.cy_px - half_height) * zoom_y,
            tx: self.tx * zoom_x,
            ty: -self.ty * zoom_y,
            ..*self
        }
    }
}

/// Checks that all numbers of a CameraInfo's field are finite.
///
/// # Errors
/// The first that is not, named `FIELD[INDEX]`.
pub fn require_finite(field: &str, values: &[f64]) -> Result<(), CameraError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(i) => Err(CameraError::NotFinite(format!("{field}[{i}]"), values[i])),
        None => Ok(()),
    }
}

/// A camera at a pose.
///
/// ```
/// use nalgebra::{Isometry3, Point3};
/// use rcs_scene::{Camera, Intrinsics};
///
/// // P of a CameraInfo of 640×480 pixels; its frame_id is an optical frame in the fixed frame's origin.
/// let p = [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// let camera = Camera::new(Intrinsics::from_p(640, 480, &p)?, &Isometry3::identity(), 0.01);
///
/// // The optical frame's z points forward, the view frame's z backward.
/// let in_view = camera.fixed_from_view().inverse() * Point3::new(0.1, 0.2, 2.0);
/// assert!((in_view - Point3::new(0.1, -0.2, -2.0)).norm() < 1e-12);
/// let clip = camera.clip_from_view() * in_view.to_homogeneous();
/// let column_px = (clip.x / clip.w + 1.0) / 2.0 * 640.0;
/// assert!((column_px - (320.0 + 500.0 * 0.1 / 2.0)).abs() < 1e-9);
/// # Ok::<(), rcs_scene::CameraError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    intrinsics: Intrinsics,
    /// Map from the drawn image to the image.
    lens: Option<Arc<PixelMap>>,
    flip: Flip,
    near_m: f64,
    fixed_from_view: Isometry3<f64>,
    clip_from_view: Matrix4<f64>,
}

impl Camera {
    /// A camera whose optical frame (x right, y down, z forward) has this pose in the fixed frame, with the view
    /// between `near_m` and [`FAR_CLIP_M`]. Tx and Ty of the intrinsics move it. Pixels are counted from the image's
    /// edges: the first one's centre is at 0.5, as rviz reads P ([`Intrinsics::as_p_means`]).
    ///
    /// A near distance outside of the range from zero to the far one is clamped.
    pub fn new(intrinsics: Intrinsics, fixed_from_optical: &Isometry3<f64>, near_m: f64) -> Self {
        let near_m = near_m.clamp(1e-6, FAR_CLIP_M * 0.999);
        let Intrinsics { fx_px, fy_px, skew_px: [s, t], cx_px, cy_px, .. } = intrinsics;
        let [eye_x, eye_y] = intrinsics.eye_m();
        let optical_from_camera = Translation3::new(eye_x, eye_y, 0.0);
        let optical_from_view = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let (width, height) = (f64::from(intrinsics.width_px), f64::from(intrinsics.height_px));
        let depth = FAR_CLIP_M - near_m;
        #[rustfmt::skip]
        let clip_from_view = Matrix4::new(
            2.0 * fx_px / width, 0.0 - 2.0 * s / width, 1.0 - 2.0 * cx_px / width, 0.0,
            0.0 - 2.0 * t / height, 2.0 * fy_px / height, 2.0 * cy_px / height - 1.0, 0.0,
            0.0, 0.0, -(FAR_CLIP_M + near_m) / depth, -2.0 * FAR_CLIP_M * near_m / depth,
            0.0, 0.0, -1.0, 0.0,
        );
        Self {
            intrinsics,
            lens: None,
            flip: Flip::NONE,
            near_m,
            fixed_from_view: fixed_from_optical * optical_from_camera * optical_from_view,
            clip_from_view,
        }
    }

    /// Puts a lens in front: the drawn image becomes the source of the image, which has the map's size.
    #[must_use]
    pub fn with_lens(self, lens: Arc<PixelMap>) -> Self {
        Self { lens: Some(lens), ..self }
    }

    /// Flips the finished image, after the lens.
    #[must_use]
    pub fn with_flip(self, flip: Flip) -> Self {
        Self { flip, ..self }
    }

    /// Flip of the finished image, after the lens.
    pub fn flip(&self) -> Flip {
        self.flip
    }

    /// Map from the drawn image to the image, if there is a lens.
    pub fn lens(&self) -> Option<&Arc<PixelMap>> {
        self.lens.as_ref()
    }

    /// Its intrinsics.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// Width of the drawn image, in pixels; without a lens that of the image.
    pub fn width_px(&self) -> u32 {
        self.intrinsics.width_px
    }

    /// Height of the drawn image, in pixels; without a lens that of the image.
    pub fn height_px(&self) -> u32 {
        self.intrinsics.height_px
    }

    /// Near clip distance in metres.
    pub fn near_m(&self) -> f64 {
        self.near_m
    }

    /// The pose of the view frame (x right, y up, looking along −z) in the fixed frame.
    pub fn fixed_from_view(&self) -> &Isometry3<f64> {
        &self.fixed_from_view
    }

    /// OpenGL's projection: clip coordinates with depth −w to w, y up.
    pub fn clip_from_view(&self) -> &Matrix4<f64> {
        &self.clip_from_view
    }

    /// The eye in the fixed frame.
    pub fn eye(&self) -> Point3<f64> {
        Point3::from(self.fixed_from_view.translation.vector)
    }

    /// From an object's frame to the view frame. Computed in `f64`, so that a scene far from the fixed frame's origin
    /// keeps its precision.
    pub fn view_from_object(&self, fixed_from_object: &Matrix4<f64>) -> Matrix4<f32> {
        (self.fixed_from_view.inverse().to_homogeneous() * fixed_from_object).cast()
    }

    /// From the frame of something that faces the camera (text), to the view frame: the object's position and scale
    /// without its rotation. What is mirrored (scaled by a negative number) stands on its head, as in Ogre.
    pub fn view_from_facing(&self, fixed_from_object: &Matrix4<f64>) -> Matrix4<f32> {
        let position = Point3::from(fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned());
        let mut view_from_object = self.fixed_from_view.inverse_transform_point(&position).coords.push(1.0);
        view_from_object.w = 1.0;
        let sign = if fixed_from_object.fixed_view::<3, 3>(0, 0).determinant() < 0.0 { -1.0 } else { 1.0 };
        let mut matrix = Matrix4::zeros();
        for i in 0..3 {
            matrix[(i, i)] = sign * fixed_from_object.fixed_view::<3, 1>(0, i).norm();
        }
        matrix.set_column(3, &view_from_object);
        matrix.cast()
    }

    /// The eye in an object's frame; the object's origin where its matrix cannot be inverted.
    pub fn eye_in_object(&self, fixed_from_object: &Matrix4<f64>) -> Point3<f32> {
        fixed_from_object
            .try_inverse()
            .map_or_else(Point3::origin, |object_from_fixed| object_from_fixed.transform_point(&self.eye()))
            .cast()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixel of a point relative to the eye.
    fn pixel(camera: &Camera, optical: Point3<f64>) -> (f64, f64) {
        let fixed_from_optical =
            camera.fixed_from_view * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        pixel_of_fixed(camera, fixed_from_optical * optical)
    }

    /// Pixel of a point in the fixed frame.
    fn pixel_of_fixed(camera: &Camera, fixed: Point3<f64>) -> (f64, f64) {
        let view = camera.fixed_from_view.inverse_transform_point(&fixed);
        let clip = camera.clip_from_view * view.to_homogeneous();
        let (width, height) = (f64::from(camera.width_px()), f64::from(camera.height_px()));
        ((clip.x / clip.w + 1.0) / 2.0 * width, (1.0 - clip.y / clip.w) / 2.0 * height)
    }

    const P: [f64; 12] = [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0];

    #[test]
    fn p_counts_pixels_from_the_first_ones_centre() {
        let intrinsics = Intrinsics::from_p(1280, 800, &P).unwrap().as_p_means();
        let camera = Camera::new(intrinsics, &Isometry3::identity(), 0.01);
        let (u, v) = pixel(&camera, Point3::new(0.1, -0.2, 2.0));
        assert!((u - 0.5 - (640.0 + 1900.0 * 0.05)).abs() < 1e-9, "{u}");
        assert!((v - 0.5 - (750.0 - 1900.0 * 0.1)).abs() < 1e-9, "{v}");
    }

    #[test]
    fn skew_and_scale_are_followed_in_the_exact_projection_only() {
        // A test's camera of 640×480: u = (500 x + 50 y + 320 z) / z.
        let p = [500.0, 50.0, 320.0, 0.0, 7.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        for scale in [1.0, 2.0, 0.1] {
            let (drawn, flip) = Intrinsics::exactly(640, 480, &p.map(|value| value * scale)).unwrap();
            assert_eq!(flip, Flip::NONE);
            let camera = Camera::new(drawn, &Isometry3::identity(), 0.01);
            let (u, v) = pixel(&camera, Point3::new(0.1, 0.2, 1.0));
            assert!((u - 0.5 - 380.0).abs() < 1e-9 && (v - 0.5 - 340.7).abs() < 1e-9, "{scale}: {u} {v}");
            let [x, y] = drawn.plane([u, v]);
            assert!((x - 0.1).abs() < 1e-12 && (y - 0.2).abs() < 1e-12 && drawn.place([x, y]) == [u, v]);
        }
        assert_eq!(Intrinsics::from_p(640, 480, &p).unwrap().as_rviz_draws().skew_px, [0.0; 2]);
    }

    #[test]
    fn a_skewed_camera_with_an_offset_stands_where_p_places_it() {
        let p = [500.0, 50.0, 320.0, -60.0, 7.0, 480.0, 240.0, 31.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::exactly(640, 480, &p).unwrap().0, &Isometry3::identity(), 0.01);
        let (x, y, z) = (0.3, -0.2, 1.5);
        let (u, v) = pixel_of_fixed(&camera, Point3::new(x, y, z));
        let [du, dv] = [p[0] * x + p[1] * y + p[2] * z + p[3], p[4] * x + p[5] * y + p[6] * z + p[7]];
        assert!((u - 0.5 - du / z).abs() < 1e-9 && (v - 0.5 - dv / z).abs() < 1e-9, "{u} {v}");
    }

    #[test]
    fn a_third_row_that_is_no_scale_and_skews_without_a_image_are_refused_by_name() {
        let with = |changes: &[(usize, f64)]| {
            let mut p = P;
            changes.iter().for_each(|(i, value)| p[*i] = *value);
            Intrinsics::exactly(1280, 800, &p).unwrap_err().to_string()
        };
        for row in [[(10, 0.0)], [(10, -1.0)], [(8, 0.1)], [(9, -0.1)], [(11, 1.0)]] {
            assert!(with(&row).starts_with("the third row of P, P[8] to P[11], is ["), "{}", with(&row));
        }
        assert!(with(&[(1, 1900.0), (4, 1900.0)]).starts_with("P[1] and P[4] (skews, 1900 and 1900)"));
        assert!(with(&[(10, f64::NAN)]).starts_with("P[10] is NaN"));
        assert!(with(&[(10, 1e-300), (0, 1e10)]).starts_with("P[0] is inf"));
        // What rviz does not look at does not end its image.
        let mut p = P;
        p[10] = 0.0;
        assert!(Intrinsics::from_p(1280, 800, &p).is_ok());
    }

    #[test]
    fn bad_camera_infos_are_refused_with_the_field_named() {
        let with = |i: usize, value: f64| {
            let mut p = P;
            p[i] = value;
            Intrinsics::from_p(1280, 800, &p).unwrap_err().to_string()
        };
        assert!(with(6, f64::NAN).starts_with("P[6] is NaN"));
        assert!(with(11, f64::INFINITY).starts_with("P[11] is inf"));
        assert!(with(5, 0.0).starts_with("P[5]"));
        assert_eq!(Intrinsics::from_p(0, 800, &P).unwrap_err().to_string(), "width is 0");
        assert_eq!(Intrinsics::from_p(1280, 16385, &P).unwrap_err().to_string(), "height is 16385, larger than 16384");
    }
}
