//! PNG files.
//!
//! [`write_png`] takes pixels as they lie in a `sensor_msgs/Image` or in a renderer's buffer (rows from the top, no
//! padding). A file appears whole or not at all: it is written beside its place under another name and renamed, so
//! that a script may wait for it to exist.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// What one pixel of a PNG file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PngFormat {
    /// Red, green, blue, one byte each.
    Rgb8,
    /// Red, green, blue, alpha, one byte each.
    Rgba8,
    /// One byte of grey.
    Gray8,
    /// Two bytes of grey in the machine's byte order.
    Gray16,
}

impl PngFormat {
    /// Bytes of one pixel.
    pub fn bytes_per_pixel(self) -> usize {
        match self {
            Self::Rgb8 => 3,
            Self::Rgba8 => 4,
            Self::Gray8 => 1,
            Self::Gray16 => 2,
        }
    }

    fn color_type(self) -> ExtendedColorType {
        match self {
            Self::Rgb8 => ExtendedColorType::Rgb8,
            Self::Rgba8 => ExtendedColorType::Rgba8,
            Self::Gray8 => ExtendedColorType::L8,
            Self::Gray16 => ExtendedColorType::L16,
        }
    }
}

/// Why a PNG file was not written.
#[derive(Debug, thiserror::Error)]
pub enum PngError {
    /// The pixels are not as many as width and height need.
    #[error("{}: a picture of {width_px}x{height_px} pixels needs {needed_bytes} bytes, but there are {got_bytes}", path.display())]
    WrongLength {
        /// The file.
        path: PathBuf,
        /// Columns.
        width_px: u32,
        /// Rows.
        height_px: u32,
        /// Bytes that the size needs.
        needed_bytes: u64,
        /// Bytes given.
        got_bytes: usize,
    },
    /// The file cannot be written.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The encoder refused the picture.
    #[error("{}: cannot encode: {source}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the encoder says.
        source: image::ImageError,
    },
}

/// Writes one PNG file, replacing one that is there. The folder must exist.
///
/// # Errors
/// [`PngError`], naming the file, when `pixels` has the wrong length or the file cannot be written.
pub fn write_png(path: &Path, width_px: u32, height_px: u32, format: PngFormat, pixels: &[u8]) -> Result<(), PngError> {
    let needed_bytes = u64::from(width_px) * u64::from(height_px) * format.bytes_per_pixel() as u64;
    if pixels.len() as u64 != needed_bytes {
        return Err(PngError::WrongLength {
            path: path.to_owned(),
            width_px,
            height_px,
            needed_bytes,
            got_bytes: pixels.len(),
        });
    }
    let unfinished = unfinished_name(path);
    let result = encode_to(&unfinished, path, (width_px, height_px), format, pixels).and_then(|()| {
        fs::rename(&unfinished, path).map_err(|source| PngError::Write { path: path.to_owned(), source })
    });
    if result.is_err() {
        // What is left of a failed attempt is of no use; the error that matters is already at hand.
        let _ = fs::remove_file(&unfinished);
    }
    result
}

/// The name under which a file is written until it is whole: hidden, in the same folder, one for each process.
fn unfinished_name(path: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    path.with_file_name(name)
}

fn encode_to(
    unfinished: &Path,
    path: &Path,
    (width_px, height_px): (u32, u32),
    format: PngFormat,
    pixels: &[u8],
) -> Result<(), PngError> {
    let write_error = |source| PngError::Write { path: path.to_owned(), source };
    let mut file = BufWriter::new(File::create(unfinished).map_err(write_error)?);
    PngEncoder::new(&mut file)
        .write_image(pixels, width_px, height_px, format.color_type())
        .map_err(|source| PngError::Encode { path: path.to_owned(), source })?;
    file.flush().map_err(write_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        for format in [PngFormat::Rgb8, PngFormat::Rgba8, PngFormat::Gray8, PngFormat::Gray16] {
            let path = folder.path().join("picture.png");
            let pixels: Vec<u8> = (0u8..).take(3 * 2 * format.bytes_per_pixel()).collect();
            write_png(&path, 3, 2, format, &pixels).unwrap();
            let read = image::open(&path).unwrap();
            assert_eq!((read.width(), read.height()), (3, 2));
            assert_eq!(read.as_bytes(), pixels, "{format:?}");
        }
        let files = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(files, 1, "no unfinished file stays behind");
    }

    #[test]
    fn a_wrong_length_and_a_missing_folder_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let error = write_png(&path, 2, 2, PngFormat::Rgb8, &[0; 11]).unwrap_err();
        assert!(matches!(error, PngError::WrongLength { needed_bytes: 12, got_bytes: 11, .. }));
        assert!(!path.exists());
        let lost = folder.path().join("missing").join("picture.png");
        let error = write_png(&lost, 1, 1, PngFormat::Gray8, &[0]).unwrap_err();
        assert!(error.to_string().contains("missing/picture.png"), "{error}");
    }
}
