//! Fuzz target: poses, paths, covariances, screws, ranges and the like.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::DISPLAY_POSES.run(data));
