//! Returning unused memory to the system.
//!
//! glibc keeps freed memory for later allocations: of a scene of a hundred thousand markers a hundred megabytes, for as
//! long as the program runs. So the thresholds above which it returns memory are fixed ([`mallopt`]), and a
//! [`MemoryTrimmer`] trims the heap ([`malloc_trim`]) when memory stays unused, see [`policy`]. Other C libraries are
//! left alone.
//!
//! [`mallopt`]: https://man7.org/linux/man-pages/man3/mallopt.3.html
//! [`malloc_trim`]: https://man7.org/linux/man-pages/man3/malloc_trim.3.html
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[path = "glibc.rs"]
mod allocator;
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
mod allocator {
    //! An allocator of unknown use, so that nothing is ever trimmed.

    pub(crate) fn anonymous_bytes() -> Option<u64> {
        None
    }

    pub(crate) fn bytes_in_use() -> u64 {
        0
    }

    pub(crate) fn fix_thresholds() {}

    pub(crate) fn trim() {}
}
mod policy;
mod trimmer;

pub use trimmer::MemoryTrimmer;
