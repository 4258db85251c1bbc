//! The process's TCP connections, as the system has them.
//!
//! rosrust does not say which of its connections still stand, and waits without limit for other nodes' answers. Where
//! the system has no `/proc`, no connection is found and nothing is repaired.

use socket2::{SockRef, Type};
use std::net::{Shutdown, SocketAddr};
use std::os::fd::{AsRawFd, RawFd};

/// A descriptor of the process that somebody else owns.
struct Foreign(RawFd);

impl AsRawFd for Foreign {
    fn as_raw_fd(&self) -> RawFd {
        self.0
    }
}

/// The two ends of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Connection {
    pub(crate) own: SocketAddr,
    pub(crate) peer: SocketAddr,
}

/// All TCP connections of the process.
pub(crate) fn connections() -> Vec<Connection> {
    descriptors().filter_map(|descriptor| connection(&descriptor)).collect()
}

/// Ends a connection: whoever waits for it in this process gets its end.
pub(crate) fn end(connection_to_end: Connection) {
    for descriptor in descriptors().filter(|descriptor| connection(descriptor) == Some(connection_to_end)) {
        // Fails only when it has ended already.
        let _ = SockRef::from(&descriptor).shutdown(Shutdown::Both);
    }
}

fn descriptors() -> impl Iterator<Item = Foreign> {
    let entries = std::fs::read_dir("/proc/self/fd").into_iter().flatten();
    entries.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok().map(Foreign))
}

/// None for what is no TCP connection, also when it was closed meanwhile.
fn connection(descriptor: &Foreign) -> Option<Connection> {
    let socket = SockRef::from(descriptor);
    if socket.r#type().ok()? != Type::STREAM {
        return None;
    }
    Some(Connection { own: socket.local_addr().ok()?.as_socket()?, peer: socket.peer_addr().ok()?.as_socket()? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::net::{TcpListener, TcpStream};

    fn connection_to(address: SocketAddr) -> Option<Connection> {
        connections().into_iter().find(|connection| connection.peer == address)
    }

    #[test]
    fn a_connection_is_seen_while_it_stands() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let stream = TcpStream::connect(address).unwrap();
        assert_eq!(connection_to(address).unwrap().own, stream.local_addr().unwrap());
        drop(stream);
        assert_eq!(connection_to(address), None);
    }

    #[test]
    fn a_reader_that_waits_for_an_ended_connection_goes_on() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let mut stream = TcpStream::connect(address).unwrap();
        let reading = std::thread::spawn(move || stream.read(&mut [0]).unwrap());
        std::thread::sleep(std::time::Duration::from_millis(50));
        end(connection_to(address).unwrap());
        assert_eq!(reading.join().unwrap(), 0);
    }
}
