//! The parsers of foreign bytes without a connection, for the fuzz targets in `tests/fuzz`. Each encodes again
//! what it has parsed, so that the targets can check that this is parsed as the same.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use crate::socket::TimedRead;
use crate::tcpros::header::Header;
use crate::xmlrpc::http::{self, Side};
use crate::xmlrpc::value;

/// Bytes that come in pieces, as from a socket.
pub(crate) struct Pieces<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) piece_bytes: usize,
}

impl Read for Pieces<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let len = self.bytes.len().min(self.piece_bytes).min(out.len());
        let (piece, rest) = self.bytes.split_at(len);
        if let Some(out) = out.get_mut(..len) {
            out.copy_from_slice(piece);
        }
        self.bytes = rest;
        Ok(len)
    }
}

impl Write for Pieces<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl TimedRead for Pieces<'_> {
    fn limit_read_time(&mut self, _: Duration) -> io::Result<()> {
        Ok(())
    }
}

fn soon() -> Instant {
    Instant::now() + Duration::from_secs(60)
}

/// Parses a connection header with the length before it.
pub fn tcpros_header(bytes: &[u8]) -> Option<Vec<u8>> {
    let header = Header::read(&mut Pieces { bytes, piece_bytes: usize::MAX }, soon()).ok()?;
    Some(header.to_bytes())
}

/// Reads the HTTP message of a call (else of an answer) in pieces and returns its body.
pub fn http_body(bytes: &[u8], piece_bytes: usize, is_call: bool) -> Option<Vec<u8>> {
    let side = if is_call { Side::Request } else { Side::Response };
    http::read_body(&mut Pieces { bytes, piece_bytes: piece_bytes.max(1) }, side, soon()).ok()
}

/// Parses an XML-RPC call.
pub fn xmlrpc_call(text: &str) -> Option<String> {
    let (method, params) = value::parse_call(text).ok()?;
    Some(value::request(&method, &params))
}

/// Parses the answer of an XML-RPC call.
pub fn xmlrpc_answer(text: &str) -> Option<String> {
    Some(value::response(&value::parse_response(text).ok()?))
}
