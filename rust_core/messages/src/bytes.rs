//! Bytes of an image: those of a received message, or another owner's.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

/// An owner of bytes, such as an image.
pub type SharedBytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// Bytes that several images may share.
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

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Own(bytes) => bytes,
            Self::Foreign(owner) => (**owner).as_ref(),
        }
    }
}
