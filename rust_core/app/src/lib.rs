//! The programs. Those with a crate of their own are only named in [`all_programs`].
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod all_programs;
pub mod help_files;
pub mod projector;
pub mod projector_blend;
pub mod projector_window;
