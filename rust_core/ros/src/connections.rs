//! The process's TCP connections, as the system has them.
//!
//! rosrust does not report which of its connections are still open, and waits without limit for other nodes' answers.
//! Where the system has no `/proc`, no connection is found and nothing is repaired.

use crate::foreign_sockets::{open_sockets, ForeignSocket};
use rustix::net::sockopt::socket_type;
use rustix::net::{getpeername, getsockname, shutdown, Shutdown, SocketType};
use std::collections::HashSet;
use std::net::SocketAddr;
use std::os::fd::OwnedFd;

/// A connection: its two ends, and which socket it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Connection {
    pub(crate) own: SocketAddr,
    pub(crate) peer: SocketAddr,
    /// Tells it from a later connection between the same two addresses.
    inode: u64,
}

/// All TCP connections of the process, each once, however many descriptors it has at the moment.
pub(crate) fn connections() -> Vec<Connection> {
    let found: HashSet<Connection> = open_sockets().filter_map(|socket| Some(connection(&socket)?.0)).collect();
    found.into_iter().collect()
}

/// Ends a connection, if it is still that one: whoever waits for its data in this process gets the end of the stream.
pub(crate) fn end(connection_to_end: Connection) {
    let candidates = open_sockets().filter(|socket| socket.inode() == connection_to_end.inode);
    for (found, duplicate) in candidates.filter_map(|socket| connection(&socket)) {
        if found == connection_to_end {
            // Fails only when it has ended already.
            let _ = shutdown(&duplicate, Shutdown::Both);
        }
    }
}

/// The connection that a socket is, read from a duplicate, which comes with it. None for what is no TCP connection,
/// also when it was closed meanwhile.
fn connection(socket: &ForeignSocket) -> Option<(Connection, OwnedFd)> {
    let duplicate = socket.duplicate()?;
    if socket_type(&duplicate).ok()? != SocketType::STREAM {
        return None;
    }
    let own = getsockname(&duplicate).ok()?.try_into().ok()?;
    let peer = getpeername(&duplicate).ok()??.try_into().ok()?;
    Some((Connection { own, peer, inode: socket.inode() }, duplicate))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::{TcpListener, TcpStream};
    use std::time::{Duration, Instant};

    /// Both ends of a new connection: ours, and the one that a listener accepted.
    fn connected() -> (TcpStream, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let stream = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        (stream, listener.accept().unwrap().0)
    }

    fn connection_of(stream: &TcpStream) -> Option<Connection> {
        let own = stream.local_addr().unwrap();
        connections().into_iter().find(|connection| connection.own == own)
    }

    fn is_open((stream, accepted): (&mut TcpStream, &mut TcpStream)) -> bool {
        stream.write_all(b"x").is_ok() && accepted.read(&mut [0]).is_ok_and(|count| count == 1)
    }

    #[test]
    fn a_connection_is_listed_while_it_is_open() {
        let (stream, accepted) = connected();
        let found = connection_of(&stream).unwrap();
        assert_eq!(found.peer, accepted.local_addr().unwrap());
        drop(stream);
        // Another test may hold a duplicate for a moment.
        let deadline = Instant::now() + Duration::from_secs(10);
        while connections().contains(&found) {
            assert!(Instant::now() < deadline, "{found:?} is still there");
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_connection_with_two_descriptors_is_one_connection() {
        let (stream, _accepted) = connected();
        let _second = stream.try_clone().unwrap();
        let own = stream.local_addr().unwrap();
        assert_eq!(connections().iter().filter(|connection| connection.own == own).count(), 1);
    }

    #[test]
    fn a_reader_that_waits_for_an_ended_connection_goes_on() {
        let (mut stream, _accepted) = connected();
        let connection = connection_of(&stream).unwrap();
        let reading = std::thread::spawn(move || stream.read(&mut [0]).unwrap());
        // Whether it waits already or begins to read an ended stream: it gets the end.
        end(connection);
        assert_eq!(reading.join().unwrap(), 0);
    }

    #[test]
    fn another_connection_on_a_reused_descriptor_is_not_ended() {
        let (stream, _accepted) = connected();
        let stale = connection_of(&stream).unwrap();
        let mut descriptor = OwnedFd::from(stream);
        let (other, mut other_accepted) = connected();
        // The other connection takes the place of the first, which is closed by that.
        rustix::io::dup2(&other, &mut descriptor).unwrap();
        drop(other);
        let mut other = TcpStream::from(descriptor);
        end(stale);
        assert!(is_open((&mut other, &mut other_accepted)));
        // The right socket, but not between the addresses that were meant.
        let found = connection_of(&other).unwrap();
        end(Connection { peer: stale.peer, ..found });
        end(Connection { own: stale.own, ..found });
        end(Connection { inode: stale.inode, ..found });
        assert!(is_open((&mut other, &mut other_accepted)));
        end(found);
        assert!(!is_open((&mut other, &mut other_accepted)));
    }
}
