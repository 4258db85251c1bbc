//! How a command of `projector_calibrate` fails: what it was given cannot be read, or no good answer follows from it.

use std::error::Error;
use std::process::ExitCode;

use rcs_scan::ScanFailure;

/// Why nothing was written. Either way one line is printed.
#[derive(Debug)]
pub enum Failure {
    /// Exit code 1: no answer that may be trusted, or it could not be written.
    Refused(anyhow::Error),
    /// Exit code 2: arguments or files that cannot be read.
    Unreadable(anyhow::Error),
}

impl Failure {
    /// A refusal, for `map_err`.
    pub fn refused(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Refused(error.into())
    }

    /// An input that cannot be read, for `map_err`.
    pub fn unreadable(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Unreadable(error.into())
    }

    /// Prints the line and gives the exit code.
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
