//! The principal axes of a covariance, in the order and with the signs that rviz's image needs.
//!
//! Any solver finds the same axes, but their order and signs are arbitrary, and both are visible: the sphere of an
//! ellipsoid has its poles on the third axis, and its facets lie around them. So the axes are found with the symmetric
//! QR algorithm as textbooks have it (Golub and Van Loan, Matrix Computations, 8.3), each rotation making the remaining
//! entry positive; then
//!
//! * the variances rise,
//! * where that is left-handed, the first two axes change places (as in rviz's `CovarianceVisual`, which makes a pair
//!   of axes right-handed this way; their variances then fall).
//!
//! So the axes of a covariance without covariances are a right-handed order of x, y and z. nalgebra's `SymmetricEigen`
//! finds the same axes, but others of them are swapped and turned over, which costs up to 2 % of strict score.
//!
//! Rounding may leave a zero variance a little below zero, which would count as invalid. So a negative variance within
//! the rounding error of the largest one is zero.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Steps after which the matrix counts as not converging; two for each row are usual.
const MAX_STEPS: usize = 100;

/// Share of the largest entry below which a negative variance is zero.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Share of the largest entry below which entries are left out: they are below its rounding error, and their squares
/// must not underflow.
const NEGLIGIBLE: f64 = f64::EPSILON * f64::EPSILON;

/// Variances of a symmetric matrix along its principal axes, which are the columns of a rotation.
///
/// Zeros and the identity for a matrix that is zero, not finite or does not converge.
pub(super) fn of_three(matrix: &Matrix3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let largest = matrix.amax();
    let share = |entry: f64| if (entry / largest).abs() < NEGLIGIBLE { 0.0 } else { entry / largest };
    let is_usable = largest > 0.0 && matrix.iter().all(|entry| entry.is_finite());
    let Some((values, mut axes)) = is_usable.then(|| diagonalized(matrix.map(share))).flatten() else {
        return (Vector3::zeros(), Matrix3::identity());
    };
    let variance = |value: f64| if (-ROUNDING..0.0).contains(&value) { 0.0 } else { value * largest };
    let mut variances = values.map(variance);
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        if variances[j] < variances[i] {
            variances.swap_rows(i, j);
            axes.swap_columns(i, j);
        }
    }
    if axes.determinant() < 0.0 {
        variances.swap_rows(0, 1);
        axes.swap_columns(0, 1);
    }
    (variances, axes)
}

/// Principal axes of two coordinates: the first two of three, the third having a larger variance.
pub(super) fn of_two(matrix: &Matrix2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
    let mut with_third = matrix.to_homogeneous();
    // No variance is above twice the largest entry.
    with_third.m33 = (4.0 * matrix.amax()).min(f64::MAX);
    let (variances, axes) = of_three(&with_third);
    (variances.xy(), axes.fixed_view::<2, 2>(0, 0).into_owned())
}

/// Eigenvalues and, as columns, eigenvectors; `None` where they do not converge.
fn diagonalized(matrix: Matrix3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let (mut a, mut axes) = tridiagonal(matrix);
    for _ in 0..MAX_STEPS {
        for i in 0..2 {
            let neighbours = a[(i, i)].abs() + a[(i + 1, i + 1)].abs();
            if a[(i + 1, i)].abs() <= f64::EPSILON * neighbours {
                a[(i + 1, i)] = 0.0;
            }
        }
        // The lowest block that is not diagonal yet.
        let Some(last) = [2, 1].into_iter().find(|&i| a[(i, i - 1)] != 0.0) else {
            return Some((a.diagonal(), axes));
        };
        let first = if last == 2 && a.m21 != 0.0 { 0 } else { last - 1 };
        let mut column = [a[(first, first)] - shift(&a, last), a[(first + 1, first)]];
        for k in first..last {
            let turn = rotation(k, column);
            a = turn.transpose() * a * turn;
            axes *= turn;
            if k + 1 < last {
                // The turn has put an entry below the subdiagonal, which the next one takes away.
                column = [a[(k + 1, k)], a[(k + 2, k)]];
            }
        }
    }
    None
}

