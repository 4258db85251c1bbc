//! Ends a program whose display server hangs.
//!
//! A call of an X server or a Wayland compositor has no timeout and cannot be cancelled. So a thread watches: if the
//! window is still open some time after the shutdown was requested, the process exits without closing it.

use std::io;
use std::sync::mpsc::{sync_channel, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::Duration;

/// Time for a window to close and the node to unregister.
const GRACE_PERIOD: Duration = Duration::from_millis(1500);
/// Period of the check for the shutdown request.
const POLL_PERIOD: Duration = Duration::from_millis(100);

/// Watches a window from before its opening until it is dropped.
pub struct WindowWatch {
    _open: SyncSender<()>,
}

impl WindowWatch {
    /// Starts the thread. If the window is still open some time after `is_ending` is true, the process exits with
    /// `exit_status`.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(exit_status: i32, is_ending: impl Fn() -> bool + Send + 'static) -> io::Result<Self> {
        let (open, is_closed) = sync_channel::<()>(0);
        let watching = move || {
            let still_open = |period| is_closed.recv_timeout(period) == Err(RecvTimeoutError::Timeout);
            while still_open(POLL_PERIOD) {
                if is_ending() {
                    if still_open(GRACE_PERIOD) {
                        log::warn!("the display server does not respond; exiting without closing the window");
                        log::logger().flush();
                        std::process::exit(exit_status);
                    }
                    return;
                }
            }
        };
        thread::Builder::new().name("window-watch".to_owned()).spawn(watching)?;
        Ok(Self { _open: open })
    }
}
