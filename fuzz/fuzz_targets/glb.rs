//! Any bytes as a mesh file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| trials::read(bytes, gimc::Format::Glb));
