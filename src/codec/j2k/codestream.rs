//! The codestream's markers (Annex A): the subset that the profile allows, written and read.
//!
//! One tile, one tile-part, components of unsigned samples at full resolution, no component transform, LRCP, default
//! precincts, no SOP or EPH, no code-block style. The reader refuses everything else before any decoder is called, so
//! that a decoder only ever sees streams that this writer could have written.

use super::quantise::{Quantisation, Step};
use super::{MAX_LAYERS, MAX_LEVELS, partition};
use crate::error::{Error, Place, Result};
use crate::plane::{Planes, Shape};

const SOC: u16 = 0xff4f;
const SIZ: u16 = 0xff51;
const COD: u16 = 0xff52;
const QCD: u16 = 0xff5c;
const QCC: u16 = 0xff5d;
const RGN: u16 = 0xff5e;
const SOT: u16 = 0xff90;
const SOD: u16 = 0xff93;
const EOC: u16 = 0xffd9;

/// Which wavelet transform (Table A.20).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Transform {
    /// 9/7: better at lossy rates; decoders may differ by one from each other.
    Irreversible97,
    /// 5/3: exact when all is sent, and the same in all decoders when not.
    Reversible53,
}

impl Transform {
    /// Its number in a codestream and in a container.
    pub(super) fn code(self) -> u8 {
        match self {
            Self::Irreversible97 => 0,
            Self::Reversible53 => 1,
        }
    }

    pub(super) fn from_code(code: u8) -> Option<Self> {
        [Self::Irreversible97, Self::Reversible53].into_iter().find(|t| t.code() == code)
    }
}

/// What a container states about a codestream, and the reader holds it to.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Profile {
    /// Columns and rows of every component.
    pub(crate) shape: Shape,
    /// Bits of a sample of each component, 1 to 16.
    pub(crate) depths: Vec<u8>,
    /// The wavelet transform.
    pub(crate) transform: Transform,
    /// Decompositions, at most [`MAX_LEVELS`] and never more than the shorter side allows.
    pub(crate) levels: u8,
    /// Quality layers, 1 to [`MAX_LAYERS`].
    pub(crate) layers: u8,
}

/// A codestream's main header.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Header {
    pub(super) profile: Profile,
    /// Code-blocks have sides of two to this.
    pub(super) block: u8,
    /// One a component.
    pub(super) quantisation: Vec<Quantisation>,
    /// By how many bits the region of interest is shifted up in each component (Annex H); 0 without one.
    pub(super) shifts: Vec<u8>,
}

impl Header {
    /// A codestream of this header and the given packets.
    pub(super) fn write(&self, packets: &[u8]) -> Result<Vec<u8>> {
        let mut out = Vec::with_capacity(packets.len() + 200);
        let profile = &self.profile;
        let components = profile.depths.len();
        put16(&mut out, SOC);

        put16(&mut out, SIZ); // A.5.1
        put16(&mut out, 38 + 3 * components as u16);
        put16(&mut out, 0); // Rsiz: the whole of Part 1
        let size = [profile.shape.width() as u32, profile.shape.height() as u32];
        // The image from the origin, and one tile as large as it.
        for value in [size, [0, 0], size, [0, 0]].concat() {
            put32(&mut out, value);
        }
        put16(&mut out, components as u16);
        for depth in &profile.depths {
            out.extend([depth - 1, 1, 1]);
        }

        put16(&mut out, COD); // A.6.1
        put16(&mut out, 12);
        out.push(0); // default precincts, no SOP, no EPH
        out.push(0); // LRCP
        put16(&mut out, u16::from(profile.layers));
        out.push(0); // no component transform
        out.extend([profile.levels, self.block - 2, self.block - 2, 0]);
        out.push(profile.transform.code());

        for (component, quantisation) in self.quantisation.iter().enumerate() {
            if component > 0 && *quantisation == self.quantisation[0] {
                continue;
            }
            let values = quantisation.write(profile.transform);
            if component == 0 {
                put16(&mut out, QCD); // A.6.4
                put16(&mut out, 2 + values.len() as u16);
            } else {
                put16(&mut out, QCC); // A.6.5
                put16(&mut out, 3 + values.len() as u16);
                out.push(component as u8);
            }
            out.extend(values);
        }
        for (component, &shift) in self.shifts.iter().enumerate() {
            if shift > 0 {
                put16(&mut out, RGN); // A.6.3
                put16(&mut out, 5);
                out.extend([component as u8, 0, shift]);
            }
        }

        put16(&mut out, SOT); // A.4.2
        put16(&mut out, 10);
        put16(&mut out, 0);
        let length = u32::try_from(packets.len() + 14)
            .map_err(|_| Error::Parameter("the codestream would be longer than 4 GiB; lower the rate".into()))?;
        put32(&mut out, length);
        out.extend([0, 1]);
        put16(&mut out, SOD);
        out.extend_from_slice(packets);
        put16(&mut out, EOC);
        Ok(out)
    }

