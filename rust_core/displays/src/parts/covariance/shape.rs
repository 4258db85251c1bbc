//! Axes and standard deviations of a covariance matrix.
//!
//! A message's matrix is 6 × 6, row by row, of x, y, z and rotations about X, Y, Z. rviz reads the part on and above
//! the diagonal.

use nalgebra::{Isometry3, Matrix2, Matrix3, Rotation3, Vector3};
use rcs_messages::geometry_msgs::PoseWithCovariance;
use rcs_messages::PlainTransform;

use super::principal_axes;
use crate::framework::world::{all_finite, isometry};

/// Thickness of flat shapes, in metres.
pub(super) const FLAT_M: f64 = 0.001;

/// A covariance of finite numbers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Covariance([f64; 36]);

/// Pose in the message's frame and its covariance; `None` unless all numbers are [finite](all_finite).
pub(crate) fn uncertain_pose(message: &PoseWithCovariance) -> Option<(Isometry3<f64>, Covariance)> {
    let pose = isometry(&PlainTransform::from(&message.pose))?;
    all_finite(&message.covariance).then_some((pose, Covariance(message.covariance)))
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct CovarianceShape {
    /// Axes of the ellipsoid in the message's frame.
    pub(super) ellipsoid_axes: Rotation3<f64>,
    /// Diameters along them: two standard deviations, in metres.
    pub(super) ellipsoid_m: Vector3<f64>,
    pub(super) orientation: OrientationShape,
}

/// Shape of an orientation's covariance. Angles are two standard deviations.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "lives for one call; never stored")]
pub(super) enum OrientationShape {
    /// Pose in space: elliptic discs in their XZ planes for roll, pitch and yaw.
    Discs {
        axes: [Rotation3<f64>; 3],
        /// Diameters along X and Z in radians; `None` without a valid one so far.
        diameters_rad: [Option<[f64; 2]>; 3],
    },
    /// Pose in the plane: width of a cone in radians; `None` without a valid one so far.
    Cone(Option<f64>),
}

/// Sizes of the last covariance with real standard deviations. One with a negative variance has its own axes, but these
/// sizes; the first ellipsoid has 1 m.
#[derive(Clone, Debug)]
pub(crate) struct CovarianceScales {
    ellipsoid_m: Vector3<f64>,
    discs_rad: [Option<[f64; 2]>; 3],
    cone_rad: Option<f64>,
}

impl Default for CovarianceScales {
    fn default() -> Self {
        Self { ellipsoid_m: Vector3::repeat(1.0), discs_rad: [None; 3], cone_rad: None }
    }
}

impl CovarianceScales {
    pub(super) fn update(&mut self, covariance: &Covariance) -> CovarianceShape {
        let planar = covariance.is_planar();
        let (ellipsoid_axes, ellipsoid_m) = if planar { covariance.ellipse() } else { covariance.ellipsoid() };
        if ellipsoid_m.iter().all(|diameter| !diameter.is_nan()) {
            self.ellipsoid_m = ellipsoid_m;
        }
        let orientation = if planar {
            let width_rad = 2.0 * covariance.at(5, 5).sqrt();
            if !width_rad.is_nan() {
                self.cone_rad = Some(width_rad);
            }
            OrientationShape::Cone(self.cone_rad)
        } else {
            let discs = [(4, 5), (3, 5), (3, 4)].map(|(i, j)| covariance.disc(i, j));
            for (kept, (_, diameters_rad)) in self.discs_rad.iter_mut().zip(&discs) {
                if diameters_rad.iter().all(|diameter| !diameter.is_nan()) {
                    *kept = Some(*diameters_rad);
                }
            }
            OrientationShape::Discs { axes: discs.map(|(axes, _)| axes), diameters_rad: self.discs_rad }
        };
        CovarianceShape { ellipsoid_axes, ellipsoid_m: self.ellipsoid_m, orientation }
    }
}

impl Covariance {
    /// Covariance of two coordinates; `row` ≤ `column` < 6.
    fn at(&self, row: usize, column: usize) -> f64 {
        self.0[6 * row + column]
    }

    /// `true` for a pose in the plane: z, roll and pitch have no variance.
    fn is_planar(&self) -> bool {
        [2, 3, 4].iter().all(|i| self.at(*i, *i) <= 0.0)
    }

    fn ellipsoid(&self) -> (Rotation3<f64>, Vector3<f64>) {
        let at = |i: usize, j: usize| self.at(i.min(j), i.max(j));
        let (variances, axes) = principal_axes::of_three(&Matrix3::from_fn(at));
        (Rotation3::from_matrix_unchecked(axes), variances.map(|variance| 2.0 * variance.sqrt()))
    }

    fn ellipse(&self) -> (Rotation3<f64>, Vector3<f64>) {
        let ([a, b], axes) = self.plane(0, 1);
        let axes = Matrix3::new(axes.m11, axes.m12, 0.0, axes.m21, axes.m22, 0.0, 0.0, 0.0, 1.0);
        (Rotation3::from_matrix_unchecked(axes), Vector3::new(a, b, FLAT_M))
    }

    fn disc(&self, i: usize, j: usize) -> (Rotation3<f64>, [f64; 2]) {
        let (diameters, axes) = self.plane(i, j);
        let axes = Matrix3::new(axes.m11, 0.0, axes.m12, 0.0, 1.0, 0.0, axes.m21, 0.0, axes.m22);
        (Rotation3::from_matrix_unchecked(axes), diameters)
    }

    /// Two standard deviations along the axes of two coordinates.
    fn plane(&self, i: usize, j: usize) -> ([f64; 2], Matrix2<f64>) {
        let matrix = Matrix2::new(self.at(i, i), self.at(i, j), self.at(i, j), self.at(j, j));
        let (variances, axes) = principal_axes::of_two(&matrix);
        ([variances.x, variances.y].map(|variance| 2.0 * variance.sqrt()), axes)
    }
}
