//! A service: requests are handled one after the other on each connection.

use std::io::{self, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rcs_process::lock;

use super::header::{read_exact, Header};
use crate::registrar::Entry;
use crate::socket::keep_alive;

/// Timeout of a request, and of writing the response.
const CALL_TIMEOUT: Duration = Duration::from_secs(5);
/// Timeout of a persistent connection without requests.
const PERSISTENT_TIMEOUT: Duration = Duration::from_secs(24 * 3600);
/// Longest request.
const MAX_REQUEST_BYTES: u32 = 16 << 20;

/// Handles a request of a node, by its name: the response, or the reason for none.
pub(crate) type Handler = Box<dyn Fn(&str, &[u8]) -> Result<Vec<u8>, String> + Send + Sync>;

/// A service by its whole name.
pub(crate) struct Service {
    /// Whole name.
    pub(crate) name: String,
    /// Number of the registration.
    pub(crate) number: u64,
    /// Type, `package/Name`.
    pub(crate) ros_type: String,
    /// Checksum of the definition.
    pub(crate) md5sum: String,
    handler: Handler,
    is_closed: AtomicBool,
    callers: Mutex<Vec<TcpStream>>,
}

impl Service {
    /// A service without connections.
    pub(crate) fn new(name: &str, ros_type: String, md5sum: String, handler: Handler) -> Arc<Self> {
        Arc::new(Self {
            name: name.to_owned(),
            number: Entry::next_number(),
            ros_type,
            md5sum,
            handler,
            is_closed: AtomicBool::new(false),
            callers: Mutex::default(),
        })
    }

    /// Ends the connections of all callers.
    pub(crate) fn close(&self) {
        self.is_closed.store(true, Ordering::Release);
        for caller in &*lock(&self.callers) {
            // Fails if it has ended.
            let _ = caller.shutdown(Shutdown::Both);
        }
    }

    /// Answers a caller's header and then its requests, until either side ends the connection.
    pub(super) fn serve(&self, mut stream: TcpStream, wanted: &Header, node_name: &str) -> io::Result<()> {
        let is_probe = wanted.is_on("probe");
        if !is_probe && !matches!(wanted.get("md5sum"), Some(sum) if sum == "*" || sum == self.md5sum) {
            let theirs = wanted.get("md5sum").unwrap_or("none");
            let reason = format!("service [{}] has md5sum {}, not {theirs}", self.name, self.md5sum);
            return Header::new([("error", reason.as_str())]).write(&mut stream, CALL_TIMEOUT);
        }
        let (request, response) = (format!("{}Request", self.ros_type), format!("{}Response", self.ros_type));
        let answer = Header::new([
            ("callerid", node_name),
            ("md5sum", &self.md5sum),
            ("service", &self.name),
            ("type", &self.ros_type),
            ("request_type", &request),
            ("response_type", &response),
        ]);
        answer.write(&mut stream, CALL_TIMEOUT)?;
        if is_probe {
            return Ok(());
        }
        keep_alive(&stream)?;
        let (own, peer) = (stream.try_clone()?, stream.peer_addr()?);
        lock(&self.callers).push(own);
        let caller = wanted.get("callerid").unwrap_or("unknown");
        let result = self.answer_calls(&mut stream, caller, wanted.is_on("persistent"));
        lock(&self.callers).retain(|caller| caller.peer_addr().is_ok_and(|address| address != peer));
        result
    }

    fn answer_calls(&self, stream: &mut TcpStream, caller: &str, is_persistent: bool) -> io::Result<()> {
        // Clients may connect long before their first call.
        let patience = if is_persistent { PERSISTENT_TIMEOUT } else { CALL_TIMEOUT };
        while !self.is_closed.load(Ordering::Acquire) {
            let mut len = [0; 4];
            match read_exact(stream, &mut len, Instant::now() + patience) {
                Err(error) if is_persistent && error.kind() == io::ErrorKind::UnexpectedEof => return Ok(()),
                other => other?,
            }
            let len = u32::from_le_bytes(len);
            if len > MAX_REQUEST_BYTES {
                return Err(io::Error::new(io::ErrorKind::InvalidData, format!("a request of {len} bytes")));
            }
            let mut request = vec![0; len as usize];
            read_exact(stream, &mut request, Instant::now() + CALL_TIMEOUT)?;
            let (is_success, body) = match (self.handler)(caller, &request) {
                Ok(response) => (1, response),
                Err(reason) => (0, reason.into_bytes()),
            };
            let mut answer = vec![is_success];
            answer.extend_from_slice(&(body.len() as u32).to_le_bytes());
            answer.extend_from_slice(&body);
            stream.set_write_timeout(Some(CALL_TIMEOUT))?;
            stream.write_all(&answer)?;
            if !is_persistent {
                return Ok(());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::listener::Listener;
    use super::*;
    use crate::socket::TEST_PATIENCE;
    use std::io::Read;

    fn listener() -> Listener {
        let listener = Listener::start("127.0.0.1:0".parse().unwrap(), "/node").unwrap();
        let handler = |caller: &str, request: &[u8]| match request {
            b"no" => Err("refused".to_owned()),
            b"who" => Ok(caller.as_bytes().to_vec()),
            request => Ok(request.iter().rev().copied().collect()),
        };
        listener.add_service(Service::new("/reverse", "a/Reverse".to_owned(), "abc".to_owned(), Box::new(handler)));
        listener
    }

    fn connect(listener: &Listener, fields: &[(&str, &str)]) -> (TcpStream, Header) {
        let mut stream = TcpStream::connect(("127.0.0.1", listener.port())).unwrap();
        Header::new(fields.iter().copied()).write(&mut stream, TEST_PATIENCE).unwrap();
        let answer = Header::read(&mut stream, Instant::now() + TEST_PATIENCE).unwrap();
        (stream, answer)
    }

    fn call(stream: &mut TcpStream, request: &[u8]) -> (u8, Vec<u8>) {
        stream.set_read_timeout(Some(TEST_PATIENCE)).unwrap();
        stream.write_all(&(request.len() as u32).to_le_bytes()).unwrap();
        stream.write_all(request).unwrap();
        let mut head = [0; 5];
        stream.read_exact(&mut head).unwrap();
        let mut body = vec![0; u32::from_le_bytes([head[1], head[2], head[3], head[4]]) as usize];
        stream.read_exact(&mut body).unwrap();
        (head[0], body)
    }

    const CALLER: [(&str, &str); 3] = [("callerid", "/caller"), ("service", "/reverse"), ("md5sum", "abc")];

    #[test]
    fn a_call_is_answered_once_and_on_a_persistent_connection_again_and_again() {
        let listener = listener();
        let (mut stream, answer) = connect(&listener, &CALLER);
        assert_eq!(answer.get("response_type"), Some("a/ReverseResponse"));
        assert_eq!(call(&mut stream, b"abc"), (1, b"cba".to_vec()));
        assert_eq!(stream.read(&mut [0]).unwrap(), 0);
        let (mut stream, _) = connect(&listener, &[CALLER.as_slice(), &[("persistent", "1")]].concat());
        for _ in 0..3 {
            assert_eq!(call(&mut stream, b"no"), (0, b"refused".to_vec()));
            assert_eq!(call(&mut stream, b"who"), (1, b"/caller".to_vec()));
        }
        listener.remove_service("/reverse");
        assert_eq!(stream.read(&mut [0]).unwrap(), 0);
    }

    #[test]
    fn wrong_callers_are_told_why_and_a_probe_is_answered() {
        let listener = listener();
        let (_, answer) = connect(&listener, &[("callerid", "/c"), ("service", "/reverse"), ("md5sum", "other")]);
        assert!(answer.get("error").unwrap().contains("md5sum abc, not other"), "{answer:?}");
        let (_, answer) = connect(&listener, &[("callerid", "/c"), ("service", "/none"), ("md5sum", "*")]);
        assert!(answer.get("error").unwrap().contains("/none"), "{answer:?}");
        let (mut stream, answer) = connect(&listener, &[("callerid", "/c"), ("service", "/reverse"), ("probe", "1")]);
        assert_eq!(answer.get("md5sum"), Some("abc"));
        assert_eq!(stream.read(&mut [0]).unwrap(), 0);
    }

    #[test]
    fn a_request_of_four_gigabytes_ends_the_connection() {
        let listener = listener();
        let (mut stream, _) = connect(&listener, &CALLER);
        stream.write_all(&u32::MAX.to_le_bytes()).unwrap();
        stream.set_read_timeout(Some(TEST_PATIENCE)).unwrap();
        assert_eq!(stream.read(&mut [0]).unwrap(), 0);
    }
}