    /// Reads and checks a codestream's header; the packets are the bytes of the range that is returned with it.
    pub(super) fn read(bytes: &[u8]) -> Result<(Self, std::ops::Range<usize>)> {
        let mut r = Reader { bytes, at: 0 };
        r.expect16(SOC, "the marker SOC")?;
        r.expect16(SIZ, "the marker SIZ")?;
        let length = r.u16()?;
        r.expect16(0, "Rsiz")?;
        let (width, height) = (r.u32()?, r.u32()?);
        let shape = Shape::new(width, height).map_err(|e| r.malformed(e.to_string()))?;
        for (value, name) in [(0, "XOsiz"), (0, "YOsiz"), (width, "XTsiz"), (height, "YTsiz"), (0, "XTOsiz"), (0, "YTOsiz")] {
            r.expect32(value, name)?;
        }
        let components = usize::from(r.u16()?);
        if components == 0 || components > Planes::MAX {
            return Err(r.malformed(format!("{components} components, expected 1 to {}", Planes::MAX)));
        }
        if usize::from(length) != 38 + 3 * components {
            return Err(r.malformed(format!("Lsiz is {length}, and there are {components} components")));
        }
        let mut depths = Vec::with_capacity(components);
        for _ in 0..components {
            let depth = r.u8()?.saturating_add(1);
            if !(1..=super::MAX_DEPTH).contains(&depth) {
                return Err(r.malformed(format!("Ssiz is {}, expected unsigned samples of 1 to 16 bits", depth - 1)));
            }
            depths.push(depth);
            r.expect8(1, "XRsiz")?;
            r.expect8(1, "YRsiz")?;
        }

        r.expect16(COD, "the marker COD")?;
        r.expect16(12, "Lcod")?;
        r.expect8(0, "Scod")?;
        r.expect8(0, "the progression order")?;
        let layers = r.u16()?;
        if layers == 0 || layers > u16::from(MAX_LAYERS) {
            return Err(r.malformed(format!("{layers} layers, expected 1 to {MAX_LAYERS}")));
        }
        r.expect8(0, "the component transform")?;
        let levels = r.u8()?;
        let most = partition::most_levels(shape).min(MAX_LEVELS);
        if levels > most {
            return Err(r.malformed(format!("{levels} decompositions, expected at most {most} for {shape} samples")));
        }
        let block = r.u8()?.saturating_add(2);
        if !(5..=6).contains(&block) {
            return Err(r.malformed(format!("code-blocks of width 2^{block}, expected 2^5 or 2^6")));
        }
        r.expect8(block - 2, "the height of code-blocks")?;
        r.expect8(0, "the code-block style")?;
        let code = r.u8()?;
        let transform =
            Transform::from_code(code).ok_or_else(|| r.malformed(format!("wavelet transform {code}, expected 0 or 1")))?;
        let profile = Profile { shape, depths, transform, levels, layers: layers as u8 };

        r.expect16(QCD, "the marker QCD")?;
        let length = usize::from(r.u16()?).saturating_sub(2);
        let first = Quantisation::read(r.take(length)?, &profile).map_err(|why| r.malformed(why))?;
        let mut quantisation = vec![first; components];
        let mut shifts = vec![0; components];
        let (mut next_qcc, mut next_rgn) = (1, 0);
        loop {
            match r.u16()? {
                QCC if next_rgn == 0 => {
                    let length = usize::from(r.u16()?).saturating_sub(3);
                    let component = r.component(&mut next_qcc, components)?;
                    quantisation[component] = Quantisation::read(r.take(length)?, &profile).map_err(|why| r.malformed(why))?;
                }
                RGN => {
                    r.expect16(5, "Lrgn")?;
                    let component = r.component(&mut next_rgn, components)?;
                    r.expect8(0, "Srgn")?;
                    shifts[component] = r.u8()?;
                    if shifts[component] == 0 {
                        return Err(r.malformed("a region of interest shifted by 0 bits, expected at least 1".into()));
                    }
                }
                SOT => break,
                other => return Err(r.malformed(format!("the marker {other:04x}, expected QCC, RGN or SOT in that order"))),
            }
        }
        let header = Self { profile, block, quantisation, shifts };
        let most = header.planes().into_iter().flatten().max().unwrap_or(0);
        if most > MAX_SIGNALLED_PLANES {
            return Err(r.malformed(format!("{most} bit-planes, expected at most {MAX_SIGNALLED_PLANES}")));
        }

        let tile_part = r.at - 2;
        r.expect16(10, "Lsot")?;
        r.expect16(0, "Isot")?;
        let length = r.u32()? as usize;
        let room = bytes.len().saturating_sub(tile_part + 2);
        if length != room || length < 14 {
            return Err(r.malformed(format!("a tile-part of {length} bytes, and {room} before the last marker")));
        }
        r.expect8(0, "TPsot")?;
        r.expect8(1, "TNsot")?;
        r.expect16(SOD, "the marker SOD")?;
        let packets = r.at..bytes.len() - 2;
        r.at = packets.end;
        r.expect16(EOC, "the marker EOC")?;
        Ok((header, packets))
    }

