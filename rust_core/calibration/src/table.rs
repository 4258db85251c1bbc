//! Frame of the plane that most points of a scan lie on, such as the top of a table.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::solve::LargestPlane;

/// Minimum share of the points on the plane.
const LEAST_SHARE: f64 = 0.25;
/// Minimum sine of the angle between the optical axis and the plane.
const LEAST_SINE: f64 = 0.1;

/// Plane with a frame: the origin is where the camera's optical axis meets it, x points to the right in the camera's
/// image, z towards the camera's side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table {
    /// Pose of the frame in the camera's optical frame, metres.
    pub camera_from_table: Isometry3<f64>,
    /// Share of the points that lie on the plane.
    pub share: f64,
}

/// Reason why there is no [`Table`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TableProblem {
    /// Too small a share of the points lies on one plane.
    #[error(
        "no table: at most {:.0} % of the points lie on one plane, {:.0} % are needed; leave --table out",
        100.0 * .0, 100.0 * LEAST_SHARE
    )]
    NoPlane(f64),
    /// The camera looks along the plane.
    #[error("no table: the camera looks along the plane that most points lie on; it must look onto the table")]
    Grazing,
}

impl Table {
    /// Finds the table among points of the camera's optical frame, metres.
    ///
    /// # Errors
    /// [`TableProblem`].
    pub fn find(points: &[Point3<f64>]) -> Result<Self, TableProblem> {
        let plane = LargestPlane::find(points, 0).map(|plane| plane.refined(points));
        let plane = plane.ok_or(TableProblem::NoPlane(0.0))?;
        if plane.share < LEAST_SHARE {
            return Err(TableProblem::NoPlane(plane.share));
        }
        // The camera is at the origin, on the side that the normal points to.
        let side = -plane.offset.signum();
        let (z, offset) = (side * plane.normal, side * plane.offset);
        if -z.z < LEAST_SINE {
            return Err(TableProblem::Grazing);
        }
        let origin = Vector3::new(0.0, 0.0, offset / z.z);
        let x = (Vector3::x() - z * z.x).normalize();
        let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
        let rotation = UnitQuaternion::from_rotation_matrix(&axes);
        let camera_from_table = Isometry3::from_parts(Translation3::from(origin), rotation);
        Ok(Self { camera_from_table, share: plane.share })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a table, seen from above at this slope, of which every third is of something on it.
    fn points(down_rad: f64) -> Vec<Point3<f64>> {
        let camera_from_table =
            Isometry3::new(Vector3::new(0.0, 0.0, 1.2), Vector3::x() * (std::f64::consts::PI - down_rad));
        let at = |index: usize| {
            let (column, row) = ((index % 40) as f64, (index / 40) as f64);
            let height = if index.is_multiple_of(3) { 0.03 + 0.004 * ((index / 3) % 50) as f64 } else { 0.0 };
            camera_from_table * Point3::new(0.02 * column - 0.4, 0.02 * row - 0.3, height)
        };
        (0..1200).map(at).collect()
    }

    #[test]
    fn the_tables_frame_lies_where_the_camera_looks_with_z_up() {
        let table = Table::find(&points(0.7)).unwrap();
        assert!((0.66..0.75).contains(&table.share), "{table:?}");
        let pose = table.camera_from_table;
        assert!((pose.translation.vector - Vector3::new(0.0, 0.0, 1.2)).norm() < 1e-6, "{pose}");
        assert!((pose * Vector3::x() - Vector3::x()).norm() < 1e-6, "{pose}");
        // Up is back towards the camera and upwards in the image.
        let up = pose * Vector3::z();
        assert!((up - Vector3::new(0.0, -0.7_f64.sin(), -0.7_f64.cos())).norm() < 1e-6, "{up}");
        assert!((pose * Vector3::y()).y < 0.0, "y points away from the camera");
    }

    #[test]
    fn what_is_no_table_is_refused() {
        assert_eq!(Table::find(&points(0.0)[..3]), Err(TableProblem::NoPlane(0.0)));
        let ball = |index: usize| {
            let turn = UnitQuaternion::from_euler_angles(0.37 * index as f64, 0.61 * index as f64, 0.0);
            Point3::new(0.0, 0.0, 1.5) + turn * Vector3::new(0.0, 0.0, 0.5)
        };
        let problem = Table::find(&(0..1000).map(ball).collect::<Vec<_>>());
        assert!(matches!(problem, Err(TableProblem::NoPlane(share)) if share < 0.2), "{problem:?}");
        assert_eq!(Table::find(&points(1.5)), Err(TableProblem::Grazing));
    }
}
