//! Fuzz target: clouds and scans, in all styles.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::DISPLAY_CLOUDS.run(data));
