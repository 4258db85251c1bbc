//! Fuzz target: bags.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::BAG.run(data));
