//! Fuzz target: capture.yaml.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::CAPTURE.run(data));
