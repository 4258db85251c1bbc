//! Images as the transports `compressed` (JPEG and PNG, also BMP, TIFF and WebP) and `compressedDepth` (PNG and RVL) of
//! ROS's `image_transport` send them.
//!
//! The format's first word is the encoding of the image that was compressed. Depth of 32-bit floats comes as 16-bit
//! numbers that grow with the inverse of the depth, with two parameters before the data.

use std::io::Cursor;
use std::panic::catch_unwind;
use std::sync::Arc;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use rcs_messages::sensor_msgs::CompressedImage;
use rcs_messages::{as_motion_jpeg, Image};

use super::encoding::PixelFormat;

const MAX_SIDE_PX: u32 = 16_384;
/// Largest number of pixels: a run of equal ones takes some bytes in each of the formats, so that the length of the
/// data does not limit them.
const MAX_PX: u64 = 1 << 25;
/// Memory limit of the decoders; that of JPEG ignores it.
const MAX_DECODED_BYTES: u64 = 512 << 20;

/// Bytes before the data of `compressedDepth`: the format's number and the two parameters.
const HEADER_LEN: usize = 12;

/// Unpacks an image of either transport: `compressedDepth` by the end of its topic or by its format, else `compressed`.
///
/// # Errors
/// The reason, in one line that does not name the topic.
///
/// ```
/// use rcs_messages::sensor_msgs::CompressedImage;
///
/// let error = "an image of an unknown format: JPEG, PNG, BMP, TIFF and WebP are read";
/// let broken = CompressedImage { format: "jpeg".to_owned(), data: vec![1, 2, 3], ..CompressedImage::default() };
/// assert_eq!(rcs_displays::unpack_image("/camera/image/compressed", &broken), Err(error.to_owned()));
/// ```
pub fn unpack_image(topic: &str, message: &CompressedImage) -> Result<Image, String> {
    if topic.ends_with("/compressedDepth") || message.format.contains("compressedDepth") {
        unpack_depth(message)
    } else {
        unpack(message)
    }
}

/// Unpacks an image of the transport `compressed`.
fn unpack(message: &CompressedImage) -> Result<Image, String> {
    let (encoding, rest) = message.format.split_once(';').unwrap_or(("", ""));
    let is_color = encoding.starts_with("rgb") || encoding.starts_with("bgr");
    // Old publishers pass images of other orders than BGR to an encoder that takes them for BGR.
    let is_swapped = is_color && !rest.contains("compressed bgr");
    let image = read(&message.data, None)?;
    let size_px = [image.width(), image.height()];
    let declared = |bits| PixelFormat::of(encoding) == Some(PixelFormat { bits, channels: 1 });
    let (encoding, bytes) = match image {
        DynamicImage::ImageLuma8(grey) => (if declared(8) { encoding } else { "mono8" }, grey.into_raw()),
        DynamicImage::ImageLuma16(grey) => {
            (if declared(16) { encoding } else { "mono16" }, little_endian(&grey.into_raw()))
        }
        DynamicImage::ImageRgb16(color) => {
            (if is_swapped { "bgr16" } else { "rgb16" }, little_endian(&color.into_raw()))
        }
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            return Err("colours of 32-bit floats: 8 and 16 bits are read".to_owned());
        }
        DynamicImage::ImageRgba8(color) => (if is_swapped { "bgra8" } else { "rgba8" }, color.into_raw()),
        other => (if is_swapped { "bgr8" } else { "rgb8" }, other.into_rgb8().into_raw()),
    };
    let step = bytes.len().checked_div(size_px[1] as usize).unwrap_or(0) as u32;
    Ok(Image::new(message.header.clone(), size_px, encoding, step, Arc::new(bytes)))
}

