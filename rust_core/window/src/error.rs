//! Errors of the window.

use rcs_files::FileError;

use crate::monitor::{MonitorError, MonitorInfo};

/// Error of opening or running the window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no window system, or its screen is not supported.
    #[error("no window: {0}")]
    NoDisplay(String),
    /// The connection to the window system broke.
    #[error("the window is lost: {0}")]
    Lost(String),
    /// The chosen monitor does not exist.
    #[error(transparent)]
    Monitor(#[from] MonitorError),
    /// The window system refuses the window.
    #[error("cannot open a window on monitor {monitor}: {reason}")]
    Open {
        /// The monitor.
        monitor: MonitorInfo,
        /// The window system's error.
        reason: String,
    },
    /// The screenshot cannot be written.
    #[error(transparent)]
    Screenshot(#[from] FileError),
    /// The system has no descriptor or no memory left.
    #[error("no window: {0}")]
    System(#[from] std::io::Error),
}
