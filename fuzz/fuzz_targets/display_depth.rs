//! Fuzz target: Image and CompressedImage with CameraInfo.
#![no_main]

libfuzzer_sys::fuzz_target!(init: rcs_fuzz_harness::catch_decoder_panics(), |data: &[u8]| {
    rcs_fuzz_harness::DISPLAY_DEPTH.run(data);
});
