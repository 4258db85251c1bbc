//! Time limits and TCP_NODELAY for the connections that rosrust publishes over.
//!
//! rosrust sets neither, and hands out none of its sockets. On Linux a connection inherits both from the socket that it
//! was accepted on, so it is enough to set them on the process's listening sockets, which `/proc/self/fd` names. With a
//! limit, a subscriber that has not taken a single byte for that long is dropped, and can connect again; without, it
//! would hold up the topic's other subscribers for as long as it stands still.
//!
//! Where there is no `/proc`, nothing is set and everything else works.

use socket2::{SockRef, Type};
use std::os::fd::{AsRawFd, RawFd};
use std::time::Duration;

/// Much longer than any network takes for a byte, and short enough for the others to bear once.
const WRITE_TIMEOUT: Duration = Duration::from_millis(300);

/// A descriptor of the process that somebody else owns.
struct Foreign(RawFd);

impl AsRawFd for Foreign {
    fn as_raw_fd(&self) -> RawFd {
        self.0
    }
}

/// Sets both for all connections that will be accepted on the process's present TCP ports.
pub fn tune_listeners() {
    let Ok(entries) = std::fs::read_dir("/proc/self/fd") else {
        log::debug!("no /proc/self/fd: connections stay as they are");
        return;
    };
    let descriptors = entries.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    for descriptor in descriptors {
        tune(&Foreign(descriptor));
    }
}

/// None for what is no listening TCP socket.
fn tune(descriptor: &Foreign) -> Option<()> {
    let socket = SockRef::from(descriptor);
    if !socket.is_listener().ok()? || socket.r#type().ok()? != Type::STREAM {
        return None;
    }
    // An X server's or other local socket has no address of this kind.
    socket.local_addr().ok()?.as_socket()?;
    socket.set_nodelay(true).ok()?;
    socket.set_write_timeout(Some(WRITE_TIMEOUT)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{ErrorKind, Write};
    use std::net::{TcpListener, TcpStream};

    #[test]
    fn writing_to_a_reader_that_stands_still_ends() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        tune_listeners();
        let _idle = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (mut accepted, _) = listener.accept().unwrap();
        assert!(accepted.nodelay().unwrap());
        let error = accepted.write_all(&vec![0; 64 << 20]).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::WouldBlock);
    }
}
