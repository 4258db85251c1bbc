//! Direct linear transformation (Abdel-Aziz and Karara, 1971): lens without distortion and pose from six points,
//! normalised as in Hartley and Zisserman, "Multiple View Geometry" (2nd ed., 7.1).
//!
//! Six points give twelve equations for the ratios of the twelve entries of the 3×4 matrix P, so one is redundant.
//! Elimination with full pivoting solves them in a fixed number of steps. P = K [R t] is then decomposed row by row,
//! from the last to the first.

use nalgebra::{
    Isometry3, Matrix3, Point2, Point3, Rotation3, SMatrix, SVector, Translation3, UnitQuaternion, Vector3,
};

use crate::statistics::median;
use crate::{Lens, Sample};

/// Plausible ratios of the focal lengths.
const FOCAL_RATIO: std::ops::Range<f64> = 0.2..5.0;
/// Reweighting rounds.
const ROUNDS: usize = 12;
/// Minimum ratio of the second smallest and the largest eigenvalue of determined equations.
const DETERMINED: f64 = 1e-9;

/// Lens and pose `lens_from_points` of six correspondences; `None` if they are coplanar, mirrored or behind the lens.
pub(super) fn lens_and_pose(
    points: &[Point3<f64>; 6],
    pixels: &[Point2<f64>; 6],
    size_px: [u32; 2],
) -> Option<(Lens, Isometry3<f64>)> {
    let center: Vector3<f64> = points.iter().map(|point| point.coords).sum::<Vector3<f64>>() / 6.0;
    let spread = points.iter().map(|point| (point.coords - center).norm()).sum::<f64>() / 6.0;
    let unit_px = f64::from(size_px[0].max(size_px[1])) * 0.5;
    let middle = Point2::new(f64::from(size_px[0]) * 0.5, f64::from(size_px[1]) * 0.5);
    let mut equations = SMatrix::<f64, 12, 12>::zeros();
    for (i, (point, pixel)) in points.iter().zip(pixels).enumerate() {
        let place = ((point.coords - center) / spread).push(1.0);
        let seen = (pixel - middle) / unit_px;
        for axis in 0..2 {
            for column in 0..4 {
                equations[(2 * i + axis, 4 * axis + column)] = place[column];
                equations[(2 * i + axis, 8 + column)] = -seen[axis] * place[column];
            }
        }
    }
    let p = null_vector(equations)?;
    let rows = SMatrix::<f64, 3, 4>::from_fn(|row, column| p[4 * row + column]);
    let left: Matrix3<f64> = rows.fixed_view::<3, 3>(0, 0) / spread;
    let last: Vector3<f64> = rows.column(3) - left * center;
    let Decomposition { k, rotation, translation, .. } = decompose(left, last)?;
    let is_before = |point: &Point3<f64>| (rotation * point.coords + translation).z > 0.0;
    // Mirrored pixels put all points behind the lens; gross errors may be there, too.
    if points.iter().filter(|point| is_before(point)).count() < 4 {
        return None;
    }
    let lens = Lens::pinhole(
        size_px,
        [k[(0, 0)] * unit_px, k[(1, 1)] * unit_px],
        [k[(0, 2)] * unit_px + middle.x, k[(1, 2)] * unit_px + middle.y],
    );
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Some((lens, Isometry3::from_parts(Translation3::from(translation), turn)))
}

