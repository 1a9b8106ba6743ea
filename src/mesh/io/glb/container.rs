//! The container (glTF 2.0, section 4): twelve bytes, then chunks with length and type.

use byteorder::{ByteOrder, LE};
use serde_json::Value;

use crate::error::{Error, Place, Result};
use crate::mesh::io::Sink;

const MAGIC: &[u8; 4] = b"glTF";
const JSON: &[u8; 4] = b"JSON";
const BIN: &[u8; 4] = b"BIN\0";

/// The scene and the numbers.
pub(super) struct Container<'a> {
    pub(super) json: Value,
    pub(super) binary: &'a [u8],
}

impl<'a> Container<'a> {
    pub(super) fn read(bytes: &'a [u8], notes: &mut Vec<String>) -> Result<Self> {
        let error = |at: usize, why: String| Error::malformed(Place::Byte(at as u64), why);
        let Some((header, _)) = bytes.split_at_checked(12).filter(|(header, _)| header.starts_with(MAGIC)) else {
            return Err(error(0, "expected glTF and a header of 12 bytes".to_owned()));
        };
        let [version, length] = [4, 8].map(|at| LE::read_u32(&header[at..at + 4]));
        if version != 2 {
            return Err(Error::Unsupported { what: "glTF version", id: version.to_string() });
        }
        let length = length as usize;
        if length > bytes.len() || length < header.len() {
            return Err(error(8, format!("a file of {length} bytes is announced, and {} are there", bytes.len())));
        }
        if length < bytes.len() {
            notes.push(format!("{} bytes after the end of the file's own length are not kept", bytes.len() - length));
        }

        let mut at = header.len();
        let mut json = None;
        let mut binary = None;
        while at < length {
            let chunk = bytes[at..length].split_at_checked(8);
            let (head, rest) = chunk.ok_or_else(|| error(at, "expected the 8 bytes that begin a chunk".to_owned()))?;
            let announced = LE::read_u32(head) as usize;
            let Some(payload) = rest.get(..announced) else {
                return Err(error(at, format!("a chunk of {announced} bytes is announced, and {} follow", rest.len())));
            };
            let kind = &head[4..];
            at += 8;
            if json.is_none() && kind != JSON {
                return Err(error(at - 4, format!("expected the chunk JSON first, found {}", kind.escape_ascii())));
            } else if json.is_none() {
                json = Some(serde_json::from_slice(payload).map_err(|e| error(at, format!("the scene is not JSON: {e}")))?);
            } else if kind == BIN && binary.is_none() {
                binary = Some(payload);
            } else {
                notes.push(format!("chunk {} is not kept", kind.escape_ascii()));
            }
            at += announced;
        }
        match json {
            Some(json) => Ok(Self { json, binary: binary.unwrap_or_default() }),
            None => Err(error(at, "expected the chunk JSON, found the end of the file".to_owned())),
        }
    }

    pub(super) fn write(json: &Value, binary: &[u8], out: &mut Sink<'_>) -> Result<()> {
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let padding = binary.len().next_multiple_of(4) - binary.len();
        let length = 12 + 8 + json.len() as u64 + 8 + (binary.len() + padding) as u64;
        let length =
            u32::try_from(length).map_err(|_| Error::Unsupported { what: "a GLB file of", id: format!("{length} bytes") })?;
        out.bytes(MAGIC);
        out.bytes(&2_u32.to_le_bytes());
        out.bytes(&length.to_le_bytes());
        for (kind, payload, padding) in [(JSON, json.as_slice(), 0), (BIN, binary, padding)] {
            out.bytes(&((payload.len() + padding) as u32).to_le_bytes());
            out.bytes(kind);
            out.bytes(payload);
            out.bytes(&[0; 3][..padding]);
        }
        Ok(())
    }
}
