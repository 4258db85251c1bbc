//! Axis scales with tick marks at round numbers, colour maps and number formats.

/// Linear scale from quantities to drawing coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Scale {
    /// Maps quantities from `low` to `high` to coordinates from `from` to `to`. A range that is empty, or too narrow
    /// for tick marks, is widened.
    pub(super) fn new([low, high]: [f64; 2], [from, to]: [f64; 2]) -> Self {
        const NARROWEST: f64 = 1e-12;
        let is_range = low.is_finite() && high.is_finite() && high - low > NARROWEST * low.abs().max(high.abs());
        let (low, high) = match (is_range, low.is_finite()) {
            (true, _) => (low, high),
            (false, true) => (low, low + low.abs().max(1.0)),
            (false, false) => (0.0, 1.0),
        };
        Self { low, high, from, to }
    }

    /// Scale whose range is extended to round numbers.
    pub(super) fn rounded([low, high]: [f64; 2], places: [f64; 2]) -> Self {
        let scale = Self::new([low, high], places);
        let step = scale.step(6.0);
        let ends = [(scale.low / step + 1e-9).floor() * step, (scale.high / step - 1e-9).ceil() * step];
        Self::new(ends, places)
    }

    /// First and last quantity.
    pub(super) fn range(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Coordinate of a quantity.
    pub(super) fn place(&self, quantity: f64) -> f64 {
        self.from + self.share(quantity) * (self.to - self.from)
    }

    /// Position of a quantity between the first (0) and the last (1).
    pub(super) fn share(&self, quantity: f64) -> f64 {
        (quantity - self.low) / (self.high - self.low)
    }

    /// Round numbers of the range with their texts, about `about` of them.
    pub(super) fn ticks(&self, about: f64) -> Vec<(f64, String)> {
        let step = self.step(about);
        let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        let first = (self.low / step - 1e-6).ceil();
        let indices = (0..1000).map(|index| first + f64::from(index));
        let ticks = indices.map(|index| index * step).take_while(|tick| *tick <= self.high + 1e-6 * step);
        // Adding zero removes the sign of a negative zero.
        ticks.map(|tick| (tick, format!("{:.decimals$}", tick + 0.0))).collect()
    }

    /// Step of 1, 2 or 5 times a power of ten that divides the range into about `about` steps.
    fn step(&self, about: f64) -> f64 {
        let wanted = (self.high - self.low) / about.max(1.0);
        let power = 10_f64.powf(wanted.log10().floor());
        let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= wanted * 0.999).unwrap_or(10.0);
        factor * power
    }
}

/// Interpolates between colour stops that are evenly spread from 0 to 1.
pub(super) fn colour(stops: &[[u8; 3]], share: f64) -> String {
    let [first, .., last] = stops else { return "#000000".to_owned() };
    let at = share.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let index = if at.is_nan() { 0 } else { at as usize };
    let (below, above) = (stops.get(index).unwrap_or(first), stops.get(index + 1).unwrap_or(last));
    let [r, g, b] = std::array::from_fn(|channel| {
        let (below, above) = (f64::from(below[channel]), f64::from(above[channel]));
        let level = below + (above - below) * (at - index as f64);
        level.round() as u8
    });
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Formats a value with a number of significant digits.
pub(super) fn digits(value: f64, count: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let decimals = (count - 1 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    format!("{value:.decimals$}")
}

/// Formats a value and its deviation to the deviation's second significant digit.
pub(super) fn with_sigma(value: f64, sigma: f64) -> [String; 2] {
    if !(sigma > 0.0 && sigma.is_finite()) {
        return [digits(value, 6), format!("{sigma}")];
    }
    let decimals = (1 - sigma.log10().floor() as i32).clamp(0, 12) as usize;
    [format!("{value:.decimals$}"), format!("{sigma:.decimals$}")]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        let texts = |range| -> Vec<String> {
            Scale::new(range, [0.0, 1.0]).ticks(5.0).into_iter().map(|(_, text)| text).collect()
        };
        assert_eq!(texts([0.0, 1280.0]), ["0", "500", "1000"]);
        assert_eq!(texts([0.0, 1.0]), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts([-0.013, 0.03]), ["-0.01", "0.00", "0.01", "0.02", "0.03"]);
        assert_eq!(texts([2.0, 2.0]), ["2.0", "2.5", "3.0", "3.5", "4.0"]);
        // Too narrow for tick marks.
        assert_eq!(texts([1.0, 1.0_f64.next_up()]), ["1.0", "1.2", "1.4", "1.6", "1.8", "2.0"]);
        assert_eq!(texts([-1e20, (-1e20_f64).next_up()]), texts([-1e20, -1e20]));
    }

    #[test]
    fn deviations_say_how_many_digits_count() {
        assert_eq!(with_sigma(1899.98765, 0.1234), ["1899.99", "0.12"]);
        assert_eq!(with_sigma(-0.08123, 0.00056), ["-0.08123", "0.00056"]);
        assert_eq!(with_sigma(640.0, 0.0), ["640.000", "0"]);
        assert_eq!([digits(0.123_456, 3), digits(1234.5, 3), digits(0.0, 3)], ["0.123", "1234", "0"]);
    }

    #[test]
    fn colours_lie_between_their_stops() {
        let stops = [[0, 0, 0], [100, 200, 50], [255, 255, 255]];
        assert_eq!(colour(&stops, 0.5), "#64c832");
        assert_eq!([colour(&stops, -1.0), colour(&stops, 7.0)], ["#000000", "#ffffff"]);
        assert_eq!(colour(&stops, 0.25), "#326419");
        assert_eq!(colour(&stops, f64::NAN).len(), 7);
    }

    proptest! {
        #[test]
        fn every_scale_has_ticks_inside(
            low in prop_oneof![-1e9..1e9, any::<f64>()],
            width in prop_oneof![1e-6..1e9, any::<f64>()],
        ) {
            for scale in [Scale::new([low, low + width], [10.0, 90.0]), Scale::rounded([low, low + width], [10.0, 90.0])] {
                let ticks = scale.ticks(5.0);
                prop_assert!(ticks.len() < 20);
                for (tick, _) in ticks {
                    prop_assert!((9.9..90.1).contains(&scale.place(tick)), "{tick} {scale:?}");
                }
            }
        }
    }
}
