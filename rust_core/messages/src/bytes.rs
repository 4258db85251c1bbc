//! The bytes of a big message: shared while they are needed, and then memory for the next message.
//!
//! Messages are made on rosrust's threads and dropped where their displays are, so what is spare is kept for the whole
//! process.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};

use crate::spares::Spares;

/// What is kept at most, in bytes. Whatever is kept was in use at some time, and most of it is soon again.
const MAX_SPARE_BYTES: usize = 256 << 20;

static SPARE: Mutex<Spares<u8>> = Mutex::new(Spares::new());

/// An empty buffer with room for so many bytes of a message, out of an earlier message's memory where there is some.
pub fn spare_bytes(len: usize) -> Vec<u8> {
    SPARE.lock().unwrap_or_else(PoisonError::into_inner).take(len)
}

/// A copy of a message's bytes.
pub(crate) fn copy_of(bytes: &[u8]) -> Vec<u8> {
    let mut copy = spare_bytes(bytes.len());
    copy.extend_from_slice(bytes);
    copy
}

/// Leaves a message's bytes for the next message.
pub(crate) fn give_back(bytes: Vec<u8>) {
    let mut spare = SPARE.lock().unwrap_or_else(PoisonError::into_inner);
    spare.give(bytes);
    spare.limit_to(MAX_SPARE_BYTES);
}

/// Something that holds bytes, such as a picture.
pub type SharedBytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// Bytes that several messages may share. The last of them gives their memory back, if it is a message's own.
#[derive(Clone)]
pub(crate) enum Bytes {
    /// A message's own.
    Own(Arc<Vec<u8>>),
    /// Those of something that is no message.
    Foreign(SharedBytes),
}

impl Default for Bytes {
    fn default() -> Self {
        Self::Own(Arc::default())
    }
}

impl fmt::Debug for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl From<Arc<Vec<u8>>> for Bytes {
    fn from(bytes: Arc<Vec<u8>>) -> Self {
        Self::Own(bytes)
    }
}

impl From<Vec<u8>> for Bytes {
    fn from(bytes: Vec<u8>) -> Self {
        Self::Own(Arc::new(bytes))
    }
}

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Own(bytes) => bytes,
            Self::Foreign(owner) => (**owner).as_ref(),
        }
    }
}

impl Drop for Bytes {
    fn drop(&mut self) {
        // Where two are dropped at once, neither is the last, and the allocator has the memory.
        if let Self::Own(bytes) = self {
            if let Some(bytes) = Arc::get_mut(bytes) {
                give_back(std::mem::take(bytes));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_of_those_who_share_bytes_gives_them_back() {
        // A length that no other test of this process asks for.
        const LEN: usize = 7_654_321;
        let first = Bytes::from(copy_of(&[7; LEN]));
        let address = first.as_ptr();
        let second = first.clone();
        drop(first);
        let other = spare_bytes(LEN);
        assert_ne!(other.as_ptr(), address, "the second has it");
        assert_eq!(second[LEN - 1], 7);
        drop(second);
        let third = spare_bytes(LEN);
        assert_eq!(third.as_ptr(), address);
    }

    #[test]
    fn bytes_that_somebody_outside_holds_stay_theirs() {
        let shared = Arc::new(vec![1, 2, 3]);
        drop(Bytes::from(Arc::clone(&shared)));
        assert_eq!(*shared, [1, 2, 3]);
    }
}
