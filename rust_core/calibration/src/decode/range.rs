//! Whether the codes that the camera saw are in the projector's picture.
//!
//! The coarse stripes of most pixels are read without a doubt. Where they say that the light comes from beside the
//! picture, the patterns were those of a projector of another size, or their list is wrong.

use super::channels::AxisChannels;
use super::search::Differences;

/// A stripe is certain if it is so bright or dark: 1 is as white and black are.
const CERTAIN: f32 = 0.35;
/// It also has to be so many standard deviations from grey.
const CERTAIN_SIGMAS: f32 = 6.0;

/// The least place along an axis that a pixel's certain stripes allow, projector pixels.
pub(super) fn least_place_px(channels: &AxisChannels, differences: &Differences, noise: f32) -> i64 {
    let code = channels.all.iter().take(channels.code_bits);
    let certain = code.zip(differences).take_while(|(_, difference)| {
        let strength = difference.abs();
        strength > CERTAIN && strength > CERTAIN_SIGMAS * noise
    });
    let (mut place_px, mut is_one) = (0, false);
    for (channel, difference) in certain {
        let stripes = &channel.stripes;
        // A Gray code's bit says whether the binary digit is another one than the digit before.
        is_one ^= *difference > 0.0;
        let digit = stripes.bits.saturating_sub(stripes.bit + 1).min(40);
        place_px += (i64::from(is_one) << digit) * i64::from(stripes.step);
        if stripes.bit == 0 {
            place_px -= i64::from(stripes.offset);
        }
    }
    place_px
}

#[cfg(test)]
mod tests {
    use super::super::channels::{Channels, MOST_CHANNELS};
    use super::*;
    use crate::patterns::{shifted_gray_code, Pattern};

    #[test]
    fn certain_stripes_bound_the_place_from_below() {
        for step in [1, 4] {
            let patterns = shifted_gray_code([1280, 800], step);
            let channels = Channels::new(&patterns).unwrap();
            let axis = &channels.axes[0];
            for u in [0, 1, 5, 639, 640, 1277, 1279] {
                let mut differences = [0.0; MOST_CHANNELS];
                for (difference, channel) in differences.iter_mut().zip(&axis.all) {
                    let is_lit = Pattern::GrayCode(channel.stripes).is_lit(u, 0);
                    *difference = if is_lit { 0.9 } else { -0.9 };
                }
                let whole = least_place_px(axis, &differences, 0.01);
                assert!((0..i64::from(step)).contains(&(i64::from(u) - whole)), "{u}: {whole}");
                // With the fine stripes blurred away, it is less.
                differences[4..].fill(0.1);
                let coarse = least_place_px(axis, &differences, 0.01);
                assert!(coarse <= whole && whole - coarse < 128, "{u}: {coarse}");
                assert_eq!(least_place_px(axis, &differences, 1.0), 0, "nothing is certain");
            }
        }
    }
}