/// Makes the corners of the matrix zero by a reflection of y and z, which is returned, too.
fn tridiagonal(matrix: Matrix3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    if matrix.m31 == 0.0 {
        return (matrix, Matrix3::identity());
    }
    let [y, z] = unit([matrix.m21, matrix.m31]);
    let reflection = Matrix3::new(1.0, 0.0, 0.0, 0.0, y, z, 0.0, z, -y);
    let mut reflected = reflection * matrix * reflection;
    (reflected.m31, reflected.m13) = (0.0, 0.0);
    (reflected, reflection)
}

/// Wilkinson's shift: the eigenvalue of the 2 × 2 block above `last` that is nearer to the last entry.
fn shift(a: &Matrix3<f64>, last: usize) -> f64 {
    let (beside, end) = (a[(last, last - 1)], a[(last, last)]);
    let half = (a[(last - 1, last - 1)] - end) / 2.0;
    end - beside * (beside / (half + half.hypot(beside).copysign(half)))
}

/// Rotation in the plane of the axes `k` and `k + 1` whose transpose takes (x, y) to (r, 0), r ≥ 0.
fn rotation(k: usize, column: [f64; 2]) -> Matrix3<f64> {
    let [cos, sin] = unit(column);
    let mut turn = Matrix3::identity();
    (turn[(k, k)], turn[(k, k + 1)]) = (cos, -sin);
    (turn[(k + 1, k)], turn[(k + 1, k + 1)]) = (sin, cos);
    turn
}

