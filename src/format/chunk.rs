//! Signature and chunks: a tag, a length, a payload, a checksum.

use crate::bits::Reader;
use crate::error::{Error, Place, Result};

/// The first bytes of every file.
pub(crate) const SIGNATURE: [u8; 4] = *b"gimc";

/// The version of the format that is written, and the only one that is read.
pub(crate) const VERSION: u8 = 0;

/// One chunk of a file that was checked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chunk<'a> {
    pub(crate) tag: [u8; 4],
    pub(crate) payload: &'a [u8],
    /// Its bytes in the file, tag, length and checksum included.
    pub(crate) size: u64,
}

impl<'a> Chunk<'a> {
    /// Reads the payload field by field.
    pub(crate) fn reader(&self) -> Reader<'a> {
        Reader::new(self.payload, self.tag)
    }
}

/// All chunks of a file.
#[derive(Debug)]
pub(crate) struct Chunks<'a>(Vec<Chunk<'a>>);

impl<'a> Chunks<'a> {
    /// Finds and checks the chunks of a file.
    pub(crate) fn read(bytes: &'a [u8]) -> Result<Self> {
        let at = |position: usize, why: String| Error::malformed(Place::Byte(position as u64), why);
        let Some(rest) = bytes.strip_prefix(&SIGNATURE) else {
            return Err(at(0, "not a gimc file: it does not begin with the bytes \"gimc\"".into()));
        };
        match rest.first() {
            Some(&VERSION) => {}
            Some(other) => return Err(Error::Unsupported { what: "format version", id: other.to_string() }),
            None => return Err(at(4, "the file ends before the format version".into())),
        }
        let mut chunks = Vec::new();
        let mut position = SIGNATURE.len() + 1;
        while position < bytes.len() {
            let mut reader = Reader::new(&bytes[position..], *b"file");
            let short = |e: Error| match e {
                Error::Malformed { at: Place::Chunk(_, offset), why } => at(position + offset as usize, why),
                other => other,
            };
            let tag: [u8; 4] = reader.take(4, "a chunk's tag").map_err(short)?.try_into().unwrap_or_default();
            if !tag.iter().all(u8::is_ascii_alphanumeric) {
                return Err(at(position, format!("expected a chunk's tag, found \"{}\"", tag.escape_ascii())));
            }
            let length = reader.varint("a chunk's length").map_err(short)?;
            let length = usize::try_from(length).unwrap_or(usize::MAX);
            let payload = reader.take(length, "a chunk's payload").map_err(short)?;
            let stored = reader.take(4, "a chunk's checksum").map_err(short)?;
            if stored != checksum(tag, payload) {
                return Err(at(position, format!("the checksum of chunk {} does not match", tag.escape_ascii())));
            }
            let size = bytes.len() - position - reader.rest().len();
            chunks.push(Chunk { tag, payload, size: size as u64 });
            position += size;
        }
        Ok(Self(chunks))
    }

    /// The one chunk of this tag.
    pub(crate) fn one(&self, tag: [u8; 4]) -> Result<Chunk<'a>> {
        let mut found = self.0.iter().filter(|chunk| chunk.tag == tag);
        match (found.next(), found.next()) {
            (Some(chunk), None) => Ok(*chunk),
            (None, _) => Err(Error::malformed(Place::Whole, format!("there is no chunk {}", tag.escape_ascii()))),
            _ => Err(Error::malformed(Place::Whole, format!("there are several chunks {}", tag.escape_ascii()))),
        }
    }

    /// The one chunk of this tag, if there is any.
    pub(crate) fn optional(&self, tag: [u8; 4]) -> Result<Option<Chunk<'a>>> {
        if self.0.iter().any(|chunk| chunk.tag == tag) { self.one(tag).map(Some) } else { Ok(None) }
    }

    /// Refuses critical chunks that are not in `known`, and a file that does not begin with the first of them.
    pub(crate) fn check_known(&self, known: &[[u8; 4]]) -> Result<()> {
        if self.0.first().map(|chunk| chunk.tag) != known.first().copied() {
            return Err(Error::malformed(Place::Byte(5), "the first chunk is not the header"));
        }
        match self.0.iter().find(|chunk| chunk.tag[0].is_ascii_uppercase() && !known.contains(&chunk.tag)) {
            Some(chunk) => Err(Error::Unsupported { what: "chunk", id: chunk.tag.escape_ascii().to_string() }),
            None => Ok(()),
        }
    }

    /// The tag of the first chunk.
    pub(crate) fn first(&self) -> Option<[u8; 4]> {
        self.0.first().map(|chunk| chunk.tag)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Chunk<'a>> {
        self.0.iter()
    }
}

