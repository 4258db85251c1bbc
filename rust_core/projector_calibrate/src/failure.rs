//! Failures of the commands: unreadable input, or no trustworthy result.

use std::error::Error;
use std::process::ExitCode;

use rcs_node_support::dialog::DialogError;
use rcs_scan::ScanFailure;

/// The reason why nothing was written; one line is printed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Exit code 1: no trustworthy result, or it cannot be written.
    Refused(anyhow::Error),
    /// Exit code 2: invalid arguments or unreadable files.
    Unreadable(anyhow::Error),
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

    /// Prints the line and returns the exit code.
    pub(super) fn report(&self) -> ExitCode {
        let (error, code) = match self {
            Self::Refused(error) => (error, 1),
            Self::Unreadable(error) => (error, 2),
        };
        eprintln!("projector_calibrate: {}", rcs_logging::one_line(error));
        ExitCode::from(code)
    }
}

impl From<ScanFailure> for Failure {
    fn from(failure: ScanFailure) -> Self {
        if failure.is_refusal() {
            Self::refused(failure)
        } else {
            Self::unreadable(failure)
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
