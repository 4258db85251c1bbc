//! What the tests of the whole share.

#![forbid(unsafe_code)]

pub mod big_robot;
pub mod programs;
pub mod puppet;
pub mod ros;
pub mod scenes;
pub mod stand;
