//! Fuzz target: HTTP messages of XML-RPC.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::HTTP.run(data));
