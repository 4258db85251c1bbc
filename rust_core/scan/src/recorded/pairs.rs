//! Whether pictures can be those of the patterns: where stripes are dark, their inverse is lit. Pictures that are one
//! pattern off are not.

use rcs_calibration::patterns::{Pattern, Stripes};

use super::sequence::SequenceError;

/// A lit pixel is brighter in white than in black by more levels.
const LIT_LEVELS: u8 = 6;
/// The share of pixels that must be lit.
const LEAST_LIT: f64 = 0.1;
/// A pixel is dark below this share of white and black. Blurred stripes light it by half, and gamma brightens that.
const DARK: f64 = 0.2;
/// The share of lit pixels that may be dark in both.
const MOST_DARK: f64 = 0.08;
/// The share of lit pixels that may be darker in white than in black.
const MOST_SWAPPED: f64 = 0.02;
/// Coarse stripes: the first bits. Half of the lit pixels must see the difference from the inverse clearly, as a share
/// of white and black.
const COARSE_BITS: u32 = 3;
const CLEAR: f64 = 0.3;
const LEAST_CLEAR: f64 = 0.5;

/// Finds a pair that cannot be one. Levels are at the same pixels in all; the patterns have white and black.
///
/// # Errors
/// [`SequenceError::NoPair`].
pub(crate) fn check(patterns: &[Pattern], levels: &[&[u8]]) -> Result<(), SequenceError> {
    let wrong = |stripes: &Stripes, share| SequenceError::NoPair { axis: stripes.axis.name(), share };
    let Some(lit) = Lit::new(patterns, levels) else { return Ok(()) };
    for (index, pattern) in patterns.iter().enumerate() {
        let Pattern::GrayCode(stripes) = pattern else { continue };
        let inverse = patterns.iter().position(|other| *other == Pattern::GrayCode(stripes.inverse()));
        let Some(inverse) = inverse.filter(|_| !stripes.inverted) else { continue };
        let dark = lit.share(levels[index], levels[inverse], |one, other| one < DARK && other < DARK);
        if dark > MOST_DARK {
            return Err(wrong(stripes, dark));
        }
    }
    Ok(())
}

/// Whether pictures look like the patterns: white brighter than black, coarse stripes clear, pairs as they must be.
pub(crate) fn look_like(patterns: &[Pattern], levels: &[&[u8]]) -> bool {
    let Some(lit) = Lit::new(patterns, levels) else { return false };
    let is_clear = |(index, pattern): (usize, &Pattern)| {
        let Pattern::GrayCode(stripes) = pattern else { return true };
        if stripes.inverted || stripes.bit >= COARSE_BITS || stripes.offset > 0 {
            return true;
        }
        let inverse = patterns.iter().position(|other| *other == Pattern::GrayCode(stripes.inverse()));
        let is_apart = |one: f64, other: f64| (one - other).abs() > CLEAR;
        inverse.is_none_or(|inverse| lit.share(levels[index], levels[inverse], is_apart) > LEAST_CLEAR)
    };
    lit.is_plausible() && patterns.iter().enumerate().all(is_clear) && check(patterns, levels).is_ok()
}

/// Pixels that are brighter in white than in black.
struct Lit<'a> {
    white: &'a [u8],
    black: &'a [u8],
    at: Vec<usize>,
}

impl<'a> Lit<'a> {
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
        lit >= LEAST_LIT * self.white.len() as f64 && swapped as f64 <= MOST_SWAPPED * lit
    }

    /// The share of lit pixels at which something holds of the levels of two pictures, 0 for black and 1 for white.
    fn share(&self, one: &[u8], other: &[u8], holds: impl Fn(f64, f64) -> bool) -> f64 {
        let level = |grey: &[u8], pixel: usize| {
            let [level, white, black] = [grey, self.white, self.black].map(|grey| f64::from(grey[pixel]));
            (level - black) / (white - black)
        };
        let held = self.at.iter().filter(|pixel| holds(level(one, **pixel), level(other, **pixel))).count();
        held as f64 / self.at.len().max(1) as f64
    }
}
