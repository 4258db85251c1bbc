//! Fuzz target: XML-RPC calls and answers.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::XMLRPC.run(data));