/// A vector of length one in a direction; x for none.
fn unit([x, y]: [f64; 2]) -> [f64; 2] {
    match x.hypot(y) {
        0.0 => [1.0, 0.0],
        length => [x / length, y / length],
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Matrix3, Rotation3, UnitQuaternion, Vector2, Vector3};
    use proptest::prelude::*;

    use super::*;

    /// Properties of any finite symmetric matrix.
    fn check(matrix: &Matrix3<f64>) -> Result<(), TestCaseError> {
        let (variances, axes) = of_three(matrix);
        let size = if matrix.amax() > 0.0 { matrix.amax() } else { 1.0 };
        prop_assert!((axes.transpose() * axes - Matrix3::identity()).amax() < 1e-12, "not orthonormal: {axes}");
        prop_assert!(axes.determinant() > 0.0, "left-handed: {axes}");
        for (axis, variance) in axes.column_iter().zip(&variances) {
            let residual = (matrix / size * axis - axis * (variance / size)).amax();
            prop_assert!(residual < 1e-12 + 5e-324 / size, "{axis} is off by {residual}: {matrix} {variances}");
        }
        prop_assert!(variances.x.max(variances.y) <= variances.z, "the largest is not the third: {variances}");
        Ok(())
    }

    /// Properties of two coordinates, which are turned by 45° at most, as far as the angle is determined: it is not
    /// where both variances are equal and the covariance is about their rounding error.
    fn check_two(matrix: &Matrix2<f64>) -> Result<(), TestCaseError> {
        let (variances, axes) = of_two(matrix);
        let size = if matrix.amax() > 0.0 { matrix.amax() } else { 1.0 };
        prop_assert!((axes.transpose() * axes - Matrix2::identity()).amax() < 1e-12, "not orthonormal: {axes}");
        let undetermined = 4.0 * f64::EPSILON / (matrix.m12 / size).abs().max(f64::MIN_POSITIVE);
        let least_cos = std::f64::consts::FRAC_1_SQRT_2 - 1e-6 - undetermined;
        prop_assert!(axes.m11.abs() > least_cos && axes.determinant() > 0.0, "{axes}");
        for (axis, variance) in axes.column_iter().zip(&variances) {
            let residual = (matrix / size * axis - axis * (variance / size)).amax();
            prop_assert!(residual < 1e-12 + 5e-324 / size, "{axis} is off by {residual}: {matrix} {variances}");
        }
        Ok(())
    }

    /// An entry of a matrix, often one that makes it degenerate.
    fn entry() -> impl Strategy<Value = f64> {
        prop_oneof![
            2 => -10.0..10.0_f64,
            2 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, 2.0]),
            1 => prop::sample::select(vec![1e-8, -1e-16, 1e-40, 1e-162, 1e-300, 5e-324, 1e30]),
        ]
    }

    /// Powers of ten by which whole matrices are made huge or tiny.
    fn scale() -> impl Strategy<Value = f64> {
        prop_oneof![Just(1.0), Just(1e300), Just(1e-300), Just(1e-320), (-30..30_i32).prop_map(|e| 10.0_f64.powi(e))]
    }

    proptest! {
        #[test]
        fn the_axes_of_any_symmetric_matrix_are_its_eigenvectors_and_right_handed(e in prop::array::uniform6(entry()), scale in scale()) {
            let [a, b, c, d, e, f] = e.map(|entry| (entry * scale).clamp(-1e307, 1e307));
            check(&Matrix3::new(a, b, c, b, d, e, c, e, f))?;
            check_two(&Matrix2::new(a, b, b, d))?;
        }

        #[test]
        fn the_variances_that_a_matrix_was_made_of_are_found_again(
            made in prop::array::uniform3(prop_oneof![Just(0.0), Just(1.0), Just(4.0), 0.0..9.0_f64]),
            turn in prop::array::uniform3(-3.2..3.2_f64),
        ) {
            let turn = Rotation3::from(UnitQuaternion::from_scaled_axis(Vector3::from(turn)));
            let matrix = turn * Matrix3::from_diagonal(&made.into()) * turn.transpose().matrix();
            let matrix = (matrix + matrix.transpose()) * 0.5;
            check(&matrix)?;
            let (found, _) = of_three(&matrix);
            let sorted = |mut values: [f64; 3]| {
                values.sort_by(f64::total_cmp);
                Vector3::from(values)
            };
            prop_assert!((sorted(found.into()) - sorted(made)).amax() < 1e-12, "{found} for {made:?}");
            // A variance of nothing is never below zero, whose root would not be a number.
            prop_assert!(found.iter().all(|variance| *variance >= 0.0), "{found}");
        }
    }

    #[test]
    fn independent_coordinates_keep_their_axes_with_the_largest_variance_third() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        for (diagonal, axes) in [
            ([1.0, 2.0, 3.0], [x, y, z]),
            ([2.0, 1.0, 3.0], [x, y, z]),
            ([3.0, 1.0, 2.0], [y, z, x]),
            ([1.0, 3.0, 2.0], [z, x, y]),
            ([1.0, 1.0, 1.0], [x, y, z]),
        ] {
            let (variances, found) = of_three(&Matrix3::from_diagonal(&Vector3::from(diagonal)));
            assert_eq!(found, Matrix3::from_columns(&axes), "{diagonal:?}");
            assert_eq!(variances, found.transpose() * Vector3::from(diagonal), "{diagonal:?}");
        }
        for diagonal in [[1.0, 2.0], [2.0, 1.0], [1.0, 1.0]] {
            let diagonal = Vector2::from(diagonal);
            assert_eq!(of_two(&Matrix2::from_diagonal(&diagonal)), (diagonal, Matrix2::identity()));
        }
    }

    #[test]
    fn matrices_without_axes_have_no_extent() {
        for bad in [0.0, f64::NAN, f64::INFINITY] {
            let matrix = Matrix3::repeat(bad);
            assert_eq!(of_three(&matrix), (Vector3::zeros(), Matrix3::identity()));
        }
        let one_bad = Matrix2::new(1.0, f64::NAN, f64::NAN, 1.0);
        assert_eq!(of_two(&one_bad), (Vector2::zeros(), Matrix2::identity()));
    }
}