    /// The number of bit-planes that the header states for each sub-band of each component (Equations E-2 and H-3).
    pub(super) fn planes(&self) -> Vec<Vec<u32>> {
        let of = |(q, shift): (&Quantisation, &u8)| q.planes().map(|planes| planes + u32::from(*shift)).collect();
        self.quantisation.iter().zip(&self.shifts).map(of).collect()
    }
}

/// The most bit-planes a header may state: what decoders take (of these, [`super::bitplane::MAX_PLANES`] may be coded).
pub(super) const MAX_SIGNALLED_PLANES: u32 = 32;

impl Quantisation {
    /// Sqcd and SPqcd (Table A.27).
    fn write(&self, transform: Transform) -> Vec<u8> {
        match transform {
            Transform::Reversible53 => {
                std::iter::once(self.guard << 5).chain(self.steps.iter().map(|s| s.exponent << 3)).collect()
            }
            Transform::Irreversible97 => {
                let mut out = vec![self.guard << 5 | 2];
                self.steps.iter().for_each(|s| put16(&mut out, u16::from(s.exponent) << 11 | s.mantissa));
                out
            }
        }
    }

    fn read(bytes: &[u8], profile: &Profile) -> Result<Self, String> {
        let bands = 3 * usize::from(profile.levels) + 1;
        let (style, size) = match profile.transform {
            Transform::Reversible53 => (0, 1),
            Transform::Irreversible97 => (2, 2),
        };
        let Some((&first, values)) = bytes.split_first() else { return Err("an empty quantisation".into()) };
        if first & 0x1f != style {
            return Err(format!("quantisation style {}, expected {style} with this transform", first & 0x1f));
        }
        if values.len() != bands * size {
            return Err(format!("{} bytes of quantisation steps, expected {size} for each of {bands} sub-bands", values.len()));
        }
        let step = |v: &[u8]| match v {
            [a, b] => Step { exponent: a >> 3, mantissa: u16::from_be_bytes([a & 7, *b]) },
            _ => Step { exponent: v[0] >> 3, mantissa: 0 },
        };
        if size == 1 && values.iter().any(|v| v & 7 != 0) {
            return Err("a reversible quantisation step with low bits, expected none".into());
        }
        let quantisation = Self { guard: first >> 5, steps: values.chunks_exact(size).map(step).collect() };
        if quantisation.steps.iter().any(|s| quantisation.guard + s.exponent == 0) {
            return Err("a sub-band of −1 bit-planes, expected at least 0".into());
        }
        Ok(quantisation)
    }
}

fn put16(out: &mut Vec<u8>, value: u16) {
    out.extend(value.to_be_bytes());
}

