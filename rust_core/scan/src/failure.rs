//! The reasons why a scan yields no capture, each with what to do, in one line.

use rcs_bag::BagError;
use rcs_calibration::{DecodeError, RefinementProblem, ScanProblem, VerificationProblem};

use crate::devices::ScanCameraError;
use crate::recorded::sequence::PatternSequenceError;

/// The reason why a scan was given up.
#[derive(Debug, thiserror::Error)]
pub enum ScanFailure {
    /// White and black look the same; the screen's name.
    #[error(
        "the camera does not see the projector's light on {0}: is the projector on and not blacked out, does the \
         camera look at what it lights, and is the room dark enough?"
    )]
    NoLight(String),
    /// Brightness changes under the same image; by this share of the projector's light.
    #[error(
        "the camera's brightness is not steady, it changes by {:.0} % while the same picture is shown: switch off \
         automatic exposure, gain and white balance, and lamps that flicker",
        100.0 * .0
    )]
    Unsteady(f64),
    /// The share of lit pixels that is clipped at white.
    #[error("{:.0} % of the lit pixels are overexposed: shorten the camera's exposure", 100.0 * .0)]
    Overexposed(f64),
    /// The share of lit pixels that differ between two images of the same pattern.
    #[error(
        "the camera or the things have moved during the scan ({:.0} % of the lit pixels have changed): keep both at \
         rest and scan again",
        100.0 * .0
    )]
    Moved(f64),
    /// The projector's image is mirrored.
    #[error(
        "the projector's picture is mirrored: switch off rear projection or mirroring in the projector's menu and in \
         the monitor's settings, and take mirrors out of the way"
    )]
    Mirrored,
    /// The projector distorts its image; the reason.
    #[error("{0}")]
    Keystone(String),
    /// The camera's image does not settle within these seconds.
    #[error("the camera's image does not settle within {0:.0} s: is something moving, or a lamp flickering?")]
    Restless(f64),
    /// The images do not belong together.
    #[error("{0}")]
    Problem(ScanProblem),
    /// The end was requested.
    #[error("interrupted before everything was seen")]
    Interrupted,
    /// Too few camera pixels were decoded; their number.
    #[error(
        "only {0} pixels could be decoded: light more of what the camera sees, or use a larger --step if the stripes \
         are too fine for it"
    )]
    Undecoded(usize),
    /// No depth was measured.
    #[error("no depth image was received during the scan: without depth, scan with --no-depth")]
    NoDepth,
    /// The camera fails.
    #[error(transparent)]
    Camera(ScanCameraError),
    /// An image or a depth image of another size than in the CameraInfo.
    #[error(
        "the {what} has {}x{} pixels, but the camera info says {}x{}",
        size_px[0], size_px[1], camera_px[0], camera_px[1]
    )]
    Size {
        /// `image` or `depth image`.
        what: &'static str,
        /// Width and height of the image, pixels.
        size_px: [u32; 2],
        /// Width and height in the CameraInfo, pixels.
        camera_px: [u32; 2],
    },
    /// The screen fails.
    #[error("cannot show a picture on {screen}: {reason:#}")]
    Screen {
        /// The screen's name.
        screen: String,
        /// The reason.
        reason: anyhow::Error,
    },
    /// A verification without a result.
    #[error(transparent)]
    Verification(#[from] VerificationProblem),
    /// A refinement without a result.
    #[error(transparent)]
    Refinement(#[from] RefinementProblem),
    /// The patterns cannot be decoded.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The patterns were not found in the recording.
    #[error(transparent)]
    Sequence(#[from] PatternSequenceError),
    /// A bag cannot be read.
    #[error(transparent)]
    Bag(#[from] BagError),
}

impl ScanFailure {
    /// `true` if what was seen before is right: the scan was interrupted, or a device failed.
    pub(crate) fn leaves_images(&self) -> bool {
        matches!(self, Self::Interrupted | Self::Camera(_) | Self::Size { .. } | Self::Screen { .. })
    }

    /// `true` if the images are refused, `false` if a device or a file cannot be used.
    pub fn is_refusal(&self) -> bool {
        !matches!(
            self,
            Self::Camera(_) | Self::Size { .. } | Self::Screen { .. } | Self::Decode(_) | Self::Bag(_) | Self::NoDepth
        )
    }
}

/// Checks that an image or depth image, of `count` pixels, has the size in the CameraInfo.
///
/// # Errors
/// [`ScanFailure::Size`].
pub(crate) fn check_size(
    what: &'static str,
    size_px: [u32; 2],
    count: usize,
    camera_px: [u32; 2],
) -> Result<(), ScanFailure> {
    if size_px == camera_px && count == camera_px[0] as usize * camera_px[1] as usize {
        Ok(())
    } else {
        Err(ScanFailure::Size { what, size_px, camera_px })
    }
}

impl From<ScanCameraError> for ScanFailure {
    fn from(error: ScanCameraError) -> Self {
        match error {
            ScanCameraError::Interrupted => Self::Interrupted,
            error => Self::Camera(error),
        }
    }
}
