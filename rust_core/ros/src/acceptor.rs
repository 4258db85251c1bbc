//! A listening socket with a thread for each connection, up to a limit.

use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rcs_process::join_within;
use rustix::event::{poll, PollFd, PollFlags};

use crate::socket::IDLE_TIMEOUT;

/// Pause after an error of `accept`, such as one without a free descriptor.
const ERROR_PAUSE: Duration = Duration::from_millis(20);

/// Time for the accepting thread to end, which is never reached.
const END_PATIENCE: Duration = Duration::from_secs(2);

/// Shortest time between two warnings.
const WARNING_PERIOD: Duration = Duration::from_secs(60);

/// Limits of a socket's connections.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Number of connections; further ones are closed.
    pub(crate) connections: usize,
    /// Stack of each connection's thread.
    pub(crate) stack_bytes: usize,
}

/// Accepts connections until it is dropped.
pub(crate) struct Acceptor {
    address: SocketAddr,
    listener: Arc<TcpListener>,
    is_ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Acceptor {
    /// Calls `serve` with each connection, on a thread of its own. Names of the threads begin with `name`.
    ///
    /// # Errors
    /// No thread can be started.
    pub(crate) fn start(
        name: &str,
        listener: TcpListener,
        limits: Limits,
        serve: impl Fn(TcpStream) -> io::Result<()> + Send + Sync + 'static,
    ) -> io::Result<Self> {
        // A caller may have left before `accept`, which must not wait for the next one then.
        listener.set_nonblocking(true)?;
        let (address, listener) = (listener.local_addr()?, Arc::new(listener));
        let is_ended = Arc::new(AtomicBool::new(false));
        let (accepting, end, serve) = (Arc::clone(&listener), Arc::clone(&is_ended), Arc::new(serve));
        let connection_name = format!("{name}-conn");
        let run = move || accept(&accepting, &end, &connection_name, limits, &serve);
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(run)?;
        Ok(Self { address, listener, is_ended, thread: Some(thread) })
    }

    /// Local address.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Accepts no more connections; present ones continue.
    pub(crate) fn end(&mut self) {
        self.is_ended.store(true, Ordering::Release);
        // Wakes the thread. Fails only if the socket has ended.
        let _ = rustix::net::shutdown(&*self.listener, rustix::net::Shutdown::Both);
        if let Some(thread) = self.thread.take() {
            // A panic there was reported by its own thread.
            if join_within(thread, END_PATIENCE).is_none() {
                log::warn!("connections are still accepted at {} after {END_PATIENCE:?}", self.address);
            }
        }
    }
}

impl Drop for Acceptor {
    fn drop(&mut self) {
        self.end();
    }
}

/// Counts a connection or a thread while it lives.
pub(crate) struct Counted(Arc<AtomicUsize>);

impl Counted {
    /// Counts on, unless there are `most` already.
    pub(crate) fn new(count: &Arc<AtomicUsize>, most: usize) -> Option<Self> {
        let is_within = count.fetch_add(1, Ordering::AcqRel) < most;
        let counted = Self(Arc::clone(count));
        is_within.then_some(counted)
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Throttle of the warnings.
#[derive(Default)]
struct Warned(Option<Instant>);

impl Warned {
    /// `true` if a warning is to be logged now.
    fn is_due(&mut self, now: Instant) -> bool {
        let is_due = self.0.is_none_or(|last| now.duration_since(last) >= WARNING_PERIOD);
        if is_due {
            self.0 = Some(now);
        }
        is_due
    }
}

#[expect(clippy::disallowed_methods, reason = "the socket is non-blocking: `poll` has waited")]
fn accept<S>(listener: &TcpListener, is_ended: &AtomicBool, name: &str, limits: Limits, serve: &Arc<S>)
where
    S: Fn(TcpStream) -> io::Result<()> + Send + Sync + 'static,
{
    let open = Arc::new(AtomicUsize::new(0));
    let mut warned = Warned::default();
    loop {
        let waited = poll(&mut [PollFd::new(listener, PollFlags::IN)], Some(&IDLE_TIMEOUT));
        let accepted = waited.map_err(io::Error::from).and_then(|_| listener.accept());
        if is_ended.load(Ordering::Acquire) {
            return;
        }
        let stream = match accepted {
            Ok((stream, _)) => stream,
            // The caller has left.
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => continue,
            Err(error) => {
                if warned.is_due(Instant::now()) {
                    log::warn!("{name}: connections cannot be accepted at present: {error}");
                }
                std::thread::sleep(ERROR_PAUSE);
                continue;
            }
        };
        let Some(counted) = Counted::new(&open, limits.connections) else {
            if warned.is_due(Instant::now()) {
                log::warn!("{name}: more than {} connections at a time, further ones are closed", limits.connections);
            }
            continue;
        };
        let (serve, own_name) = (Arc::clone(serve), name.to_owned());
        let serving = move || {
            let _counted = counted;
            if let Err(error) = serve(stream) {
                log::debug!("{own_name}: a connection ended: {error}");
            }
        };
        let builder = std::thread::Builder::new().name(name.to_owned()).stack_size(limits.stack_bytes);
        if let Err(error) = builder.spawn(serving) {
            if warned.is_due(Instant::now()) {
                log::warn!("{name}: a connection cannot be served: {error}");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn that_connections_cannot_be_served_is_logged_once_a_minute() {
        let (mut warned, begin) = (Warned::default(), Instant::now());
        let times = [0, 1, 59, 60, 61, 119, 120].map(|seconds| begin + Duration::from_secs(seconds));
        assert_eq!(times.map(|now| warned.is_due(now)), [true, false, false, true, false, false, true]);
    }
}
