//! What a call returns, and why one failed.

use std::fmt;

/// What a call came to. After anything but `RCS_RESULT_OK`, `rcs_last_error` has the reason in words, and nothing was
/// written through the call's pointers.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RcsResult {
    /// Done.
    Ok = 0,
    /// A pointer that is needed is NULL.
    NullPointer,
    /// A length is not what the sizes need, or more than a memory holds.
    BadLength,
    /// A number is none of those that it may be, a pointer is not aligned, or two buffers overlap.
    BadValue,
    /// A field of the CameraInfo makes drawing impossible.
    BadCameraInfo,
    /// There is no valid CameraInfo: none was set, the last one was refused, or it was cleared.
    NoCameraInfo,
    /// The text is no `.rviz` file.
    BadConfig,
    /// A fault of this library. The handle may be used further; please report it.
    Panic,
}

/// Why a call failed.
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
