//! A mesh and options chosen by the bytes: encode, decode, compare slowly.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| trials::roundtrip(bytes));
