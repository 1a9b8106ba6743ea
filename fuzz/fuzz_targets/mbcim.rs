//! Images of vertices: a mesh that the bytes choose through any image codec, then damaged.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| trials::image(bytes));
