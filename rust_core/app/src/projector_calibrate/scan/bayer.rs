//! Grey levels of a raw camera's Bayer pattern.
//!
//! A pixel of the sensor sees one colour. The two that it lacks are the means of its neighbours' that see them, of the
//! eight around it (bilinear interpolation); at the edge of the image of those that there are.

use super::received::luma;

/// How a sensor's value is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sample {
    Bits8,
    Bits16,
}

impl Sample {
    /// Bytes of a value.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Bits8 => 1,
            Self::Bits16 => 2,
        }
    }
}

/// A Bayer encoding of `sensor_msgs/image_encodings.h`, such as `bayer_rggb8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bayer {
    /// The channels (0 red, 1 green, 2 blue) of the four pixels of a square, by row and column.
    square: [[usize; 2]; 2],
    pub(super) sample: Sample,
}

impl Bayer {
    /// The encoding of a name; `None` for any other.
    pub(super) fn of(encoding: &str) -> Option<Self> {
        let (square, bits) = encoding.strip_prefix("bayer_")?.split_at_checked(4)?;
        let square = match square {
            "rggb" => [[0, 1], [1, 2]],
            "bggr" => [[2, 1], [1, 0]],
            "gbrg" => [[1, 2], [0, 1]],
            "grbg" => [[1, 0], [2, 1]],
            _ => return None,
        };
        let sample = match bits {
            "8" => Sample::Bits8,
            "16" => Sample::Bits16,
            _ => return None,
        };
        Some(Self { square, sample })
    }

    /// Grey levels row by row. All rows have the same length.
    pub(super) fn grey_levels(self, rows: &[&[u8]], is_bigendian: bool) -> Vec<u8> {
        let width = rows.first().map_or(0, |row| row.len() / self.sample.bytes());
        let level = |row: usize, column: usize| -> Option<u8> {
            match self.sample {
                Sample::Bits8 => rows.get(row)?.get(column).copied(),
                // The high byte.
                Sample::Bits16 => rows.get(row)?.get(2 * column + usize::from(!is_bigendian)).copied(),
            }
        };
        let mut grey = Vec::with_capacity(rows.len() * width);
        for row in 0..rows.len() {
            for column in 0..width {
                let mut sums = [[0_u32; 2]; 3];
                for y in row.saturating_sub(1)..=row + 1 {
                    for x in column.saturating_sub(1)..=column + 1 {
                        let Some(level) = level(y, x) else { continue };
                        let [sum, count] = &mut sums[self.square[y % 2][x % 2]];
                        *sum += u32::from(level);
                        *count += 1;
                    }
                }
                let own = self.square[row % 2][column % 2];
                sums[own] = [u32::from(level(row, column).unwrap_or(0)), 1];
                grey.push(luma(sums.map(|[sum, count]| ((sum + count / 2) / count.max(1)) as u8)));
            }
        }
        grey
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [(&str, [[usize; 2]; 2]); 4] = [
        ("bayer_rggb8", [[0, 1], [1, 2]]),
        ("bayer_bggr8", [[2, 1], [1, 0]]),
        ("bayer_gbrg8", [[1, 2], [0, 1]]),
        ("bayer_grbg8", [[1, 0], [2, 1]]),
    ];

    /// What a sensor with this pattern sees of an even colour.
    fn seen(square: [[usize; 2]; 2], color: [u8; 3], size: usize) -> Vec<Vec<u8>> {
        (0..size).map(|y| (0..size).map(|x| color[square[y % 2][x % 2]]).collect()).collect()
    }

    #[test]
    fn an_even_colour_is_its_luma_everywhere_in_all_orders() {
        for color in [[255, 0, 0], [0, 255, 0], [0, 0, 255], [200, 100, 50]] {
            for (name, square) in NAMES {
                let pixels = seen(square, color, 5);
                let rows: Vec<&[u8]> = pixels.iter().map(Vec::as_slice).collect();
                assert_eq!(Bayer::of(name).unwrap().grey_levels(&rows, false), [luma(color); 25], "{name} {color:?}");
            }
        }
    }

    #[test]
    fn sixteen_bits_keep_their_high_byte_in_either_order() {
        let bayer = Bayer::of("bayer_grbg16").unwrap();
        assert_eq!(bayer.sample, Sample::Bits16);
        let little = [7, 200, 9, 200].as_slice();
        assert_eq!(bayer.grey_levels(&[little, little], false), [200; 4]);
        let big = [200, 7, 200, 9].as_slice();
        assert_eq!(bayer.grey_levels(&[big, big], true), [200; 4]);
    }

    #[test]
    fn an_edge_of_light_stays_within_a_pixel() {
        let row: Vec<u8> = (0..8).map(|x| if x < 4 { 0 } else { 250 }).collect();
        let grey = Bayer::of("bayer_rggb8").unwrap().grey_levels(&[row.as_slice(); 4], false);
        for row in grey.chunks(8) {
            assert!(row[..3].iter().all(|level| *level == 0) && row[5..].iter().all(|level| *level == 250), "{row:?}");
        }
    }

    #[test]
    fn other_encodings_are_none() {
        for name in ["mono8", "bayer_", "bayer_rggb", "bayer_rggb12", "bayer_rgbg8", "bayer_é"] {
            assert_eq!(Bayer::of(name), None, "{name}");
        }
    }
}
