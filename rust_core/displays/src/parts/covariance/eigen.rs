//! Eigenvalues and eigenvectors of small symmetric matrices, in the order and with the signs of rviz.
//!
//! An ellipsoid's axes are the same whichever solver finds them, but which of them the poles of the sphere lie on, and
//! whether a variance of nothing comes out a little below zero, both show in the picture. So this is the method of
//! Eigen's `SelfAdjointEigenSolver`: the implicit symmetric QR algorithm with Wilkinson's shift (Golub and Van Loan,
//! Matrix Computations, 8.3) upon a tridiagonal form, values in rising order. The axes are made right-handed by swapping
//! the first two.

use nalgebra::{Matrix2, Matrix3, SMatrix, Vector2, Vector3};

/// QR steps for each row before a matrix is given up.
const MAX_STEPS: usize = 30;

/// Eigenvalues and, as columns, right-handed eigenvectors. Zero and the identity for what does not converge.
pub(super) fn symmetric2(matrix: &Matrix2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
    let scale = scale(&[matrix.m11, matrix.m21, matrix.m22]);
    let mut tridiagonal = Tridiagonal {
        diagonal: [matrix.m11 / scale, matrix.m22 / scale],
        beside: [matrix.m21 / scale, 0.0],
        vectors: Matrix2::identity(),
    };
    if !tridiagonal.solve() {
        return (Vector2::zeros(), Matrix2::identity());
    }
    let (mut values, mut vectors) = (Vector2::from(tridiagonal.diagonal) * scale, tridiagonal.vectors);
    if vectors.determinant() < 0.0 {
        values.swap_rows(0, 1);
        vectors.swap_columns(0, 1);
    }
    (values, vectors)
}

/// Eigenvalues and, as columns, right-handed eigenvectors. Zero and the identity for what does not converge.
pub(super) fn symmetric3(matrix: &Matrix3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let scale = scale(&[matrix.m11, matrix.m21, matrix.m22, matrix.m31, matrix.m32, matrix.m33]);
    let mut tridiagonal = tridiagonal3(&(matrix / scale));
    if !tridiagonal.solve() {
        return (Vector3::zeros(), Matrix3::identity());
    }
    let (mut values, mut vectors) = (Vector3::from(tridiagonal.diagonal) * scale, tridiagonal.vectors);
    if vectors.determinant() < 0.0 {
        values.swap_rows(0, 1);
        vectors.swap_columns(0, 1);
    }
    (values, vectors)
}

/// The largest of the entries, by which they are divided; 1 when all are zero.
fn scale(entries: &[f64]) -> f64 {
    let largest = entries.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    if largest == 0.0 {
        1.0
    } else {
        largest
    }
}

/// One reflection takes the corner of a 3 × 3 matrix away.
fn tridiagonal3(matrix: &Matrix3<f64>) -> Tridiagonal<3> {
    let corner_squared = matrix.m31 * matrix.m31;
    if corner_squared <= f64::MIN_POSITIVE {
        return Tridiagonal {
            diagonal: [matrix.m11, matrix.m22, matrix.m33],
            beside: [matrix.m21, matrix.m32, 0.0],
            vectors: Matrix3::identity(),
        };
    }
    let length = (matrix.m21 * matrix.m21 + corner_squared).sqrt();
    let (u, v) = (matrix.m21 * (1.0 / length), matrix.m31 * (1.0 / length));
    let moved = 2.0 * u * matrix.m32 + v * (matrix.m33 - matrix.m22);
    Tridiagonal {
        diagonal: [matrix.m11, matrix.m22 + v * moved, matrix.m33 - v * moved],
        beside: [length, matrix.m32 - u * moved, 0.0],
        vectors: Matrix3::new(1.0, 0.0, 0.0, 0.0, u, v, 0.0, v, -u),
    }
}

