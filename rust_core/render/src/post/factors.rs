//! Scaling a row's colours by a factor for each pixel.

use rcs_scene::Encoding;

/// The factor that changes nothing; factors are multiples of one over this.
pub(super) const ONE: u16 = 1 << 15;

/// Pixels that are looked at together: most are lit as drawn, or dark.
const BLOCK: usize = 16;

/// Scales each pixel of a row, alpha not included. Factors are at most [`ONE`].
pub(super) fn scale_row(encoding: Encoding, factors: &[u16], row: &mut [u8]) {
    let cell = encoding.bytes_per_pixel();
    for (factors, bytes) in factors.chunks(BLOCK).zip(row.chunks_mut(BLOCK * cell)) {
        if factors.iter().all(|factor| *factor == ONE) {
            continue;
        }
        match encoding {
            Encoding::Mono8 => scale::<1, 1>(factors, bytes),
            Encoding::Rgb8 | Encoding::Bgr8 => scale::<3, 3>(factors, bytes),
            Encoding::Rgba8 | Encoding::Bgra8 => scale::<4, 3>(factors, bytes),
            Encoding::Mono16 => scale_words(factors, bytes),
        }
    }
}

/// Scales the first `COLORS` of each `CELL` bytes.
fn scale<const CELL: usize, const COLORS: usize>(factors: &[u16], bytes: &mut [u8]) {
    for (pixel, factor) in bytes.as_chunks_mut::<CELL>().0.iter_mut().zip(factors) {
        for level in pixel.iter_mut().take(COLORS) {
            *level = scaled(u32::from(*level), *factor) as u8;
        }
    }
}

fn scale_words(factors: &[u16], bytes: &mut [u8]) {
    for (word, factor) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(factors) {
        *word = (scaled(u32::from(u16::from_le_bytes(*word)), *factor) as u16).to_le_bytes();
    }
}

/// A level by a factor, to the nearest.
fn scaled(level: u32, factor: u16) -> u32 {
    (level * u32::from(factor) + u32::from(ONE) / 2) >> 15
}
