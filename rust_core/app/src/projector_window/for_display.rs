//! Images of encodings that are not colours, as `image_view` shows them.
//!
//! `image_view` of Noetic (cv_bridge's `cvtColorForDisplay`) is what is reproduced: 16UC1 is grey from 0 to 10 m in
//! millimetres, 32FC1 from the image's least to its greatest number, Bayer mosaics and YUV 4:2:2 become colours. It
//! refuses 8UC1, 8UC3 and 8UC4, which are shown here as OpenCV takes them: grey, BGR, BGRA; infinite numbers do not
//! count for the range, as in later versions.

use std::borrow::Cow;
use std::sync::Arc;

use rcs_messages::Image;

/// Greatest depth of a 16UC1 image, which is white, in millimetres.
const WHITE_MM: f32 = 10_000.0;

/// The image in an encoding that a window shows: rgb8, rgba8, bgr8, bgra8, mono8 or mono16. Others stay as they are.
///
/// # Errors
/// The data are shorter than the image's size and step need.
pub(super) fn for_display(image: &Image) -> Result<Cow<'_, Image>, String> {
    let renamed = |encoding: &str| {
        let mut renamed = image.clone();
        encoding.clone_into(&mut renamed.encoding);
        Ok(Cow::Owned(renamed))
    };
    match image.encoding.as_str() {
        "8UC1" => renamed("mono8"),
        "8UC3" => renamed("bgr8"),
        "8UC4" => renamed("bgra8"),
        "16UC1" => {
            let levels = image.rows(2)?.flat_map(|row| row.as_chunks().0).map(|pixel| f32::from(image.u16_of(*pixel)));
            Ok(with_pixels(image, "mono8", levels.map(|millimetres| grey(millimetres, 0.0, WHITE_MM)).collect()))
        }
        "32FC1" => {
            let values =
                || Ok::<_, String>(image.rows(4)?.flat_map(|row| row.as_chunks().0).map(|pixel| image.f32_of(*pixel)));
            let (least, greatest) = range(values()?);
            Ok(with_pixels(image, "mono8", values()?.map(|value| grey(value, least, greatest)).collect()))
        }
        "rgb16" | "bgr16" => narrowed::<3>(image),
        "rgba16" | "bgra16" => narrowed::<4>(image),
        "yuv422" => yuv422(image, |[u, y0, v, y1]| ([y0, y1], u, v)),
        "yuv422_yuy2" => yuv422(image, |[y0, u, y1, v]| ([y0, y1], u, v)),
        _ => match image.demosaic() {
            Some(colors) => Ok(with_pixels(image, "rgb8", colors?)),
            None => Ok(Cow::Borrowed(image)),
        },
    }
}

/// The image with other pixels, without padding between rows.
fn with_pixels(image: &Image, encoding: &str, pixels: Vec<u8>) -> Cow<'static, Image> {
    let step = pixels.len().checked_div(image.height as usize).and_then(|bytes| u32::try_from(bytes).ok()).unwrap_or(0);
    Cow::Owned(Image::new(image.header.clone(), [image.width, image.height], encoding, step, Arc::new(pixels)))
}

/// Least and greatest of the finite numbers; 0 and 0 if there are none.
fn range(values: impl Iterator<Item = f32>) -> (f32, f32) {
    let finite = values.filter(|value| value.is_finite()).map(|value| (value, value));
    finite.reduce(|(least, greatest), (value, _)| (least.min(value), greatest.max(value))).unwrap_or((0.0, 0.0))
}

/// Grey level of a number between black at `least` and white at `greatest`; NaN is black, and 128 if both are equal.
fn grey(value: f32, least: f32, greatest: f32) -> u8 {
    if least == greatest {
        return 128;
    }
    // Numbers to bytes saturate, and NaN becomes 0.
    ((f64::from(value) - f64::from(least)) * 255.0 / (f64::from(greatest) - f64::from(least))).round_ties_even() as u8
}

/// Rounds 16-bit channels to 8 bits.
fn narrowed<const CHANNELS: usize>(image: &Image) -> Result<Cow<'_, Image>, String> {
    let channels = image.rows(2 * CHANNELS)?.flat_map(|row| row.as_chunks().0);
    let levels = channels.map(|channel| ((u32::from(image.u16_of(*channel)) + 128) / 257) as u8).collect();
    Ok(with_pixels(image, &image.encoding.replace("16", "8"), levels))
}

/// Converts YUV 4:2:2, two pixels per four bytes.
fn yuv422(image: &Image, split: impl Fn([u8; 4]) -> ([u8; 2], u8, u8)) -> Result<Cow<'_, Image>, String> {
    if !image.width.is_multiple_of(2) {
        return Err(format!("a {} image has an even width, not {}", image.encoding, image.width));
    }
    let pairs = image.rows(2)?.flat_map(|row| row.as_chunks().0).map(|pair| split(*pair));
    let pixels = pairs.flat_map(|([y0, y1], u, v)| [rgb(y0, u, v), rgb(y1, u, v)]).flatten().collect();
    Ok(with_pixels(image, "rgb8", pixels))
}

