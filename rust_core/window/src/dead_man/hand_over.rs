//! The end of a black window whose process has died, when another one covers the monitor.
//!
//! Such a window listens on a datagram socket with an abstract name made of the display and the monitor (unix(7)). The
//! child of a new process sends a datagram there: unlike X11's selections, that works with every window system.

use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};

/// Longest name: `sun_path` has 108 bytes, of which the first is zero.
const MAX_NAME_BYTES: usize = 107;

/// The place of a black window.
#[derive(Debug)]
pub(super) struct BlackPlace(SocketAddr);

impl BlackPlace {
    /// The place on a monitor of the display that the environment names.
    pub(super) fn new(monitor: &str) -> std::io::Result<Self> {
        let display = ["XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "DISPLAY"];
        let display = display.map(|name| std::env::var(name).unwrap_or_default()).join(",");
        let name = format!("rviz_camera_stream black window,{display},{monitor}");
        // The end tells displays and monitors apart.
        let name = name.as_bytes();
        let end = name.get(name.len().saturating_sub(MAX_NAME_BYTES)..).unwrap_or(name);
        SocketAddr::from_abstract_name(end).map(Self)
    }

    /// The socket on which a window without a process waits for another one; `None` while somebody else has the place.
    pub(super) fn take(&self) -> Option<UnixDatagram> {
        UnixDatagram::bind_addr(&self.0).ok()
    }

    /// Ends the window without a process that is there, if any. Does not wait.
    pub(super) fn end_other(&self) {
        let send = || {
            let socket = UnixDatagram::unbound()?;
            socket.set_nonblocking(true)?;
            socket.send_to_addr(&[0], &self.0)
        };
        // Mostly there is none.
        let _: std::io::Result<usize> = send();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_taken_once_and_hears_of_another_window() {
        let monitor = format!("monitor of process {}", std::process::id());
        let place = BlackPlace::new(&monitor).unwrap();
        let socket = place.take().unwrap();
        assert!(place.take().is_none());
        BlackPlace::new("another monitor").unwrap().end_other();
        socket.set_nonblocking(true).unwrap();
        assert!(socket.recv(&mut [0; 8]).is_err());
        place.end_other();
        assert_eq!(socket.recv(&mut [0; 8]).unwrap(), 1);
        drop(socket);
        assert!(BlackPlace::new(&monitor).unwrap().take().is_some());
    }

    #[test]
    fn a_long_name_keeps_its_end() {
        for length in [0, 50, 107, 108, 500] {
            assert!(BlackPlace::new(&"x".repeat(length)).is_ok(), "{length}");
        }
    }
}
