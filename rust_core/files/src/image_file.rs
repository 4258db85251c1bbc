//! Writing images as PNG and JPEG files, by the name's extension, and reading their grey levels.

use std::borrow::Cow;
use std::io::{Cursor, Read};
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::error::{ParameterError, ParameterErrorKind};
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageError, ImageReader};
use rcs_messages::as_motion_jpeg;
use rcs_scene::{Encoding, Image};

use crate::atomic_file::write_atomically;
use crate::image_limits::ImageLimits;
use crate::FileError;

/// Format of an image file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageFormat {
    /// Lossless.
    Png,
    /// Lossy, of high quality; colours and greys of 8 bits.
    Jpeg,
}

/// Quality of JPEG files, at which edges have no visible noise.
const JPEG_QUALITY: u8 = 95;

impl ImageFormat {
    /// Extensions, as a text for messages.
    pub const ENDINGS: &str = ".png, .jpg or .jpeg";

    /// Format by a name's extension.
    ///
    /// # Errors
    /// [`FileError`] for another extension.
    pub fn of(path: &Path) -> Result<Self, FileError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("jpg" | "jpeg") => Ok(Self::Jpeg),
            _ => Err(FileError::new(path, format_args!("a picture's name ends with {}", Self::ENDINGS))),
        }
    }
}

/// Writes or replaces an image in the format of the name's extension: colours as RGB, mono8 as grey, mono16 as 16-bit
/// grey in a PNG file and as 8-bit grey in a JPEG file. Alpha is dropped. The file appears whole or not at all, in an
/// existing folder.
///
/// ```
/// use rcs_files::image_file;
/// use rcs_scene::{Encoding, Image};
///
/// let folder = tempfile::tempdir()?;
/// let red = Image { width_px: 1, height_px: 1, encoding: Encoding::Bgr8, data: vec![0, 0, 255] };
/// image_file::write(&folder.path().join("red.png"), &red)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FileError`], naming the file, if the image's data have the wrong length or the file cannot be written.
pub fn write(path: &Path, image: &Image) -> Result<(), FileError> {
    let format = ImageFormat::of(path)?;
    let Image { width_px, height_px, encoding, data } = image;
    let (width_px, height_px) = (*width_px, *height_px);
    let needed_bytes = u64::from(width_px) * u64::from(height_px) * encoding.bytes_per_pixel() as u64;
    if data.len() as u64 != needed_bytes {
        let problem = format!(
            "a picture of {width_px}x{height_px} pixels needs {needed_bytes} bytes, but there are {}",
            data.len()
        );
        return Err(FileError::new(path, problem));
    }
    let (color_type, bytes) = pixels_for(format, *encoding, data);
    let failed = |error| match error {
        ImageError::IoError(error) => FileError::writing(path, error),
        error => FileError::new(path, format_args!("cannot encode: {error}")),
    };
    write_atomically(
        path,
        |file| {
            let written = match format {
                ImageFormat::Png => PngEncoder::new(file).write_image(&bytes, width_px, height_px, color_type),
                ImageFormat::Jpeg => {
                    let encoder = JpegEncoder::new_with_quality(file, JPEG_QUALITY);
                    encoder.write_image(&bytes, width_px, height_px, color_type)
                }
            };
            written.map_err(failed)
        },
        |error| FileError::writing(path, error),
    )
}

/// Limits of a camera's images.
const LIMITS: ImageLimits = ImageLimits { most_px: 1 << 27, to_do: "scale it down" };

/// Reads an image of a camera: width and height in pixels, and grey levels of 8 bits, row by row.
///
/// # Errors
/// [`FileError`] with the file: it cannot be read, is no image, or too large.
pub fn read_grey(path: &Path) -> Result<([u32; 2], Vec<u8>), FileError> {
    let failed = |error: ImageError| FileError::new(path, error);
    let mut bytes = Vec::new();
    LIMITS.open(path)?.read_to_end(&mut bytes).map_err(|error| failed(error.into()))?;
    let reader = ImageReader::new(Cursor::new(as_motion_jpeg(bytes))).with_guessed_format();
    let mut reader = reader.map_err(|error| failed(error.into()))?;
    reader.limits(LIMITS.of_decoder());
    let decoder = reader.into_decoder().map_err(failed)?;
    LIMITS.check(path, &decoder)?;
    let image = DynamicImage::from_decoder(decoder).map_err(failed)?.into_luma8();
    Ok(([image.width(), image.height()], image.into_raw()))
}

/// Coding of an image for a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coding {
    /// Lossy, with a quality from 1 to 100; colours and greys of 8 bits.
    Jpeg {
        /// Quality from 1 to 100.
        quality: u8,
    },
    /// Lossless.
    Png {
        /// Level of zlib from 1 to 9.
        level: u8,
    },
}

