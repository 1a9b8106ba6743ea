//! Chunk `HEAD`: what a file holds, without decoding it (spec/format.md, "HEAD").

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;
use crate::plane::Lattice;

/// The most bits a coordinate may have.
pub(crate) const MAX_BITS: u32 = 24;
/// Lattice coordinates lie in 0 ..= 2³⁰ − 1, relative to the lowest.
pub(crate) const MAX_EXTENT: u64 = (1 << 30) - 1;

/// Everything that is known before a codec is asked.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    /// The codec that the other chunks are for.
    pub(crate) codec: u8,
    /// Whether decoded positions are `f64` and not `f32`.
    pub(crate) double: bool,
    /// Which optional chunks follow, so that none can be cut off unnoticed.
    pub(crate) extras: Extras,
    pub(crate) vertices: u32,
    pub(crate) faces: u32,
    pub(crate) lattice: LatticeForm,
    /// The lowest lattice coordinates.
    pub(crate) low: [i64; 3],
    /// The largest lattice coordinates, relative to `low`.
    pub(crate) extent: [i32; 3],
    /// No point of either surface is farther than this from the other, in the units of the mesh.
    pub(crate) bound: f32,
}

/// Which chunks a file has beside those that every file has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Extras {
    pub(crate) fixes: bool,
    pub(crate) order: bool,
    pub(crate) labels: bool,
    pub(crate) attributes: bool,
    pub(crate) exact: bool,
}

impl Extras {
    #[cfg(feature = "encode")]
    fn bits(self) -> u8 {
        let flags = [self.fixes, self.order, self.labels, self.attributes, self.exact];
        flags.iter().rev().fold(0, |bits, &flag| bits << 1 | u8::from(flag))
    }

    fn from_bits(bits: u8) -> Self {
        let is_set = |i: u8| bits >> i & 1 != 0;
        Self { fixes: is_set(0), order: is_set(1), labels: is_set(2), attributes: is_set(3), exact: is_set(4) }
    }
}

/// How the lattice is written down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LatticeForm {
    /// 2^bits points from one end of the longest side of the box to the other.
    Box {
        /// log₂ of the points on the longest side.
        bits: u32,
        /// The lowest corner, where the lattice begins.
        low: [f64; 3],
        /// Which side of the box is the longest.
        axis: usize,
        /// Its upper end.
        high: f64,
    },
    /// Any lattice.
    Free(Lattice),
    /// A lattice whose numbers are exactly `f32`.
    Short(Lattice),
}

impl LatticeForm {
    /// The lattice that is meant.
    pub(crate) fn lattice(&self) -> Lattice {
        match *self {
            Self::Free(lattice) | Self::Short(lattice) => lattice,
            Self::Box { bits, low, axis, high } => {
                let side = high - low[axis];
                let step = if side > 0.0 { side / ((1_u64 << bits) - 1) as f64 } else { 1.0 };
                Lattice { origin: low, step }
            }
        }
    }
}

/// The first byte of a lattice: 0–2 a box by its longest axis, in `f32`; 3–5 the same in `f64`; 6 free; 7 the same in `f32`.
const BOX_F64: u8 = 3;
const FREE: u8 = 6;
const SHORT: u8 = 7;

impl Header {
    pub(crate) const TAG: [u8; 4] = *b"HEAD";
    /// The codec `surface`.
    pub(crate) const SURFACE: u8 = 0;
    /// The codec `mbcim`.
    pub(crate) const MBCIM: u8 = 1;
    /// Planes of an image of vertices, as plain samples.
    pub(crate) const RAW: u8 = 2;
    /// The same as an OpenEXR picture.
    pub(crate) const EXR: u8 = 3;
    /// The same as a JPEG 2000 codestream.
    pub(crate) const J2K: u8 = 4;