/// ITU-R BT.601 with luma from 16 to 235, in OpenCV's fixed point.
fn rgb(y: u8, u: u8, v: u8) -> [u8; 3] {
    const ONE: f64 = (1 << 20) as f64;
    const LUMA: i32 = (1.164 * ONE) as i32;
    const HALF: i32 = 1 << 19;
    let luma = (i32::from(y) - 16).max(0) * LUMA + HALF;
    let (u, v) = (i32::from(u) - 128, i32::from(v) - 128);
    let (red, blue) = ((1.596 * ONE) as i32 * v, (2.018 * ONE) as i32 * u);
    let green = (0.813 * ONE) as i32 * v + (0.391 * ONE) as i32 * u;
    [luma + red, luma - green, luma + blue].map(|level| (level >> 20).clamp(0, 255) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rcs_messages::std_msgs::Header;

    fn image(encoding: &str, size_px: [u32; 2], data: &[u8]) -> Image {
        Image::new(Header::default(), size_px, encoding, data.len() as u32 / size_px[1], Arc::new(data.to_vec()))
    }

    fn shown(encoding: &str, size_px: [u32; 2], data: &[u8]) -> (String, Vec<u8>) {
        let image = image(encoding, size_px, data);
        let shown = for_display(&image).unwrap();
        (shown.encoding.clone(), shown.data().to_vec())
    }

    #[test]
    fn depths_in_millimetres_are_white_at_ten_metres_as_in_image_view() {
        let levels: Vec<u8> = [8519_u16, 10416, 7183, 20, 1968, 609].iter().flat_map(|mm| mm.to_le_bytes()).collect();
        assert_eq!(shown("16UC1", [3, 2], &levels), ("mono8".to_owned(), vec![217, 255, 183, 1, 50, 16]));
        let mut big = image("16UC1", [1, 1], &[0x21, 0x47]);
        big.is_bigendian = 1;
        assert_eq!(for_display(&big).unwrap().data(), [217]);
    }

    #[test]
    fn numbers_are_grey_from_the_least_to_the_greatest_as_in_image_view() {
        let bytes = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
        let values = bytes(&[109.0, 1485.0, 11586.0, 10882.0, 843.0, 8445.0]);
        assert_eq!(shown("32FC1", [6, 1], &values).1, [0, 31, 255, 239, 16, 185]);
        let odd = bytes(&[1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2.0]);
        assert_eq!(shown("32FC1", [5, 1], &odd).1, [0, 0, 255, 0, 255]);
        assert_eq!(shown("32FC1", [2, 1], &bytes(&[3.5, 3.5])).1, [128, 128]);
        assert_eq!(shown("32FC1", [1, 1], &bytes(&[f32::NAN])).1, [128]);
    }

    #[test]
    fn yuv_is_the_color_of_opencv() {
        let pixels = [59, 154, 204, 199, 215, 167, 125, 43];
        let expected_bgr = [[21, 126, 255], [74, 178, 255], [255, 144, 171], [207, 0, 27]];
        let expected: Vec<u8> = expected_bgr.iter().flat_map(|[b, g, r]| [*r, *g, *b]).collect();
        assert_eq!(shown("yuv422", [4, 1], &pixels), ("rgb8".to_owned(), expected.clone()));
        let swapped: Vec<u8> = pixels.as_chunks().0.iter().flat_map(|[a, b]| [*b, *a]).collect();
        assert_eq!(shown("yuv422_yuy2", [4, 1], &swapped).1, expected);
        assert!(for_display(&image("yuv422", [3, 1], &[0; 6])).unwrap_err().contains("even width"));
    }

    #[test]
    fn opencvs_names_are_grey_and_bgr_and_sixteen_bits_become_eight() {
        for (encoding, becomes) in [("8UC1", "mono8"), ("8UC3", "bgr8"), ("8UC4", "bgra8"), ("rgb8", "rgb8")] {
            assert_eq!(shown(encoding, [1, 1], &[1, 2, 3, 4]), (becomes.to_owned(), vec![1, 2, 3, 4]), "{encoding}");
        }
        let wide: Vec<u8> = [6541_u16, 11556, 6884].iter().flat_map(|level| level.to_le_bytes()).collect();
        assert_eq!(shown("rgb16", [1, 1], &wide), ("rgb8".to_owned(), vec![25, 45, 27]));
        assert_eq!(shown("bayer_rggb8", [3, 3], &[9; 9]), ("rgb8".to_owned(), vec![9; 27]));
        assert!(for_display(&image("32FC1", [4, 4], &[0; 15])).is_err());
    }
}
