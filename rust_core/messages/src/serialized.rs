//! A message that is not decoded yet. Its header stays as it is when it is published.

use crate::bytes::copy_of;
use crate::wire::LENGTH_PREFIX;
use rosrust::{Message, RosMsg};
use std::fmt;
use std::io;
use std::marker::PhantomData;

/// Bytes of a message of type `T`, without the length that TCPROS puts before them.
///
/// ```
/// use rcs_messages::{rosgraph_msgs::Clock, Message, Serialized, Time};
///
/// let clock = Clock { clock: Time { sec: 3, nsec: 4 } };
/// let serialized = Serialized::<Clock>::new(rcs_messages::encode(&clock));
/// assert_eq!(Serialized::<Clock>::msg_type(), "rosgraph_msgs/Clock");
/// assert_eq!(rcs_messages::decode::<Clock>(&serialized.bytes)?, clock);
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct Serialized<T> {
    /// The message.
    pub bytes: Vec<u8>,
    kind: PhantomData<fn() -> T>,
}

impl<T> Serialized<T> {
    /// Wraps the bytes of a message of type `T`.
    pub fn new(bytes: Vec<u8>) -> Self {
        Self { bytes, kind: PhantomData }
    }
}

impl<T> Clone for Serialized<T> {
    fn clone(&self) -> Self {
        Self::new(self.bytes.clone())
    }
}

impl<T> fmt::Debug for Serialized<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Serialized({} bytes)", self.bytes.len())
    }
}

impl<T> Default for Serialized<T> {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl<T> PartialEq for Serialized<T> {
    fn eq(&self, other: &Self) -> bool {
        self.bytes == other.bytes
    }
}

impl<T: Message> Message for Serialized<T> {
    fn msg_definition() -> String {
        T::msg_definition()
    }

    fn md5sum() -> String {
        T::md5sum()
    }

    fn msg_type() -> String {
        T::msg_type()
    }
}

impl<T> RosMsg for Serialized<T> {
    fn encode<W: io::Write>(&self, mut w: W) -> io::Result<()> {
        w.write_all(&self.bytes)
    }

    fn decode<R: io::Read>(mut r: R) -> io::Result<Self> {
        let mut bytes = Vec::new();
        r.read_to_end(&mut bytes)?;
        Ok(Self::new(bytes))
    }

    fn encode_vec(&self) -> io::Result<Vec<u8>> {
        crate::wire::framed(self.bytes.len(), |out| out.extend_from_slice(&self.bytes))
    }

    fn decode_slice(bytes: &[u8]) -> io::Result<Self> {
        let message = bytes.get(LENGTH_PREFIX..).ok_or(io::ErrorKind::UnexpectedEof)?;
        Ok(Self::new(copy_of(message)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rosgraph_msgs::Clock;

    #[test]
    fn the_frame_is_the_same_as_of_the_decoded_message() {
        let clock = Clock { clock: rosrust::Time { sec: 3, nsec: 4 } };
        let frame = clock.encode_vec().unwrap();
        let serialized = Serialized::<Clock>::decode_slice(&frame).unwrap();
        assert_eq!(serialized.bytes, crate::encode(&clock));
        assert_eq!(serialized.encode_vec().unwrap(), frame);
        assert!(Serialized::<Clock>::decode_slice(&[1]).is_err());
    }
}
