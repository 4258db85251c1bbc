//! Failures of the commands: unreadable input, or no trustworthy result.

use std::error::Error;
use std::process::ExitCode;

use rcs_node_support::dialog::DialogError;
use rcs_scan::{ScanCameraError, ScanFailure};

/// The reason why nothing was written; one line is printed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Exit code 1: no trustworthy result, or it cannot be written.
    Refused(anyhow::Error),
    /// Exit code 2: invalid arguments or unreadable files.
    Unreadable(anyhow::Error),
    /// Exit code 130, as of a program that Ctrl-C ends: interrupted before it had its result.
    Interrupted(anyhow::Error),
}

impl Failure {
    /// A refusal, for `map_err`.
    pub(crate) fn refused(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Refused(error.into())
    }

    /// An unreadable input, for `map_err`.
    pub(crate) fn unreadable(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Unreadable(error.into())
    }

    /// The error alone.
    pub(crate) fn into_error(self) -> anyhow::Error {
        let (Self::Refused(error) | Self::Unreadable(error) | Self::Interrupted(error)) = self;
        error
    }

    /// Prints the line, and below it the topics that may be meant by a silent one, and returns the exit code.
    pub(super) fn report(self) -> ExitCode {
        let code = match self {
            Self::Refused(_) => 1,
            Self::Unreadable(_) => 2,
            Self::Interrupted(_) => 130,
        };
        let error = self.into_error();
        eprintln!("projector_calibrate: {}", rcs_logging::one_line(&error));
        if let Some(ScanCameraError::Silent { known_topics, .. }) = error.downcast_ref() {
            known_topics.iter().for_each(|line| eprintln!("{line}"));
        }
        ExitCode::from(code)
    }
}

impl From<ScanFailure> for Failure {
    fn from(failure: ScanFailure) -> Self {
        match failure {
            ScanFailure::Interrupted => Self::Interrupted(failure.into()),
            ScanFailure::Camera(error) => Self::unreadable(error),
            failure if failure.is_refusal() => Self::refused(failure),
            failure => Self::unreadable(failure),
        }
    }
}

impl From<DialogError> for Failure {
    fn from(error: DialogError) -> Self {
        match error {
            DialogError::Ended | DialogError::Output(_) => Self::refused(error),
            DialogError::Unusable(_) | DialogError::Input(_) => Self::unreadable(error),
        }
    }
}
