//! Fuzz target: COLLADA.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::COLLADA.run(data));
