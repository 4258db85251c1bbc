//! The programs as users run them, as in `e2e`, where times, rates or loads are measured: one test at a time.
//!
//! ```text
//! cargo build --release -p rcs_app --bins
//! cargo test --release -p rcs_tests --test timing -- --test-threads=1                   all tests
//! cargo test --release -p rcs_tests --test timing -- frame_rate::                       the tests of one file
//! RCS_RENDERER=gpu cargo test ...                                                      the nodes draw on the GPU
//! ```

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod floods;
mod frame_rate;
mod heavy;
mod latency;
mod load;
mod meshes;
mod soak;
