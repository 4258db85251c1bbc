//! P3P: pose of a known lens from three points, by Grunert's solution of 1841 in the form of Haralick, Lee, Ottenberg
//! and Nölle, "Review and analysis of solutions of the three point perspective pose estimation problem" (IJCV 1994).
//!
//! The law of cosines in the triangles of two points and the lens centre gives a quartic in the ratio of two distances.
//! Each real root gives the distances, and three points in both frames the pose. The roots are the eigenvalues of the
//! quartic's companion matrix; Newton steps on the distances then recover their rounding errors.

use nalgebra::{Isometry3, Matrix3, Matrix4, Rotation3, Schur, Translation3, UnitQuaternion, Vector3};

/// Newton steps on the distances.
const POLISHING_STEPS: usize = 3;
/// Maximum imaginary part of a real root as a share of its size: noise splits double roots.
const NEARLY_REAL: f64 = 1e-3;
/// Maximum number of steps towards the eigenvalues.
const SCHUR_STEPS: usize = 100;

/// Up to four poses `lens_from_points` that put the points onto rays of any length.
pub(super) fn poses(points: [Vector3<f64>; 3], rays: [Vector3<f64>; 3]) -> impl Iterator<Item = Isometry3<f64>> {
    let [ray_1, ray_2, ray_3] = rays.map(|ray| ray.normalize());
    let (cos_a, cos_b, cos_c) = (ray_2.dot(&ray_3), ray_1.dot(&ray_3), ray_1.dot(&ray_2));
    let a2 = (points[1] - points[2]).norm_squared();
    let b2 = (points[0] - points[2]).norm_squared();
    let c2 = (points[0] - points[1]).norm_squared();
    let (a_to_b, c_to_b) = (a2 / b2, c2 / b2);
    let difference = a_to_b - c_to_b;
    let missing = 1.0 - a_to_b - c_to_b;
    let quartic = [
        (difference - 1.0).powi(2) - 4.0 * c_to_b * cos_a * cos_a,
        4.0 * (difference * (1.0 - difference) * cos_b - missing * cos_a * cos_c
            + 2.0 * c_to_b * cos_a * cos_a * cos_b),
        2.0 * (difference * difference - 1.0
            + 2.0 * difference * difference * cos_b * cos_b
            + 2.0 * (1.0 - c_to_b) * cos_a * cos_a
            - 4.0 * (a_to_b + c_to_b) * cos_a * cos_b * cos_c
            + 2.0 * (1.0 - a_to_b) * cos_c * cos_c),
        4.0 * (-difference * (1.0 + difference) * cos_b + 2.0 * a_to_b * cos_c * cos_c * cos_b
            - missing * cos_a * cos_c),
        (1.0 + difference).powi(2) - 4.0 * a_to_b * cos_c * cos_c,
    ];
    real_roots(quartic).filter_map(move |third_to_first| {
        let v = third_to_first;
        let u = ((difference - 1.0) * v * v - 2.0 * difference * cos_b * v + 1.0 + difference)
            / (2.0 * (cos_c - v * cos_a));
        let first = (b2 / (1.0 + v * v - 2.0 * v * cos_b)).sqrt();
        let distances = Vector3::new(first, u * first, v * first);
        if !distances.iter().all(|distance| distance.is_finite() && *distance > 0.0) {
            return None;
        }
        let distances = refined(distances, [cos_a, cos_b, cos_c], Vector3::new(a2, b2, c2));
        pose_between(points, [ray_1 * distances[0], ray_2 * distances[1], ray_3 * distances[2]])
    })
}

/// Distances after Newton steps on the law of cosines in the three triangles: a root of the quartic loses digits where
/// its quotient of two distances is ill-conditioned. `squares` are those of the sides opposite to each point.
fn refined(mut distances: Vector3<f64>, [cos_a, cos_b, cos_c]: [f64; 3], squares: Vector3<f64>) -> Vector3<f64> {
    let residuals = |d: &Vector3<f64>| {
        let side = |i: usize, j: usize, cos: f64| d[i] * d[i] + d[j] * d[j] - 2.0 * d[i] * d[j] * cos;
        Vector3::new(side(1, 2, cos_a), side(0, 2, cos_b), side(0, 1, cos_c)) - squares
    };
    for _ in 0..POLISHING_STEPS {
        let d = distances;
        let slope = |i: usize, j: usize, cos: f64| 2.0 * (d[i] - d[j] * cos);
        let jacobian = Matrix3::new(
            0.0,
            slope(1, 2, cos_a),
            slope(2, 1, cos_a),
            slope(0, 2, cos_b),
            0.0,
            slope(2, 0, cos_b),
            slope(0, 1, cos_c),
            slope(1, 0, cos_c),
            0.0,
        );
        let Some(step) = jacobian.lu().solve(&residuals(&d)) else { break };
        let better = d - step;
        let is_better = residuals(&better).norm() < residuals(&d).norm();
        if !is_better {
            break;
        }
        distances = better;
    }
    distances
}

