//! Writers of recordings, shared by the tests of several crates.
#![forbid(unsafe_code)]

mod bag_writer;
mod mcap_writer;

pub use bag_writer::BagWriter;
pub use mcap_writer::McapWriter;
