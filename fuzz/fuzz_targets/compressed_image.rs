//! Fuzz target: JPEG, PNG and RVL of image_transport.
#![no_main]

libfuzzer_sys::fuzz_target!(init: rcs_fuzz_harness::catch_decoder_panics(), |data: &[u8]| {
    rcs_fuzz_harness::COMPRESSED_IMAGE.run(data);
});
