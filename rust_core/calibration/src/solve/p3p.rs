//! P3P: pose of a known lens from three points, by Grunert's solution of 1841 in the form of Haralick, Lee, Ottenberg
//! and Nölle, "Review and analysis of solutions of the three point perspective pose estimation problem" (IJCV 1994).
//!
//! The law of cosines in the triangles of two points and the lens centre gives a quartic in the ratio of two distances.
//! Each real root gives the distances, and three points in both frames the pose.
//! The quartic is solved by Ferrari's method: a real root of the resolvent cubic splits it into two quadratics; Newton
//! steps then recover the closed form's rounding errors (notation of Abramowitz and Stegun, 3.8.3).

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// Newton steps on each root.
const POLISHING_STEPS: usize = 3;
/// Maximum imaginary part of a real root as a share of its size: noise splits double roots.
const NEARLY_REAL: f64 = 1e-6;

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

/// Real roots of `c[0] x⁴ + c[1] x³ + c[2] x² + c[3] x + c[4]`, at most four; none if a coefficient is not finite.
pub(super) fn real_roots(c: [f64; 5]) -> impl Iterator<Item = f64> {
    let signs = [1.0, -1.0, 1.0, -1.0];
    let found = roots(c).into_iter().zip(signs).filter_map(|(root, sign)| Some((root?, sign)));
    found.map(move |(root, sign)| polished(c, root, sign)).filter(|root| root.is_finite())
}

fn roots(c: [f64; 5]) -> [Option<f64>; 4] {
    let largest = c.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    if !largest.is_finite() || largest == 0.0 {
        return [None; 4];
    }
    if c[0].abs() < 1e-12 * largest {
        return match cubic_root([c[1], c[2], c[3], c[4]]) {
            Some(root) => {
                let b = c[2] + c[1] * root;
                let [first, second] = quadratic(c[1], b, c[3] + b * root);
                [Some(root), first, second, None]
            }
            None => {
                let [first, second] = quadratic(c[2], c[3], c[4]);
                [first, second, None, None]
            }
        };
    }
    let [a3, a2, a1, a0] = [c[1] / c[0], c[2] / c[0], c[3] / c[0], c[4] / c[0]];
    // Without the cubic term, for y = x + a3 / 4: y⁴ + p y² + q y + r.
    let shift = 0.25 * a3;
    let p = a2 - 6.0 * shift * shift;
    let q = a1 - 2.0 * a2 * shift + 8.0 * shift.powi(3);
    let r = a0 - a1 * shift + a2 * shift * shift - 3.0 * shift.powi(4);
    // (y² + p/2 + m)² = 2m y² − q y + m² + m p + p²/4 − r, whose right side is a square for a root of this cubic.
    let Some(m) = cubic_root([8.0, 8.0 * p, 2.0 * p * p - 8.0 * r, -q * q]) else { return [None; 4] };
    let found = if m > 1e-14 * (1.0 + p.abs()) {
        let side = (2.0 * m).sqrt();
        let [first, second] = quadratic(1.0, -side, 0.5 * p + m + 0.5 * q / side);
        let [third, fourth] = quadratic(1.0, side, 0.5 * p + m - 0.5 * q / side);
        [first, second, third, fourth]
    } else {
        let [square, other] = quadratic(1.0, p, r).map(|square| square.filter(|square| *square >= 0.0));
        let (square, other) = (square.map(f64::sqrt), other.map(f64::sqrt));
        [square, square.map(|root| -root), other, other.map(|root| -root)]
    };
    found.map(|root| root.map(|root| root - shift))
}