/// Unpacks an image of the transport `compressedDepth`.
fn unpack_depth(message: &CompressedImage) -> Result<Image, String> {
    let (encoding, rest) = message.format.split_once(';').unwrap_or((&message.format, ""));
    let too_short = || format!("{} bytes are too few for a depth image", message.data.len());
    let (header, data) = message.data.split_at_checked(HEADER_LEN).ok_or_else(too_short)?;
    let (size_px, values) = if rest.contains("rvl") { read_rvl(data)? } else { read_png(data)? };
    let header_of_image = message.header.clone();
    match PixelFormat::of(encoding) {
        Some(PixelFormat { bits: 16, channels: 1 }) => {
            let bytes = Arc::new(little_endian(&values));
            Ok(Image::new(header_of_image, size_px, encoding, size_px[0] * 2, bytes))
        }
        Some(PixelFormat { bits: 32, channels: 1 }) => {
            let [a, b] = [4, 8].map(|at| header.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()));
            let [a, b] = [a, b].map(|bytes| f32::from_le_bytes(bytes.unwrap_or_default()));
            let depth_m = |value: &u16| if *value == 0 { f32::NAN } else { a / (f32::from(*value) - b) };
            let bytes = values.iter().flat_map(|value| depth_m(value).to_le_bytes()).collect();
            Ok(Image::new(header_of_image, size_px, encoding, size_px[0] * 4, Arc::new(bytes)))
        }
        _ => Err(format!("format [{}] is no depth format; 16UC1 and 32FC1 are", message.format)),
    }
}

/// Refuses sizes that a few bytes can claim and that would take gigabytes.
fn check_size(size_px: [u32; 2]) -> Result<(), String> {
    let [width, height] = size_px;
    if width.max(height) > MAX_SIDE_PX {
        return Err(format!("an image of {width}x{height}, at most {MAX_SIDE_PX} a side"));
    }
    if u64::from(width) * u64::from(height) > MAX_PX {
        return Err(format!("an image of {width}x{height}, at most {MAX_PX} pixels"));
    }
    Ok(())
}

/// Formats that are read, of those that OpenCV's `imdecode` reads for ROS.
const FORMATS: [ImageFormat; 5] =
    [ImageFormat::Jpeg, ImageFormat::Png, ImageFormat::Bmp, ImageFormat::Tiff, ImageFormat::WebP];

fn read(bytes: &[u8], format: Option<ImageFormat>) -> Result<DynamicImage, String> {
    let format = match format.or_else(|| image::guess_format(bytes).ok()) {
        Some(format) if FORMATS.contains(&format) => format,
        other => {
            let name = other.map_or("of an unknown format".to_owned(), |format| format!("in {format:?}"));
            return Err(format!("an image {name}: JPEG, PNG, BMP, TIFF and WebP are read"));
        }
    };
    // Some damaged images make the decoder of JPEG panic, which must not end the calling thread.
    catch_unwind(|| decode(bytes, format)).unwrap_or_else(|_| Err(format!("the {format:?} decoder panicked")))
}

fn decode(bytes: &[u8], format: ImageFormat) -> Result<DynamicImage, String> {
    let bytes = as_motion_jpeg(bytes.to_vec());
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    check_size([width, height])?;
    DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())
}

fn read_png(bytes: &[u8]) -> Result<([u32; 2], Vec<u16>), String> {
    match read(bytes, Some(ImageFormat::Png))? {
        DynamicImage::ImageLuma16(depth) => Ok(([depth.width(), depth.height()], depth.into_raw())),
        other => Err(format!("a PNG of {:?}, not of 16-bit grey", other.color())),
    }
}

/// Wilson's RVL: width, height, and runs of zeros and of differences, in numbers of 3 bits a nibble.
fn read_rvl(bytes: &[u8]) -> Result<([u32; 2], Vec<u16>), String> {
    let too_short = || "the RVL data end too early".to_owned();
    let (size, stream) = bytes.split_at_checked(8).ok_or_else(too_short)?;
    let side = |at: usize| size.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes);
    let size_px = [side(0), side(4)];
    check_size(size_px)?;
    let count = size_px[0] as usize * size_px[1] as usize;
    // Words of 32 bits with the first nibble on top.
    let words = stream.chunks_exact(4).filter_map(|word| Some(u32::from_le_bytes(word.try_into().ok()?)));
    let mut nibbles = words.flat_map(|word| (0..8).rev().map(move |i| (word >> (4 * i)) & 15));
    let mut number = || {
        let (mut value, mut shift) = (0_u32, 0);
        loop {
            let nibble = nibbles.next().ok_or_else(too_short)?;
            value |= (nibble & 7).checked_shl(shift).unwrap_or(0);
            shift += 3;
            if nibble & 8 == 0 {
                return Ok::<u32, String>(value);
            }
        }
    };
    let mut values: Vec<u16> = Vec::new();
    let mut last = 0_i32;
    while values.len() < count {
        let left = count - values.len();
        let zeros = number()? as usize;
        values.resize(values.len() + zeros.min(left), 0);
        let differences = (number()? as usize).min(count - values.len());
        for _ in 0..differences {
            let coded = number()?;
            last = last.wrapping_add((coded >> 1) as i32 ^ -((coded & 1) as i32));
            values.push(last as u16);
        }
        if zeros == 0 && differences == 0 {
            return Err("an empty run in the RVL data".to_owned());
        }
    }
    Ok((size_px, values))
}

