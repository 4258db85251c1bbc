//! Fuzz target: Marker and MarkerArray.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::DISPLAY_MARKERS.run(data));
