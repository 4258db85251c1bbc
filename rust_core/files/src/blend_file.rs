//! Blend weights of a projector as a PNG, which `projector_blend` writes and `camera_stream --blend` reads.
//!
//! Grey is the weight in linear light, and transparency the black-level lift in linear light, so that an opaque
//! image, such as a mask drawn by hand, lifts nothing. Files have 16 bits; 8 bits are read, too.

use std::io::BufReader;
use std::path::Path;

use image::codecs::png::{PngDecoder, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageError};

use crate::atomic_file::write_atomically;
use crate::image_limits::ImageLimits;
use crate::FileError;

/// 8K has 33 million pixels.
const LIMITS: ImageLimits = ImageLimits { most_px: 1 << 25, to_do: "save it in the projector's size" };
/// Weight 1.
const FULL: f32 = 65535.0;

/// Weights and lifts of a projector's pixels, row by row, as fractions of 65535.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BlendFile {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Factors of linear light.
    pub weights: Vec<u16>,
    /// Linear light that is added.
    pub lifts: Vec<u16>,
}

impl BlendFile {
    /// Converts weights and lifts from 0 to 1, clamping others.
    pub fn new(size_px: [u32; 2], weights: &[f32], lifts: &[f32]) -> Self {
        let fixed = |share: &f32| (share.clamp(0.0, 1.0) * FULL).round() as u16;
        Self { size_px, weights: weights.iter().map(fixed).collect(), lifts: lifts.iter().map(fixed).collect() }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`FileError`], naming the file.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let decode_error = |error: ImageError| FileError::new(path, format_args!("not a PNG of weights: {error}"));
        let file = BufReader::new(LIMITS.open(path)?);
        let decoder = PngDecoder::with_limits(file, LIMITS.of_decoder()).map_err(decode_error)?;
        LIMITS.check(path, &decoder)?;
        let image = DynamicImage::from_decoder(decoder).map_err(decode_error)?.into_luma_alpha16();
        let size_px = [image.width(), image.height()];
        let (weights, lifts) = image.pixels().map(|pixel| (pixel.0[0], u16::MAX - pixel.0[1])).unzip();
        Ok(Self { size_px, weights, lifts })
    }

    /// Writes a file.
    ///
    /// # Errors
    /// [`FileError`], naming the file.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        let opacity = |lift: &u16| u16::MAX - lift;
        let pixels = self.weights.iter().zip(&self.lifts).flat_map(|(weight, lift)| [*weight, opacity(lift)]);
        let bytes: Vec<u8> = pixels.flat_map(u16::to_ne_bytes).collect();
        let [width, height] = self.size_px;
        write_atomically(
            path,
            |file| {
                let encoder = PngEncoder::new(file);
                encoder
                    .write_image(&bytes, width, height, ExtendedColorType::La16)
                    .map_err(|error| FileError::writing(path, error))
            },
            |error| FileError::writing(path, error),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_and_lifts_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("left.png");
        let file = BlendFile::new([3, 2], &[0.0, 0.25, 0.5, 0.75, 1.0, 1.5], &[0.0, 0.0, 0.01, 0.02, 0.0, -1.0]);
        assert_eq!((file.weights[1], file.weights[5], file.lifts[2], file.lifts[5]), (16384, 65535, 655, 0));
        file.write(&path).unwrap();
        assert_eq!(BlendFile::read(&path).unwrap(), file);
    }

    #[test]
    fn a_grey_image_of_any_tool_is_weights_without_lifts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        image::GrayImage::from_raw(2, 1, vec![0, 255]).unwrap().save(&path).unwrap();
        let expected = BlendFile { size_px: [2, 1], weights: vec![0, 65535], lifts: vec![0, 0] };
        assert_eq!(BlendFile::read(&path).unwrap(), expected);
        image::RgbImage::from_raw(2, 1, vec![0, 0, 0, 255, 255, 255]).unwrap().save(&path).unwrap();
        assert_eq!(BlendFile::read(&path).unwrap(), expected);
    }

    #[test]
    fn a_file_that_is_missing_or_no_image_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("left.png");
        assert!(BlendFile::read(&path).unwrap_err().to_string().contains("left.png: cannot read it"));
        std::fs::write(&path, b"no picture").unwrap();
        assert!(BlendFile::read(&path).unwrap_err().to_string().contains("left.png: not a PNG of weights"));
        let lost = folder.path().join("missing/left.png");
        assert!(BlendFile::default().write(&lost).unwrap_err().to_string().contains("missing/left.png"));
    }

    #[test]
    fn a_small_file_with_more_pixels_than_a_projector_has_is_refused_before_it_is_decoded() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        for (size_px, expected) in [
            (
                [16384, 16384],
                Err("mask.png: cannot read it: 16384x16384 pixels, more than 33554432 in all; save it in"),
            ),
            ([16385, 1], Err("mask.png: cannot read it: 16385x1 pixels, more than 16384 a side; save it in")),
            ([16384, 1], Ok(())),
        ] {
            std::fs::write(&path, png_of_zeros(size_px)).unwrap();
            let read = BlendFile::read(&path).map(|file| assert_eq!(file.size_px, size_px));
            let said = read.map_err(|error| error.to_string());
            match expected {
                Ok(()) => assert_eq!(said, Ok(())),
                Err(expected) => assert!(said.clone().is_err_and(|said| said.contains(expected)), "{said:?}"),
            }
        }
    }

    /// A black image, which is a small file.
    fn png_of_zeros([width, height]: [u32; 2]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let pixels = vec![0; width as usize * height as usize];
        PngEncoder::new(&mut bytes).write_image(&pixels, width, height, ExtendedColorType::L8).unwrap();
        bytes
    }

    #[test]
    fn a_fifo_does_not_hold_up_the_reader() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let error = BlendFile::read(&path).unwrap_err().to_string();
        assert!(error.ends_with("mask.png: cannot read it: it is a FIFO, only regular files are read"), "{error}");
    }
}
