//! ROS 1's serialisation: little endian, fields in order, a `u32` element count before strings and variable arrays.
//!
//! [`Reader`] walks a slice and checks every length against what is left of it. An element count is multiplied by the
//! least number of bytes that an element takes before anything is allocated, so a hostile count costs nothing.

use crate::std_msgs::Header;
use rosrust::{RosMsg, Time};
use std::io;

/// What is wrong with the bytes of a message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// A value, or the elements that a count announces, would lie past the end.
    #[error("message too short: {needed} bytes of {what} at byte {at}, {left} left")]
    TooShort {
        /// The ROS type of the value.
        what: &'static str,
        /// Offset of the value in the message.
        at: usize,
        /// How many bytes it takes at least.
        needed: u64,
        /// How many bytes there are.
        left: usize,
    },
    /// Bytes follow the message's last field.
    #[error("message too long: {0} bytes after its last field")]
    TrailingBytes(usize),
}

impl From<DecodeError> for io::Error {
    fn from(error: DecodeError) -> Self {
        Self::new(io::ErrorKind::InvalidData, error)
    }
}

/// A position in the bytes of one message.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// Starts at the first of `bytes`.
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Offset of the next byte.
    pub(crate) fn position(&self) -> usize {
        self.at
    }

    /// How many bytes are left.
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

/// How many bytes TCPROS puts before a message for its length.
pub(crate) const LENGTH_PREFIX: usize = 4;

impl Reader<'_> {
    pub(crate) fn u8(&mut self, what: &'static str) -> Result<u8, DecodeError> {
        let [byte] = self.array::<1>(what)?;
        Ok(byte)
    }

    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, DecodeError> {
        Ok(u32::from_le_bytes(self.array(what)?))
    }

    /// ROS strings are bytes of no stated encoding; what is no UTF-8 becomes U+FFFD.
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

/// Reads a whole message; bytes left over are an error.
pub fn decode<T: RosMsg>(bytes: &[u8]) -> io::Result<T> {
    let mut rest = bytes;
    let value = T::decode(&mut rest)?;
    match rest.len() {
        0 => Ok(value),
        left => Err(DecodeError::TrailingBytes(left).into()),
    }
}

/// The bytes of a message, without the length that TCPROS puts before them.
pub fn encode<T: RosMsg>(message: &T) -> Vec<u8> {
    let mut out = Vec::new();
    // Writing to a vector cannot fail.
    let _ = message.encode(&mut out);
    out
}

/// A message of about `len` bytes with its length before it.
pub(crate) fn framed(len: usize, write: impl FnOnce(&mut Vec<u8>)) -> io::Result<Vec<u8>> {
    let mut out = Vec::with_capacity(LENGTH_PREFIX + len);
    out.extend_from_slice(&[0; LENGTH_PREFIX]);
    write(&mut out);
    let len = u32::try_from(out.len() - LENGTH_PREFIX).map_err(|_| io::ErrorKind::InvalidInput)?;
    if let Some(prefix) = out.first_chunk_mut() {
        *prefix = len.to_le_bytes();
    }
    Ok(out)
}

pub(crate) fn write_u32(value: u32, out: &mut Vec<u8>) {
    out.extend_from_slice(&value.to_le_bytes());
}

/// Appends an element count. ROS counts with 32 bits; no message of this project comes near that.
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
        let error = Reader::new(&bytes).count(8, "D").unwrap_err();
        assert_eq!(error, DecodeError::TooShort { what: "D", at: 4, needed: u64::from(u32::MAX) * 8, left: 3 });
    }

    #[test]
    fn a_string_longer_than_the_message_is_an_error() {
        let bytes = [5, 0, 0, 0, b'a', b'b'];
        assert!(Reader::new(&bytes).string("name").is_err());
    }

    #[test]
    fn a_string_of_other_bytes_than_utf8_is_kept_readable() {
        let bytes = [3, 0, 0, 0, b'a', 0xe9, b'b'];
        assert_eq!(Reader::new(&bytes).string("name").unwrap(), "a\u{fffd}b");
    }
}
