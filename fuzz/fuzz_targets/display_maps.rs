//! Fuzz target: OccupancyGrid with updates, GridCells.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::DISPLAY_MAPS.run(data));
