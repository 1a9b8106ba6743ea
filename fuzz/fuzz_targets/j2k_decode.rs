//! Any bytes as a JPEG 2000 codestream; and streams of our own, damaged as the bytes say.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    gimc::inner::j2k::decode_bytes(bytes);
    gimc::inner::j2k::decode_damaged(bytes);
});