fn put32(out: &mut Vec<u8>, value: u32) {
    out.extend(value.to_be_bytes());
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn malformed(&self, why: String) -> Error {
        Error::malformed(Place::Byte(self.at as u64), format!("in a JPEG 2000 codestream: {why}"))
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        let Some(bytes) = self.bytes[self.at..].get(..n) else {
            return Err(self.malformed(format!("the end, expected {n} more bytes")));
        };
        self.at += n;
        Ok(bytes)
    }

    fn number(&mut self, bytes: usize) -> Result<u32> {
        Ok(self.take(bytes)?.iter().fold(0, |n, &b| n << 8 | u32::from(b)))
    }

    fn u8(&mut self) -> Result<u8> {
        Ok(self.number(1)? as u8)
    }

    fn u16(&mut self) -> Result<u16> {
        Ok(self.number(2)? as u16)
    }

    fn u32(&mut self) -> Result<u32> {
        self.number(4)
    }

    fn expect(&mut self, bytes: usize, expected: u32, name: &str) -> Result<()> {
        let found = self.number(bytes)?;
        if found == expected {
            return Ok(());
        }
        let digits = 2 * bytes;
        Err(self.malformed(format!("{found:0digits$x}, expected {expected:0digits$x} for {name}")))
    }

    fn expect8(&mut self, expected: u8, name: &str) -> Result<()> {
        self.expect(1, expected.into(), name)
    }

    fn expect16(&mut self, expected: u16, name: &str) -> Result<()> {
        self.expect(2, expected.into(), name)
    }

    fn expect32(&mut self, expected: u32, name: &str) -> Result<()> {
        self.expect(4, expected, name)
    }

    /// A component's number; they come in order, and none twice.
    fn component(&mut self, next: &mut usize, components: usize) -> Result<usize> {
        let component = usize::from(self.u8()?);
        if component < *next || component >= components {
            return Err(self.malformed(format!("component {component}, expected {next} to {}", components - 1)));
        }
        *next = component + 1;
        Ok(component)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        let quantisation =
            |e: u8| Quantisation { guard: 2, steps: (0..7).map(|b| Step { exponent: e + b, mantissa: 0 }).collect() };
        Header {
            profile: Profile {
                shape: Shape::new(300, 7).unwrap(),
                depths: vec![12, 8, 12],
                transform: Transform::Reversible53,
                levels: 2,
                layers: 3,
            },
            block: 6,
            quantisation: vec![quantisation(12), quantisation(8), quantisation(12)],
            shifts: vec![0, 11, 0],
        }
    }

    #[test]
    fn a_header_reads_back_as_it_was_written() {
        let mut header = header();
        let bytes = header.write(&[1, 2, 3]).unwrap();
        let (back, packets) = Header::read(&bytes).unwrap();
        assert_eq!(back, header);
        assert_eq!(&bytes[packets], [1, 2, 3]);
        header.profile.transform = Transform::Irreversible97;
        header.quantisation[2].steps[3].mantissa = 2047;
        assert_eq!(Header::read(&header.write(&[]).unwrap()).unwrap().0, header);
    }

    #[test]
    fn a_header_with_any_byte_changed_is_refused_or_read_as_another_that_would_be_written_so() {
        let bytes = header().write(&[1, 2, 3]).unwrap();
        let (_, packets) = Header::read(&bytes).unwrap();
        for at in (0..bytes.len()).filter(|at| !packets.contains(at)) {
            for change in 1..=255 {
                let mut other = bytes.clone();
                other[at] ^= change;
                if let Ok((header, packets)) = Header::read(&other) {
                    assert_eq!(header.write(&other[packets]).unwrap(), other, "byte {at}");
                }
            }
            assert!(Header::read(&bytes[..at]).is_err());
        }
    }

    #[test]
    fn other_tiles_levels_and_block_styles_are_refused_by_name() {
        let bytes = header().write(&[]).unwrap();
        let why = |at: usize, value: u8| {
            let mut other = bytes.clone();
            other[at] = value;
            Header::read(&other).unwrap_err().to_string()
        };
        // The markers follow each other at fixed places: SIZ at 2, COD at 51.
        assert_eq!(why(27, 100), "byte 28: in a JPEG 2000 codestream: 00000164, expected 0000012c for XTsiz");
        assert!(why(42, 0x8b).contains("unsigned samples"));
        assert!(why(43, 2).contains("XRsiz"));
        assert!(why(55, 1).contains("Scod"));
        assert!(why(56, 1).contains("progression order"));
        assert!(why(59, 1).contains("component transform"));
        assert!(why(60, 3).contains("3 decompositions, expected at most 2"));
        assert!(why(61, 8).contains("code-blocks of width 2^10"));
        assert!(why(63, 1).contains("block style"));
        assert!(why(64, 2).contains("wavelet transform 2"));
    }
}
