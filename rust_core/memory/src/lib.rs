//! Memory that is no longer used, given back to the system.
//!
//! The C library keeps what a program frees for what it allocates next. Of a scene of a hundred thousand markers that
//! may be a hundred megabytes, for as long as the program runs. Two things keep that from happening:
//! - A large free piece at the end of one of the C library's areas goes back at once. By itself the C library lets such
//!   pieces grow up to 64 MB in each area, once something large was freed ([`mallopt`]).
//! - A [`Keeper`] looks how much is unused, every five seconds, and has the C library give that back ([`malloc_trim`])
//!   where there was as much at the last look. A scene whose messages free and allocate the same again and again keeps
//!   its memory, see [`policy`].
//!
//! Only glibc is treated, which is what ROS 1 runs on; elsewhere nothing is done.
//!
//! [`mallopt`]: https://man7.org/linux/man-pages/man3/mallopt.3.html
//! [`malloc_trim`]: https://man7.org/linux/man-pages/man3/malloc_trim.3.html
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[path = "glibc.rs"]
mod allocator;
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
#[path = "other.rs"]
mod allocator;
mod keeper;
mod policy;

pub use keeper::Keeper;
