//! Chunk `SURF`: the streams of the surface codec (spec/format.md, "SURF").

use super::stage::read_stages;
#[cfg(feature = "encode")]
use super::stage::write_stages;
use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;

/// What the surface codec needs beside the header.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceChunk<'a> {
    /// How the streams are coded: 0 fast, 1 default, 2 best.
    pub(crate) effort: u8,
    /// Bits that each stage after the first adds to every coordinate.
    pub(crate) stages: Vec<u8>,
    /// Whether the one stage is for a region of interest only.
    pub(crate) has_region: bool,
    /// How vertices slide along the surface, if they may.
    pub(crate) slide: Option<SlideField>,
    pub(crate) holes: u32,
    pub(crate) components: u32,
    pub(crate) handles: u32,
    pub(crate) connectivity: &'a [u8],
    /// What follows the connectivity: the position streams of the first stage, one after the other.
    positions: Reader<'a>,
}

/// How vertices slide along the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SlideField {
    /// Whether the step along the normal becomes finer where edges are short.
    pub(crate) fine: bool,
    /// √2 to the power of this is how many times longer than that the other steps may be, where the file says it.
    pub(crate) longest: Option<u8>,
    /// The coefficients of the filter, if there is one.
    pub(crate) filter: Option<[i8; Self::COEFFICIENTS]>,
}

impl SlideField {
    const COEFFICIENTS: usize = 20;
    const FILTERED: u8 = 1;
    const FINE: u8 = 2;
    const LIMITED: u8 = 4;
    const ALL: u8 = 7;
    /// Limits are below this.
    const LIMITS: u8 = 8;

    #[cfg(feature = "encode")]
    fn write(self, w: &mut Writer) {
        let flags = [(Self::FILTERED, self.filter.is_some()), (Self::FINE, self.fine), (Self::LIMITED, self.longest.is_some())];
        w.u8(flags.iter().filter(|flag| flag.1).map(|flag| flag.0).sum());
        self.longest.iter().for_each(|&limit| w.u8(limit));
        self.filter.iter().flatten().for_each(|&a| w.u8(a as u8));
    }

    fn read(r: &mut Reader<'_>) -> Result<Self> {
        let flags = r.u8("how vertices slide")?;
        if flags > Self::ALL {
            return Err(r.error(format!("flags of sliding vertices below 8, found {flags}")));
        }
        let longest = if flags & Self::LIMITED != 0 { Some(r.u8("how long a step may be")?) } else { None };
        if let Some(limit) = longest.filter(|&limit| limit >= Self::LIMITS) {
            return Err(r.error(format!("a limit of steps below {}, found {limit}", Self::LIMITS)));
        }
        let mut filter = None;
        if flags & Self::FILTERED != 0 {
            let mut coefficients = [0; Self::COEFFICIENTS];
            for a in &mut coefficients {
                *a = r.u8("the filter")? as i8;
            }
            filter = Some(coefficients);
        }
        Ok(Self { fine: flags & Self::FINE != 0, longest, filter })
    }
}

impl<'a> SurfaceChunk<'a> {
    pub(crate) const TAG: [u8; 4] = *b"SURF";

    /// Said with the effort where there are stages.
    const STAGED: u8 = 4;
    /// Said beside it where the one stage is for some vertices only.
    const REGION: u8 = 8;
    /// Said with the effort where vertices slide.
    const SLIDING: u8 = 16;

    #[cfg(feature = "encode")]
    pub(crate) fn write(
        effort: u8,
        stages: &[u8],
        has_region: bool,
        slide: Option<SlideField>,
        [holes, components, handles]: [u32; 3],
        connectivity: &[u8],
        positions: &[Vec<u8>],
    ) -> Vec<u8> {
        let mut w = Writer::default();
        let flag = |set: bool, flag: u8| if set { flag } else { 0 };
        w.u8(effort
            | flag(!stages.is_empty(), Self::STAGED)
            | flag(has_region, Self::REGION)
            | flag(slide.is_some(), Self::SLIDING));
        if !stages.is_empty() {
            write_stages(&mut w, stages);
        }
        if let Some(slide) = slide {
            slide.write(&mut w);
        }
        w.varint(holes.into());
        w.varint(components.into());
        w.varint(handles.into());
        w.varint(connectivity.len() as u64);
        w.bytes(connectivity);
        write_streams(&mut w, positions);
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'a>) -> Result<Self> {
        let effort = r.u8("the effort")?;
        let stages = if effort & Self::STAGED != 0 { read_stages(&mut r)? } else { Vec::new() };
        let has_region = effort & Self::REGION != 0;
        if has_region && stages.len() != 1 {
            return Err(r.error(format!("a region of interest in {} later stages, one expected", stages.len())));
        }
        let slide = if effort & Self::SLIDING != 0 { Some(SlideField::read(&mut r)?) } else { None };
        if slide.is_some() && (!stages.is_empty() || effort & 3 == 0) {
            return Err(r.error("vertices that slide, in stages or with effort fast"));
        }
        let mut count = |what| {
            let n = r.varint(what)?;
            u32::try_from(n).map_err(|_| r.error(format!("{what} do not fit 32 bits: {n}")))
        };
        let (holes, components, handles) = (count("the holes")?, count("the components")?, count("the handles")?);
        let length = r.varint("the length of the connectivity")?;
        let connectivity = r.take(usize::try_from(length).unwrap_or(usize::MAX), "the connectivity")?;
        let effort = effort & !(Self::STAGED | Self::REGION | Self::SLIDING);
        Ok(Self { effort, stages, has_region, slide, holes, components, handles, connectivity, positions: r })
    }

    /// The bytes of the position streams of the first stage, with their lengths.
    pub(crate) fn positions_size(&self) -> u64 {
        self.positions.clone().rest().len() as u64
    }

    /// The position streams of the first stage.
    pub(crate) fn positions(&self, count: usize) -> Result<Vec<&'a [u8]>> {
        read_stage(self.positions.clone(), count)
    }
}

/// Writes streams, one after the other; the last takes all that is left.
#[cfg(feature = "encode")]
fn write_streams(w: &mut Writer, streams: &[Vec<u8>]) {
    if let Some((last, others)) = streams.split_last() {
        for stream in others {
            w.varint(stream.len() as u64);
            w.bytes(stream);
        }
        w.bytes(last);
    }
}

/// The streams of a later stage as the payload of its chunk.
#[cfg(feature = "encode")]
pub(crate) fn write_stage(streams: &[Vec<u8>]) -> Vec<u8> {
    let mut w = Writer::default();
    write_streams(&mut w, streams);
    w.into_bytes()
}

/// Reads `count` streams.
pub(crate) fn read_stage(mut r: Reader<'_>, count: usize) -> Result<Vec<&[u8]>> {
    let mut streams = Vec::new();
    for _ in 1..count {
        let length = r.varint("the length of a position stream")?;
        streams.push(r.take(usize::try_from(length).unwrap_or(usize::MAX), "a position stream")?);
    }
    streams.push(r.rest());
    Ok(streams)
}
