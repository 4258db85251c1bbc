//! Fuzz target: package.xml.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rcs_fuzz_harness::PACKAGE_XML.run(data));
