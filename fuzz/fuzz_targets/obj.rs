//! Fuzz target: OBJ and its MTL.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::OBJ.run(data));
