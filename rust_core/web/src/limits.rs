//! Limits of connections: their number and their times.

use std::time::Duration;

/// Limits of connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most connections at a time, pages included: half of them without the token, of which the oldest give way.
    pub connections: usize,
    /// Time for a request's headers.
    pub headers: Duration,
    /// Time for a request's body.
    pub body: Duration,
    /// Time for a connection that does not become a WebSocket.
    pub request: Duration,
    /// Time that a page may take for one message.
    pub send: Duration,
    /// Period of pings.
    pub ping: Duration,
    /// Longest silence of a page: it answers pings.
    pub silence: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 256,
            headers: Duration::from_secs(2),
            body: Duration::from_secs(10),
            request: Duration::from_secs(60),
            send: Duration::from_secs(15),
            ping: Duration::from_secs(10),
            silence: Duration::from_secs(30),
        }
    }
}
