//! Noise in the chunks beside the surface: repairs, exact coordinates, attributes, order, names.
#![no_main]

use std::sync::LazyLock;

static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| trials::worn::files().unwrap_or_default());

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| trials::worn::decode(&FILES, bytes));
