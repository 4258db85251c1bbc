//! Fuzz target: JPEG, PNG and RVL of image_transport.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::COMPRESSED_IMAGE.run(data));
