//! Fuzz target: lists of patterns.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::PATTERN_LIST.run(data));
