//! Fuzz target: projector files.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::PROJECTOR.run(data));
