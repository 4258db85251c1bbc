//! A server of XML-RPC calls: one listening socket, a bounded number of connections, each with a deadline.

use std::io;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::http::{self, Side};
use super::value::{self, Value};

/// How long a caller may take for a whole call.
const CALL_TIMEOUT: Duration = Duration::from_secs(5);
/// Callers beyond these are turned away.
const MAX_CONNECTIONS: usize = 64;
const STACK_BYTES: usize = 512 * 1024;

/// What a handler makes of a call.
pub(crate) enum Answer {
    /// The value to answer with.
    Value(Value),
    /// A whole answer as XML, as another server gave it.
    Xml(String),
}

/// Answers calls until it is dropped.
pub(crate) struct Server {
    address: SocketAddr,
    listener: Arc<TcpListener>,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens at an address (port 0: a free one) and answers each call, given as text, on a thread of its own.
    ///
    /// # Errors
    /// The system's, where the address cannot be had or there is no thread left.
    pub(crate) fn start(
        name: &str,
        address: SocketAddr,
        handler: impl Fn(&str) -> Answer + Send + Sync + 'static,
    ) -> io::Result<Self> {
        Self::serve(name, TcpListener::bind(address)?, handler)
    }

    /// As [`start`](Self::start), on a port that is open already.
    ///
    /// # Errors
    /// The system's, where there is no thread left.
    pub(crate) fn serve(
        name: &str,
        listener: TcpListener,
        handler: impl Fn(&str) -> Answer + Send + Sync + 'static,
    ) -> io::Result<Self> {
        let (address, listener) = (listener.local_addr()?, Arc::new(listener));
        let ended = Arc::new(AtomicBool::new(false));
        let (end, handler, thread_name) = (Arc::clone(&ended), Arc::new(handler), format!("{name}-call"));
        let accepted = Arc::clone(&listener);
        let accepting = move || accept(&accepted, &end, &thread_name, &handler);
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(accepting)?;
        Ok(Self { address, listener, ended, thread: Some(thread) })
    }

    /// Where it listens.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        end(&self.listener);
        if let Some(thread) = self.thread.take() {
            // A panic there was reported by its own thread.
            let _ = thread.join();
        }
    }
}

/// Ends a listening socket, so that the thread which waits in `accept` goes on and looks at its flag.
pub(crate) fn end(listener: &TcpListener) {
    // Fails only where it has ended.
    let _ = rustix::net::shutdown(listener, rustix::net::Shutdown::Both);
}

/// Counts a connection for as long as it lives.
struct Counted(Arc<AtomicUsize>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

fn accept<H>(listener: &TcpListener, ended: &AtomicBool, name: &str, handler: &Arc<H>)
where
    H: Fn(&str) -> Answer + Send + Sync + 'static,
{
    let open = Arc::new(AtomicUsize::new(0));
    loop {
        let accepted = listener.accept();
        if ended.load(Ordering::Acquire) {
            return;
        }
        let stream = match accepted {
            Ok((stream, _)) => stream,
            Err(error) => {
                log::debug!("{name}: {error}");
                // No descriptor is left, say; others may be closed soon.
                std::thread::sleep(Duration::from_millis(20));
                continue;
            }
        };
        if open.fetch_add(1, Ordering::AcqRel) >= MAX_CONNECTIONS {
            open.fetch_sub(1, Ordering::AcqRel);
            continue;
        }
        let (counted, handler) = (Counted(Arc::clone(&open)), Arc::clone(handler));
        let answering = move || {
            let _counted = counted;
            if let Err(error) = answer(stream, &*handler) {
                log::debug!("a call was not answered: {error}");
            }
        };
        let spawned = std::thread::Builder::new().name(name.to_owned()).stack_size(STACK_BYTES).spawn(answering);
        if let Err(error) = spawned {
            log::debug!("{name}: {error}");
        }
    }
}

fn answer(mut stream: TcpStream, handler: &dyn Fn(&str) -> Answer) -> io::Result<()> {
    let body = http::read_body(&mut stream, Side::Request, Instant::now() + CALL_TIMEOUT)?;
    let text = String::from_utf8_lossy(&body);
    let xml = match handler(&text) {
        Answer::Value(value) => value::response(&value),
        Answer::Xml(xml) => xml,
    };
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
            Answer::Value(Value::Array(answer))
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
        let answer = call(&uri, "m", &params, Duration::from_secs(2)).unwrap();
        assert_eq!(answer, Value::Array(params.to_vec()));
        assert!(post(&uri, "no xml", Duration::from_secs(2)).is_ok());
        drop(silent);
    }

    #[test]
    fn it_ends_at_once_although_somebody_is_connected() {
        let server = echo();
        let _silent = TcpStream::connect(server.address()).unwrap();
        let begin = Instant::now();
        drop(server);
        assert!(begin.elapsed() < Duration::from_secs(1));
    }
}
