//! Why a scan yields no capture. Each is one line that says what to do.

use rcs_bag::BagError;
use rcs_calibration::{DecodeError, ScanProblem, VerificationProblem};

use crate::devices::CameraError;
use crate::recorded::sequence::SequenceError;

/// Why a scan was given up.
#[derive(Debug, thiserror::Error)]
pub enum ScanFailure {
    /// White and black look the same.
    #[error(
        "the camera does not see the projector's light on {screen}: is the projector on, does the camera look at what \
         it lights, and is the room dark enough?"
    )]
    NoLight {
        /// The screen's name.
        screen: String,
    },
    /// Brightness changes while the same is shown.
    #[error(
        "the camera's brightness is not steady, it changes by {:.0} % while the same picture is shown: switch off \
         automatic exposure, gain and white balance, and lamps that flicker",
        100.0 * change
    )]
    Unsteady {
        /// The change as a share of the projector's light.
        change: f64,
    },
    /// Much of the picture is clipped at white.
    #[error("{:.0} % of the lit pixels are overexposed: shorten the camera's exposure", 100.0 * clipped)]
    Overexposed {
        /// The share of lit pixels.
        clipped: f64,
    },
    /// The same pattern looks different after some time.
    #[error(
        "the camera or the things have moved during the scan ({:.0} % of the lit pixels have changed): keep both at \
         rest and scan again",
        100.0 * share
    )]
    Moved {
        /// The share of lit pixels that have changed.
        share: f64,
    },
    /// The projector's picture is mirrored.
    #[error(
        "the projector's picture is mirrored: switch off rear projection or mirroring in the projector's menu and in \
         the monitor's settings, and take mirrors out of the way"
    )]
    Mirrored,
    /// The projector distorts its picture; the reason.
    #[error("{0}")]
    Keystone(String),
    /// Stripes that the picture does not have.
    #[error(
        "{:.0} % of the lit pixels see stripes that no picture of {}x{} pixels has: is another picture, a scaled one, \
         or one of another size shown on {screen}?",
        100.0 * share, size_px[0], size_px[1]
    )]
    OtherPicture {
        /// The share of lit pixels.
        share: f64,
        /// The projector's width and height, pixels.
        size_px: [u32; 2],
        /// The screen's name.
        screen: String,
    },
    /// Two pictures in a row never look the same.
    #[error(
        "what the camera sees does not come to rest within {secs:.0} s: is something moving, or a lamp flickering?"
    )]
    Restless {
        /// How long it was waited for.
        secs: f64,
    },
    /// The pictures do not belong together.
    #[error("{0}")]
    Problem(ScanProblem),
    /// Ctrl-C before there was enough.
    #[error("interrupted before enough was seen")]
    Interrupted,
    /// Too little was decoded.
    #[error("only {count} pixels could be decoded: light more of what the camera sees")]
    Undecoded {
        /// Decoded camera pixels.
        count: usize,
    },
    /// No depth was measured.
    #[error("no depth image was received during the scan: without depth, scan with --no-depth")]
    NoDepth,
    /// The camera fails.
    #[error(transparent)]
    Camera(CameraError),
    /// A picture or a depth image of another size than the camera info says.
    #[error(
        "the {what} has {}x{} pixels, but the camera info says {}x{}",
        size_px[0], size_px[1], camera_px[0], camera_px[1]
    )]
    Size {
        /// `picture` or `depth image`.
        what: &'static str,
        /// Its width and height, pixels.
        size_px: [u32; 2],
        /// Width and height in the camera info.
        camera_px: [u32; 2],
    },
    /// The screen fails.
    #[error("cannot show a picture on {screen}: {reason:#}")]
    Screen {
        /// The screen's name.
        screen: String,
        /// Why.
        reason: anyhow::Error,
    },
    /// A verification that says nothing.
    #[error(transparent)]
    Verification(#[from] VerificationProblem),
    /// The patterns cannot be decoded.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// It is not known which pictures of a recording show which pattern.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// A bag cannot be read.
    #[error(transparent)]
    Bag(#[from] BagError),
}

impl ScanFailure {
    /// `true` if what was seen is refused, `false` if a device or a file cannot be used.
    pub fn is_refusal(&self) -> bool {
        !matches!(
            self,
            Self::Camera(_) | Self::Size { .. } | Self::Screen { .. } | Self::Decode(_) | Self::Bag(_) | Self::NoDepth
        )
    }
}

/// Whether a picture or depth image of so many pixels has the size of the camera info.
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

impl From<CameraError> for ScanFailure {
    fn from(error: CameraError) -> Self {
        match error {
            CameraError::Interrupted => Self::Interrupted,
            error => Self::Camera(error),
        }
    }
}