fn little_endian(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use image::{ImageBuffer, Luma, Rgb};
    use proptest::prelude::*;

    use super::*;

    fn message(format: &str, data: Vec<u8>) -> CompressedImage {
        CompressedImage { format: format.to_owned(), data, ..CompressedImage::default() }
    }

    fn packed(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn depth_png() -> Vec<u8> {
        let depth = ImageBuffer::<Luma<u16>, _>::from_raw(3, 1, vec![0, 1000, 65535]).unwrap();
        packed(&DynamicImage::ImageLuma16(depth), ImageFormat::Png)
    }

    #[test]
    fn colours_come_out_in_their_order_whoever_sent_them() {
        let image = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(2, 1, Rgb([250, 10, 20])));
        for (kind, tolerance) in [
            (ImageFormat::Png, 0),
            (ImageFormat::Bmp, 0),
            (ImageFormat::Tiff, 0),
            (ImageFormat::WebP, 0),
            (ImageFormat::Jpeg, 3),
        ] {
            let data = packed(&image, kind);
            for (format, encoding) in [
                ("rgb8; jpeg compressed bgr8", "rgb8"),
                ("bgr8; png compressed bgr8", "rgb8"),
                ("jpeg", "rgb8"),
                ("rgb8; jpeg compressed ", "bgr8"),
            ] {
                let image = unpack(&message(format, data.clone())).unwrap();
                assert_eq!((image.encoding.as_str(), image.width, image.height, image.step), (encoding, 2, 1, 6));
                let near =
                    image.data().iter().zip([250_u8, 10, 20, 250, 10, 20]).all(|(a, b)| a.abs_diff(b) <= tolerance);
                assert!(near, "{format}: {:?}", image.data());
            }
        }
    }

    /// Without the segments of some markers, from the start to the first scan.
    fn without_segments(jpeg: &[u8], markers: &[u8]) -> Vec<u8> {
        let mut left = jpeg[..2].to_vec();
        let mut rest = &jpeg[2..];
        while rest[1] != 0xda {
            let (segment, after) = rest.split_at(2 + usize::from(u16::from_be_bytes([rest[2], rest[3]])));
            if !markers.contains(&segment[1]) {
                left.extend(segment);
            }
            rest = after;
        }
        left.extend(rest);
        left
    }

    #[test]
    fn a_frame_of_motion_jpeg_has_the_standard_huffman_tables() {
        let pixel = |x, y| Rgb([(x * 8) as u8, (y * 10) as u8, ((x * y) % 256) as u8]);
        for image in [
            DynamicImage::ImageRgb8(ImageBuffer::from_fn(32, 24, pixel)),
            DynamicImage::ImageLuma8(ImageBuffer::from_fn(32, 24, |x, y| Luma([(x * y) as u8]))),
        ] {
            // This encoder's tables are the standard's.
            let whole = packed(&image, ImageFormat::Jpeg);
            let expected = unpack(&message("jpeg", whole.clone())).unwrap();
            let (huffman, app0) = (0xc4, 0xe0);
            for missing in [&[huffman][..], &[huffman, app0], &[app0]] {
                let frame = without_segments(&whole, missing);
                assert!(frame.len() < whole.len());
                assert_eq!(unpack(&message("jpeg", frame)).unwrap(), expected, "without {missing:x?}");
            }
        }
    }

    #[test]
    fn a_format_that_is_not_read_is_named() {
        let gif = b"GIF89a\x01\0\x01\0\0\0\0;".to_vec();
        let netpbm = b"P6 1 1 255 abc".to_vec();
        for (data, name) in [(gif, "in Gif"), (netpbm, "in Pnm"), (b"oh".to_vec(), "of an unknown format")] {
            let error = unpack(&message("bgr8; jpeg compressed bgr8", data)).unwrap_err();
            assert_eq!(error, format!("an image {name}: JPEG, PNG, BMP, TIFF and WebP are read"));
        }
    }

    #[test]
    fn depth_comes_as_png_of_16_bits() {
        let image = unpack(&message("16UC1; png compressed ", depth_png())).unwrap();
        assert_eq!((image.encoding.as_str(), image.step), ("16UC1", 6));
        assert_eq!(image.data(), [0, 0, 0xe8, 3, 255, 255]);
        let mut data = vec![0; HEADER_LEN];
        data.extend(depth_png());
        let image = unpack_depth(&message("16UC1; compressedDepth png", data)).unwrap();
        assert_eq!((image.encoding.as_str(), image.data()), ("16UC1", [0, 0, 0xe8, 3, 255, 255].as_slice()));
    }

    #[test]
    fn the_transport_is_told_by_topic_or_format() {
        let mut data = vec![0; HEADER_LEN];
        data.extend(depth_png());
        for (topic, format, data, is_image) in [
            ("/depth/compressedDepth", "16UC1; compressedDepth", &data, true),
            ("/depth/compressedDepth", "16UC1", &data, true),
            ("/depth_small", "16UC1; compressedDepth png", &data, true),
            ("/depth/compressed", "16UC1; png compressed ", &depth_png(), true),
            ("/depth/compressed", "16UC1; png compressed ", &data, false),
        ] {
            assert_eq!(unpack_image(topic, &message(format, data.clone())).is_ok(), is_image, "{topic} {format}");
        }
    }

    #[test]
    fn float_depth_is_the_inverse_of_what_is_sent() {
        let mut data = vec![0; 4];
        data.extend(5000.0_f32.to_le_bytes());
        data.extend(500.0_f32.to_le_bytes());
        data.extend(depth_png());
        let image = unpack_depth(&message("32FC1; compressedDepth", data)).unwrap();
        let depths: Vec<f32> = image.data().chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert!(depths[0].is_nan());
        assert_eq!(depths[1..], [10.0, 5000.0 / (65535.0 - 500.0)]);
    }

    #[test]
    fn rvl_is_runs_of_zeros_and_of_differences() {
        // 2 zeros, then 3 values: 5 (+5 is coded as 10), 3 (−2 as 3), 3 (0 as 0); one zero, no values.
        let nibbles = [2_u32, 3, 8 | 2, 1, 3, 0, 1, 0];
        let word = nibbles.iter().fold(0, |word, nibble| word << 4 | nibble);
        let mut data = vec![0; HEADER_LEN];
        data.extend([6_u32, 1].iter().flat_map(|side| side.to_le_bytes()));
        data.extend(word.to_le_bytes());
        let image = unpack_depth(&message("16UC1; compressedDepth rvl", data.clone())).unwrap();
        assert_eq!((image.width, image.height), (6, 1));
        assert_eq!(image.data(), [0, 0, 0, 0, 5, 0, 3, 0, 3, 0, 0, 0]);
        data.truncate(data.len() - 4);
        assert!(unpack_depth(&message("16UC1; compressedDepth rvl", data)).is_err());
    }

    #[test]
    fn thirty_bytes_of_rvl_are_no_image_of_half_a_gigabyte() {
        let mut data = vec![0; HEADER_LEN];
        data.extend([16_384_u32, 16_384].iter().flat_map(|side| side.to_le_bytes()));
        // A run of 2^28 zeros, then of no values.
        data.extend([0x8888_8888_u32, 0x8200_0000].iter().flat_map(|word| word.to_le_bytes()));
        let error = unpack_depth(&message("16UC1; compressedDepth rvl", data)).unwrap_err();
        assert_eq!(error, "an image of 16384x16384, at most 33554432 pixels");
    }

    proptest! {
        #[test]
        fn damaged_images_are_errors(
            cut in 0..200_usize, at in 0..200_usize, value: u8, rvl: bool, junk in prop::collection::vec(any::<u8>(), 0..64),
        ) {
            let mut data = vec![0; HEADER_LEN];
            data.extend(depth_png());
            data.truncate(cut);
            if let Some(byte) = data.get_mut(at) {
                *byte = value;
            }
            let format = if rvl { "16UC1; compressedDepth rvl" } else { "32FC1; compressedDepth" };
            for data in [data, junk] {
                for image in [unpack(&message("rgb8; jpeg compressed bgr8", data.clone())), unpack_depth(&message(format, data))] {
                    let is_whole = |image: &Image| image.data().len() == image.step as usize * image.height as usize;
                    prop_assert!(image.as_ref().map_or(true, is_whole));
                }
            }
        }
    }
}
