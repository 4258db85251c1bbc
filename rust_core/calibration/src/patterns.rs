//! Gray-code patterns (Inokuchi, Sato, Matsuda: "Range imaging system for 3-D object recognition", 1984).
//!
//! The stripes of bit b encode bit b of the Gray code of a pixel's column or row; neighbours differ in one bit. Each
//! pattern comes with its inverse, which replaces thresholds and cancels interreflections. White and black come first.

/// Image axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Columns: u.
    X,
    /// Rows: v.
    Y,
}

impl Axis {
    /// Both.
    pub const ALL: [Self; 2] = [Self::X, Self::Y];

    /// 0 for x, 1 for y.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// `x` or `y`.
    pub const fn name(self) -> &'static str {
        ["x", "y"][self as usize]
    }
}

/// Stripes of one bit of a Gray code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Stripes {
    /// Encoded axis.
    pub axis: Axis,
    /// Bits of the code, 1 to [`Stripes::MOST_BITS`].
    pub bits: u32,
    /// Index of the bit; 0 is the most significant.
    pub bit: u32,
    /// Pixels that share a code, at least 1.
    pub step: u32,
    /// Shift towards lower coordinates, pixels.
    pub offset: u32,
    /// `true` if lit and dark are exchanged.
    pub inverted: bool,
}

impl Stripes {
    /// Maximum bits of a code.
    pub const MOST_BITS: u32 = 16;

    /// `true` if column or row `at` is lit: code c = (at + offset) div step, Gray g = c xor (c >> 1), lit where bit
    /// `bit` of g is 1.
    pub fn is_lit(&self, at: u32) -> bool {
        let code = (u64::from(at) + u64::from(self.offset)) / u64::from(self.step.max(1));
        let gray = code ^ (code >> 1);
        let significance = self.bits.saturating_sub(self.bit + 1).min(63);
        ((gray >> significance) & 1 == 1) != self.inverted
    }

    /// Stripes with lit and dark exchanged.
    pub fn inverse(self) -> Self {
        Self { inverted: !self.inverted, ..self }
    }

    /// Width of the narrowest inner stripe, pixels.
    pub fn width_px(&self) -> f64 {
        f64::from(self.step) * 2.0_f64.powi((self.bits - self.bit).min(Self::MOST_BITS) as i32)
    }
}

/// Image projected during a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pattern {
    /// Everything lit.
    White,
    /// Nothing lit.
    Black,
    /// One bit of a Gray code.
    GrayCode(Stripes),
}

impl Pattern {
    /// `true` if a projector pixel is lit.
    pub fn is_lit(&self, u: u32, v: u32) -> bool {
        match self {
            Self::White => true,
            Self::Black => false,
            Self::GrayCode(stripes) => stripes.is_lit(match stripes.axis {
                Axis::X => u,
                Axis::Y => v,
            }),
        }
    }

    /// Grey levels, 0 or 255, row by row from the top.
    pub fn image(&self, size_px: [u32; 2]) -> Vec<u8> {
        let [width, height] = size_px;
        let level = |is_lit| if is_lit { 255 } else { 0 };
        let mut image = Vec::with_capacity(width as usize * height as usize);
        match self {
            Self::GrayCode(stripes) if stripes.axis == Axis::X => {
                let row: Vec<u8> = (0..width).map(|u| level(stripes.is_lit(u))).collect();
                (0..height).for_each(|_| image.extend_from_slice(&row));
            }
            _ => (0..height).for_each(|v| {
                image.resize(image.len() + width as usize, level(self.is_lit(0, v)));
            }),
        }
        image
    }
}

/// Patterns of a scan: white, black, and for each axis every bit with its inverse, the most significant first. Each
/// pixel has its own code: 44 patterns for 1280×800.
pub fn gray_code(size_px: [u32; 2]) -> Vec<Pattern> {
    let mut patterns = vec![Pattern::White, Pattern::Black];
    for axis in Axis::ALL {
        let bits = bits_for(size_px[axis.index()]);
        patterns
            .extend((0..bits).flat_map(|bit| pair(Stripes { axis, bits, bit, step: 1, offset: 0, inverted: false })));
    }
    patterns
}

/// Patterns for a camera that cannot resolve the finest stripes: codes of `step` pixels (2 or more), and the finest bit
/// again, shifted by each number of pixels below half its period, so that an edge lies between any two pixels. No
/// stripe is narrower than two steps. With step 4: 64 patterns for 1280×800.
pub fn shifted_gray_code(size_px: [u32; 2], step: u32) -> Vec<Pattern> {
    let step = step.max(1);
    let mut patterns = vec![Pattern::White, Pattern::Black];
    for axis in Axis::ALL {
        let last_offset = 2 * step - 1;
        let bits = bits_for((size_px[axis.index()] + last_offset).div_ceil(step));
        let stripes = |bit, offset| pair(Stripes { axis, bits, bit, step, offset, inverted: false });
        patterns.extend((0..bits).flat_map(|bit| stripes(bit, 0)));
        patterns.extend((1..=last_offset).flat_map(|offset| stripes(bits - 1, offset)));
    }
    patterns
}

