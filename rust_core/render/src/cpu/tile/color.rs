//! Packed colours of 8 bits a channel, and how they are blended: with the arithmetic of Mesa's rasteriser.

use fearless_simd::Simd;

use super::lanes::{inlined, U};

/// A colour as the buffers hold it: four bytes, red first in memory.
#[inline]
pub(in crate::cpu) fn pack(color: [u8; 4]) -> u32 {
    u32::from_ne_bytes(color)
}

/// `color` over `behind`, by the colour's alpha.
#[inline]
pub(in crate::cpu) fn blend(behind: u32, color: [u8; 4]) -> u32 {
    // Two channels in each number, each with 16 bits.
    const CHANNELS: u32 = 0x00ff_00ff;
    let alpha = u32::from(color[3]);
    let color = pack(color);
    let scaled = |two: u32, factor: u32| {
        let products = two * factor;
        ((products + ((products >> 8) & CHANNELS) + 0x0080_0080) >> 8) & CHANNELS
    };
    let over = |color: u32, behind: u32| {
        let sum = scaled(color & CHANNELS, alpha) + scaled(behind & CHANNELS, 255 - alpha);
        // 256 becomes 255.
        sum - ((sum >> 8) & 0x0001_0001)
    };
    over(color, behind) | over(color >> 8, behind >> 8) << 8
}

/// As [`blend`], several at once: two channels in each half of the bits.
#[inline(always)]
pub(super) fn blend_lanes<S: Simd>(behind: U<S>, colors: U<S>) -> U<S> {
    const EVEN: u32 = 0x00ff_00ff;
    let alpha = (colors >> channel_shift(3)) & 255;
    let rest = 255 - alpha;
    // What is added to a product of 16 bits never leaves them.
    let scale = inlined(
        #[inline(always)]
        |values: U<S>, factor: U<S>| {
            let product = values * factor;
            ((product + ((product >> 8) & EVEN) + 0x0080_0080) >> 8) & EVEN
        },
    );
    let sum = inlined(
        #[inline(always)]
        |over: U<S>, under: U<S>| {
            let sum = scale(over & EVEN, alpha) + scale(under & EVEN, rest);
            // 256 becomes 255.
            sum - ((sum >> 8) & 0x0001_0001)
        },
    );
    sum(colors, behind) | (sum(colors >> 8, behind >> 8) << 8)
}

/// By how many bits a channel is shifted in a packed colour.
#[inline(always)]
pub(in crate::cpu) fn channel_shift(channel: usize) -> u32 {
    let mut color = [0; 4];
    color[channel] = 1;
    pack(color).trailing_zeros()
}

/// A channel of 0 to 1 as a byte, to the nearest and of two equally near ones to the even; NaN becomes 0.
#[inline]
pub(in crate::cpu) fn unorm8(value: f32) -> u8 {
    // At 2^23 an f32 has no fraction left, so that the sum is rounded and its lowest bits are the whole number.
    const NO_FRACTION: f32 = 8_388_608.0;
    let level = if value > 0.0 { value.min(1.0) * 255.0 } else { 0.0 };
    (level + NO_FRACTION).to_bits() as u8
}

#[cfg(test)]
mod tests {
    use fearless_simd::prelude::*;
    use fearless_simd::{dispatch, Level};
    use proptest::prelude::*;

    use super::*;
    use crate::cpu::tile::lanes::LANES;

    #[test]
    fn blending_rounds_to_the_nearest_level() {
        assert_eq!(blend(pack([0, 100, 255, 255]), [255, 100, 0, 255]), pack([255, 100, 0, 255]));
        let [r, g, b, _] = blend(pack([0, 100, 255, 255]), [255, 100, 0, 0]).to_ne_bytes();
        assert_eq!([r, g, b], [0, 100, 255]);
        let [r, g, b, _] = blend(pack([0, 100, 255, 255]), [255, 100, 0, 128]).to_ne_bytes();
        assert_eq!([r, g, b], [128, 100, 127]);
    }

    /// Any colours, with channels of 0 and 255 more often than others.
    fn colors() -> impl Strategy<Value = [u32; LANES]> {
        let channel = || prop_oneof![1 => Just(0_u8), 1 => Just(255_u8), 4 => any::<u8>()];
        let color = [channel(), channel(), channel(), channel()].prop_map(pack);
        proptest::array::uniform(color)
    }

    /// `color` over `behind`, channel by channel: `value · factor / 255` is rounded for both.
    fn blended_by_channel(behind: u32, color: u32) -> u32 {
        let (behind, color) = (behind.to_ne_bytes(), color.to_ne_bytes());
        let scale = |value: u8, factor: u8| {
            let product = u32::from(value) * u32::from(factor);
            (product + (product >> 8) + 128) >> 8
        };
        let alpha = color[3];
        pack([0, 1, 2, 3].map(|i| (scale(color[i], alpha) + scale(behind[i], 255 - alpha)).min(255) as u8))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn pixels_blend_channel_by_channel(behind in colors(), colors in colors()) {
            for (behind, color) in behind.into_iter().zip(colors) {
                let expected = blended_by_channel(behind, color);
                prop_assert_eq!(blend(behind, color.to_ne_bytes()), expected);
            }
        }

        #[test]
        fn several_pixels_blend_as_one_does(behind in colors(), colors in colors()) {
            fn blended<S: Simd>(simd: S, behind: [u32; LANES], colors: [u32; LANES]) -> [u32; LANES] {
                blend_lanes(U::load_array(simd, behind), U::load_array(simd, colors)).to_array()
            }
            let lanes = dispatch!(Level::new(), simd => blended(simd, behind, colors));
            let singly: [u32; LANES] = std::array::from_fn(|i| blend(behind[i], colors[i].to_ne_bytes()));
            prop_assert_eq!(lanes, singly);
        }
    }

    #[test]
    fn channels_round_to_the_nearest_byte() {
        assert_eq!([0.0, 1.0, 2.0, -1.0, f32::NAN].map(unorm8), [0, 255, 255, 0, 0]);
        assert_eq!([0.3, 0.5, 100.4 / 255.0, 100.6 / 255.0].map(unorm8), [76, 128, 100, 101]);
        assert!((0..=255).all(|byte| unorm8(f32::from(byte) / 255.0) == byte));
    }
}
