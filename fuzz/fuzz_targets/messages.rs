//! Fuzz target: messages of every type, and requests of services.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::MESSAGES.run(data));
