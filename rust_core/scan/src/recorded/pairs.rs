//! Checks that images can be those of the patterns: where stripes are dark, their inverse is lit. Images that are one
//! pattern off fail.

use rcs_calibration::patterns::{Pattern, Stripes};

use super::sequence::PatternSequenceError;

/// The least difference of white and black of a lit pixel, levels.
const LIT_LEVELS: u8 = 6;
/// The least share of lit pixels.
const MIN_LIT: f64 = 0.1;
/// A pixel is dark below this share of white and black. Blurred stripes light it by half, and gamma brightens that.
const DARK: f64 = 0.2;
/// Limit of the share of lit pixels that are dark in both.
const MAX_DARK: f64 = 0.08;
/// Limit of the share of lit pixels that are darker in white than in black.
const MAX_SWAPPED: f64 = 0.02;
/// Bits of coarse stripes, the least clear difference from the inverse as a share of white and black, and the least
/// share of lit pixels that see it.
const COARSE_BITS: u32 = 3;
const CLEAR: f64 = 0.3;
const MIN_CLEAR: f64 = 0.5;

/// Checks all pairs of stripes. Levels are at the same pixels in all; white and black are among the patterns.
///
/// # Errors
/// [`PatternSequenceError::NoPair`].
pub(crate) fn check(patterns: &[Pattern], levels: &[&[u8]]) -> Result<(), PatternSequenceError> {
    let Some(lit) = LitPixels::new(patterns, levels) else { return Ok(()) };
    for (stripes, index, inverse) in pairs(patterns) {
        let share = lit.share(levels[index], levels[inverse], |one, other| one < DARK && other < DARK);
        if share > MAX_DARK {
            return Err(PatternSequenceError::NoPair { axis: stripes.axis.name(), share });
        }
    }
    Ok(())
}

/// `true` if images match the patterns: white is brighter than black, coarse stripes are clear, pairs match.
pub(crate) fn are_plausible(patterns: &[Pattern], levels: &[&[u8]]) -> bool {
    let Some(lit) = LitPixels::new(patterns, levels) else { return false };
    let is_clear = |(stripes, index, inverse): (&Stripes, usize, usize)| {
        let share = || lit.share(levels[index], levels[inverse], |one, other| (one - other).abs() > CLEAR);
        stripes.bit >= COARSE_BITS || stripes.offset > 0 || share() > MIN_CLEAR
    };
    lit.is_plausible() && pairs(patterns).all(is_clear) && check(patterns, levels).is_ok()
}

/// The stripes that are not inverted, with their index and their inverse's.
fn pairs(patterns: &[Pattern]) -> impl Iterator<Item = (&Stripes, usize, usize)> {
    patterns.iter().enumerate().filter_map(move |(index, pattern)| {
        let Pattern::GrayCode(stripes) = pattern else { return None };
        let inverse = patterns.iter().position(|other| *other == Pattern::GrayCode(stripes.inverse()))?;
        (!stripes.inverted).then_some((stripes, index, inverse))
    })
}

/// Pixels that are brighter in white than in black.
struct LitPixels<'a> {
    white: &'a [u8],
    black: &'a [u8],
    at: Vec<usize>,
}

impl<'a> LitPixels<'a> {
    fn new(patterns: &[Pattern], levels: &[&'a [u8]]) -> Option<Self> {
        let find = |wanted| patterns.iter().position(|pattern| *pattern == wanted);
        let (white, black) = (levels[find(Pattern::White)?], levels[find(Pattern::Black)?]);
        let is_lit = |pixel: &usize| white[*pixel].saturating_sub(black[*pixel]) > LIT_LEVELS;
        Some(Self { white, black, at: (0..white.len()).filter(is_lit).collect() })
    }

    fn is_plausible(&self) -> bool {
        let is_swapped = |(white, black): &(&u8, &u8)| black.saturating_sub(**white) > LIT_LEVELS;
        let swapped = self.white.iter().zip(self.black).filter(is_swapped).count();
        let lit = self.at.len() as f64;
        lit >= MIN_LIT * self.white.len() as f64 && swapped as f64 <= MAX_SWAPPED * lit
    }

    /// The share of lit pixels whose levels in two images fulfil a condition; 0 is black and 1 white.
    fn share(&self, one: &[u8], other: &[u8], holds: impl Fn(f64, f64) -> bool) -> f64 {
        let level = |grey: &[u8], pixel: usize| {
            let [level, white, black] = [grey, self.white, self.black].map(|grey| f64::from(grey[pixel]));
            (level - black) / (white - black)
        };
        let held = self.at.iter().filter(|pixel| holds(level(one, **pixel), level(other, **pixel))).count();
        held as f64 / self.at.len().max(1) as f64
    }
}
