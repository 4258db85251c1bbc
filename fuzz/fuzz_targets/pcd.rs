//! Fuzz target: PCD.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::PCD.run(data));
