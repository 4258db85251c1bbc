//! Deadlines and keep-alive of connections.

use std::io::{self, Read};
use std::net::TcpStream;
use std::time::Duration;

use rustix::event::Timespec;
use rustix::net::sockopt;

/// [`rcs_process::IDLE_PERIOD`], for `poll`.
pub(crate) const IDLE_TIMEOUT: Timespec = Timespec { tv_sec: rcs_process::IDLE_PERIOD.as_secs() as i64, tv_nsec: 0 };

/// A silent peer is probed after a minute and given up after three.
const KEEP_ALIVE_IDLE: Duration = Duration::from_secs(60);
const KEEP_ALIVE_PERIOD: Duration = Duration::from_secs(20);
const KEEP_ALIVE_PROBES: u32 = 6;

/// Timeout of waits in tests: ten times what a slow machine needs.
#[cfg(test)]
pub(crate) const TEST_PATIENCE: Duration = Duration::from_secs(60);

/// A reader whose reads can be limited in time: a socket, or bytes in memory in a test.
pub(crate) trait TimedRead: Read {
    /// Limits each read from now on; one that takes longer ends with `WouldBlock`.
    fn limit_read_time(&mut self, timeout: Duration) -> io::Result<()>;
}

impl TimedRead for TcpStream {
    fn limit_read_time(&mut self, timeout: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(timeout))
    }
}

/// Has the system probe a silent peer, and end the connection where it does not answer.
pub(crate) fn keep_alive(stream: &TcpStream) -> io::Result<()> {
    sockopt::set_socket_keepalive(stream, true)?;
    sockopt::set_tcp_keepidle(stream, KEEP_ALIVE_IDLE)?;
    sockopt::set_tcp_keepintvl(stream, KEEP_ALIVE_PERIOD)?;
    sockopt::set_tcp_keepcnt(stream, KEEP_ALIVE_PROBES)?;
    Ok(())
}
