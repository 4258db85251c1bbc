//! Pinhole lens with distortion: projection of points of the optical frame to pixels, and back.
//!
//! Used for projectors and cameras. Pixel coordinates are those of ROS and OpenCV: u to the right, v down, integers at
//! pixel centres. Points are in metres in the optical frame: x right, y down, z along the view or light.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Point3, Vector2, Vector3};

use crate::Distortion;

/// Intrinsics of a projector or camera. Lenses of the solver have no skew; those of other tools may.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Image width and height, pixels.
    pub size_px: [u32; 2],
    /// Focal lengths fx, fy, pixels; negative if the image is mirrored.
    pub focal_px: Vector2<f64>,
    /// `K[1]` and `K[3]`, pixels: the pixel's shift along a row with y, and along a column with x.
    pub skew_px: Vector2<f64>,
    /// Principal point cx, cy, pixels; outside of the image for a lens shift, as of projectors that throw upwards.
    pub center_px: Point2<f64>,
    /// Deviation from a pinhole.
    pub distortion: Distortion,
}

/// Pixel of a point with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProjectedPoint {
    /// The pixel.
    pub pixel: Point2<f64>,
    /// Derivatives by the point in the optical frame, pixels per metre.
    pub by_point: Matrix2x3<f64>,
}

impl Lens {
    /// Creates a lens without distortion and skew.
    pub fn pinhole(size_px: [u32; 2], focal_px: [f64; 2], center_px: [f64; 2]) -> Self {
        let (focal_px, center_px) = (focal_px.into(), center_px.into());
        Self { size_px, focal_px, skew_px: Vector2::zeros(), center_px, distortion: Distortion::NONE }
    }

    /// Camera matrix K.
    pub fn matrix(&self) -> Matrix3<f64> {
        let (f, s, c) = (self.focal_px, self.skew_px, self.center_px);
        Matrix3::new(f.x, s.x, c.x, s.y, f.y, c.y, 0.0, 0.0, 1.0)
    }

    /// Upper left 2×2 block of K.
    fn scales(&self) -> Matrix2<f64> {
        Matrix2::new(self.focal_px.x, self.skew_px.x, self.skew_px.y, self.focal_px.y)
    }

    /// Pixel of a point of the optical frame, in or outside of the image. `None` if the point is not in front of the
    /// lens or beyond the distortion's valid radius.
    pub fn project(&self, point: &Point3<f64>) -> Option<Point2<f64>> {
        if point.z > 0.0 {
            self.pixel(Point2::new(point.x / point.z, point.y / point.z))
        } else {
            None
        }
    }

    /// [`Self::project`] with its derivatives.
    pub fn project_with_jacobian(&self, point: &Point3<f64>) -> Option<ProjectedPoint> {
        if point.z.is_nan() || point.z <= 0.0 {
            return None;
        }
        let near = 1.0 / point.z;
        let plane = Point2::new(point.x * near, point.y * near);
        let distorted = self.distortion.distort_with_jacobian(plane)?;
        let plane_by_point = Matrix2x3::new(near, 0.0, -plane.x * near, 0.0, near, -plane.y * near);
        let by_point = self.scales() * (distorted.jacobian * plane_by_point);
        Some(ProjectedPoint { pixel: self.from_distorted(distorted.place), by_point })
    }

    /// Pixel of a point of the plane z = 1.
    pub fn pixel(&self, plane: Point2<f64>) -> Option<Point2<f64>> {
        self.distortion.distort(plane).map(|place| self.from_distorted(place))
    }

    /// Point of the plane z = 1 that a pixel sees or lights; `None` where the distortion has no inverse.
    pub fn plane(&self, pixel: Point2<f64>) -> Option<Point2<f64>> {
        self.distortion.undistort(self.to_distorted(pixel))
    }

    /// Direction that a pixel sees or lights: a vector of the optical frame with z = 1.
    pub fn ray(&self, pixel: Point2<f64>) -> Option<Vector3<f64>> {
        self.plane(pixel).map(|place| place.coords.push(1.0))
    }

    /// `true` if a pixel is in the image, including the outermost half pixels.
    pub fn contains(&self, pixel: Point2<f64>) -> bool {
        let [width, height] = self.size_px.map(f64::from);
        (-0.5..width - 0.5).contains(&pixel.x) && (-0.5..height - 0.5).contains(&pixel.y)
    }

