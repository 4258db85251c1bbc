//! Reading and writing an HTTP message within limits of size and time.

use std::io::{self, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::socket::TimedRead;

/// Longest head.
const MAX_HEAD_BYTES: usize = 16 * 1024;
/// Longest body of a call.
const MAX_REQUEST_BYTES: usize = 16 * 1024 * 1024;
/// Longest body of an answer, enough for a robot description of 64 MB.
const MAX_RESPONSE_BYTES: usize = 128 * 1024 * 1024;
const MAX_HEADERS: usize = 64;

/// Kind of message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Request,
    Response,
}

impl Side {
    fn max_body_bytes(self) -> usize {
        match self {
            Self::Request => MAX_REQUEST_BYTES,
            Self::Response => MAX_RESPONSE_BYTES,
        }
    }
}

/// A parsed head.
struct Head {
    len: usize,
    /// `None` if the message ends with the connection.
    body_bytes: Option<usize>,
    is_chunked: bool,
    expects_continue: bool,
}

fn bad(text: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, text.into())
}

/// Reads available bytes by the deadline.
fn read_some(stream: &mut impl TimedRead, bytes: &mut Vec<u8>, deadline: Instant) -> io::Result<usize> {
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() {
        return Err(io::ErrorKind::TimedOut.into());
    }
    stream.limit_read_time(left.max(Duration::from_millis(1)))?;
    let mut piece = [0; 16 * 1024];
    let len = loop {
        match stream.read(&mut piece) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Err(io::ErrorKind::TimedOut.into()),
            other => break other?,
        }
    };
    bytes.extend_from_slice(piece.get(..len).unwrap_or_default());
    Ok(len)
}

/// Parses the head; `None` while it is incomplete.
fn head(bytes: &[u8], side: Side) -> io::Result<Option<Head>> {
    let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let (status, headers, code) = match side {
        Side::Request => {
            let mut request = httparse::Request::new(&mut headers);
            let status = request.parse(bytes).map_err(|error| bad(format!("not HTTP: {error}")))?;
            (status, &*request.headers, None)
        }
        Side::Response => {
            let mut response = httparse::Response::new(&mut headers);
            let status = response.parse(bytes).map_err(|error| bad(format!("not HTTP: {error}")))?;
            (status, &*response.headers, response.code)
        }
    };
    let httparse::Status::Complete(len) = status else {
        return if bytes.len() > MAX_HEAD_BYTES { Err(bad("the HTTP head is too long")) } else { Ok(None) };
    };
    if let Some(code) = code.filter(|code| *code != 200) {
        return Err(bad(format!("HTTP status {code}")));
    }
    let named = |name: &str| {
        let header = headers.iter().find(|header| header.name.eq_ignore_ascii_case(name));
        header.map(|header| String::from_utf8_lossy(header.value).trim().to_ascii_lowercase())
    };
    let body_bytes = match named("content-length") {
        Some(text) => Some(text.parse().map_err(|_| bad("Content-Length is no number"))?),
        None => None,
    };
    if body_bytes.is_some_and(|len| len > side.max_body_bytes()) {
        return Err(bad("the HTTP body is too long"));
    }
    Ok(Some(Head {
        len,
        body_bytes,
        is_chunked: named("transfer-encoding").is_some_and(|coding| coding == "chunked"),
        expects_continue: named("expect").is_some_and(|expected| expected == "100-continue"),
    }))
}

/// The received part of a chunked body. Each chunk is read once, however many pieces it comes in.
#[derive(Default)]
struct Chunks {
    body: Vec<u8>,
    /// Offset of the next chunk in the received bytes.
    next: usize,
}

impl Chunks {
    /// Reads the complete chunks in `bytes`, all received bytes. Returns `true` after the last chunk.
    fn read(&mut self, bytes: &[u8], max_bytes: usize) -> io::Result<bool> {
        loop {
            let rest = bytes.get(self.next..).unwrap_or_default();
            let (at, size) = match httparse::parse_chunk_size(rest) {
                Ok(httparse::Status::Complete((at, size))) => (at, usize::try_from(size).unwrap_or(usize::MAX)),
                Ok(httparse::Status::Partial) => return Ok(false),
                Err(_) => return Err(bad("a chunk of no valid size")),
            };
            if size == 0 {
                return Ok(true);
            }
            if self.body.len().saturating_add(size) > max_bytes {
                return Err(bad("the HTTP body is too long"));
            }
            let end = at + size + b"\r\n".len();
            let (Some(chunk), true) = (rest.get(at..at + size), end <= rest.len()) else { return Ok(false) };
            self.body.extend_from_slice(chunk);
            self.next += end;
        }
    }
}

/// Reads a message's body.
///
/// # Errors
/// The connection's; `TimedOut` at the deadline, `UnexpectedEof` for an early end, `InvalidData` for an invalid message
/// or a status other than 200.
pub(crate) fn read_body(stream: &mut (impl TimedRead + Write), side: Side, deadline: Instant) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let head = loop {
        if read_some(stream, &mut bytes, deadline)? == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        if let Some(head) = head(&bytes, side)? {
            break head;
        }
    };
    if head.expects_continue {
        stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n")?;
    }
    let mut body = bytes.split_off(head.len);
    if head.is_chunked {
        let mut chunks = Chunks::default();
        loop {
            if chunks.read(&body, side.max_body_bytes())? {
                return Ok(chunks.body);
            }
            if read_some(stream, &mut body, deadline)? == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            if body.len() > 2 * side.max_body_bytes() {
                return Err(bad("the HTTP body is too long"));
            }
        }
    }
    match head.body_bytes {
        Some(len) => {
            while body.len() < len {
                if read_some(stream, &mut body, deadline)? == 0 {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
            }
            body.truncate(len);
        }
        None if side == Side::Request => return Err(bad("a request without Content-Length")),
        None => {
            while read_some(stream, &mut body, deadline)? > 0 {
                if body.len() > side.max_body_bytes() {
                    return Err(bad("the HTTP body is too long"));
                }
            }
        }
    }
    Ok(body)
}

/// Writes a message by the deadline.
pub(super) fn write_all(stream: &mut TcpStream, bytes: &[u8], deadline: Instant) -> io::Result<()> {
    let mut rest = bytes;
    while !rest.is_empty() {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.set_write_timeout(Some(left.max(Duration::from_millis(1))))?;
        match stream.write(rest) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(len) => rest = rest.get(len..).unwrap_or_default(),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Err(io::ErrorKind::TimedOut.into()),
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fuzzing::Pieces;

    /// It exceeded its deadline when all chunks so far were read again after each piece.
    #[test]
    fn a_body_of_many_chunks_in_many_pieces_is_read_once() {
        let message =
            [b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n".to_vec(), b"8\r\n01234567\r\n".repeat(500_000)];
        let bytes = [message.concat().as_slice(), b"0\r\n\r\n"].concat();
        let mut pieces = Pieces { bytes: &bytes, piece_bytes: 1000 };
        let body = read_body(&mut pieces, Side::Response, Instant::now() + Duration::from_secs(10)).unwrap();
        assert_eq!(body.len(), 4_000_000);
    }
}