/// Pose that maps three points onto three others, exactly if the triangles are congruent.
fn pose_between(from: [Vector3<f64>; 3], to: [Vector3<f64>; 3]) -> Option<Isometry3<f64>> {
    let turn = axes(to)? * axes(from)?.transpose();
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    Some(Isometry3::from_parts(Translation3::from(to[0] - rotation * from[0]), rotation))
}

/// Orthonormal axes of a triangle; `None` if its corners are collinear.
fn axes(corners: [Vector3<f64>; 3]) -> Option<Matrix3<f64>> {
    let along = (corners[1] - corners[0]).try_normalize(0.0)?;
    let normal = along.cross(&(corners[2] - corners[0])).try_normalize(1e-12)?;
    Some(Matrix3::from_columns(&[along, normal.cross(&along), normal]))
}

/// Real roots of `c[0] x⁴ + c[1] x³ + c[2] x² + c[3] x + c[4]`, at most four; none if they are not finite.
fn real_roots(c: [f64; 5]) -> impl Iterator<Item = f64> {
    let [a3, a2, a1, a0] = [1, 2, 3, 4].map(|power| -c[power] / c[0]);
    let companion = Matrix4::new(a3, a2, a1, a0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let finite = Some(companion).filter(|companion| companion.iter().all(|entry| entry.is_finite()));
    let schur = finite.and_then(|companion| Schur::try_new(companion, f64::EPSILON, SCHUR_STEPS));
    let roots = schur.map(|schur| schur.complex_eigenvalues().data.0[0]);
    roots.into_iter().flatten().filter(|root| root.im.abs() <= NEARLY_REAL * root.re.abs()).map(|root| root.re)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_true_pose_is_among_those_found(
            seen in prop::array::uniform3(prop::array::uniform3(-1.0..1.0)),
            turn in prop::array::uniform3(-1.5..1.5),
            shift in prop::array::uniform3(-1.0..1.0),
        ) {
            let corners = seen.map(|[x, y, z]| Vector3::new(0.8 * x, 0.6 * y, 1.5 + 0.8 * z));
            let area = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
            prop_assume!(area > 0.05);
            let pose = Isometry3::new(shift.into(), turn.into());
            let points = corners.map(|corner| (pose.inverse() * nalgebra::Point3::from(corner)).coords);
            let found: Vec<_> = poses(points, corners).collect();
            prop_assert!(found.len() <= 4);
            let nearest = found.iter().map(|found| (found.inverse() * pose).translation.vector.norm());
            // Near a double root the pose is hard to tell, so a millimetre is allowed for.
            prop_assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-3, "{found:?} instead of {pose:?}");
        }
    }

    #[test]
    fn points_on_a_line_give_no_pose() {
        let points = [Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.1, 0.0, 1.0), Vector3::new(0.2, 0.0, 1.0)];
        assert_eq!(poses(points, points).count(), 0);
    }

    fn expanded(roots: [f64; 4]) -> [f64; 5] {
        let mut c = [1.0, 0.0, 0.0, 0.0, 0.0];
        for root in roots {
            for i in (1..5).rev() {
                c[i] -= root * c[i - 1];
            }
        }
        c
    }

    proptest! {
        #[test]
        fn real_roots_are_found(roots in prop::array::uniform4(-3.0..3.0), lead in 0.1..10.0) {
            let mut sorted = roots;
            sorted.sort_by(f64::total_cmp);
            prop_assume!(sorted.windows(2).all(|pair| pair[1] - pair[0] > 0.02));
            let found: Vec<f64> = real_roots(expanded(roots).map(|value| value * lead)).collect();
            for root in roots {
                prop_assert!(found.iter().any(|x| (x - root).abs() < 1e-6), "{root} not in {found:?}");
            }
        }
    }
}