    /// Pixel of a distorted point of the plane z = 1.
    #[expect(clippy::wrong_self_convention, reason = "names the direction of the conversion")]
    pub(crate) fn from_distorted(&self, place: Point2<f64>) -> Point2<f64> {
        let skewed = self.skew_px.component_mul(&place.coords.yx());
        self.center_px + place.coords.component_mul(&self.focal_px) + skewed
    }

    /// Inverse of [`Self::from_distorted`].
    pub(crate) fn to_distorted(self, pixel: Point2<f64>) -> Point2<f64> {
        let (off, f, s) = (pixel - self.center_px, self.focal_px, self.skew_px);
        let y = (off.y - s.y * off.x / f.x) / (f.y - s.y * s.x / f.x);
        Point2::new((off.x - s.x * y) / f.x, y)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn lens() -> Lens {
        let distortion = Distortion::plumb_bob([-0.12, 0.03, 0.001, -0.0015, 0.0]);
        Lens { distortion, ..Lens::pinhole([1280, 800], [1410.0, 1395.0], [640.0, 817.0]) }
    }

    #[test]
    fn a_point_on_the_axis_lands_on_the_principal_point() {
        assert_eq!(lens().project(&Point3::new(0.0, 0.0, 1.7)), Some(Point2::new(640.0, 817.0)));
        assert_eq!(lens().project(&Point3::new(0.1, 0.0, 0.0)), None);
        assert_eq!(lens().project(&Point3::new(0.1, 0.0, -1.0)), None);
        assert_eq!(lens().project(&Point3::new(0.1, 0.0, f64::NAN)), None);
        assert!(lens().project_with_jacobian(&Point3::new(0.1, 0.0, f64::NAN)).is_none());
    }

    #[test]
    fn skews_move_pixels_as_k_says() {
        let lens = Lens { skew_px: Vector2::new(-4.0, 2.0), ..lens() };
        let place = lens.distortion.distort(Point2::new(0.3, 0.4)).unwrap();
        let by_k = lens.matrix() * place.to_homogeneous();
        assert!((lens.project(&Point3::new(0.6, 0.8, 2.0)).unwrap() - Point2::from(by_k.xy())).norm() < 1e-9);
        let without = Lens { skew_px: Vector2::zeros(), ..lens };
        let off = lens.pixel(Point2::new(0.3, 0.4)).unwrap() - without.pixel(Point2::new(0.3, 0.4)).unwrap();
        assert!((off - Vector2::new(-4.0 * place.y, 2.0 * place.x)).norm() < 1e-9);
    }

    #[test]
    fn an_integer_is_a_pixels_centre() {
        let lens = lens();
        assert!(lens.contains(Point2::new(-0.5, 0.0)) && lens.contains(Point2::new(1279.4, 799.4)));
        assert!(!lens.contains(Point2::new(-0.6, 0.0)) && !lens.contains(Point2::new(1279.6, 0.0)));
    }

    /// Lenses: plain, with skews, mirrored, or both.
    fn lenses() -> impl Strategy<Value = Lens> {
        (prop_oneof![Just([0.0; 2]), Just([-4.0, 0.0]), Just([60.0, -9.0])], any::<bool>()).prop_map(
            |(skew, mirrors)| {
                let sign = if mirrors { -1.0 } else { 1.0 };
                Lens { skew_px: skew.into(), focal_px: Vector2::new(sign * 1410.0, 1395.0), ..lens() }
            },
        )
    }

    proptest! {
        #[test]
        fn a_ray_lands_where_it_came_from(lens in lenses(), u in 0.0..1280.0, v in 0.0..800.0, depth in 0.3..5.0) {
            let pixel = Point2::new(u, v);
            let point = Point3::from(lens.ray(pixel).unwrap() * depth);
            prop_assert!((lens.project(&point).unwrap() - pixel).norm() < 1e-7);
        }

        #[test]
        fn derivatives_are_the_differences(lens in lenses(), x in -0.4..0.4, y in -0.6..0.2, z in 0.6..3.0) {
            let point = Point3::new(x, y, z);
            let projected = lens.project_with_jacobian(&point).unwrap();
            prop_assert!((projected.pixel - lens.project(&point).unwrap()).norm() < 1e-9);
            for axis in 0..3 {
                let mut step = Vector3::zeros();
                step[axis] = 1e-6;
                let change = lens.project(&(point + step)).unwrap() - lens.project(&(point - step)).unwrap();
                prop_assert!((change / 2e-6 - projected.by_point.column(axis)).norm() < 1e-3);
            }
        }
    }
}
