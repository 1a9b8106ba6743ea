//! Any bytes as a layout of a geometry image and its coefficients.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| gimc::inner::wavelet::any(bytes));
