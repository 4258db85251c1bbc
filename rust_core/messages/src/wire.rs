//! ROS 1's serialisation: little endian, fields in order, a `u32` element count before strings and variable arrays.
//!
//! [`WireReader`] checks every length against the bytes left. An element count is multiplied by the least length of an
//! element before anything is allocated, so a hostile count costs nothing.

use crate::std_msgs::Header;
use rosrust::{RosMsg, Time};
use std::io;

/// Bytes are not a valid message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// A value or an array reaches past the end.
    #[error("message too short: {needed} bytes of {what} at byte {at}, {left} left")]
    TooShort {
        /// The ROS type of the value.
        what: &'static str,
        /// Offset of the value in the message.
        at: usize,
        /// Least length of the value, bytes.
        needed: u64,
        /// Bytes left.
        left: usize,
    },
    /// Bytes follow the last field.
    #[error("message too long: {0} bytes after its last field")]
    TrailingBytes(usize),
    /// A generated type's decoding has reached the end.
    #[error("message too short: it ends before its last field")]
    EndsEarly,
}

impl From<DecodeError> for io::Error {
    fn from(error: DecodeError) -> Self {
        Self::new(io::ErrorKind::InvalidData, error)
    }
}

/// A position in the bytes of one message.
#[derive(Clone, Debug)]
pub(crate) struct WireReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> WireReader<'a> {
    /// Starts at the first byte.
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Offset of the next byte.
    pub(crate) fn position(&self) -> usize {
        self.at
    }

    /// Number of bytes left.
    pub(crate) fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// The next `len` bytes; `what` is named in the error.
    pub(crate) fn take(&mut self, len: usize, what: &'static str) -> Result<&'a [u8], DecodeError> {
        let end = self.at.checked_add(len);
        match end.and_then(|end| self.bytes.get(self.at..end)) {
            Some(bytes) => {
                self.at += len;
                Ok(bytes)
            }
            None => Err(self.too_short(what, len as u64)),
        }
    }

    /// The next `N` bytes as an array.
    pub(crate) fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], DecodeError> {
        let error = self.too_short(what, N as u64);
        <[u8; N]>::try_from(self.take(N, what)?).map_err(|_| error)
    }

    /// An element count, checked against the bytes left for elements of at least `min_len` bytes each.
    pub(crate) fn count(&mut self, min_len: usize, what: &'static str) -> Result<usize, DecodeError> {
        let count = u32::from_le_bytes(self.array::<4>("array length")?);
        let needed = u64::from(count) * min_len.max(1) as u64;
        if needed > self.left() as u64 {
            return Err(self.too_short(what, needed));
        }
        Ok(count as usize)
    }

    /// Fails if bytes are left over.
    pub(crate) fn finish(&self) -> Result<(), DecodeError> {
        match self.left() {
            0 => Ok(()),
            left => Err(DecodeError::TrailingBytes(left)),
        }
    }

    fn too_short(&self, what: &'static str, needed: u64) -> DecodeError {
        DecodeError::TooShort { what, at: self.at, needed, left: self.left() }
    }
}

impl WireReader<'_> {
    pub(crate) fn u8(&mut self, what: &'static str) -> Result<u8, DecodeError> {
        let [byte] = self.array::<1>(what)?;
        Ok(byte)
    }

    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, DecodeError> {
        Ok(u32::from_le_bytes(self.array(what)?))
    }

    /// A string, in which bytes that are not UTF-8 become U+FFFD.
    pub(crate) fn string(&mut self, what: &'static str) -> Result<String, DecodeError> {
        let len = self.count(1, what)?;
        Ok(String::from_utf8_lossy(self.take(len, what)?).into_owned())
    }

    pub(crate) fn header(&mut self) -> Result<Header, DecodeError> {
        Ok(Header {
            seq: self.u32("header.seq")?,
            stamp: Time { sec: self.u32("header.stamp")?, nsec: self.u32("header.stamp")? },
            frame_id: self.string("header.frame_id")?,
        })
    }
}

/// Decodes a whole message.
///
/// # Errors
/// The message's, or [`DecodeError::TrailingBytes`].
pub fn decode<T: RosMsg>(bytes: &[u8]) -> io::Result<T> {
    let mut rest = bytes;
    let value = T::decode(&mut rest).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => DecodeError::EndsEarly.into(),
        _ => error,
    })?;
    match rest.len() {
        0 => Ok(value),
        left => Err(DecodeError::TrailingBytes(left).into()),
    }
}

/// Encodes a message, without the length that TCPROS puts before it.
pub fn encode<T: RosMsg>(message: &T) -> Vec<u8> {
    let mut out = Vec::new();
    // Writing to a vector cannot fail.
    let _ = message.encode(&mut out);
    out
}

pub(crate) fn write_u32(value: u32, out: &mut Vec<u8>) {
    out.extend_from_slice(&value.to_le_bytes());
}

/// Appends an element count of 32 bits, which no message of this project comes near.
pub(crate) fn write_count(count: usize, out: &mut Vec<u8>) {
    write_u32(u32::try_from(count).unwrap_or(u32::MAX), out);
}

pub(crate) fn write_string(text: &str, out: &mut Vec<u8>) {
    write_count(text.len(), out);
    out.extend_from_slice(text.as_bytes());
}

pub(crate) fn write_header(header: &Header, out: &mut Vec<u8>) {
    write_u32(header.seq, out);
    write_u32(header.stamp.sec, out);
    write_u32(header.stamp.nsec, out);
    write_string(&header.frame_id, out);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_giant_count_is_an_error_before_anything_is_allocated() {
        let bytes = [0xff, 0xff, 0xff, 0xff, 1, 2, 3];
        let error = WireReader::new(&bytes).count(8, "D").unwrap_err();
        assert_eq!(error, DecodeError::TooShort { what: "D", at: 4, needed: u64::from(u32::MAX) * 8, left: 3 });
    }

    #[test]
    fn a_generated_type_with_a_byte_less_or_more_is_an_error() {
        for (len, text) in [(7, "message too short"), (9, "message too long: 1 bytes")] {
            let error = decode::<crate::rosgraph_msgs::Clock>(&vec![0; len]).unwrap_err();
            assert!(error.to_string().starts_with(text), "{error}");
        }
    }

    #[test]
    fn a_string_longer_than_the_message_is_an_error() {
        let bytes = [5, 0, 0, 0, b'a', b'b'];
        assert!(WireReader::new(&bytes).string("name").is_err());
    }

    #[test]
    fn a_string_of_other_bytes_than_utf8_is_kept_readable() {
        let bytes = [3, 0, 0, 0, b'a', 0xe9, b'b'];
        assert_eq!(WireReader::new(&bytes).string("name").unwrap(), "a\u{fffd}b");
    }
}