/// Encodes an image in memory.
///
/// # Errors
/// The encoder's, or a data length that does not fit the size.
pub fn encode(image: &Image, coding: Coding) -> Result<Vec<u8>, ImageError> {
    let Image { width_px, height_px, encoding, data } = image;
    let (width_px, height_px) = (*width_px, *height_px);
    let mut file = Vec::new();
    match coding {
        Coding::Jpeg { quality } => {
            let (color_type, bytes) = pixels_for(ImageFormat::Jpeg, *encoding, data);
            check_length(&bytes, width_px, height_px, color_type)?;
            let encoder = JpegEncoder::new_with_quality(&mut file, quality.clamp(1, 100));
            encoder.write_image(&bytes, width_px, height_px, color_type)?;
        }
        Coding::Png { level } => {
            let (color_type, bytes) = pixels_for(ImageFormat::Png, *encoding, data);
            check_length(&bytes, width_px, height_px, color_type)?;
            let compression = CompressionType::Level(level.clamp(1, 9));
            let encoder = PngEncoder::new_with_quality(&mut file, compression, FilterType::Adaptive);
            encoder.write_image(&bytes, width_px, height_px, color_type)?;
        }
    }
    Ok(file)
}

/// Checks the data's length, because the encoders panic if it does not fit the size.
fn check_length(bytes: &[u8], width_px: u32, height_px: u32, color: ExtendedColorType) -> Result<(), ImageError> {
    let needed = u64::from(width_px) * u64::from(height_px) * u64::from(color.bits_per_pixel() / 8);
    match bytes.len() as u64 == needed && needed > 0 {
        true => Ok(()),
        false => Err(ImageError::Parameter(ParameterError::from_kind(ParameterErrorKind::DimensionMismatch))),
    }
}

/// A format's name of the pixels, and their bytes in its order.
fn pixels_for(format: ImageFormat, encoding: Encoding, data: &[u8]) -> (ExtendedColorType, Cow<'_, [u8]>) {
    match (format, encoding) {
        // The high byte of each value.
        (ImageFormat::Jpeg, Encoding::Mono16) => {
            (ExtendedColorType::L8, data.iter().skip(1).step_by(2).copied().collect())
        }
        _ => png_pixels(encoding, data),
    }
}

