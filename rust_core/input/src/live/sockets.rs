//! The process's TCP connections, as the system has them. rosrust does not say which of its connections still stand.

use socket2::{SockRef, Type};
use std::net::SocketAddr;
use std::os::fd::{AsRawFd, RawFd};

/// A descriptor of the process that somebody else owns.
struct Foreign(RawFd);

impl AsRawFd for Foreign {
    fn as_raw_fd(&self) -> RawFd {
        self.0
    }
}

/// The other ends of the process's TCP connections. Empty where the system has no `/proc`.
pub(super) fn connected_peers() -> Vec<SocketAddr> {
    let Ok(entries) = std::fs::read_dir("/proc/self/fd") else {
        return Vec::new();
    };
    let descriptors = entries.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    descriptors.filter_map(|descriptor| peer(&Foreign(descriptor))).collect()
}

/// None for what is no TCP connection, also when it was closed meanwhile.
fn peer(descriptor: &Foreign) -> Option<SocketAddr> {
    let socket = SockRef::from(descriptor);
    if socket.r#type().ok()? != Type::STREAM {
        return None;
    }
    socket.peer_addr().ok()?.as_socket()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::{TcpListener, TcpStream};

    #[test]
    fn a_connection_is_seen_while_it_stands() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let stream = TcpStream::connect(address).unwrap();
        assert!(connected_peers().contains(&address));
        drop(stream);
        assert!(!connected_peers().contains(&address));
    }
}
