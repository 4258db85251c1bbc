//! Rolling window over the last measurements of a quantity, and its percentiles.
//!
//! Percentiles are nearest ranks: the smallest measured value that the given share of the values does not exceed. A
//! figure is always one that was measured, and of two values the median is the smaller one.

/// The last `N` values. Adding one takes constant time and allocates nothing.
#[derive(Clone, Debug)]
pub struct RollingWindow<const N: usize> {
    values: [f64; N],
    len: usize,
    /// Index of the next value.
    next: usize,
}

/// Percentiles of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Percentiles {
    /// 50th percentile.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
}

impl<const N: usize> Default for RollingWindow<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> RollingWindow<N> {
    /// No values.
    pub const fn new() -> Self {
        Self { values: [0.0; N], len: 0, next: 0 }
    }

    /// Adds a value, which replaces the oldest once there are `N`.
    pub fn push(&mut self, value: f64) {
        if let Some(place) = self.values.get_mut(self.next) {
            *place = value;
            self.len = (self.len + 1).min(N);
            self.next = (self.next + 1) % N;
        }
    }

    /// Number of values, `N` at most.
    pub fn len(&self) -> usize {
        self.len
    }

    /// `true` without values.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Median and 95th percentile; `None` without values.
    pub fn percentiles(&self) -> Option<Percentiles> {
        let mut sorted = self.values;
        let sorted = sorted.get_mut(..self.len)?;
        sorted.sort_unstable_by(f64::total_cmp);
        Some(Percentiles { median: percentile(sorted, 50)?, p95: percentile(sorted, 95)? })
    }
}

/// The nearest rank of sorted values.
fn percentile(sorted: &[f64], percent: usize) -> Option<f64> {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.checked_sub(1)?).copied()
}

/// As `median / p95`, with two decimals.
impl std::fmt::Display for Percentiles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.2} / {:.2}", self.median, self.p95)
    }
}

/// A figure as text, `-` where there is none.
pub fn figure(figure: Option<impl std::fmt::Display>) -> String {
    figure.map_or_else(|| "-".to_owned(), |figure| figure.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn percentiles_of(values: impl IntoIterator<Item = i32>) -> Option<(f64, f64)> {
        let mut window = RollingWindow::<100>::new();
        values.into_iter().for_each(|value| window.push(f64::from(value)));
        window.percentiles().map(|percentiles| (percentiles.median, percentiles.p95))
    }

    #[test]
    fn median_and_p95_are_nearest_ranks() {
        assert_eq!(percentiles_of([]), None);
        assert_eq!(percentiles_of([7]), Some((7.0, 7.0)));
        assert_eq!(percentiles_of([9, 4]), Some((4.0, 9.0)));
        assert_eq!(percentiles_of([3, 1, 2]), Some((2.0, 3.0)));
        assert_eq!(percentiles_of((1..=20).rev()), Some((10.0, 19.0)));
        assert_eq!(percentiles_of(1..=100), Some((50.0, 95.0)));
    }

    #[test]
    fn the_oldest_values_are_replaced() {
        let mut window = RollingWindow::<3>::new();
        for (value, len) in [(100.0, 1), (1.0, 2), (2.0, 3), (3.0, 3)] {
            window.push(value);
            assert_eq!(window.len(), len);
        }
        assert_eq!(window.percentiles(), Some(Percentiles { median: 2.0, p95: 3.0 }));
        assert_eq!(percentiles_of(std::iter::repeat_n(9, 40).chain(1..=100)), Some((50.0, 95.0)));
    }

    #[test]
    fn negative_values_are_sorted_and_printed() {
        let mut window = RollingWindow::<8>::new();
        [-1.0, -20.5, 3.0].into_iter().for_each(|value| window.push(value));
        assert_eq!(window.percentiles().unwrap().to_string(), "-1.00 / 3.00");
    }
}
