//! The connection header: fields `name=value`, each after its length, all after theirs.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::socket::TimedRead;

/// Longest header. The definition of a message of many parts has some ten thousand bytes.
const MAX_BYTES: usize = 1 << 20;

/// A connection header.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Header(BTreeMap<String, String>);

fn invalid(text: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, text)
}

/// Fills `bytes` by the deadline.
pub(super) fn read_exact(stream: &mut impl TimedRead, bytes: &mut [u8], deadline: Instant) -> io::Result<()> {
    let mut filled = 0;
    while let Some(rest) = bytes.get_mut(filled..).filter(|rest| !rest.is_empty()) {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.limit_read_time(left.max(Duration::from_millis(1)))?;
        match stream.read(rest) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(len) => filled += len,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Err(io::ErrorKind::TimedOut.into()),
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

impl Header {
    /// A header of these fields.
    pub(crate) fn new<'a>(fields: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        Self(fields.into_iter().map(|(name, value)| (name.to_owned(), value.to_owned())).collect())
    }

    /// A field's value.
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    /// `true` if a field is `1`, such as `latching` or `tcp_nodelay`.
    pub(crate) fn is_on(&self, name: &str) -> bool {
        self.get(name) == Some("1")
    }

    /// Encodes the header.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut fields = Vec::new();
        for (name, value) in &self.0 {
            let len = name.len() + 1 + value.len();
            fields.extend_from_slice(&(len as u32).to_le_bytes());
            fields.extend_from_slice(name.as_bytes());
            fields.push(b'=');
            fields.extend_from_slice(value.as_bytes());
        }
        let mut bytes = (fields.len() as u32).to_le_bytes().to_vec();
        bytes.append(&mut fields);
        bytes
    }

    /// Parses the fields after a header's length.
    pub(crate) fn parse(mut bytes: &[u8]) -> io::Result<Self> {
        let mut fields = BTreeMap::new();
        while !bytes.is_empty() {
            let (len, rest) = bytes.split_first_chunk::<4>().ok_or_else(|| invalid("a header field without length"))?;
            let len = u32::from_le_bytes(*len) as usize;
            let field = rest.get(..len).ok_or_else(|| invalid("a header field longer than the header"))?;
            let equals =
                field.iter().position(|byte| *byte == b'=').ok_or_else(|| invalid("a header field without ="))?;
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            fields.insert(text(&field[..equals]), text(&field[equals + 1..]));
            bytes = &rest[len..];
        }
        Ok(Self(fields))
    }

    /// Reads a header from a connection.
    ///
    /// # Errors
    /// The connection's; `TimedOut` at the deadline, `InvalidData` for an invalid header.
    pub(crate) fn read(stream: &mut impl TimedRead, deadline: Instant) -> io::Result<Self> {
        let mut len = [0; 4];
        read_exact(stream, &mut len, deadline)?;
        let len = u32::from_le_bytes(len) as usize;
        if len > MAX_BYTES {
            return Err(invalid("a header of more than a megabyte"));
        }
        let mut fields = vec![0; len];
        read_exact(stream, &mut fields, deadline)?;
        Self::parse(&fields)
    }

    /// Writes a header within `timeout`.
    pub(crate) fn write(&self, stream: &mut TcpStream, timeout: Duration) -> io::Result<()> {
        stream.set_write_timeout(Some(timeout))?;
        stream.write_all(&self.to_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_was_written_reads_the_same(fields in prop::collection::btree_map("[a-z_0-9]{1,9}", "[ -~\\n=é]{0,30}", 0..8)) {
            let header = Header(fields);
            let bytes = header.to_bytes();
            prop_assert_eq!(Header::parse(&bytes[4..]).unwrap(), header);
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..60)) {
            let _ = Header::parse(&bytes);
        }
    }
}
