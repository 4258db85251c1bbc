//! Fuzz target: connection headers of TCPROS.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::TCPROS_HEADER.run(data));