/// Decomposition P = K [R t] with positive focal lengths and K's last entry 1.
struct Decomposition {
    /// K without its skew.
    k: Matrix3<f64>,
    skew: f64,
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

fn decompose(left: Matrix3<f64>, last: Vector3<f64>) -> Option<Decomposition> {
    let scale = left.row(2).norm();
    let [m1, m2, m3] = [0, 1, 2].map(|row| left.row(row).transpose() / scale);
    let last = last / scale;
    let (cx, cy) = (m1.dot(&m3), m2.dot(&m3));
    let second = m2 - m3 * cy;
    let fy = second.norm();
    let r2 = second / fy;
    let first = m1 - m3 * cx;
    let skew = first.dot(&r2);
    let first = first - r2 * skew;
    let fx = first.norm();
    let r1 = first / fx;
    let is_sound = [fx, fy, cx, cy].iter().all(|value| value.is_finite()) && FOCAL_RATIO.contains(&(fx / fy));
    if !is_sound {
        return None;
    }
    let t = Vector3::new((last.x - cx * last.z) / fx, (last.y - cy * last.z) / fy, last.z);
    let rotation = Matrix3::from_rows(&[r1.transpose(), r2.transpose(), m3.transpose()]);
    // P is known up to its sign, and only one of them is a rotation.
    let sign = rotation.determinant().signum();
    let k = Matrix3::new(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0);
    Some(Decomposition { k, skew, rotation: rotation * sign, translation: t * sign })
}

/// Robust estimate, by iterative reweighting, of the skew of a lens without distortion as a share of the smaller focal
/// length, and the median error in pixels; `None` if the points are coplanar.
pub(crate) fn skew_of_all(samples: &[Sample], size_px: [u32; 2]) -> Option<(f64, f64)> {
    let center = samples.iter().map(|sample| sample.point.coords).sum::<Vector3<f64>>() / samples.len().max(1) as f64;
    let spread = samples.iter().map(|sample| (sample.point.coords - center).norm()).sum::<f64>() / samples.len() as f64;
    let unit_px = f64::from(size_px[0].max(size_px[1])) * 0.5;
    let middle = Point2::new(f64::from(size_px[0]) * 0.5, f64::from(size_px[1]) * 0.5);
    let places: Vec<_> = (samples.iter())
        .map(|sample| (((sample.point.coords - center) / spread).push(1.0), (sample.pixel - middle) / unit_px))
        .collect();
    let mut weights = vec![1.0; samples.len()];
    let mut found = None;
    for _ in 0..ROUNDS {
        let mut normal = SMatrix::<f64, 12, 12>::zeros();
        for ((place, seen), weight) in places.iter().zip(&weights) {
            for axis in 0..2 {
                let mut row = SVector::<f64, 12>::zeros();
                row.fixed_rows_mut::<4>(4 * axis).copy_from(place);
                row.fixed_rows_mut::<4>(8).copy_from(&(place * -seen[axis]));
                normal += row * row.transpose() * *weight;
            }
        }
        let eigen = normal.symmetric_eigen();
        let mut order: [usize; 12] = std::array::from_fn(|i| i);
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        // Coplanar points have several solutions.
        if eigen.eigenvalues[order[1]].is_nan()
            || eigen.eigenvalues[order[1]] < DETERMINED * eigen.eigenvalues[order[11]]
        {
            return None;
        }
        let p = eigen.eigenvectors.column(order[0]).into_owned();
        let rows = SMatrix::<f64, 3, 4>::from_fn(|row, column| p[4 * row + column]);
        let errors: Vec<f64> = (places.iter())
            .map(|(place, seen)| {
                let projected = rows * place;
                (projected.xy() / projected.z - seen).norm() * unit_px
            })
            .collect();
        let typical_px = median(&mut errors.clone()).max(1e-9);
        weights = (errors.iter().zip(&places))
            .map(|(error, (place, _))| (rows * place).z.powi(-2) / (1.0 + (error / (2.0 * typical_px)).powi(2)))
            .collect();
        let Decomposition { k, skew, .. } =
            decompose(rows.fixed_view::<3, 3>(0, 0).into_owned(), rows.column(3).into_owned())?;
        found = Some((skew / k[(0, 0)].min(k[(1, 1)]), typical_px));
    }
    found
}

/// Null vector of a matrix of rank eleven; `None` if the rank is lower.
fn null_vector(mut a: SMatrix<f64, 12, 12>) -> Option<[f64; 12]> {
    let mut columns: [usize; 12] = std::array::from_fn(|i| i);
    for step in 0..11 {
        let (mut row, mut column) = (step, step);
        for j in step..12 {
            for i in step..12 {
                if a[(i, j)].abs() > a[(row, column)].abs() {
                    (row, column) = (i, j);
                }
            }
        }
        if a[(row, column)].is_nan() || a[(row, column)].abs() < 1e-10 {
            return None;
        }
        a.swap_rows(step, row);
        a.swap_columns(step, column);
        columns.swap(step, column);
        for i in step + 1..12 {
            let factor = a[(i, step)] / a[(step, step)];
            for j in step..12 {
                a[(i, j)] -= factor * a[(step, j)];
            }
        }
    }
    let mut solution = [0.0; 12];
    solution[11] = 1.0;
    for row in (0..11).rev() {
        let sum: f64 = (row + 1..12).map(|column| a[(row, column)] * solution[column]).sum();
        solution[row] = -sum / a[(row, row)];
    }
    let mut sorted = [0.0; 12];
    for (column, value) in columns.iter().zip(solution) {
        sorted[*column] = value;
    }
    Some(sorted)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn truth() -> (Lens, Isometry3<f64>) {
        let lens = Lens::pinhole([1280, 800], [1410.0, 1395.0], [655.0, 817.0]);
        (lens, Isometry3::new(Vector3::new(0.2, 0.15, 0.05), Vector3::new(0.1, -0.2, 0.05)))
    }

    proptest! {
        #[test]
        fn six_exact_points_give_lens_and_pose(
            places in prop::array::uniform6((-0.5..0.5, -0.4..0.4, 0.8..2.0)),
        ) {
            let (lens, pose) = truth();
            let points = places.map(|(x, y, z): (f64, f64, f64)| Point3::new(x * z, y * z, z));
            let pixels = points.map(|point| lens.project(&(pose * point)).unwrap());
            if let Some((found, found_pose)) = lens_and_pose(&points, &pixels, lens.size_px) {
                // Points near a plane or a twisted cubic determine little.
                let error = points.iter().zip(&pixels).map(|(point, pixel)| {
                    found.project(&(found_pose * point)).map_or(1e9, |found| (found - pixel).norm())
                });
                let is_found = (found.focal_px - lens.focal_px).norm() < 0.1;
                prop_assert!(error.fold(0.0, f64::max) < 1e-2 || !is_found);
            }
        }
    }

    #[test]
    fn a_box_gives_the_lens_and_a_mirrored_box_none() {
        let (lens, pose) = truth();
        let points =
            [[-0.4, -0.3, 1.0], [0.5, -0.2, 1.3], [0.4, 0.3, 0.9], [-0.3, 0.4, 1.8], [0.0, 0.0, 1.5], [0.2, -0.4, 1.9]]
                .map(Point3::from);
        let pixels = points.map(|point| lens.project(&(pose * point)).unwrap());
        let (found, found_pose) = lens_and_pose(&points, &pixels, lens.size_px).unwrap();
        assert!((found.focal_px - lens.focal_px).norm() < 1e-5 && (found.center_px - lens.center_px).norm() < 1e-5);
        assert!((found_pose.translation.vector - pose.translation.vector).norm() < 1e-8);
        let mirrored = pixels.map(|pixel| Point2::new(1279.0 - pixel.x, pixel.y));
        assert!(lens_and_pose(&points, &mirrored, lens.size_px).is_none());
        let flat = points.map(|point| Point3::new(point.x, point.y, 1.5));
        let pixels = flat.map(|point| lens.project(&(pose * point)).unwrap());
        assert!(lens_and_pose(&flat, &pixels, lens.size_px).is_none());
    }
}
