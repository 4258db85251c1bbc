//! Fuzz target: InteractiveMarkerInit and InteractiveMarkerUpdate.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::DISPLAY_INTERACTIVE.run(data));
