//! Fuzz target: glTF, text and GLB.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::GLTF.run(data));
