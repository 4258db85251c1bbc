//! Errors of a capture folder or a list of patterns: one line, with file and line.

use std::path::PathBuf;

use rcs_camera::LensProblem;

use crate::yaml_text::brief;
use crate::FileError;

/// A capture folder or a list of patterns cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A link leads out of the folder.
    #[error("{}: a link to {}, which is not in the capture's folder", path.display(), target.display())]
    Outside {
        /// The name in the folder.
        path: PathBuf,
        /// Target of the link.
        target: PathBuf,
    },
    /// Invalid value, or not YAML; the message names key, line and column.
    #[error("{}: {}", path.display(), brief(source))]
    Yaml {
        /// The file.
        path: PathBuf,
        /// Reason, with key, line and column.
        source: serde_yaml_ng::Error,
    },
    /// The camera's CameraInfo or an image cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The camera's CameraInfo describes no lens.
    #[error("{}: {problem}", path.display())]
    Lens {
        /// The file.
        path: PathBuf,
        /// Key and reason.
        problem: LensProblem,
    },
    /// An image is wider or higher than any camera's or projector's.
    #[error("{}: pictures of {}x{} pixels; the most is {most_px}", path.display(), size_px[0], size_px[1])]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Width and height, pixels.
        size_px: [u32; 2],
        /// Largest size, pixels.
        most_px: u32,
    },
    /// All images together need too much memory.
    #[error(
        "{}: {patterns} pictures of {}x{} pixels need more than {} GiB",
        path.display(), size_px[0], size_px[1], most_bytes >> 30
    )]
    TooMuch {
        /// The file.
        path: PathBuf,
        /// Number of images.
        patterns: usize,
        /// Their width and height, pixels.
        size_px: [u32; 2],
        /// Largest size, bytes.
        most_bytes: u64,
    },
    /// An image cannot be decoded.
    #[error("{}: invalid image: {source}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// The decoder's error.
        source: image::ImageError,
    },
    /// An image has another size than the CameraInfo.
    #[error(
        "{}: {}x{} pixels where the CameraInfo says {}x{}",
        path.display(), size_px[0], size_px[1], camera_px[0], camera_px[1]
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// Its width and height, pixels.
        size_px: [u32; 2],
        /// Width and height of the CameraInfo, pixels.
        camera_px: [u32; 2],
    },
    /// An image has an unsupported pixel format.
    #[error("{}: {found} where {wanted} is needed", path.display())]
    Pixels {
        /// The file.
        path: PathBuf,
        /// Its format.
        found: String,
        /// The format needed.
        wanted: &'static str,
    },
    /// The data to be written could not be read again.
    #[error("{}: {reason}", path.display())]
    Unwritable {
        /// The folder.
        path: PathBuf,
        /// Reason.
        reason: String,
    },
    /// A file cannot be written.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}
