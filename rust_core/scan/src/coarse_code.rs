//! Incremental decoding of a pixel's Gray code, the most significant bit first: each bit halves the range of columns.

use rcs_calibration::patterns::Stripes;

/// Least difference of a clear bit, as a share of the contrast of white and black.
const CLEAR: f64 = 0.3;

/// The first bits of a pixel's code along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct CoarseCode {
    code: u32,
    /// Number of bits that were read.
    pub(crate) bits: u32,
}

impl CoarseCode {
    /// A pixel's bit by a pair of stripes: lit in the first (`true`) or in its inverse (`false`); `None` if unclear.
    /// `contrast` is the difference of white and black there.
    pub(crate) fn bit(stripes: u8, inverse: u8, contrast: f64) -> Option<bool> {
        let difference = f64::from(stripes) - f64::from(inverse);
        (difference.abs() >= CLEAR * contrast).then_some(difference > 0.0)
    }

    /// Adds the next bit.
    pub(crate) fn push(&mut self, is_lit: bool) {
        // A bit of the Gray code tells whether two consecutive bits of the number differ.
        self.code = 2 * self.code + ((self.code & 1) ^ u32::from(is_lit));
        self.bits += 1;
    }

    /// The middle of the columns or rows with this code, pixels. `stripes` are any of the code's, without an offset.
    pub(crate) fn place_px(&self, stripes: &Stripes) -> f64 {
        let width = f64::from(stripes.step) * 2.0_f64.powi(stripes.bits.saturating_sub(self.bits) as i32);
        (f64::from(self.code) + 0.5) * width - f64::from(stripes.offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rcs_calibration::patterns::Axis;

    #[test]
    fn the_place_narrows_down_to_the_pixel() {
        let stripes = |bit| Stripes { axis: Axis::X, bits: 11, bit, step: 1, offset: 0, inverted: false };
        for at in [0, 1, 700, 1279] {
            let mut code = CoarseCode::default();
            for bit in 0..11 {
                code.push(stripes(bit).is_lit(at));
                let (middle, half) = (code.place_px(&stripes(0)), f64::from(1 << (10 - bit)) / 2.0);
                assert!((middle - half..middle + half).contains(&f64::from(at)), "{at} {bit}: {middle} {half}");
            }
            assert_eq!(code.bits, 11);
        }
    }

    #[test]
    fn a_bit_that_is_not_clear_is_none() {
        assert_eq!(
            [(200, 50), (50, 200), (130, 120)].map(|(a, b)| CoarseCode::bit(a, b, 160.0)),
            [Some(true), Some(false), None]
        );
    }
}
