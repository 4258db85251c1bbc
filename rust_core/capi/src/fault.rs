//! Result codes of calls, and errors.

use std::fmt;

/// Result code of a call. After every code except `RCS_RESULT_OK`, `rcs_last_error` has the reason as text, and nothing
/// was written through the call's pointers.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RcsResult {
    /// Success.
    Ok = 0,
    /// A required pointer is NULL.
    NullPointer,
    /// A length does not match the sizes, or is larger than memory.
    BadLength,
    /// A number is out of range, a buffer is not aligned, or two buffers overlap.
    BadValue,
    /// A field of the CameraInfo is invalid.
    BadCameraInfo,
    /// There is no valid CameraInfo: none was set, the last one was invalid, or it was cleared.
    NoCameraInfo,
    /// The text is no `.rviz` file.
    BadConfig,
    /// A bug of this library; please report it. The handle can still be used.
    Panic,
}

/// Error of a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) result: RcsResult,
    /// One line, without the function's name.
    pub(crate) text: String,
}

impl Fault {
    pub(crate) fn new(result: RcsResult, text: impl fmt::Display) -> Self {
        Self { result, text: text.to_string() }
    }

    pub(crate) fn null(name: &str) -> Self {
        Self::new(RcsResult::NullPointer, format_args!("{name} is NULL"))
    }

    pub(crate) fn no_camera_info() -> Self {
        Self::new(RcsResult::NoCameraInfo, "no valid CameraInfo was set")
    }
}
