//! Chunk `GIMG`: a geometry image, with all that is known of it before it is decoded (spec/format.md, "GIMG").

use crate::bits::Reader;
#[cfg(feature = "encode")]
use crate::bits::Writer;
use crate::error::Result;
use crate::plane::{Gluing, Lattice, MAX_DEPTH, Seams, Shape};

/// A geometry image: the first chunk of its file, which needs no other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImageChunk<'a> {
    pub(crate) gluing: Gluing,
    /// Whether decoded positions are `f64` and not `f32`.
    pub(crate) double: bool,
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    /// How an open border is glued further.
    pub(crate) seams: Option<Seams>,
    pub(crate) holes: Option<HolesField<'a>>,
    pub(crate) region: Option<RegionField<'a>>,
    pub(crate) body: ImageBody,
    /// The psnr of the whole image against its original, in hundredths of a dB, rounded down.
    pub(crate) psnr: Option<u16>,
    /// No point of either surface is farther than this from the other, in the units of the mesh.
    pub(crate) bound: Option<f32>,
    /// The image, as its codec has it.
    pub(crate) bytes: &'a [u8],
}

/// Squares that are no part of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct HolesField<'a> {
    /// Vertices of what is left.
    pub(crate) vertices: u32,
    /// Squares that are left.
    pub(crate) squares: u32,
    /// The mask.
    pub(crate) bytes: &'a [u8],
}

/// A region of interest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RegionField<'a> {
    /// Steps of details away from it are 2 to this times as large.
    pub(crate) coarser: u8,
    /// The psnr of the region against its original, in hundredths of a dB, rounded down.
    pub(crate) psnr: u16,
    /// The mask of its cells.
    pub(crate) bytes: &'a [u8],
}

impl<'a> RegionField<'a> {
    /// The most that steps are coarser by, as a power of two.
    pub(crate) const COARSEST: u8 = 8;

    #[cfg(feature = "encode")]
    fn write(&self, w: &mut Writer) {
        w.u8(self.coarser);
        w.bytes(&self.psnr.to_le_bytes());
        w.varint(self.bytes.len() as u64);
        w.bytes(self.bytes);
    }

    fn read(r: &mut Reader<'a>) -> Result<Self> {
        let coarser = r.u8("the steps outside the region")?;
        if coarser > Self::COARSEST {
            return Err(
                r.error(format!("steps 2^{coarser} times as large outside the region, at most 2^{} expected", Self::COARSEST))
            );
        }
        let psnr = r.take(2, "the psnr of the region")?;
        let psnr = u16::from_le_bytes([psnr[0], psnr[1]]);
        let length = usize::try_from(r.varint("the bytes of the region")?).unwrap_or(usize::MAX);
        Ok(Self { coarser, psnr, bytes: r.take(length, "the region")? })
    }
}

/// What a codec needs beside its bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ImageBody {
    /// Coefficients.
    Wavelet { levels: u8, step: f32, bounds: CoarseBox },
    /// Three planes of samples on a lattice.
    Planes { codec: PlanesBy, depth: u8, lattice: Lattice },
}

/// Codecs of planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PlanesBy {
    Raw,
    Exr,
    J2k,
}

/// A box in steps of 2^exponent: all points lie in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CoarseBox {
    pub(crate) exponent: i64,
    pub(crate) low: [i64; 3],
    pub(crate) extent: [u64; 3],
}

/// Exponents of boxes: what `f32` has, and a little more.
const EXPONENTS: std::ops::RangeInclusive<i64> = -160..=130;
/// Coordinates of boxes.
const FARTHEST: u64 = 1 << 50;
/// The longest side of a box that is written has at most so many steps.
#[cfg(feature = "encode")]
const FINENESS: f64 = 32.0;

impl CoarseBox {
    fn unit(exponent: i64) -> f64 {
        f64::from_bits(((exponent.clamp(-1000, 1000) + 1023) as u64) << 52)
    }

    /// The corners.
    pub(crate) fn bounds(&self) -> [[f64; 3]; 2] {
        let unit = Self::unit(self.exponent);
        let low = self.low.map(|x| x as f64 * unit);
        [low, [0, 1, 2].map(|i| low[i] + self.extent[i] as f64 * unit)]
    }

