//! The end of a program whose display server hangs.
//!
//! A call of an X server or a Wayland compositor waits for its answer without a limit, and cannot be cancelled. So a
//! thread of its own watches: if the window is still open some time after the program was asked to end, the process
//! ends without closing it. The display server removes the window when it goes on.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{sync_channel, RecvTimeoutError, SyncSender};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};

/// How long a window may take to close. In this time the node unregisters, too.
const GRACE_PERIOD: Duration = Duration::from_millis(1500);
/// How often it is checked whether the program is asked to end.
const POLL_PERIOD: Duration = Duration::from_millis(100);

/// Watches a window from before its opening until this is dropped.
pub struct WindowWatch {
    _open: SyncSender<()>,
}

impl WindowWatch {
    /// If the window is still open some time after `is_ending` has returned true, the process ends with `exit_status`.
    ///
    /// # Errors
    /// The system's, where there is no thread left.
    pub fn start(exit_status: i32, is_ending: impl Fn() -> bool + Send + 'static) -> io::Result<Self> {
        let (open, is_closed) = sync_channel::<()>(0);
        let watching = move || {
            let still_open = |period| is_closed.recv_timeout(period) == Err(RecvTimeoutError::Timeout);
            while still_open(POLL_PERIOD) {
                if is_ending() {
                    if still_open(GRACE_PERIOD) {
                        log::warn!("the display server does not answer, ending without closing the window");
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

    /// The same for a program that SIGINT and SIGTERM ask to end. A second signal ends it at once.
    ///
    /// # Errors
    /// As for [`start`](Self::start), or when the signal handlers cannot be installed.
    pub fn start_with_signals(exit_status: i32) -> io::Result<Self> {
        let is_asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: the first signal sets the flag, a second one finds it set.
            signal_hook::flag::register_conditional_default(signal, Arc::clone(&is_asked))?;
            signal_hook::flag::register(signal, Arc::clone(&is_asked))?;
        }
        Self::start(exit_status, move || is_asked.load(Ordering::Acquire))
    }
}
