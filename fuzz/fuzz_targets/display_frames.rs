//! Fuzz target: TFMessage, and a camera's CameraInfo.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::DISPLAY_FRAMES.run(data));