    /// The box around one that is given exactly. `finest` is a length below which nothing matters.
    #[cfg(feature = "encode")]
    pub(crate) fn around([low, high]: [[f64; 3]; 2], finest: f64) -> Self {
        let longest = (0..3).map(|i| high[i] - low[i]).fold(finest, f64::max);
        let far = low.iter().chain(&high).fold(0.0, |far: f64, x| far.max(x.abs()));
        let fits = |&e: &i64| FINENESS * Self::unit(e) >= longest && far / Self::unit(e) < (FARTHEST / 2) as f64;
        let exponent = EXPONENTS.into_iter().find(fits).unwrap_or(*EXPONENTS.end());
        let unit = Self::unit(exponent);
        let low = low.map(|x| (x / unit).floor() as i64);
        let high = high.map(|x| (x / unit).ceil() as i64);
        Self { exponent, low, extent: [0, 1, 2].map(|i| high[i].abs_diff(low[i])) }
    }

    #[cfg(feature = "encode")]
    fn write(&self, w: &mut Writer) {
        w.signed(self.exponent);
        self.low.into_iter().for_each(|x| w.signed(x));
        self.extent.into_iter().for_each(|x| w.varint(x));
    }

    fn read(r: &mut Reader<'_>) -> Result<Self> {
        let exponent = r.signed("the unit of the box")?;
        if !EXPONENTS.contains(&exponent) {
            return Err(r.error(format!("a box in steps of 2^{exponent}, {EXPONENTS:?} expected")));
        }
        let (mut low, mut extent) = ([0; 3], [0; 3]);
        for x in &mut low {
            *x = r.signed("the box")?;
        }
        for x in &mut extent {
            *x = r.varint("the box")?;
        }
        if low.iter().any(|x| x.unsigned_abs() > FARTHEST) || extent.iter().any(|&x| x > FARTHEST) {
            return Err(r.error(format!("a box of {low:?} and {extent:?} steps, at most {FARTHEST} expected")));
        }
        Ok(Self { exponent, low, extent })
    }
}

const GLUING: u8 = 3;
const ORBIFOLD: u8 = 1;
const SEAMS: u8 = 2;
const DOUBLE: u8 = 1 << 2;
const NOT_SQUARE: u8 = 1 << 3;
const PSNR: u8 = 1 << 4;
const BOUND: u8 = 1 << 5;
const HOLES: u8 = 1 << 6;
const REGION: u8 = 1 << 7;

/// Numbers of 16 bits: the upper half of an `f32`.
#[cfg(feature = "encode")]
pub(crate) fn short(x: f64, up: bool) -> f32 {
    let x32 = x as f32;
    let below = f32::from_bits(x32.to_bits() & 0xffff_0000);
    let shorter = |x: f32| f32::from_bits((x.to_bits() >> 16).saturating_add(1) << 16);
    match up {
        true if f64::from(below) < x => shorter(below),
        false if f64::from(below) > x && below > 0.0 => f32::from_bits(((below.to_bits() >> 16) - 1) << 16),
        _ => below,
    }
}

impl<'a> HolesField<'a> {
    fn read(r: &mut Reader<'a>, [columns, rows]: [u32; 2]) -> Result<Self> {
        let all = u64::from(columns.saturating_sub(1)) * u64::from(rows.saturating_sub(1));
        let mut count = |what: &str, most: u64| {
            let n = r.varint(what)?;
            if n >= 1 && n <= most { Ok(n) } else { Err(r.error(format!("{n} {what}, 1 to {most} expected"))) }
        };
        // Two fans at a point make two vertices of it.
        let vertices = count("vertices", (4 * all).min(u32::MAX.into()))? as u32;
        let squares = count("squares", all.min(u32::MAX.into()))? as u32;
        let length = usize::try_from(r.varint("the bytes of holes")?).unwrap_or(usize::MAX);
        Ok(Self { vertices, squares, bytes: r.take(length, "the holes")? })
    }
}

impl<'a> ImageChunk<'a> {
    pub(crate) const TAG: [u8; 4] = *b"GIMG";
    /// How an image came about, in the words of its makers; ancillary.
    pub(crate) const HISTORY: [u8; 4] = *b"hist";

