//! The last so many measurements of one thing, and what is typical of them.
//!
//! Percentiles are nearest ranks: the least of the measured values that so many percent of them do not exceed. So what is
//! told was measured, and of two values the median is the smaller one.

/// The last `N` values. Adding one takes the same time however many there are, and nothing is allocated.
#[derive(Clone, Debug)]
pub(crate) struct Recent<const N: usize> {
    values: [f64; N],
    len: usize,
    /// Where the next value goes.
    next: usize,
}

/// What is typical of some values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Typical {
    /// Half of the values are not above it.
    pub(crate) median: f64,
    /// 95 of 100 values are not above it.
    pub(crate) p95: f64,
}

impl<const N: usize> Recent<N> {
    /// No values.
    pub(crate) const fn new() -> Self {
        Self { values: [0.0; N], len: 0, next: 0 }
    }

    /// Adds a value, in the place of the oldest where there are `N`.
    pub(crate) fn push(&mut self, value: f64) {
        if let Some(place) = self.values.get_mut(self.next) {
            *place = value;
            self.len = (self.len + 1).min(N);
            self.next = (self.next + 1) % N;
        }
    }

    /// How many values there are, `N` at most.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// What is typical of them; `None` without any.
    pub(crate) fn typical(&self) -> Option<Typical> {
        let mut sorted = self.values;
        let sorted = sorted.get_mut(..self.len)?;
        sorted.sort_unstable_by(f64::total_cmp);
        Some(Typical { median: percentile(sorted, 50)?, p95: percentile(sorted, 95)? })
    }
}

/// The nearest rank of sorted values.
fn percentile(sorted: &[f64], percent: usize) -> Option<f64> {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.checked_sub(1)?).copied()
}

/// As `median / p95`, with two decimals.
impl std::fmt::Display for Typical {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.2} / {:.2}", self.median, self.p95)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typical(values: impl IntoIterator<Item = i32>) -> Option<(f64, f64)> {
        let mut recent = Recent::<100>::new();
        values.into_iter().for_each(|value| recent.push(f64::from(value)));
        recent.typical().map(|typical| (typical.median, typical.p95))
    }

    #[test]
    fn median_and_p95_are_nearest_ranks() {
        assert_eq!(typical([]), None);
        assert_eq!(typical([7]), Some((7.0, 7.0)));
        assert_eq!(typical([9, 4]), Some((4.0, 9.0)));
        assert_eq!(typical([3, 1, 2]), Some((2.0, 3.0)));
        assert_eq!(typical((1..=20).rev()), Some((10.0, 19.0)));
        assert_eq!(typical(1..=100), Some((50.0, 95.0)));
    }

    #[test]
    fn the_oldest_values_give_way() {
        let mut recent = Recent::<3>::new();
        for (value, len) in [(100.0, 1), (1.0, 2), (2.0, 3), (3.0, 3)] {
            recent.push(value);
            assert_eq!(recent.len(), len);
        }
        assert_eq!(recent.typical(), Some(Typical { median: 2.0, p95: 3.0 }));
        assert_eq!(typical(std::iter::repeat_n(9, 40).chain(1..=100)), Some((50.0, 95.0)));
    }

    #[test]
    fn negative_values_are_in_order_and_told() {
        let mut recent = Recent::<8>::new();
        [-1.0, -20.5, 3.0].into_iter().for_each(|value| recent.push(value));
        assert_eq!(recent.typical().unwrap().to_string(), "-1.00 / 3.00");
    }
}
