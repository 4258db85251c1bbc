//! Waiting for a ROS master: the node starts once one answers.

use std::time::Duration;

use crate::error::NodeError;
use crate::master::ping;
use crate::xmlrpc::client::host_and_port;
use crate::xmlrpc::CallError;

/// Period of calls to a missing master.
const WAIT_PERIOD: Duration = Duration::from_millis(300);
/// Logged reasons: a server that sends garbage may cause another each time.
const MOST_REASONS: usize = 4;

fn check_uri(uri: &str) -> Result<(), NodeError> {
    host_and_port(uri).map(drop).ok_or_else(|| NodeError::MasterUri(uri.to_owned()))
}

/// Checks that a ROS master answers now.
pub(crate) fn check_master(uri: &str) -> Result<(), NodeError> {
    check_uri(uri)?;
    ping(uri).map_err(|error| NodeError::NoMaster { uri: uri.to_owned(), reason: error.to_string() })
}

/// Waits until a ROS master answers, or `cancelled` returns `true`. Each reason is logged once.
pub(crate) fn wait_for_master(uri: &str, cancelled: &dyn Fn() -> bool) -> Result<(), NodeError> {
    check_uri(uri)?;
    ask_until_answered(uri, cancelled, || ping(uri))
}

/// Calls until the master answers, or `cancelled` returns `true`. Each reason is logged once.
pub(crate) fn ask_until_answered<T>(
    uri: &str,
    cancelled: &dyn Fn() -> bool,
    ask: impl Fn() -> Result<T, CallError>,
) -> Result<T, NodeError> {
    let mut logged = Vec::new();
    loop {
        let reason = match ask() {
            Ok(answer) => return Ok(answer),
            Err(_) if cancelled() => return Err(NodeError::Cancelled(uri.to_owned())),
            Err(error) => error.to_string(),
        };
        if logged.contains(&reason) || logged.len() >= MOST_REASONS {
            log::debug!("still no answer of a ROS master at {uri}: {reason}");
        } else {
            log::warn!("no ROS master at {uri} yet, waiting for it: {reason}");
            logged.push(reason);
        }
        std::thread::sleep(WAIT_PERIOD);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_for_a_master_can_be_cancelled_at_once() {
        let started = std::time::Instant::now();
        // Port 1 of this machine: nothing listens there.
        let result = wait_for_master("http://127.0.0.1:1/", &|| started.elapsed() > Duration::from_millis(100));
        assert_eq!(result, Err(NodeError::Cancelled("http://127.0.0.1:1/".to_owned())));
    }

    #[test]
    fn what_answers_but_is_no_master_is_none() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let uri = format!("http://{}/", listener.local_addr().unwrap());
        let answering = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            std::io::Write::write_all(&mut stream, b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n").unwrap();
        });
        let error = check_master(&uri).unwrap_err().to_string();
        assert!(error.contains("404") && !error.contains('\n'), "{error}");
        answering.join().unwrap();
    }
}
