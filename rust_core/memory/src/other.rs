//! An allocator that tells nothing about what it keeps.

/// Not known, so that no other function is called.
pub(crate) fn anonymous_bytes() -> Option<u64> {
    None
}

/// Not known.
pub(crate) fn bytes_in_use() -> u64 {
    0
}

/// Nothing is done.
pub(crate) fn fix_sizes() {}

/// Nothing is done.
pub(crate) fn give_back() {}
