//! Planes and settings chosen by the bytes: encode as JPEG 2000, decode, hold to what was asked for.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| gimc::inner::j2k::encode_and_decode(bytes));
