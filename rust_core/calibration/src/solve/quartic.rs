//! Real roots of a quartic, in a bounded number of steps.
//!
//! Ferrari's method: a real root of the resolvent cubic splits the quartic into two quadratics; Newton steps on the
//! quartic then recover the closed form's rounding errors (notation of Abramowitz and Stegun, 3.8.3).

/// Newton steps on each root.
const POLISHING_STEPS: usize = 3;
/// Maximum imaginary part of a real root as a share of its size: noise splits double roots.
const NEARLY_REAL: f64 = 1e-6;

/// Real roots of `c[0] x⁴ + c[1] x³ + c[2] x² + c[3] x + c[4]`, at most four; none if a coefficient is not finite.
pub(super) fn real_roots(c: [f64; 5]) -> impl Iterator<Item = f64> {
    roots(c).into_iter().flatten().map(move |root| polished(c, root)).filter(|root| root.is_finite())
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

fn polished(c: [f64; 5], mut root: f64) -> f64 {
    let value = |x: f64| (((c[0] * x + c[1]) * x + c[2]) * x + c[3]) * x + c[4];
    for _ in 0..POLISHING_STEPS {
        let slope = ((4.0 * c[0] * root + 3.0 * c[1]) * root + 2.0 * c[2]) * root + c[3];
        let better = root - value(root) / slope;
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