    /// Vertices of the mesh at full size.
    pub(crate) fn vertices(&self) -> u64 {
        let (columns, rows) = (u64::from(self.columns), u64::from(self.rows));
        match (&self.holes, &self.seams) {
            (Some(holes), _) => holes.vertices.into(),
            (None, Some(seams)) => seams.vertices(columns.saturating_sub(1)),
            (None, None) if self.gluing == Gluing::Orbifold => {
                columns.saturating_sub(1).saturating_mul(rows.saturating_sub(1)).saturating_add(2)
            }
            (None, None) => columns.saturating_mul(rows),
        }
    }

    /// Triangles of the mesh at full size.
    pub(crate) fn faces(&self) -> u64 {
        if let Some(holes) = &self.holes {
            return 2 * u64::from(holes.squares);
        }
        2 * u64::from(self.columns.saturating_sub(1)) * u64::from(self.rows.saturating_sub(1))
    }

    #[cfg(feature = "encode")]
    pub(crate) fn write(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.u8(match self.body {
            ImageBody::Wavelet { .. } => 0,
            ImageBody::Planes { codec, .. } => 1 + codec as u8,
        });
        let gluing = match (self.gluing, &self.seams) {
            (_, Some(_)) => SEAMS,
            (Gluing::Orbifold, None) => ORBIFOLD,
            (Gluing::Open, None) => 0,
        };
        let flag = |set: bool, flag: u8| if set { flag } else { 0 };
        let square = self.columns == self.rows;
        w.u8(gluing
            | flag(self.double, DOUBLE)
            | flag(!square, NOT_SQUARE)
            | flag(self.psnr.is_some(), PSNR)
            | flag(self.bound.is_some(), BOUND)
            | flag(self.holes.is_some(), HOLES)
            | flag(self.region.is_some(), REGION));
        w.varint(self.columns.into());
        if !square {
            w.varint(self.rows.into());
        }
        if let Some(seams) = &self.seams {
            super::seams::write(seams, &mut w);
        }
        if let Some(holes) = &self.holes {
            w.varint(holes.vertices.into());
            w.varint(holes.squares.into());
            w.varint(holes.bytes.len() as u64);
            w.bytes(holes.bytes);
        }
        if let Some(region) = &self.region {
            region.write(&mut w);
        }
        let upper_half = |x: f32| ((x.to_bits() >> 16) as u16).to_le_bytes();
        match self.body {
            ImageBody::Wavelet { levels, step, bounds } => {
                w.u8(levels);
                w.bytes(&upper_half(step));
                bounds.write(&mut w);
            }
            ImageBody::Planes { depth, lattice, .. } => {
                w.u8(depth);
                lattice.origin.into_iter().chain([lattice.step]).for_each(|x| w.f64(x));
            }
        }
        if let Some(psnr) = self.psnr {
            w.bytes(&psnr.to_le_bytes());
        }
        if let Some(bound) = self.bound {
            w.bytes(&upper_half(bound));
        }
        w.bytes(self.bytes);
        w.into_bytes()
    }

    /// The corners of a box that holds all points.
    pub(crate) fn bounds(&self) -> [[f64; 3]; 2] {
        match self.body {
            ImageBody::Wavelet { bounds, .. } => bounds.bounds(),
            ImageBody::Planes { depth, lattice, .. } => [lattice.origin, lattice.point([(1 << depth) - 1; 3])],
        }
    }

    /// How often the image can be halved.
    pub(crate) fn levels(&self) -> u8 {
        match self.body {
            ImageBody::Wavelet { levels, .. } => levels.min(self.seam_levels()),
            ImageBody::Planes { .. } => 0,
        }
    }

    /// How often the image can be halved so that its seams still fit.
    fn seam_levels(&self) -> u8 {
        let levels = |seams: &Seams| Shape::new(self.columns, self.rows).map_or(0, |shape| seams.levels(shape));
        self.seams.as_ref().map_or(u8::MAX, levels)
    }