/// PNG's name of the pixels, and their bytes in its order; 16-bit grey is in the machine's byte order for the encoder.
fn png_pixels(encoding: Encoding, data: &[u8]) -> (ExtendedColorType, Cow<'_, [u8]>) {
    let rgb = |order: [usize; 3]| -> Cow<'_, [u8]> {
        let pixels = data.chunks_exact(encoding.bytes_per_pixel());
        pixels.flat_map(|pixel| order.map(|channel| pixel[channel])).collect()
    };
    match encoding {
        Encoding::Rgb8 => (ExtendedColorType::Rgb8, data.into()),
        Encoding::Rgba8 => (ExtendedColorType::Rgb8, rgb([0, 1, 2])),
        Encoding::Bgr8 | Encoding::Bgra8 => (ExtendedColorType::Rgb8, rgb([2, 1, 0])),
        Encoding::Mono8 => (ExtendedColorType::L8, data.into()),
        Encoding::Mono16 => {
            let native = data.chunks_exact(2).flat_map(|b| u16::from_le_bytes([b[0], b[1]]).to_ne_bytes());
            (ExtendedColorType::L16, native.collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(encoding: Encoding, width_px: u32, data: &[u8]) -> Image {
        Image { width_px, height_px: 1, encoding, data: data.to_owned() }
    }

    #[test]
    fn every_encoding_is_saved_in_its_colours() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let cases: [(Encoding, &[u8], &[u8]); 6] = [
            (Encoding::Rgb8, &[1, 2, 3, 4, 5, 6], &[1, 2, 3, 4, 5, 6]),
            (Encoding::Rgba8, &[1, 2, 3, 255, 4, 5, 6, 255], &[1, 2, 3, 4, 5, 6]),
            (Encoding::Bgr8, &[3, 2, 1, 6, 5, 4], &[1, 2, 3, 4, 5, 6]),
            (Encoding::Bgra8, &[3, 2, 1, 255, 6, 5, 4, 255], &[1, 2, 3, 4, 5, 6]),
            (Encoding::Mono8, &[7, 8], &[7, 8]),
            (Encoding::Mono16, &[1, 2, 3, 4], &[1, 2, 3, 4]),
        ];
        for (encoding, data, expected) in cases {
            write(&path, &image(encoding, 2, data)).unwrap();
            let read = image::open(&path).unwrap();
            assert_eq!((read.width(), read.height()), (2, 1));
            let read = match read {
                image::DynamicImage::ImageLuma16(grey) => grey.iter().flat_map(|v| v.to_le_bytes()).collect(),
                other => other.into_bytes(),
            };
            assert_eq!(read, expected, "{encoding:?}");
        }
    }

    #[test]
    fn a_image_for_a_message_reads_as_it_was() {
        let colors = image(Encoding::Bgr8, 8, &[30, 20, 10].repeat(8));
        for coding in [Coding::Png { level: 1 }, Coding::Png { level: 9 }, Coding::Jpeg { quality: 90 }] {
            let read = image::load_from_memory(&encode(&colors, coding).unwrap()).unwrap().into_rgb8();
            let pixel = read.get_pixel(4, 0).0;
            assert!(pixel.iter().zip([10, 20, 30]).all(|(a, b)| a.abs_diff(b) < 4), "{coding:?} {pixel:?}");
        }
        let small = encode(&colors, Coding::Jpeg { quality: 1 }).unwrap();
        assert!(small.len() < encode(&colors, Coding::Jpeg { quality: 100 }).unwrap().len());
        let grey = image(Encoding::Mono16, 2, &[1, 2, 3, 4]);
        let read = image::load_from_memory(&encode(&grey, Coding::Png { level: 5 }).unwrap()).unwrap();
        assert_eq!(read.into_luma16().into_raw(), [0x0201, 0x0403]);
        assert!(encode(&image(Encoding::Rgb8, 8, &[0; 5]), Coding::Png { level: 1 }).is_err());
        assert!(encode(&image(Encoding::Rgb8, 0, &[]), Coding::Jpeg { quality: 80 }).is_err());
    }

    #[test]
    fn the_ending_of_the_name_is_the_format() {
        let folder = tempfile::tempdir().unwrap();
        let grey = image(Encoding::Mono16, 16, &[0, 200].repeat(16));
        for (name, format) in [
            ("a.png", image::ImageFormat::Png),
            ("a.JPG", image::ImageFormat::Jpeg),
            ("b.jpeg", image::ImageFormat::Jpeg),
        ] {
            let path = folder.path().join(name);
            write(&path, &grey).unwrap();
            assert_eq!(image::guess_format(&std::fs::read(&path).unwrap()).unwrap(), format);
            let read = image::load_from_memory(&std::fs::read(&path).unwrap()).unwrap().into_luma8();
            assert!(read.get_pixel(7, 0).0[0].abs_diff(200) < 3, "{name}: {:?}", read.get_pixel(7, 0));
        }
        for name in ["a", "a.bmp", "png", ".png"] {
            let error = write(&folder.path().join(name), &grey).unwrap_err();
            assert!(error.to_string().contains(".png, .jpg or .jpeg"), "{error}");
        }
    }

    /// As cameras send JPEG, and programs write it to files.
    #[test]
    fn a_jpeg_without_huffman_tables_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.jpg");
        write(&path, &image(Encoding::Mono8, 16, &[90; 16])).unwrap();
        let mut jpeg = std::fs::read(&path).unwrap();
        while let Some(at) = jpeg.windows(2).position(|bytes| bytes == [0xff, 0xc4]) {
            let len = usize::from(u16::from_be_bytes([jpeg[at + 2], jpeg[at + 3]]));
            jpeg.drain(at..at + 2 + len);
        }
        std::fs::write(&path, jpeg).unwrap();
        let (size_px, grey) = read_grey(&path).unwrap();
        assert!(size_px == [16, 1] && grey.iter().all(|level| level.abs_diff(90) < 3), "{grey:?}");
    }

    #[test]
    fn grey_levels_are_read_whatever_the_format() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.jpg", "a.bmp", "a.tiff", "a.pgm", "a.ppm", "a.webp"] {
            let path = folder.path().join(name);
            DynamicImage::from(image::RgbImage::from_pixel(16, 1, image::Rgb([90; 3]))).save(&path).unwrap();
            let (size_px, grey) = read_grey(&path).unwrap();
            assert!(size_px == [16, 1] && grey.iter().all(|level| level.abs_diff(90) < 3), "{name}: {grey:?}");
        }
        for (name, text) in [("plain.pgm", "P2\n# by hand\n2 1\n15\n0 15\n"), ("raw.pgm", "P5\n2 1\n127\n\0\x7f")] {
            std::fs::write(folder.path().join(name), text).unwrap();
            assert_eq!(read_grey(&folder.path().join(name)).unwrap(), ([2, 1], vec![0, 255]), "{name}");
        }
        let path = folder.path().join("b.png");
        std::fs::write(&path, "no picture").unwrap();
        assert!(read_grey(&path).unwrap_err().to_string().contains("b.png"));
    }

    #[test]
    fn a_wrong_length_and_a_missing_folder_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let error = write(&path, &image(Encoding::Rgb8, 4, &[0; 11])).unwrap_err();
        assert!(error.to_string().ends_with("needs 12 bytes, but there are 11"), "{error}");
        assert!(!path.exists());
        let lost = folder.path().join("missing").join("picture.png");
        let error = write(&lost, &image(Encoding::Mono8, 1, &[0])).unwrap_err();
        assert!(error.to_string().contains("missing/picture.png"), "{error}");
    }
}
