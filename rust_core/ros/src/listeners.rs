//! Time limits and TCP_NODELAY for the connections that rosrust publishes over.
//!
//! rosrust sets neither, and hands out none of its sockets. On Linux a connection inherits both from the socket that it
//! was accepted on, so it is enough to set them on the process's listening sockets ([`crate::foreign_sockets`]). With a
//! limit, a subscriber that has not taken a single byte for that long is dropped, and can connect again; without, it
//! would block the topic's other subscribers for as long as it is stopped.
//!
//! Where there is no `/proc`, nothing is set and everything else works.

use crate::foreign_sockets::{open_sockets, ForeignSocket};
use rustix::net::sockopt::{set_socket_timeout, set_tcp_nodelay, socket_acceptconn, socket_type, Timeout};
use rustix::net::{getsockname, SocketType};
use std::net::SocketAddr;
use std::time::Duration;

/// Much longer than any network takes for a byte, and short enough for the others to bear once.
const WRITE_TIMEOUT: Duration = Duration::from_millis(300);

/// Sets both for all connections that will be accepted on the process's present TCP ports.
pub(crate) fn tune_listeners() {
    for socket in open_sockets() {
        tune(&socket);
    }
}

/// None for what is no listening TCP socket, or was closed meanwhile.
fn tune(socket: &ForeignSocket) -> Option<()> {
    let duplicate = socket.duplicate()?;
    if !socket_acceptconn(&duplicate).ok()? || socket_type(&duplicate).ok()? != SocketType::STREAM {
        return None;
    }
    // An X server's or other local socket has no address of this kind.
    SocketAddr::try_from(getsockname(&duplicate).ok()?).ok()?;
    set_tcp_nodelay(&duplicate, true).ok()?;
    set_socket_timeout(&duplicate, Timeout::Send, Some(WRITE_TIMEOUT)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{ErrorKind, Write};
    use std::net::{TcpListener, TcpStream};

    #[test]
    fn writing_to_a_stopped_reader_ends() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        tune_listeners();
        let _idle = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (mut accepted, _) = listener.accept().unwrap();
        assert!(accepted.nodelay().unwrap());
        let error = accepted.write_all(&vec![0; 64 << 20]).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::WouldBlock);
    }
}
