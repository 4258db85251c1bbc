//! Mipmap levels of images.

/// The next smaller level of an image of red, green, blue and alpha; `None` for a single texel.
///
/// Each texel is the mean of two by two, rounded. Of odd sides the last row or column is left out; texels that are
/// missing are white.
pub fn halved([width, height]: [u32; 2], rgba: &[[u8; 4]]) -> Option<([u32; 2], Vec<[u8; 4]>)> {
    if width.max(height) <= 1 {
        return None;
    }
    let [half_width, half_height] = [width, height].map(|side| (side / 2).max(1));
    let texel = |x: u32, y: u32| {
        let (x, y) = (x.min(width.saturating_sub(1)) as usize, y.min(height.saturating_sub(1)) as usize);
        rgba.get(y * width as usize + x).copied().unwrap_or([255; 4])
    };
    let texels = (0..half_height).flat_map(|y| (0..half_width).map(move |x| [2 * x, 2 * y]));
    let mean = |[x, y]: [u32; 2]| {
        let [a, b, c, d] = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|[x, y]| texel(x, y).map(u16::from));
        [0, 1, 2, 3].map(|i| ((a[i] + b[i] + c[i] + d[i] + 2) / 4) as u8)
    };
    Some(([half_width, half_height], texels.map(mean).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_the_mean_of_four() {
        let image: Vec<[u8; 4]> = (0..8).map(|i| [i * 10; 4]).collect();
        let (size, half) = halved([4, 2], &image).unwrap();
        assert_eq!((size, half.as_slice()), ([2, 1], &[[25; 4], [45; 4]][..]));
        assert_eq!(halved(size, &half), Some(([1, 1], vec![[35; 4]])));
        assert_eq!(halved([1, 1], &half), None);
    }

    #[test]
    fn of_odd_sides_the_last_is_left_out_and_missing_texels_are_white() {
        let image: Vec<[u8; 4]> = (0..3).map(|i| [i * 10; 4]).collect();
        assert_eq!(halved([3, 1], &image), Some(([1, 1], vec![[5; 4]])));
        assert_eq!(halved([2, 2], &image[..2]), Some(([1, 1], vec![[130; 4]])));
    }
}
