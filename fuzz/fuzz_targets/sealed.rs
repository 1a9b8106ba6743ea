//! Any payloads under checksums that match: past the container, into the codecs.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = trials::decode(&trials::seal::from_noise(bytes));
});
