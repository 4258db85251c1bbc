//! Fuzz target: PLY.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::PLY.run(data));
