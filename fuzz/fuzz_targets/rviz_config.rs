//! Fuzz target: .rviz.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::RVIZ_CONFIG.run(data));