fn pair(stripes: Stripes) -> [Pattern; 2] {
    [Pattern::GrayCode(stripes), Pattern::GrayCode(stripes.inverse())]
}

/// Number of bits for this many codes, at least one.
fn bits_for(codes: u32) -> u32 {
    (u32::BITS - codes.saturating_sub(1).leading_zeros()).max(1)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    fn stripes_of(patterns: &[Pattern], axis: Axis) -> Vec<Stripes> {
        let all = patterns.iter().filter_map(|pattern| match pattern {
            Pattern::GrayCode(stripes) => Some(*stripes),
            _ => None,
        });
        all.filter(|stripes| stripes.axis == axis).collect()
    }

    #[test]
    fn the_stripes_are_those_of_the_definition() {
        let stripes = Stripes { axis: Axis::X, bits: 11, bit: 10, step: 1, offset: 0, inverted: false };
        let lit: Vec<bool> = (0..8).map(|u| stripes.is_lit(u)).collect();
        assert_eq!(lit, [false, true, true, false, false, true, true, false]);
        let wide = Stripes { bits: 9, bit: 8, step: 4, offset: 2, ..stripes };
        let lit: Vec<bool> = (0..12).map(|u| wide.is_lit(u)).collect();
        let expected =
            [[false, false], [true, true], [true, true], [true, true], [true, true], [false, false]].concat();
        assert_eq!(lit, expected);
        assert_eq!((0..2000).find(|u| stripes.is_lit(*u) == stripes.inverse().is_lit(*u)), None);
        let coarsest = Stripes { bit: 0, ..stripes };
        assert_eq!((0..2048).position(|u| coarsest.is_lit(u)), Some(1024));
        assert_eq!((stripes.width_px(), wide.width_px(), coarsest.width_px()), (2.0, 8.0, 2048.0));
    }

    #[test]
    fn each_pixel_has_a_code_and_neighbours_differ_in_one_bit() {
        let patterns = gray_code([1280, 800]);
        assert_eq!(patterns.len(), 44);
        for (axis, size) in [(Axis::X, 1280), (Axis::Y, 800)] {
            let stripes: Vec<Stripes> =
                stripes_of(&patterns, axis).into_iter().filter(|stripes| !stripes.inverted).collect();
            let codes: Vec<Vec<bool>> =
                (0..size).map(|at| stripes.iter().map(|stripes| stripes.is_lit(at)).collect()).collect();
            assert_eq!(codes.iter().collect::<HashSet<_>>().len(), size as usize);
            for pair in codes.windows(2) {
                assert_eq!(pair[0].iter().zip(&pair[1]).filter(|(a, b)| a != b).count(), 1);
            }
        }
    }

    #[test]
    fn shifted_stripes_tell_each_pixel_and_are_never_narrow() {
        for (size, count) in [([1280, 800], 64), ([1024, 768], 64)] {
            let patterns = shifted_gray_code(size, 4);
            assert_eq!(patterns.len(), count, "{size:?}");
            for axis in Axis::ALL {
                let stripes = stripes_of(&patterns, axis);
                assert!(stripes.iter().all(|stripes| stripes.width_px() >= 8.0));
                let codes: HashSet<Vec<bool>> = (0..size[axis.index()])
                    .map(|at| stripes.iter().map(|stripes| stripes.is_lit(at)).collect())
                    .collect();
                assert_eq!(codes.len(), size[axis.index()] as usize);
            }
        }
    }

    #[test]
    fn images_show_the_stripes() {
        let size = [37, 23];
        for pattern in gray_code(size) {
            let image = pattern.image(size);
            assert_eq!(image.len(), 37 * 23);
            for (index, level) in image.into_iter().enumerate() {
                let (u, v) = (index as u32 % 37, index as u32 / 37);
                assert_eq!(level == 255, pattern.is_lit(u, v));
            }
        }
        assert_eq!(Pattern::White.image([3, 2]), [255; 6]);
        assert_eq!(Pattern::Black.image([3, 2]), [0; 6]);
    }

    #[test]
    fn tiny_projectors_have_a_code() {
        assert_eq!(gray_code([1, 1]).len(), 6);
        assert_eq!(gray_code([2, 3]).len(), 2 + 2 + 4);
    }
}