/// A symmetric matrix of a diagonal and the entries beside it (the last of them is not used), and the vectors that
/// brought it there.
struct Tridiagonal<const N: usize> {
    diagonal: [f64; N],
    beside: [f64; N],
    vectors: SMatrix<f64, N, N>,
}

impl<const N: usize> Tridiagonal<N> {
    /// Makes it diagonal, the values rising. False when it does not converge.
    fn solve(&mut self) -> bool {
        let (mut first, mut last, mut steps) = (0, N - 1, 0);
        while last > 0 {
            for i in first..last {
                if self.is_negligible(i) {
                    self.beside[i] = 0.0;
                }
            }
            while last > 0 && self.beside[last - 1] == 0.0 {
                last -= 1;
            }
            if last == 0 {
                break;
            }
            steps += 1;
            if steps > MAX_STEPS * N {
                return false;
            }
            first = last - 1;
            while first > 0 && self.beside[first - 1] != 0.0 {
                first -= 1;
            }
            self.step(first, last);
        }
        self.sort();
        true
    }

    fn is_negligible(&self, i: usize) -> bool {
        let scaled = self.beside[i] / f64::EPSILON;
        self.beside[i].abs() < f64::MIN_POSITIVE
            || scaled * scaled <= self.diagonal[i].abs() + self.diagonal[i + 1].abs()
    }

    /// One QR step on the rows `first` to `last`.
    fn step(&mut self, first: usize, last: usize) {
        let (d, b) = (&mut self.diagonal, &mut self.beside);
        let (mut x, mut bulge) = (d[first] - shift(d[last - 1], b[last - 1], d[last]), b[first]);
        for k in first..last {
            if bulge == 0.0 {
                break;
            }
            let (cos, sin) = rotation(x, bulge);
            let lower = [sin * d[k] + cos * b[k], sin * b[k] + cos * d[k + 1]];
            d[k] = cos * (cos * d[k] - sin * b[k]) - sin * (cos * b[k] - sin * d[k + 1]);
            d[k + 1] = sin * lower[0] + cos * lower[1];
            b[k] = cos * lower[0] - sin * lower[1];
            if k > first {
                b[k - 1] = cos * b[k - 1] - sin * bulge;
            }
            x = b[k];
            if k + 1 < last {
                bulge = -sin * b[k + 1];
                b[k + 1] *= cos;
            }
            for row in 0..N {
                let [p, q] = [self.vectors[(row, k)], self.vectors[(row, k + 1)]];
                self.vectors[(row, k)] = cos * p - sin * q;
                self.vectors[(row, k + 1)] = sin * p + cos * q;
            }
        }
    }

    fn sort(&mut self) {
        for i in 0..N {
            let smallest = (i..N).fold(i, |least, j| if self.diagonal[j] < self.diagonal[least] { j } else { least });
            if smallest != i {
                self.diagonal.swap(i, smallest);
                self.vectors.swap_columns(i, smallest);
            }
        }
    }
}

/// Wilkinson's shift: the eigenvalue of the last 2 × 2 block that is nearest to its last entry.
fn shift(before: f64, beside: f64, last: f64) -> f64 {
    let half = (before - last) * 0.5;
    let squared = beside * beside;
    if half == 0.0 {
        return last - beside.abs();
    }
    let sum = half + half.hypot(beside).copysign(half);
    if squared == 0.0 {
        last - beside / (sum / beside)
    } else {
        last - squared / sum
    }
}

/// Cosine and sine of the turn that takes (x, z) to (r, 0), as Eigen's `makeGivens` signs them.
fn rotation(x: f64, z: f64) -> (f64, f64) {
    if x == 0.0 {
        (0.0, -z.signum())
    } else if x.abs() > z.abs() {
        let slope = z / x;
        let cos = 1.0 / (1.0 + slope * slope).sqrt().copysign(x);
        (cos, -slope * cos)
    } else {
        let slope = x / z;
        let sin = -1.0 / (1.0 + slope * slope).sqrt().copysign(z);
        (-slope * sin, sin)
    }
}
