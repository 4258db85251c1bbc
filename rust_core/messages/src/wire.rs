//! ROS 1's serialisation: little endian, fields in order, a `u32` element count before strings and variable arrays.
//!
//! [`Reader`] walks a slice and checks every length against what is left of it. An element count is multiplied by the
//! least number of bytes that an element takes ([`Wire::MIN_LEN`]) before anything is allocated, so a hostile count
//! costs nothing.

use std::fmt::Write as _;

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
    /// The message was over before its bytes were.
    #[error("message too long: {0} bytes after its last field")]
    TrailingBytes(usize),
}

/// A position in the bytes of one message.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// Starts at the first of `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Offset of the next byte.
    pub fn position(&self) -> usize {
        self.at
    }

    /// How many bytes are left.
    pub fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// The next `len` bytes; `what` is named in the error.
    pub fn take(&mut self, len: usize, what: &'static str) -> Result<&'a [u8], DecodeError> {
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
    pub fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], DecodeError> {
        let error = self.too_short(what, N as u64);
        <[u8; N]>::try_from(self.take(N, what)?).map_err(|_| error)
    }

    /// An element count, checked against the bytes left for elements of at least `min_len` bytes each.
    pub fn count(&mut self, min_len: usize, what: &'static str) -> Result<usize, DecodeError> {
        let count = u32::from_le_bytes(self.array::<4>("array length")?);
        let needed = u64::from(count) * min_len.max(1) as u64;
        if needed > self.left() as u64 {
            return Err(self.too_short(what, needed));
        }
        Ok(count as usize)
    }

    /// Says that nothing may be left.
    pub fn finish(&self) -> Result<(), DecodeError> {
        match self.left() {
            0 => Ok(()),
            left => Err(DecodeError::TrailingBytes(left)),
        }
    }

    fn too_short(&self, what: &'static str, needed: u64) -> DecodeError {
        DecodeError::TooShort { what, at: self.at, needed, left: self.left() }
    }
}

/// A value with a place in ROS 1's serialisation: a primitive, a string, an array or a message.
pub trait Wire: Sized {
    /// The least number of bytes that a value takes.
    const MIN_LEN: usize;

    /// Reads one value.
    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError>;

    /// Appends the value.
    fn write(&self, out: &mut Vec<u8>);

    /// The type as a ROS message definition spells it, such as `float64[9]`.
    fn ros_type() -> String;

    /// Adds the messages that this type is made of to `found`, itself first, as pairs of type and field text.
    fn collect_definitions(_found: &mut Vec<(String, String)>) {}
}

macro_rules! primitive {
    ($($rust:ty: $ros:literal),* $(,)?) => {$(
        impl Wire for $rust {
            const MIN_LEN: usize = size_of::<$rust>();

            fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
                Ok(<$rust>::from_le_bytes(reader.array($ros)?))
            }

            fn write(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            fn ros_type() -> String {
                $ros.to_owned()
            }
        }
    )*};
}

primitive! {
    u8: "uint8", i8: "int8", u16: "uint16", i16: "int16", u32: "uint32", i32: "int32", u64: "uint64", i64: "int64",
    f32: "float32", f64: "float64",
}

impl Wire for bool {
    const MIN_LEN: usize = 1;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        Ok(reader.array::<1>("bool")? != [0])
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn ros_type() -> String {
        "bool".to_owned()
    }
}

/// ROS strings are bytes of no stated encoding; what is no UTF-8 becomes U+FFFD.
impl Wire for String {
    const MIN_LEN: usize = 4;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let len = reader.count(1, "string")?;
        Ok(Self::from_utf8_lossy(reader.take(len, "string")?).into_owned())
    }

    fn write(&self, out: &mut Vec<u8>) {
        write_count(self.len(), out);
        out.extend_from_slice(self.as_bytes());
    }

    fn ros_type() -> String {
        "string".to_owned()
    }
}

impl<T: Wire> Wire for Vec<T> {
    const MIN_LEN: usize = 4;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let count = reader.count(T::MIN_LEN, "array elements")?;
        let mut values = Self::with_capacity(count);
        for _ in 0..count {
            values.push(T::read(reader)?);
        }
        Ok(values)
    }

    fn write(&self, out: &mut Vec<u8>) {
        write_count(self.len(), out);
        out.reserve(self.len().saturating_mul(T::MIN_LEN));
        for value in self {
            value.write(out);
        }
    }

    fn ros_type() -> String {
        format!("{}[]", T::ros_type())
    }

    fn collect_definitions(found: &mut Vec<(String, String)>) {
        T::collect_definitions(found);
    }
}

impl<T: Wire + Copy + Default, const N: usize> Wire for [T; N] {
    const MIN_LEN: usize = N * T::MIN_LEN;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = T::read(reader)?;
        }
        Ok(values)
    }

    fn write(&self, out: &mut Vec<u8>) {
        for value in self {
            value.write(out);
        }
    }

    fn ros_type() -> String {
        let mut name = T::ros_type();
        // Writing to a String cannot fail.
        let _ = write!(name, "[{N}]");
        name
    }

    fn collect_definitions(found: &mut Vec<(String, String)>) {
        T::collect_definitions(found);
    }
}

/// Appends an element count. ROS counts with 32 bits; no message of this project comes near that.
pub(crate) fn write_count(count: usize, out: &mut Vec<u8>) {
    out.extend_from_slice(&u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_giant_count_is_an_error_before_anything_is_allocated() {
        let bytes = [0xff, 0xff, 0xff, 0xff, 1, 2, 3];
        let error = Vec::<f64>::read(&mut Reader::new(&bytes)).unwrap_err();
        assert_eq!(
            error,
            DecodeError::TooShort { what: "array elements", at: 4, needed: u64::from(u32::MAX) * 8, left: 3 }
        );
    }

    #[test]
    fn a_string_longer_than_the_message_is_an_error() {
        let bytes = [5, 0, 0, 0, b'a', b'b'];
        assert!(String::read(&mut Reader::new(&bytes)).is_err());
    }

    #[test]
    fn a_string_of_other_bytes_than_utf8_is_kept_readable() {
        let bytes = [3, 0, 0, 0, b'a', 0xe9, b'b'];
        assert_eq!(String::read(&mut Reader::new(&bytes)).unwrap(), "a\u{fffd}b");
    }

    #[test]
    fn type_names_are_those_of_message_definitions() {
        assert_eq!(<[f64; 9]>::ros_type(), "float64[9]");
        assert_eq!(Vec::<String>::ros_type(), "string[]");
    }
}
