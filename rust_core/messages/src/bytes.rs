//! Shared bytes of big messages, whose memory is recycled.
//!
//! Messages are received and dropped on different threads, so the process has one pool.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::buffer_pool::BufferPool;

/// Largest size of the pool, bytes.
const MAX_POOLED_BYTES: usize = 256 << 20;

/// Time after which unused memory is freed, such as that of a cloud of millions of points that came once.
const UNUSED_TIME: Duration = Duration::from_secs(10);

static POOL: Mutex<BufferPool<u8>> = Mutex::new(BufferPool::new());

/// An empty buffer with room for `len` bytes, in an earlier message's memory if possible.
pub fn pooled_bytes(len: usize) -> Vec<u8> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let bytes = pool.take(len);
    free_unused(&mut pool);
    bytes
}

/// Frees the memory of earlier messages that was unused for ten seconds, as each new message does.
pub fn free_unused_bytes() {
    free_unused(&mut POOL.lock().unwrap_or_else(PoisonError::into_inner));
}

fn free_unused(pool: &mut BufferPool<u8>) {
    if let Some(time) = Instant::now().checked_sub(UNUSED_TIME) {
        pool.free_unused_since(time);
    }
}

/// A copy of a message's bytes.
pub(crate) fn copy_of(bytes: &[u8]) -> Vec<u8> {
    let mut copy = pooled_bytes(bytes.len());
    copy.extend_from_slice(bytes);
    copy
}

/// Returns a message's bytes to the pool.
pub(crate) fn give_back(bytes: Vec<u8>) {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    pool.give(bytes);
    pool.limit_to(MAX_POOLED_BYTES);
}

/// An owner of bytes, such as a picture.
pub type SharedBytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// Bytes that several messages may share. The last of them returns a message's own memory to the pool.
#[derive(Clone)]
pub(crate) enum Bytes {
    /// Bytes of a received message.
    Own(Arc<Vec<u8>>),
    /// Bytes of another owner.
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
        // If two are dropped at the same time, neither is the last, and the memory is freed.
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
    fn the_last_of_several_messages_returns_their_bytes_to_the_pool() {
        // A length that no other test of this process asks for.
        const LEN: usize = 7_654_321;
        let first = Bytes::from(copy_of(&[7; LEN]));
        let address = first.as_ptr();
        let second = first.clone();
        drop(first);
        let other = pooled_bytes(LEN);
        assert_ne!(other.as_ptr(), address, "the second still has it");
        assert_eq!(second[LEN - 1], 7);
        drop(second);
        let third = pooled_bytes(LEN);
        assert_eq!(third.as_ptr(), address);
    }

    #[test]
    fn bytes_that_are_shared_outside_are_not_pooled() {
        let shared = Arc::new(vec![1, 2, 3]);
        drop(Bytes::from(Arc::clone(&shared)));
        assert_eq!(*shared, [1, 2, 3]);
    }
}
