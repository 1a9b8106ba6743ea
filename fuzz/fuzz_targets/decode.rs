//! Any bytes as a `.gimc` file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = trials::decode(bytes);
});
