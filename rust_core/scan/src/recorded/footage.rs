//! What a scan that was recorded needs of its recording. Tests bring one that was never written.

use std::ops::Range;
use std::time::Duration;

use rcs_calibration::patterns::Pattern;
use rcs_calibration::Lens;

use crate::devices::DepthFrame;
use crate::failure::ScanFailure;

/// What is done with each of a recording's pictures: its number, its time, its width and height, its grey levels row by
/// row from the top.
pub type VisitPicture<'a> = dyn FnMut(usize, Duration, [u32; 2], Vec<u8>) -> Result<(), ScanFailure> + 'a;

/// What is done with each of a recording's depth images.
pub type VisitDepth<'a> = dyn FnMut(DepthFrame) -> Result<(), ScanFailure> + 'a;

/// A picture that a node showed with the projector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shown {
    /// When it was published.
    pub at: Duration,
    /// What it is; none if it is no pattern.
    pub pattern: Option<Pattern>,
}

/// A recording of a camera that saw patterns. Times are since its beginning.
pub trait Footage {
    /// What a message calls it.
    fn name(&self) -> String;

    /// The camera's lens; its size is that of all pictures.
    fn lens(&self) -> Lens;

    /// The camera's optical frame; may be empty.
    fn frame_id(&self) -> String;

    /// Visits the pictures with the wanted numbers in the order of time; the first has number 0.
    ///
    /// # Errors
    /// A picture that cannot be read, or the visitor's error.
    fn pictures(&self, wanted: &dyn Fn(usize) -> bool, visit: &mut VisitPicture<'_>) -> Result<(), ScanFailure>;

    /// Whether there is depth.
    fn has_depth(&self) -> bool;

    /// Visits the depth images of a part of the recording.
    ///
    /// # Errors
    /// One that cannot be read, or the visitor's error.
    fn depths(&self, during: Range<Duration>, visit: &mut VisitDepth<'_>) -> Result<(), ScanFailure>;

    /// What was shown when, if that was recorded. `recognise` tells the pattern of a picture of the projector's size.
    ///
    /// # Errors
    /// A picture that cannot be read.
    fn shown(&self, recognise: &dyn Fn(&[u8]) -> Option<Pattern>) -> Result<Option<Vec<Shown>>, ScanFailure>;
}
