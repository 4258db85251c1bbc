//! Waiting for a ROS master. rosrust gives up at once if there is none, so it is started only once something listens at
//! the master's address.

use crate::NodeError;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::mpsc::{channel, RecvTimeoutError};
use std::time::Duration;

/// How often a master that is not there yet is tried.
const WAIT_PERIOD: Duration = Duration::from_millis(300);

/// Host and port of a URI such as `http://localhost:11311/`.
fn host_and_port(uri: &str) -> Option<(String, u16)> {
    let rest = uri.strip_prefix("http://")?;
    let rest = rest.split_once('/').map_or(rest, |(authority, _)| authority);
    let (host, port) = rest.rsplit_once(':')?;
    Some((host.trim_matches(['[', ']']).to_owned(), port.parse().ok()?))
}

/// The addresses of a URI.
pub(crate) fn addresses_of(uri: &str) -> impl Iterator<Item = SocketAddr> {
    let address = host_and_port(uri);
    address.and_then(|(host, port)| (host.as_str(), port).to_socket_addrs().ok()).into_iter().flatten()
}

/// Fails unless something listens at the master's address now.
pub(crate) fn check_master(uri: &str) -> Result<(), NodeError> {
    let address = host_and_port(uri).ok_or_else(|| NodeError::MasterUri(uri.to_owned()))?;
    if is_listening(&address) {
        Ok(())
    } else {
        Err(NodeError::NoMaster(uri.to_owned()))
    }
}

/// Waits until something listens at the master's address, or `cancelled` returns true.
///
/// Connects on a thread of its own, so that cancelling never waits for the network.
pub(crate) fn wait_for_master(uri: &str, cancelled: &dyn Fn() -> bool) -> Result<(), NodeError> {
    let address = host_and_port(uri).ok_or_else(|| NodeError::MasterUri(uri.to_owned()))?;
    let (found, is_found) = channel();
    let uri_of_thread = uri.to_owned();
    std::thread::spawn(move || {
        let mut is_logged = false;
        loop {
            let listens = is_listening(&address);
            // Sending fails once the caller has given up.
            if found.send(listens).is_err() || listens {
                return;
            }
            if !is_logged {
                log::warn!("no ROS master at {uri_of_thread} yet, waiting for it");
                is_logged = true;
            }
            std::thread::sleep(WAIT_PERIOD);
        }
    });
    loop {
        match is_found.recv_timeout(Duration::from_millis(50)) {
            Ok(true) => return Ok(()),
            Ok(false) | Err(RecvTimeoutError::Timeout) if !cancelled() => {}
            _ => return Err(NodeError::Cancelled(uri.to_owned())),
        }
    }
}

fn is_listening(address: &(String, u16)) -> bool {
    let Ok(mut addresses) = (address.0.as_str(), address.1).to_socket_addrs() else {
        return false;
    };
    addresses.any(|address| TcpStream::connect_timeout(&address, Duration::from_secs(1)).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_master_uri_gives_host_and_port() {
        let robot = Some(("robot".to_owned(), 11311));
        assert_eq!(host_and_port("http://robot:11311/"), robot);
        assert_eq!(host_and_port("http://robot:11311"), robot);
        assert_eq!(host_and_port("http://[::1]:5/"), Some(("::1".to_owned(), 5)));
        assert_eq!(host_and_port("robot:11311"), None);
        assert_eq!(host_and_port("http://robot/"), None);
    }

    #[test]
    fn waiting_for_a_master_can_be_cancelled_at_once() {
        let started = std::time::Instant::now();
        // Port 1 of this machine: nothing listens there.
        let result = wait_for_master("http://127.0.0.1:1/", &|| started.elapsed() > Duration::from_millis(100));
        assert_eq!(result, Err(NodeError::Cancelled("http://127.0.0.1:1/".to_owned())));
        assert!(started.elapsed() < Duration::from_secs(1));
    }
}
