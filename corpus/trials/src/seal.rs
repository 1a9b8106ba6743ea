//! Damage that checksums do not notice: chunks are changed and sealed again, so that hostile bytes reach the codecs.
//!
//! Written from spec/format.md, apart from the code of the library.

/// A tag, and its payload.
pub type Chunk = ([u8; 4], Vec<u8>);

/// CRC-32 as in PNG, bit by bit.
pub fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = !0_u32;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    !crc
}

/// The chunks of a sound file.
pub fn open(file: &[u8]) -> Vec<Chunk> {
    let mut chunks = Vec::new();
    let mut at = 5;
    while at < file.len() {
        let tag = [file[at], file[at + 1], file[at + 2], file[at + 3]];
        at += 4;
        let (mut length, mut shift) = (0_usize, 0);
        loop {
            let byte = file[at];
            at += 1;
            length |= usize::from(byte & 0x7f) << shift;
            shift += 7;
            if byte < 0x80 {
                break;
            }
        }
        chunks.push((tag, file[at..at + length].to_vec()));
        at += length + 4;
    }
    chunks
}

/// A file of these chunks, with the checksums that they need.
pub fn close(chunks: &[Chunk]) -> Vec<u8> {
    let mut file = b"gimc\0".to_vec();
    for (tag, payload) in chunks {
        file.extend(tag);
        let mut length = payload.len();
        while length >= 0x80 {
            file.push(length as u8 | 0x80);
            length >>= 7;
        }
        file.push(length as u8);
        file.extend(payload);
        file.extend(crc32(&[&tag[..], payload].concat()).to_le_bytes());
    }
    file
}

/// The same file with other payloads, sealed again.
pub fn changed(file: &[u8], change: impl FnOnce(&mut Vec<Chunk>)) -> Vec<u8> {
    let mut chunks = open(file);
    change(&mut chunks);
    close(&chunks)
}

/// A file whose header and body are these bytes: the first says how many of them are the header's.
pub fn from_noise(bytes: &[u8]) -> Vec<u8> {
    let Some((&length, rest)) = bytes.split_first() else { return close(&[]) };
    let (header, body) = rest.split_at(usize::from(length).min(rest.len()));
    close(&[(*b"HEAD", header.to_vec()), (*b"SURF", body.to_vec())])
}

/// The bytes from which [`from_noise`] makes this file, if its chunks are as there: seeds for a fuzzer.
pub fn to_noise(file: &[u8]) -> Option<Vec<u8>> {
    match &open(file)[..] {
        [(header, a), (body, b)] if header == b"HEAD" && body == b"SURF" => {
            Some([&[u8::try_from(a.len()).ok()?][..], a, b].concat())
        }
        _ => None,
    }
}
