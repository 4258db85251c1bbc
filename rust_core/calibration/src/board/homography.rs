//! Homographies by the normalised direct linear transformation (Hartley and Zisserman, "Multiple View Geometry", 4.4).

use nalgebra::{Matrix3, Point2, SMatrix, SVector};

/// Homography that maps points of a plane to pixels; `None` for fewer than four points or points on a line.
pub(super) fn homography(from: &[Point2<f64>], to: &[Point2<f64>]) -> Option<Matrix3<f64>> {
    if from.len() < 4 {
        return None;
    }
    let (from_unit, to_unit) = (unit_from(from)?, unit_from(to)?);
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (from, to) in from.iter().zip(to) {
        let (place, seen) = (from_unit * from.to_homogeneous(), to_unit.transform_point(to));
        for axis in 0..2 {
            let mut row = SVector::<f64, 9>::zeros();
            row.fixed_rows_mut::<3>(3 * axis).copy_from(&place);
            row.fixed_rows_mut::<3>(6).copy_from(&(place * -seen[axis]));
            normal += row * row.transpose();
        }
    }
    let eigen = normal.symmetric_eigen();
    let entries = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let unit_homography = Matrix3::from_fn(|row, column| entries[3 * row + column]);
    let result = to_unit.try_inverse()? * unit_homography * from_unit;
    let scale = result[(2, 2)];
    (scale.abs() > f64::EPSILON && result.iter().all(|entry| entry.is_finite())).then(|| result / scale)
}

/// Similarity that moves points to a mean of 0 and a mean distance of √2.
fn unit_from(points: &[Point2<f64>]) -> Option<Matrix3<f64>> {
    let count = points.len() as f64;
    let middle = points.iter().map(|point| point.coords).sum::<nalgebra::Vector2<f64>>() / count;
    let spread = points.iter().map(|point| (point.coords - middle).norm()).sum::<f64>() / count;
    let scale = std::f64::consts::SQRT_2 / spread;
    scale.is_finite().then(|| Matrix3::new(scale, 0.0, -scale * middle.x, 0.0, scale, -scale * middle.y, 0.0, 0.0, 1.0))
}
