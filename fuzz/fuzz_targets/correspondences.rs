//! Fuzz target: lists of correspondences.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::CORRESPONDENCES.run(data));
