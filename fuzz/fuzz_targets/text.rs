//! Fuzz target: text in any encoding, and the XML in it.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::TEXT.run(data));