    pub(crate) fn read(mut r: Reader<'a>) -> Result<Self> {
        let codec = r.u8("the codec")?;
        let flags = r.u8("the flags")?;
        let gluing = match flags & GLUING {
            0 | SEAMS => Gluing::Open,
            ORBIFOLD => Gluing::Orbifold,
            other => return Err(crate::Error::Unsupported { what: "gluing", id: other.to_string() }),
        };
        let mut side = |what| {
            let n = r.varint(what)?;
            u32::try_from(n).map_err(|_| r.error(format!("{what} do not fit 32 bits: {n}")))
        };
        let columns = side("the columns")?;
        let rows = if flags & NOT_SQUARE == 0 { columns } else { side("the rows")? };
        if flags & NOT_SQUARE != 0 && rows == columns {
            return Err(r.error("a square that is said not to be one"));
        }
        let seams = if flags & GLUING == SEAMS { Some(super::seams::read(&mut r)?) } else { None };
        if let Some(seams) = &seams {
            let fits = Shape::new(columns, rows).and_then(|shape| seams.check(shape));
            fits.map_err(|why| r.error(why.to_string()))?;
        }
        let holes = if flags & HOLES == 0 { None } else { Some(HolesField::read(&mut r, [columns, rows])?) };
        let region = if flags & REGION == 0 { None } else { Some(RegionField::read(&mut r)?) };
        let body = match codec {
            0 => {
                let levels = r.u8("the levels")?;
                let step = upper_half(&mut r, "the step")?;
                if !(step > 0.0 && step.is_finite()) {
                    return Err(r.error(format!("a step of {step}")));
                }
                ImageBody::Wavelet { levels, step, bounds: CoarseBox::read(&mut r)? }
            }
            1..=3 => {
                let depth = r.u8("the depth")?;
                if !(1..=MAX_DEPTH).contains(&depth) {
                    return Err(r.error(format!("samples of {depth} bits, 1 to {MAX_DEPTH} expected")));
                }
                let mut number = |what| r.f64(what);
                let origin = [number("the origin")?, number("the origin")?, number("the origin")?];
                let lattice = Lattice { origin, step: number("the step")? };
                let highest = lattice.point([1 << depth; 3]);
                if lattice.step <= 0.0 || origin.iter().chain(&highest).any(|x| !x.is_finite()) {
                    return Err(r.error("a lattice whose points are not finite numbers"));
                }
                let codec = [PlanesBy::Raw, PlanesBy::Exr, PlanesBy::J2k][usize::from(codec) - 1];
                ImageBody::Planes { codec, depth, lattice }
            }
            other => return Err(crate::Error::Unsupported { what: "codec of geometry images", id: other.to_string() }),
        };
        if let (Some(RegionField { coarser: 1.., .. }), ImageBody::Planes { .. }) = (region, body) {
            return Err(r.error("coarser steps outside a region, of planes of samples"));
        }
        let psnr = if flags & PSNR == 0 {
            None
        } else {
            let bytes = r.take(2, "the psnr")?;
            Some(u16::from_le_bytes([bytes[0], bytes[1]]))
        };
        let bound = if flags & BOUND == 0 { None } else { Some(upper_half(&mut r, "the bound")?) };
        if let Some(bound) = bound.filter(|b| !(*b >= 0.0 && b.is_finite())) {
            return Err(r.error(format!("a bound of {bound}")));
        }
        let double = flags & DOUBLE != 0;
        let chunk = Self { gluing, double, columns, rows, seams, holes, region, body, psnr, bound, bytes: r.rest() };
        if chunk.vertices() > u64::from(u32::MAX) || chunk.faces() > u64::from(u32::MAX) {
            return Err(
                r.error(format!("an image of {columns} x {rows} samples has more vertices or faces than 32 bits count"))
            );
        }
        Ok(chunk)
    }
}