    #[cfg(feature = "encode")]
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.u8(self.codec);
        w.u8(u8::from(self.double) | self.extras.bits() << 1);
        w.varint(self.vertices.into());
        w.signed(i64::from(self.faces) - 2 * i64::from(self.vertices));
        match self.lattice {
            LatticeForm::Box { bits, low, axis, high } => {
                let is_f32 = low.iter().chain([&high]).all(|&x| f64::from(x as f32) == x);
                w.u8(axis as u8 + if is_f32 { 0 } else { BOX_F64 });
                w.u8(bits as u8);
                for x in low.into_iter().chain([high]) {
                    if is_f32 { w.f32(x as f32) } else { w.f64(x) }
                }
            }
            LatticeForm::Free(Lattice { origin, step }) => {
                w.u8(FREE);
                origin.into_iter().chain([step]).for_each(|x| w.f64(x));
                self.low.into_iter().for_each(|q| w.signed(q));
            }
            LatticeForm::Short(Lattice { origin, step }) => {
                w.u8(SHORT);
                origin.into_iter().chain([step]).for_each(|x| w.f32(x as f32));
            }
        }
        self.extent.into_iter().for_each(|e| w.varint(e as u64));
        w.f32(self.bound);
        w.into_bytes()
    }

    pub(crate) fn read(mut r: Reader<'_>) -> Result<Self> {
        let codec = r.u8("the codec")?;
        let kind = r.u8("the number type")?;
        if kind > 63 {
            return Err(r.error(format!("a number type of 0 or 1, and flags of known chunks, found {kind}")));
        }
        let (double, extras) = (kind & 1 != 0, Extras::from_bits(kind >> 1));
        let vertices = r.varint("the vertices")?;
        let faces = (vertices as i64).saturating_mul(2).saturating_add(r.signed("the faces")?);
        let (Ok(vertices), Ok(faces)) = (u32::try_from(vertices), u32::try_from(faces)) else {
            return Err(r.error(format!("{vertices} vertices and {faces} faces do not fit 32 bits")));
        };
        let form = r.u8("the lattice")?;
        let mut low = [0; 3];
        let lattice = match form {
            0..FREE => {
                let bits = u32::from(r.u8("the bits")?);
                if !(1..=MAX_BITS).contains(&bits) {
                    return Err(r.error(format!("coordinates of {bits} bits, 1 to {MAX_BITS} expected")));
                }
                let mut number = |what| if form < BOX_F64 { r.f32(what).map(f64::from) } else { r.f64(what) };
                let low = [number("the box")?, number("the box")?, number("the box")?];
                LatticeForm::Box { bits, low, axis: (form % BOX_F64).into(), high: number("the box")? }
            }
            FREE => {
                let mut number = |what| r.f64(what);
                let origin = [number("the origin")?, number("the origin")?, number("the origin")?];
                let step = number("the step")?;
                for q in &mut low {
                    *q = r.signed("the lowest coordinate")?;
                }
                LatticeForm::Free(Lattice { origin, step })
            }
            SHORT => {
                let mut number = |what| r.f32(what).map(f64::from);
                let origin = [number("the origin")?, number("the origin")?, number("the origin")?];
                LatticeForm::Short(Lattice { origin, step: number("the step")? })
            }
            other => return Err(r.error(format!("a lattice of form 0 to {SHORT}, found {other}"))),
        };
        let mut extent = [0; 3];
        for e in &mut extent {
            let wide = r.varint("the largest coordinate")?;
            if wide > MAX_EXTENT {
                return Err(r.error(format!("a box of {wide} steps, at most {MAX_EXTENT} expected")));
            }
            *e = wide as i32;
        }
        let bound = r.f32("the bound")?;
        r.finish()?;
        let header = Self { codec, double, extras, vertices, faces, lattice, low, extent, bound };
        header.check(&r)?;
        Ok(header)
    }

    /// Refuses boxes and bounds that are no numbers.
    fn check(&self, r: &Reader<'_>) -> Result<()> {
        let Lattice { origin, step } = self.lattice.lattice();
        let far = |q: i64| q.unsigned_abs() > 1 << 52;
        let corners = [self.corner(false), self.corner(true)];
        if step <= 0.0
            || origin.iter().chain(corners.iter().flatten()).chain([&step]).any(|x| !x.is_finite())
            || !self.double && corners.iter().flatten().any(|&x| !(x as f32).is_finite())
            || self.low.into_iter().any(far)
        {
            return Err(r.error("a lattice whose points are not finite numbers"));
        }
        if !(self.bound >= 0.0 && self.bound.is_finite()) {
            return Err(r.error(format!("a bound of {}", self.bound)));
        }
        Ok(())
    }

    /// The lowest or the highest corner of the box of lattice points.
    pub(crate) fn corner(&self, high: bool) -> [f64; 3] {
        let q = [0, 1, 2].map(|i| self.low[i].saturating_add(if high { self.extent[i].into() } else { 0 }));
        self.lattice.lattice().point(q)
    }

    /// The position of a lattice point relative to the lowest, as the decoded mesh has it.
    #[inline]
    pub(crate) fn position(&self, lattice: &Lattice, q: [i32; 3]) -> [f64; 3] {
        let p = lattice.point([0, 1, 2].map(|i| self.low[i] + i64::from(q[i])));
        if self.double { p } else { p.map(|x| f64::from(x as f32)) }
    }
}
