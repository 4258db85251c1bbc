//! A server of XML-RPC calls with limits of connections and time.

use std::io;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

use super::http::{self, Side};
use super::value::{self, Value};
use crate::acceptor::{Acceptor, Limits};

/// Timeout of a call.
const CALL_TIMEOUT: Duration = Duration::from_secs(5);
const LIMITS: Limits = Limits { connections: 64, stack_bytes: 512 * 1024 };

/// Answers calls until it is dropped.
pub(crate) struct Server(Acceptor);

impl Server {
    /// Listens at an address (port 0: a free one) and answers each call, given as text, on a thread of its own.
    ///
    /// # Errors
    /// The address or a thread cannot be had.
    pub(crate) fn start(
        name: &str,
        address: SocketAddr,
        handler: impl Fn(&str) -> Value + Send + Sync + 'static,
    ) -> io::Result<Self> {
        Acceptor::start(name, TcpListener::bind(address)?, LIMITS, move |stream| answer(stream, &handler)).map(Self)
    }

    /// Local address.
    pub(crate) fn address(&self) -> SocketAddr {
        self.0.address()
    }
}

fn answer(mut stream: TcpStream, handler: &dyn Fn(&str) -> Value) -> io::Result<()> {
    let body = http::read_body(&mut stream, Side::Request, Instant::now() + CALL_TIMEOUT)?;
    let text = String::from_utf8_lossy(&body);
    let xml = value::response(&handler(&text));
    let head = format!(
        "HTTP/1.1 200 OK\r\nServer: rviz_camera_stream\r\nContent-Type: text/xml\r\nConnection: close\r\nContent-Length: {}\r\n\r\n",
        xml.len()
    );
    http::write_all(&mut stream, format!("{head}{xml}").as_bytes(), Instant::now() + CALL_TIMEOUT)?;
    stream.shutdown(Shutdown::Write)
}

#[cfg(test)]
mod tests {
    use super::super::client::{call, post};
    use super::*;
    use std::io::Write;

    fn echo() -> Server {
        Server::start("echo", "127.0.0.1:0".parse().unwrap(), |text| {
            let (method, params) = value::parse_call(text).unwrap_or_default();
            let answer = vec![Value::Int(1), method.into(), Value::Array(params)];
            Value::Array(answer)
        })
        .unwrap()
    }

    #[test]
    fn a_call_is_answered_also_while_others_send_garbage_or_nothing() {
        let server = echo();
        let uri = format!("http://{}/", server.address());
        let silent: Vec<TcpStream> = (0..40).map(|_| TcpStream::connect(server.address()).unwrap()).collect();
        for garbage in [&b"POST / HTTP/1.1\r\nContent-Length: 4294967295\r\n\r\n"[..], b"\0\xff\0", b"GET"] {
            TcpStream::connect(server.address()).unwrap().write_all(garbage).unwrap();
        }
        let params = [Value::from("x"), Value::Int(3)];
        let answer = call(&uri, "m", &params, crate::socket::TEST_PATIENCE).unwrap();
        assert_eq!(answer, Value::Array(params.to_vec()));
        assert!(post(&uri, "no xml", crate::socket::TEST_PATIENCE).is_ok());
        drop(silent);
    }

    #[test]
    fn it_ends_at_once_although_somebody_is_connected() {
        let server = echo();
        let _silent = TcpStream::connect(server.address()).unwrap();
        let begin = Instant::now();
        drop(server);
        assert!(begin.elapsed() < CALL_TIMEOUT);
    }
}