/// Largest real root of a cubic; `None` if the leading coefficient is 0.
fn cubic_root(c: [f64; 4]) -> Option<f64> {
    if c[0] == 0.0 {
        return None;
    }
    let (b, linear, constant) = (c[1] / c[0] / 3.0, c[2] / c[0], c[3] / c[0]);
    // Without the quadratic term, for y = x + b: y³ + 3 p y + 2 q.
    let p = linear / 3.0 - b * b;
    let q = b.powi(3) - 0.5 * b * linear + 0.5 * constant;
    let discriminant = q * q + p.powi(3);
    let y = if discriminant > 0.0 {
        let larger = -q.signum() * (q.abs() + discriminant.sqrt()).cbrt();
        if larger == 0.0 {
            0.0
        } else {
            larger - p / larger
        }
    } else if p < 0.0 {
        let radius = (-p).sqrt();
        2.0 * radius * ((-q / radius.powi(3)).clamp(-1.0, 1.0).acos() / 3.0).cos()
    } else {
        0.0
    };
    let mut root = y - b;
    for _ in 0..POLISHING_STEPS {
        let slope = (3.0 * root + 6.0 * b) * root + linear;
        let step = (((root + 3.0 * b) * root + linear) * root + constant) / slope;
        if !step.is_finite() {
            break;
        }
        root -= step;
    }
    root.is_finite().then_some(root)
}

/// Real roots of a quadratic, without cancellation.
fn quadratic(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    if a == 0.0 {
        return [(b != 0.0).then(|| -c / b), None];
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < -NEARLY_REAL * (b * b + (a * c).abs()) {
        return [None; 2];
    }
    let sum = -0.5 * (b + b.signum() * discriminant.max(0.0).sqrt());
    [Some(sum / a), if sum == 0.0 { Some(0.0) } else { Some(c / sum) }]
}

/// A root without the closed form's rounding errors. Between the roots of a pair that rounding has merged, where Newton
/// steps fail, the parabola there parts them; `sign` selects one.
fn polished(c: [f64; 5], mut root: f64, sign: f64) -> f64 {
    let value = |x: f64| (((c[0] * x + c[1]) * x + c[2]) * x + c[3]) * x + c[4];
    let slope = |x: f64| ((4.0 * c[0] * x + 3.0 * c[1]) * x + 2.0 * c[2]) * x + c[3];
    let curvature = (12.0 * c[0] * root + 6.0 * c[1]) * root + 2.0 * c[2];
    let apart = slope(root).powi(2) - 2.0 * value(root) * curvature;
    if apart > 2.0 * slope(root).powi(2) {
        let parted = root + (sign * apart.sqrt() - slope(root)) / curvature;
        if value(parted).abs() < value(root).abs() {
            root = parted;
        }
    }
    for _ in 0..POLISHING_STEPS {
        let better = root - value(root) / slope(root);
        if better.is_finite() && value(better).abs() < value(root).abs() {
            root = better;
        } else {
            break;
        }
    }
    root
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

        #[test]
        fn complex_roots_are_not_made_up(a in 0.1..3.0, b in 0.1..3.0, x in -2.0..2.0, y in -2.0..2.0) {
            // ((t - x)² + a) ((t - y)² + b)
            let (first, second): ([f64; 3], [f64; 3]) = ([1.0, -2.0 * x, x * x + a], [1.0, -2.0 * y, y * y + b]);
            let mut c = [0.0; 5];
            for (i, left) in first.iter().enumerate() {
                for (j, right) in second.iter().enumerate() {
                    c[i + j] += left * right;
                }
            }
            prop_assert_eq!(real_roots(c).count(), 0);
        }
    }

    #[test]
    fn special_cases() {
        assert_eq!(real_roots([0.0; 5]).count(), 0);
        assert_eq!(real_roots([f64::NAN, 1.0, 1.0, 1.0, 1.0]).count(), 0);
        let mut found: Vec<f64> = real_roots([1.0, 0.0, -5.0, 0.0, 4.0]).collect();
        found.sort_by(f64::total_cmp);
        assert!(found.iter().zip([-2.0, -1.0, 1.0, 2.0]).all(|(x, y)| (x - y).abs() < 1e-12), "{found:?}");
        assert!(real_roots([0.0, 1.0, -6.0, 11.0, -6.0]).count() == 3);
        assert!(real_roots([0.0, 0.0, 1.0, -3.0, 2.0]).count() == 2);
    }
}
