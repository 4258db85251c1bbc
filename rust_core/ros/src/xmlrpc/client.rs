//! Calls with a deadline.

use std::io;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use super::http::{self, Side};
use super::value::{self, Value, XmlError};

/// A call has failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CallError {
    /// The address is invalid.
    #[error("'{0}' is not an address of the form http://host:port/")]
    Uri(String),
    /// The host is unknown.
    #[error("unknown host {host}: {source}")]
    Host { host: String, source: io::Error },
    /// The connection failed, broke, or timed out.
    #[error("{0}")]
    Connection(io::Error),
    /// The answer is not XML-RPC, or is a fault.
    #[error("{0}")]
    Answer(XmlError),
    /// The answer's status is not 1.
    #[error("{0}")]
    Refused(String),
}

impl CallError {
    /// `true` if the other side refused the call.
    pub(crate) fn is_answer(&self) -> bool {
        matches!(self, Self::Refused(_) | Self::Answer(XmlError::Fault { .. }))
    }
}

/// Host and port of a URI such as `http://localhost:11311/`.
pub(crate) fn host_and_port(uri: &str) -> Option<(String, u16)> {
    let rest = uri.strip_prefix("http://")?;
    let authority = rest.split_once('/').map_or(rest, |(authority, _)| authority);
    let (host, port) = authority.rsplit_once(':')?;
    let host = host.trim_matches(['[', ']']);
    (!host.is_empty()).then_some((host.to_owned(), port.parse().ok()?))
}

/// Resolves the host of a URI.
///
/// # Errors
/// [`CallError::Uri`], [`CallError::Host`].
#[expect(clippy::disallowed_methods, reason = "the resolver has limits, and the caller is a thread of its own")]
pub(crate) fn addresses(uri: &str) -> Result<Vec<SocketAddr>, CallError> {
    let (host, port) = host_and_port(uri).ok_or_else(|| CallError::Uri(uri.to_owned()))?;
    match (host.as_str(), port).to_socket_addrs() {
        Ok(addresses) => Ok(in_order(addresses)),
        Err(source) => Err(CallError::Host { host, source }),
    }
}

/// Addresses in the order in which they are tried: IPv4 first.
pub(crate) fn in_order(addresses: impl Iterator<Item = SocketAddr>) -> Vec<SocketAddr> {
    let mut addresses: Vec<SocketAddr> = addresses.collect();
    addresses.sort_by_key(|address| !address.is_ipv4());
    addresses
}

/// Connects to the first address that accepts by the deadline. Each has its share of the time.
pub(crate) fn connect(addresses: &[SocketAddr], deadline: Instant) -> io::Result<TcpStream> {
    let mut last = io::Error::from(io::ErrorKind::AddrNotAvailable);
    for (index, address) in addresses.iter().enumerate() {
        let left = deadline.saturating_duration_since(Instant::now()) / (addresses.len() - index) as u32;
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        match TcpStream::connect_timeout(address, left) {
            Ok(stream) => {
                let _ = stream.set_nodelay(true);
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Posts a body and reads the answer's body.
pub(crate) fn post(uri: &str, body: &str, timeout: Duration) -> Result<String, CallError> {
    let addresses = addresses(uri)?;
    let deadline = Instant::now() + timeout;
    let (host, port) = host_and_port(uri).ok_or_else(|| CallError::Uri(uri.to_owned()))?;
    let mut stream = connect(&addresses, deadline).map_err(CallError::Connection)?;
    // HTTP 1.0, whose answers are not chunked.
    let head = format!(
        "POST / HTTP/1.0\r\nHost: {host}:{port}\r\nUser-Agent: rviz_camera_stream\r\nContent-Type: text/xml\r\n\
         Content-Length: {}\r\n\r\n",
        body.len()
    );
    http::write_all(&mut stream, format!("{head}{body}").as_bytes(), deadline).map_err(CallError::Connection)?;
    let answer = http::read_body(&mut stream, Side::Response, deadline).map_err(CallError::Connection)?;
    Ok(String::from_utf8_lossy(&answer).into_owned())
}

/// Calls a method of ROS's APIs, whose answers are `[status, text, value]`, and returns the value.
///
/// # Errors
/// [`CallError`], after `timeout` at the latest, unless the system takes longer to resolve the host.
pub(crate) fn call(uri: &str, method: &str, params: &[Value], timeout: Duration) -> Result<Value, CallError> {
    let answer = post(uri, &value::request(method, params), timeout)?;
    match value::parse_response(&answer).map_err(CallError::Answer)? {
        Value::Array(items) => match <[Value; 3]>::try_from(items) {
            Ok([Value::Int(1), _, value]) => Ok(value),
            Ok([Value::Int(_), Value::String(text), _]) => Err(CallError::Refused(text)),
            _ => Err(CallError::Answer(XmlError::Value("not [status, text, value]".to_owned()))),
        },
        other => Err(CallError::Answer(XmlError::Value(format!("{other:?}").chars().take(40).collect()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::TcpListener;

    /// A server that reads a little and then sends some bytes, or stays silent.
    fn server(answer: Option<&'static str>) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let uri = format!("http://{}/", listener.local_addr().unwrap());
        std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let _ = stream.read(&mut [0; 4096]);
            if let Some(answer) = answer {
                stream.write_all(answer.as_bytes()).unwrap();
            } else {
                let _ = stream.read(&mut [0; 4096]);
            }
        });
        uri
    }

    fn ask(answer: Option<&'static str>) -> Result<Value, CallError> {
        call(&server(answer), "getPid", &["/x".into()], Duration::from_millis(300))
    }

    #[test]
    fn an_address_has_host_and_port() {
        let robot = Some(("robot".to_owned(), 11311));
        assert_eq!(host_and_port("http://robot:11311/"), robot);
        assert_eq!(host_and_port("http://robot:11311"), robot);
        assert_eq!(host_and_port("http://[::1]:5/"), Some(("::1".to_owned(), 5)));
        for wrong in ["robot:11311", "http://robot/", "http://:1/", "http://robot:x/"] {
            assert_eq!(host_and_port(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_silent_server_is_a_timeout() {
        assert!(matches!(ask(None), Err(CallError::Connection(error)) if error.kind() == io::ErrorKind::TimedOut));
    }

    #[test]
    fn answers_of_any_kind_are_values_or_errors() {
        let whole = "HTTP/1.1 200 OK\r\nContent-Length: 216\r\n\r\n<?xml version='1.0'?><methodResponse><params><param>\
                     <value><array><data><value><int>1</int></value><value><string></string></value><value><int>42</int></value>\
                     </data></array></value></param></params></methodResponse>   ";
        let len = whole.split_once("\r\n\r\n").unwrap().1.len();
        let whole: &'static str = Box::leak(whole.replace("216", &len.to_string()).into_boxed_str());
        assert!(matches!(ask(Some(whole)), Ok(Value::Int(42))));
        let chunked = "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n5\r\n<meth\r\n0\r\n\r\n";
        assert!(matches!(ask(Some(chunked)), Err(CallError::Answer(_))));
        assert!(matches!(ask(Some("HTTP/1.1 404 Not Found\r\n\r\n")), Err(CallError::Connection(_))));
        assert!(matches!(ask(Some("garbage\r\n\r\n")), Err(CallError::Connection(_))));
        assert!(ask(Some("HTTP/1.1 200 OK\r\nContent-Length: 999999999999\r\n\r\n")).is_err());
        assert!(matches!(ask(Some("")), Err(CallError::Connection(_))));
    }
}
