//! A call of another node's service: header, request and response on a connection of its own, by one deadline.

use std::io::{self, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::header::{read_exact, Header};

/// Longest response.
const MAX_RESPONSE_BYTES: u32 = 16 << 20;

/// Reason why a call failed.
fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock => "it did not answer in time".to_owned(),
        io::ErrorKind::UnexpectedEof => "it closed the connection".to_owned(),
        _ => error.to_string(),
    }
}

/// Sends the header and a request, and returns the response.
///
/// # Errors
/// The reason in words, the server's own where it has given one; after the deadline at the latest.
pub(crate) fn call(
    stream: &mut TcpStream,
    header: &Header,
    request: &[u8],
    deadline: Instant,
) -> Result<Vec<u8>, String> {
    let (is_success, body) = exchange(stream, header, request, deadline)?;
    if is_success {
        return Ok(body);
    }
    Err(format!("it answered with an error: {}", String::from_utf8_lossy(&body)))
}

/// Success and contents of the response.
fn exchange(
    stream: &mut TcpStream,
    header: &Header,
    request: &[u8],
    deadline: Instant,
) -> Result<(bool, Vec<u8>), String> {
    let in_words = |error: io::Error| reason(&error);
    let time_left = || deadline.saturating_duration_since(Instant::now()).max(Duration::from_millis(1));
    header.write(stream, time_left()).map_err(in_words)?;
    if let Some(refusal) = Header::read(stream, deadline).map_err(in_words)?.get("error") {
        return Err(format!("it refused the call: {refusal}"));
    }
    let len = u32::try_from(request.len()).map_err(|_| "the request is too long".to_owned())?;
    stream.set_write_timeout(Some(time_left())).map_err(in_words)?;
    stream.write_all(&[&len.to_le_bytes(), request].concat()).map_err(in_words)?;
    let mut head = [0; 5];
    read_exact(stream, &mut head, deadline).map_err(in_words)?;
    let [is_success, len @ ..] = head;
    let len = u32::from_le_bytes(len);
    if len > MAX_RESPONSE_BYTES {
        return Err(format!("its answer has {len} bytes, more than {MAX_RESPONSE_BYTES}"));
    }
    let mut body = vec![0; len as usize];
    read_exact(stream, &mut body, deadline).map_err(in_words)?;
    Ok((is_success == 1, body))
}

#[cfg(test)]
mod tests {
    use super::super::listener::Listener;
    use super::super::service::Service;
    use super::*;
    use crate::socket::TEST_PATIENCE;
    use std::net::TcpListener;

    const CALLER: [(&str, &str); 3] = [("callerid", "/caller"), ("service", "/reverse"), ("md5sum", "abc")];

    fn call_at(port: u16, fields: &[(&str, &str)], request: &[u8], timeout: Duration) -> Result<Vec<u8>, String> {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        call(&mut stream, &Header::new(fields.iter().copied()), request, Instant::now() + timeout)
    }

    #[test]
    fn a_service_answers_fails_or_refuses() {
        let listener = Listener::start("127.0.0.1:0".parse().unwrap(), "/node").unwrap();
        let handler = |_: &str, request: &[u8]| match request {
            b"no" => Err("it is Sunday".to_owned()),
            request => Ok(request.iter().rev().copied().collect()),
        };
        listener.add_service(Service::new("/reverse", "a/Reverse".to_owned(), "abc".to_owned(), Box::new(handler)));
        let call = |fields: &[(&str, &str)], request: &[u8]| call_at(listener.port(), fields, request, TEST_PATIENCE);
        assert_eq!(call(&CALLER, b"abc"), Ok(b"cba".to_vec()));
        assert_eq!(call(&CALLER, b""), Ok(Vec::new()));
        assert_eq!(call(&CALLER, b"no"), Err("it answered with an error: it is Sunday".to_owned()));
        let other = [("callerid", "/caller"), ("service", "/reverse"), ("md5sum", "other")];
        let error = call(&other, b"abc").unwrap_err();
        assert!(error.starts_with("it refused the call: ") && error.contains("md5sum abc, not other"), "{error}");
    }

    /// Calls a server that sends some bytes and then waits, or closes the connection.
    fn call_of(answer: &'static [u8], waits: bool, timeout: Duration) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let serving = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            Header::read(&mut stream, Instant::now() + TEST_PATIENCE).unwrap();
            stream.write_all(answer).unwrap();
            if waits {
                // Until the caller has given up.
                let _ = read_exact(&mut stream, &mut [0; 64], Instant::now() + TEST_PATIENCE);
            }
        });
        let error = call_at(port, &CALLER, b"abc", timeout).unwrap_err();
        serving.join().unwrap();
        error
    }

    #[test]
    fn a_server_that_hangs_closes_or_floods_is_an_error() {
        let soon = Duration::from_millis(200);
        assert_eq!(call_of(b"", true, soon), "it did not answer in time");
        // A header without fields, and no response.
        assert_eq!(call_of(&[0; 4], true, soon), "it did not answer in time");
        assert_eq!(call_of(b"", false, TEST_PATIENCE), "it closed the connection");
        let flood = call_of(&[0, 0, 0, 0, 1, 255, 255, 255, 255], true, TEST_PATIENCE);
        assert_eq!(flood, "its answer has 4294967295 bytes, more than 16777216");
    }
}