fn upper_half(r: &mut Reader<'_>, what: &str) -> Result<f32> {
    let bytes = r.take(2, what)?;
    Ok(f32::from_bits(u32::from(u16::from_le_bytes([bytes[0], bytes[1]])) << 16))
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use crate::plane::BorderSide;

    #[allow(clippy::unwrap_used)]
    fn chunks() -> Vec<ImageChunk<'static>> {
        let bounds = CoarseBox::around([[-1.0, 0.2, 5e5], [1.5, 0.9, 5e5 + 3.0]], 1e-3);
        let wavelet = ImageBody::Wavelet { levels: 5, step: short(0.0123, false), bounds };
        let lattice = Lattice { origin: [0.1, -7.0, 1e6], step: 0.25 };
        let planes = |codec| ImageBody::Planes { codec, depth: 16, lattice };
        let chunk = |gluing, columns, rows, body, psnr, bound| ImageChunk {
            gluing,
            double: columns == 5,
            columns,
            rows,
            seams: None,
            holes: None,
            region: None,
            body,
            psnr,
            bound,
            bytes: b"body",
        };
        let sides = [2, 3, 0, 1].map(|mate| BorderSide { length: 8, mate });
        let seams = Seams::new(8, 3, sides.to_vec()).unwrap();
        let region = RegionField { coarser: 2, psnr: 7023, bytes: b"region" };
        let holes = HolesField { vertices: 900, squares: 700, bytes: b"holes" };
        vec![
            chunk(Gluing::Orbifold, 257, 257, wavelet, Some(7012), Some(short(0.3, true))),
            chunk(Gluing::Open, 100, 37, wavelet, None, None),
            chunk(Gluing::Open, 5, 5, planes(PlanesBy::Raw), Some(1), None),
            chunk(Gluing::Orbifold, 5, 7, planes(PlanesBy::J2k), None, Some(0.0)),
            chunk(Gluing::Open, 5, 7, planes(PlanesBy::Exr), None, None),
            ImageChunk { seams: Some(seams.clone()), ..chunk(Gluing::Open, 33, 33, wavelet, None, None) },
            ImageChunk { seams: Some(seams), holes: Some(holes), ..chunk(Gluing::Open, 33, 33, wavelet, None, Some(1.0)) },
            ImageChunk { holes: Some(holes), ..chunk(Gluing::Orbifold, 33, 35, wavelet, None, None) },
            ImageChunk { region: Some(region), ..chunk(Gluing::Orbifold, 33, 33, wavelet, Some(6011), None) },
            ImageChunk {
                region: Some(RegionField { coarser: 0, ..region }),
                holes: Some(holes),
                ..chunk(Gluing::Open, 33, 33, planes(PlanesBy::J2k), None, None)
            },
        ]
    }

    #[test]
    fn what_is_written_is_read_back_and_every_cut_is_refused() {
        for chunk in chunks() {
            let bytes = chunk.write();
            assert_eq!(ImageChunk::read(Reader::new(&bytes, ImageChunk::TAG)).unwrap(), chunk);
            for end in 0..bytes.len() - chunk.bytes.len() {
                assert!(ImageChunk::read(Reader::new(&bytes[..end], ImageChunk::TAG)).is_err(), "cut at {end}");
            }
        }
    }

    #[test]
    fn planes_have_no_coarser_steps() {
        let region = RegionField { coarser: 1, psnr: 7023, bytes: b"region" };
        for chunk in chunks() {
            let chunk = ImageChunk { region: Some(region), ..chunk };
            let read = ImageChunk::read(Reader::new(&chunk.write(), ImageChunk::TAG)).is_ok();
            assert_eq!(read, matches!(chunk.body, ImageBody::Wavelet { .. }));
        }
    }

    #[test]
    fn a_coarse_box_holds_the_exact_one_and_is_little_larger() {
        for (low, high, finest) in [
            ([-1.0, 0.2, 5e5], [1.5, 0.9, 5e5 + 3.0], 1e-3),
            ([0.0; 3], [0.0; 3], 1e-6),
            ([1e-30; 3], [2e-30; 3], 1e-34),
            ([-3e37; 3], [2e38; 3], 1e30),
            ([1e12, 0.0, 0.0], [1e12 + 1.0, 0.0, 0.0], 1e-3),
        ] {
            let [l, h] = CoarseBox::around([low, high], finest).bounds();
            let longest = (0..3).map(|i| high[i] - low[i]).fold(finest, f64::max);
            assert!((0..3).all(|i| l[i] <= low[i] && h[i] >= high[i]), "{low:?} {high:?}");
            assert!((0..3).all(|i| low[i] - l[i] <= longest / 8.0 && h[i] - high[i] <= longest / 8.0), "{low:?} {high:?}");
        }
    }

    #[test]
    fn short_numbers_lie_on_the_wanted_side() {
        for x in [1.0, 0.1, 1.0 / 3.0, 12345.678, 1e-30, 3e38, 1.007_812_5] {
            let (down, up) = (f64::from(short(x, false)), f64::from(short(x, true)));
            assert!(down <= x && x <= up && up - down <= x / 128.0, "{x}: {down} and {up}");
        }
    }
}
