//! What bytes are read from by a deadline: a socket, or bytes in memory where a reader is tested by itself.

use std::io::{self, Read};
use std::net::TcpStream;
use std::time::Duration;

/// A reader whose reads can be limited in time.
pub(crate) trait TimedRead: Read {
    /// No read takes longer from now on; one that would ends with `WouldBlock`.
    fn limit_read_time(&mut self, timeout: Duration) -> io::Result<()>;
}

impl TimedRead for TcpStream {
    fn limit_read_time(&mut self, timeout: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(timeout))
    }
}
