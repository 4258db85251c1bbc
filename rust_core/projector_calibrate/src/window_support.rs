//! Helpers of the commands with a window on the projector.

use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{anyhow, Context as _};
use rcs_node_support::lifecycle::EndRequest;
use rcs_process::join_within;
use rcs_window::{ImageSink, MonitorInfo};

/// Timeout for a thread that was asked to end: it may be writing its files, or ends a node.
const END_TIMEOUT: Duration = Duration::from_secs(10);

/// Starts a thread with a name.
pub(super) fn spawn<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> T + Send + 'static,
) -> anyhow::Result<JoinHandle<T>> {
    thread::Builder::new().name(name.to_owned()).spawn(work).context("cannot start a thread")
}

/// Closes the window once the end is requested.
pub(super) fn close_on_end(end: EndRequest, sink: ImageSink) -> anyhow::Result<()> {
    let waiting = move || {
        end.wait_for(Duration::MAX);
        sink.close();
    };
    spawn("signals", waiting).map(drop)
}

/// Joins a thread that was asked to end; `name` is its work, such as `the scan`.
///
/// # Errors
/// It panicked, or does not end, and is left behind.
pub(super) fn join<T>(thread: JoinHandle<T>, name: &str) -> anyhow::Result<T> {
    match join_within(thread, END_TIMEOUT) {
        Some(Ok(result)) => Ok(result),
        Some(Err(_)) => Err(anyhow!("the thread of {name} has panicked")),
        None => Err(anyhow!("the thread of {name} does not end, so it is left behind")),
    }
}

/// Checks that a monitor has the projector's pixels.
///
/// # Errors
/// The monitor's size, with what to do.
pub(super) fn check_monitor(monitor: &MonitorInfo, projector_px: [u32; 2]) -> anyhow::Result<()> {
    let [width, height] = projector_px;
    anyhow::ensure!(
        monitor.size_px == (width, height),
        "monitor {monitor} does not have the projector's {width}x{height} pixels: choose the projector's monitor, in \
         its native resolution and without scaling"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_monitor_of_another_size_is_refused() {
        let monitor = MonitorInfo {
            name: "HDMI-1".to_owned(),
            position_px: (0, 0),
            size_px: (1920, 1080),
            is_primary: false,
            is_virtual: false,
        };
        assert!(check_monitor(&monitor, [1920, 1080]).is_ok());
        let error = check_monitor(&monitor, [1280, 800]).unwrap_err().to_string();
        assert!(error.contains("1920x1080") && error.contains("1280x800"), "{error}");
    }
}
