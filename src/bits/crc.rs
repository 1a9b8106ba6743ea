//! The checksum of files, as in PNG and zlib.

/// CRC-32 of some bytes.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}
