//! Fuzz target: textures: PNG, JPEG, BMP, TGA, TIFF, GIF.
#![no_main]

libfuzzer_sys::fuzz_target!(init: rcs_fuzz_harness::catch_decoder_panics(), |data: &[u8]| {
    rcs_fuzz_harness::TEXTURE.run(data);
});
