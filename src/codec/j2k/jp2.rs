//! The JP2 file format (Annex I) around a codestream, for viewers that do not open a raw one.
//!
//! Only written: the signature, the file type, the header (size, depth, colour) and the codestream. Inside a `.gimc` file
//! the codestream stands alone.

use super::codestream::Profile;
use crate::error::{Error, Result};

/// A JP2 file that shows the codestream's first three components as red, green and blue, or else the first as grey.
pub(crate) fn wrap(codestream: &[u8]) -> Result<Vec<u8>> {
    let Profile { shape, depths, .. } = super::profile(codestream)?;
    let mut out = Vec::with_capacity(codestream.len() + 200);
    put_box(&mut out, b"jP  ", &[0x0d, 0x0a, 0x87, 0x0a])?;
    put_box(&mut out, b"ftyp", b"jp2 \0\0\0\0jp2 ")?;

    let mut header = Vec::new();
    let same_depth = depths.iter().all(|d| *d == depths[0]);
    let mut ihdr = Vec::new(); // I.5.3.1
    ihdr.extend((shape.height() as u32).to_be_bytes());
    ihdr.extend((shape.width() as u32).to_be_bytes());
    ihdr.extend((depths.len() as u16).to_be_bytes());
    // Compression 7 is the only one; the colours are known; no rights are claimed.
    ihdr.extend([if same_depth { depths[0] - 1 } else { 255 }, 7, 0, 0]);
    put_box(&mut header, b"ihdr", &ihdr)?;
    if !same_depth {
        put_box(&mut header, b"bpcc", &depths.iter().map(|d| d - 1).collect::<Vec<u8>>())?;
    }
    // I.5.3.3: an enumerated colour space, sRGB or grey.
    let colours: u16 = if depths.len() >= 3 { 3 } else { 1 };
    put_box(&mut header, b"colr", &[1, 0, 0, 0, 0, 0, if colours == 3 { 16 } else { 17 }])?;
    let channels = depths.len() as u16;
    if channels > colours {
        // I.5.3.6: the channels beyond the colours are of no stated type.
        let mut cdef = channels.to_be_bytes().to_vec();
        for channel in 0..channels {
            let (kind, of) = if channel < colours { (0, channel + 1) } else { (0xffff, 0xffff) };
            [channel, kind, of].iter().for_each(|v| cdef.extend(v.to_be_bytes()));
        }
        put_box(&mut header, b"cdef", &cdef)?;
    }
    put_box(&mut out, b"jp2h", &header)?;
    put_box(&mut out, b"jp2c", codestream)?;
    Ok(out)
}

/// A box (I.4): its length with this head, its type, its contents.
fn put_box(out: &mut Vec<u8>, kind: &[u8; 4], contents: &[u8]) -> Result<()> {
    let length = u32::try_from(contents.len() + 8)
        .map_err(|_| Error::Parameter("the codestream is too long for a box of a JP2 file; write it as .j2k".into()))?;
    out.extend(length.to_be_bytes());
    out.extend(kind);
    out.extend(contents);
    Ok(())
}
