//! What the tests of the whole share.

pub mod big_robot;
pub mod programs;
pub mod puppet;
pub mod ros;
pub mod scenes;
pub mod stand;