/// Writes the signature, then chunks one by one.
#[cfg(feature = "encode")]
#[derive(Debug)]
pub(crate) struct ChunkWriter(crate::bits::Writer);

#[cfg(feature = "encode")]
impl ChunkWriter {
    pub(crate) fn new() -> Self {
        let mut writer = crate::bits::Writer::default();
        writer.bytes(&SIGNATURE);
        writer.u8(VERSION);
        Self(writer)
    }

    /// Goes on where a file ended.
    pub(crate) fn after(file: &[u8]) -> Self {
        let mut writer = crate::bits::Writer::default();
        writer.bytes(file);
        Self(writer)
    }

    pub(crate) fn chunk(&mut self, tag: [u8; 4], payload: &[u8]) {
        self.0.bytes(&tag);
        self.0.varint(payload.len() as u64);
        self.0.bytes(payload);
        self.0.bytes(&checksum(tag, payload));
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.0.into_bytes()
    }
}

/// CRC-32 (as in PNG and zlib) of tag and payload, lowest byte first.
fn checksum(tag: [u8; 4], payload: &[u8]) -> [u8; 4] {
    let mut crc = crc32fast::Hasher::new();
    crc.update(&tag);
    crc.update(payload);
    crc.finalize().to_le_bytes()
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;

    fn two_chunks() -> Vec<u8> {
        let mut writer = ChunkWriter::new();
        writer.chunk(*b"HEAD", &[1, 2, 3]);
        writer.chunk(*b"note", b"an ancillary chunk");
        writer.into_bytes()
    }

    #[test]
    fn chunks_come_back_and_their_sizes_fill_the_file() {
        let bytes = two_chunks();
        let chunks = Chunks::read(&bytes).unwrap();
        assert_eq!(chunks.one(*b"HEAD").unwrap().payload, [1, 2, 3]);
        assert_eq!(5 + chunks.iter().map(|chunk| chunk.size).sum::<u64>(), bytes.len() as u64);
        assert!(chunks.one(*b"BODY").is_err());
    }

    #[test]
    fn an_unknown_chunk_is_skipped_if_ancillary_and_refused_if_critical() {
        let bytes = two_chunks();
        assert!(Chunks::read(&bytes).unwrap().check_known(&[*b"HEAD"]).is_ok());
        let mut writer = ChunkWriter::new();
        writer.chunk(*b"HEAD", &[]);
        writer.chunk(*b"BODY", &[]);
        let bytes = writer.into_bytes();
        let refused = Chunks::read(&bytes).unwrap().check_known(&[*b"HEAD"]);
        assert!(matches!(refused, Err(Error::Unsupported { what: "chunk", .. })));
    }

    #[test]
    fn every_changed_bit_and_every_cut_inside_a_chunk_is_noticed() {
        let bytes = two_chunks();
        for bit in 0..8 * bytes.len() {
            let mut changed = bytes.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(Chunks::read(&changed).is_err(), "bit {bit}");
        }
        let first = 5 + 4 + 1 + 3 + 4;
        for end in 0..bytes.len() {
            assert_eq!(Chunks::read(&bytes[..end]).is_ok(), end == 5 || end == first, "cut at {end}");
        }
    }
}
