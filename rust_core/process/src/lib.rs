//! Locks, threads, and memory that goes back to the system: parts that a whole process shares.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod memory;
mod threads;

pub use memory::{keep_one_heap, trim_regularly};
pub use threads::{join_within, lock, name_threads, wait_timeout, wait_while, IDLE_PERIOD};
