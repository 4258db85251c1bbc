//! Medians and quantiles by selection, root mean squares, and bisection.

/// Quantile at a share from 0 to 1; NaN without values. Reorders the values.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let index = ((values.len() as f64 * share) as usize).min(values.len() - 1);
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

/// Median; NaN without values. Reorders the values.
pub fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// [`median`] of single-precision values.
pub(crate) fn median_f32(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return f32::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Root mean square; 0 without values.
pub(crate) fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

/// Halves an interval `[low, high]` in a number of steps around where `is_low` becomes false.
pub(crate) fn bisect([mut low, mut high]: [f64; 2], steps: u32, mut is_low: impl FnMut(f64) -> bool) -> [f64; 2] {
    for _ in 0..steps {
        let middle = 0.5 * (low + high);
        *(if is_low(middle) { &mut low } else { &mut high }) = middle;
    }
    [low, high]
}
