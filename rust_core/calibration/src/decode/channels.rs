//! Images of a scan by role: white, black, and each axis's stripes with their inverses.

use crate::patterns::{Axis, Pattern, Stripes};

use super::DecodeError;

/// Maximum number of an axis's stripes, without their inverses.
pub(super) const MOST_CHANNELS: usize = 32;

/// Stripes with the indices of their images.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StripeChannel {
    pub(crate) stripes: Stripes,
    /// Image of the stripes.
    pub(crate) lit: usize,
    /// Image of their inverse.
    pub(crate) inverse: usize,
}

#[derive(Debug)]
pub(crate) struct Channels {
    pub(crate) white: usize,
    pub(crate) black: usize,
    /// Stripes along x and y.
    pub(crate) axes: [AxisChannels; 2],
}

#[derive(Debug)]
pub(crate) struct AxisChannels {
    /// Stripes, those of the code first.
    pub(crate) all: Vec<StripeChannel>,
    /// Number of bits of the code, from the most significant on.
    pub(crate) code_bits: usize,
}

impl Channels {
    /// Sorts patterns by role.
    ///
    /// # Errors
    /// [`DecodeError`]: white, black, an inverse or coarse bits are missing.
    pub(crate) fn new(patterns: &[Pattern]) -> Result<Self, DecodeError> {
        let find = |wanted| patterns.iter().position(|pattern| *pattern == wanted);
        let white = find(Pattern::White).ok_or(DecodeError::Missing("the white picture"))?;
        let black = find(Pattern::Black).ok_or(DecodeError::Missing("the black picture"))?;
        let axes = [AxisChannels::new(Axis::X, patterns)?, AxisChannels::new(Axis::Y, patterns)?];
        Ok(Self { white, black, axes })
    }

    /// Checks that the codes cover a projector of this size.
    ///
    /// # Errors
    /// [`DecodeError::ShortCode`].
    pub(super) fn check_size(&self, projector_px: [u32; 2]) -> Result<(), DecodeError> {
        for ((axis, name), size_px) in self.axes.iter().zip(["x", "y"]).zip(projector_px) {
            let Some(Stripes { bits, step, offset, .. }) = axis.all.first().map(|channel| channel.stripes) else {
                continue;
            };
            let needed = (u64::from(size_px.saturating_sub(1)) + u64::from(offset)) / u64::from(step.max(1)) + 1;
            let codes = 1_u64.checked_shl(bits).unwrap_or(u64::MAX);
            if codes < needed {
                return Err(DecodeError::ShortCode { axis: name, codes, size_px });
            }
        }
        Ok(())
    }
}

impl AxisChannels {
    fn new(axis: Axis, patterns: &[Pattern]) -> Result<Self, DecodeError> {
        let mut all = Vec::new();
        for (lit, pattern) in patterns.iter().enumerate() {
            let Pattern::GrayCode(stripes) = *pattern else { continue };
            if stripes.axis != axis || stripes.inverted {
                continue;
            }
            let inverse = Pattern::GrayCode(stripes.inverse());
            let inverse = patterns.iter().position(|other| *other == inverse);
            let inverse = inverse.ok_or(DecodeError::NoInverse(axis.name(), stripes.bit))?;
            if !all.iter().any(|channel: &StripeChannel| channel.stripes == stripes) {
                all.push(StripeChannel { stripes, lit, inverse });
            }
        }
        // The code is the one with the most consecutive bits from the first on.
        let codes: Vec<(u32, u32, u32)> = all.iter().map(|channel| code_of(&channel.stripes)).collect();
        let length = |code: (u32, u32, u32)| {
            let has = |bit| all.iter().any(|channel| code_of(&channel.stripes) == code && channel.stripes.bit == bit);
            (0..code.0).take_while(|bit| has(*bit)).count()
        };
        let best = codes.iter().copied().max_by_key(|code| (length(*code), std::cmp::Reverse(code.2)));
        let Some(best) = best.filter(|code| length(*code) > 0) else {
            return Err(DecodeError::NoCode(axis.name()));
        };
        let code_bits = length(best);
        if all.iter().any(|channel| code_of(&channel.stripes) == best && channel.stripes.bit as usize > code_bits) {
            return Err(DecodeError::MissingBit(axis.name(), code_bits as u32));
        }
        let rank = |channel: &StripeChannel| {
            let bit = channel.stripes.bit as usize;
            (code_of(&channel.stripes) != best || bit >= code_bits, bit)
        };
        all.sort_by_key(rank);
        if all.len() > MOST_CHANNELS {
            return Err(DecodeError::TooMany { axis: axis.name(), count: all.len(), most: MOST_CHANNELS });
        }
        Ok(Self { all, code_bits })
    }
}

/// Bits, step and offset, which the stripes of one code share.
fn code_of(stripes: &Stripes) -> (u32, u32, u32) {
    (stripes.bits, stripes.step, stripes.offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patterns::{gray_code, shifted_gray_code};

    #[test]
    fn stripes_are_sorted_by_axis_and_bit() {
        let mut patterns = gray_code([1280, 800]);
        patterns.reverse();
        let channels = Channels::new(&patterns).unwrap();
        assert_eq!((patterns[channels.white], patterns[channels.black]), (Pattern::White, Pattern::Black));
        for (axis, bits) in channels.axes.iter().zip([11, 10]) {
            assert_eq!((axis.all.len(), axis.code_bits), (bits, bits));
            for (bit, channel) in axis.all.iter().enumerate() {
                assert_eq!(channel.stripes.bit as usize, bit);
                assert_eq!(patterns[channel.lit], Pattern::GrayCode(channel.stripes));
                assert_eq!(patterns[channel.inverse], Pattern::GrayCode(channel.stripes.inverse()));
            }
        }
        assert_eq!(channels.check_size([1280, 800]), Ok(()));
        let short = DecodeError::ShortCode { axis: "y", codes: 1024, size_px: 1080 };
        assert_eq!(channels.check_size([1920, 1080]), Err(short));
        let shifted = Channels::new(&shifted_gray_code([1280, 800], 4)).unwrap();
        assert_eq!(shifted.axes.each_ref().map(|axis| (axis.all.len(), axis.code_bits)), [(16, 9), (15, 8)]);
        assert!(shifted.axes[0].all[..9].iter().all(|channel| channel.stripes.offset == 0));
    }

    #[test]
    fn what_is_missing_is_named() {
        let patterns = gray_code([16, 16]);
        let without = |index: usize| {
            let mut fewer = patterns.clone();
            fewer.remove(index);
            Channels::new(&fewer).unwrap_err().to_string()
        };
        assert!(without(0).contains("white") && without(1).contains("black"));
        assert!(without(3).contains("x") && without(3).contains("inverse"), "{}", without(3));
        let is_third_of_x = |pattern: &Pattern| matches!(pattern, Pattern::GrayCode(stripes) if stripes.axis == Axis::X && stripes.bit == 2);
        let without_bit: Vec<Pattern> = patterns.iter().copied().filter(|pattern| !is_third_of_x(pattern)).collect();
        let expected = DecodeError::MissingBit("x", 2);
        assert_eq!(Channels::new(&without_bit).unwrap_err(), expected);
        let only_x: Vec<Pattern> = patterns[..10].to_vec();
        assert!(Channels::new(&only_x).unwrap_err().to_string().contains('y'));
    }
}
