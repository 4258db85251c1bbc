//! What only tests use and several crates share: writing bags.
#![forbid(unsafe_code)]

mod bag_writer;
mod mcap_writer;

pub use bag_writer::BagWriter;
pub use mcap_writer::McapWriter;
