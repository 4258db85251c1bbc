//! Fuzz target: .rviz files that a camera is added to.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::NEW_CAMERA.run(data));
