//! The encoder from end to end: planes to a codestream, with lossless, rate and quality targets.

use super::bitplane::{self, BlockStyle, CodedBlock, Stripes};
use super::codestream::{Header, Profile, Transform};
use super::dwt::{self, Coefficients};
use super::maxshift;
use super::packet::PacketWriter;
use super::partition::{self, Block, Partition};
use super::quantise::{self, Quantisation};
use super::rate::{Hulls, Weight, last_that_fits};
use super::{MAX_DEPTH, MAX_LAYERS, MAX_LEVELS};
use crate::error::{Error, Result};
use crate::limits::{Budget, Limits};
use crate::par;
use crate::plane::{Mask, Plane, Planes};
use crate::task::Task;

/// What a codestream is to reach.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Quality {
    /// Every sample exactly; needs [`Transform::Reversible53`].
    Lossless,
    /// At most so many bytes in all.
    Bytes(u64),
    /// At most so many bits in all for each pixel (all components of it together).
    BitsPerPixel(f64),
    /// At least this peak signal-to-noise ratio in dB, over all components, each against its own peak; checked by decoding.
    Psnr(f64),
}

/// How planes are coded.
#[derive(Clone, Debug)]
pub(crate) struct Settings<'a> {
    /// The wavelet transform. Default: reversible.
    pub(crate) transform: Transform,
    /// Decompositions, at most [`MAX_LEVELS`]; fewer are made of an image too small for them. Default: 5.
    pub(crate) levels: u8,
    /// Code-blocks have sides of two to this, 5 or 6. Default: 6.
    pub(crate) block: u8,
    /// What to reach. Default: lossless.
    pub(crate) quality: Quality,
    /// Quality layers, 1 to [`MAX_LAYERS`]; each before the last has half the bytes of the next. Default: 1.
    pub(crate) layers: u8,
    /// How much an error in each component counts when bytes are shared out, relative to its peak. Default: 1 for all.
    pub(crate) weights: Vec<f64>,
    /// Pixels that come first, and exactly if the transform is reversible and the bytes suffice for them. Default: none.
    pub(crate) region: Option<&'a Mask>,
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self {
            transform: Transform::Reversible53,
            levels: 5,
            block: 6,
            quality: Quality::Lossless,
            layers: 1,
            weights: Vec::new(),
            region: None,
        }
    }
}

/// A codestream, and where its layers end.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Encoded {
    /// The whole codestream.
    pub(crate) bytes: Vec<u8>,
    /// What a container states about it.
    pub(crate) profile: Profile,
    /// The byte after the last packet of each layer.
    pub(crate) layer_ends: Vec<usize>,
}

impl Encoded {
    /// The codestream of the first `layers` layers alone.
    pub(crate) fn first_layers(&self, layers: u8) -> Result<Self> {
        let (mut header, packets) = Header::read(&self.bytes)?;
        if layers == 0 || layers > header.profile.layers {
            return Err(Error::Parameter(format!("{layers} layers, of {}", header.profile.layers)));
        }
        header.profile.layers = layers;
        let bytes = header.write(&self.bytes[packets.start..self.layer_ends[usize::from(layers) - 1]])?;
        Ok(Self { bytes, profile: header.profile, layer_ends: self.layer_ends[..usize::from(layers)].to_vec() })
    }
}

/// Codes planes as a JPEG 2000 codestream.
pub(crate) fn encode(planes: &Planes, settings: &Settings, task: &Task) -> Result<Encoded> {
    check(planes, settings)?;
    let goal = match settings.quality {
        Quality::BitsPerPixel(bpp) => Quality::Bytes((bpp * planes.shape().pixels() as f64 / 8.0) as u64),
        other => other,
    };
    match goal {
        Quality::Psnr(psnr) => reach(planes, settings, psnr, task),
        other => Coded::new(planes, settings, DEFAULT_UNIT, task)?.pack(settings, other),
    }
}

/// An error of one quantiser step costs as much as an error of this in one sample: more is lost by rounding to integers.
const DEFAULT_UNIT: f64 = 1.0;

fn check(planes: &Planes, settings: &Settings) -> Result<()> {
    let refuse = |why: String| Err(Error::Parameter(why));
    if let Some((i, plane)) = planes.iter().enumerate().find(|(_, p)| p.depth() > MAX_DEPTH) {
        return refuse(format!("plane {i} has samples of {} bits; JPEG 2000 is used up to {MAX_DEPTH}", plane.depth()));
    }
    if settings.levels > MAX_LEVELS {
        return refuse(format!("{} decompositions; at most {MAX_LEVELS} are made", settings.levels));
    }
    if !(5..=6).contains(&settings.block) {
        return refuse(format!("code-blocks of 2^{0} x 2^{0}; they are 2^5 or 2^6 wide", settings.block));
    }
    if !(1..=MAX_LAYERS).contains(&settings.layers) {
        return refuse(format!("{} layers; there can be 1 to {MAX_LAYERS}", settings.layers));
    }
    if !settings.weights.is_empty() && settings.weights.len() != planes.len() {
        return refuse(format!("{} weights for {} planes", settings.weights.len(), planes.len()));
    }
    if let Some(weight) = settings.weights.iter().find(|w| !(1e-9..=1e9).contains(*w)) {
        return refuse(format!("a weight of {weight}; it must be between 1e-9 and 1e9"));
    }
    if let Some(mask) = settings.region
        && mask.shape() != planes.shape()
    {
        return refuse(format!("a region of interest of {} pixels for an image of {}", mask.shape(), planes.shape()));
    }
    match settings.quality {
        Quality::Lossless if settings.transform != Transform::Reversible53 => {
            refuse("lossless needs the reversible transform (5/3)".into())
        }
        Quality::BitsPerPixel(bpp) if !(bpp > 0.0 && bpp.is_finite()) => refuse(format!("a rate of {bpp} bits per pixel")),
        Quality::Psnr(psnr) if !(0.0..=200.0).contains(&psnr) => refuse(format!("a psnr of {psnr} dB; it must be 0 to 200")),
        _ => Ok(()),
    }
}

/// Lowers the error until the decoded planes have the psnr that is asked for.
fn reach(planes: &Planes, settings: &Settings, psnr: f64, task: &Task) -> Result<Encoded> {
    // Mean squared error relative to the peak.
    let allowed = 1.0 / power_of_ten(psnr / 10.0);
    let deepest = planes.depths().into_iter().max().unwrap_or(1);
    let rms = allowed.sqrt() * peak(deepest);
    // Steps a few times smaller than the error allowed leave the choice to the optimisation, and not many planes to code.
    let mut unit = (rms * 12f64.sqrt() / 4.0).clamp(FINEST_UNIT, COARSEST_UNIT);
    loop {
        let coded = Coded::new(planes, settings, unit, task)?;
        if let Some(encoded) = coded.pack_to_error(planes, settings, allowed, task)? {
            return Ok(encoded);
        }
        if settings.transform == Transform::Reversible53 || unit <= FINEST_UNIT {
            // The reversible transform without a loss reaches anything.
            let exact = Settings { transform: Transform::Reversible53, quality: Quality::Lossless, ..settings.clone() };
            return Coded::new(planes, &exact, DEFAULT_UNIT, task)?.pack(&exact, Quality::Lossless);
        }
        unit = (unit / 4.0).max(FINEST_UNIT);
    }
}

/// Below this the rounding of samples to integers is all that is left of the error.
const FINEST_UNIT: f64 = 1.0 / 16.0;
/// Above this the deepest samples have a handful of steps left.
const COARSEST_UNIT: f64 = 1024.0;
/// How many single steps are tried for the last bytes of a rate.
const FILLING: usize = 24;
/// How often a stream is decoded to correct the aim.
const ATTEMPTS: usize = 8;
/// A mean squared error this near to the allowed one (0.03 dB) is near enough.
const NEAR_ENOUGH: f64 = 0.993;

/// 10^x for 0 ≤ x ≤ 20, the same on every platform: only a bound for a search, exact to a few parts in 10^15.
fn power_of_ten(x: f64) -> f64 {
    // Whole and halved powers: 10^(1/2), 10^(1/4), … by square roots.
    let mut result = (0..x as u32).fold(1.0, |r, _| r * 10.0);
    let (mut rest, mut root) = (x - f64::from(x as u32), 10f64);
    for _ in 0..52 {
        root = root.sqrt();
        rest *= 2.0;
        if rest >= 1.0 {
            rest -= 1.0;
            result *= root;
        }
    }
    result
}

fn peak(depth: u8) -> f64 {
    f64::from((1u32 << depth) - 1)
}

fn decode_all(encoded: &Encoded) -> Result<Planes> {
    let unlimited = Limits::default().memory(u64::MAX).pixels(u64::MAX).work(u64::MAX);
    super::decode(&encoded.bytes, &encoded.profile, &mut Budget::new(unlimited))
}

/// The mean squared error relative to each component's peak.
fn error(a: &Planes, b: &Planes) -> f64 {
    let of = |(a, b): (&Plane, &Plane)| {
        let squares = a.samples().iter().zip(b.samples()).map(|(x, y)| f64::from((x - y) * (x - y)));
        squares.sum::<f64>() / (peak(a.depth()) * peak(a.depth()))
    };
    a.iter().zip(b.iter()).map(of).sum::<f64>() / (a.len() * a.shape().pixels()) as f64
}

/// The peak signal-to-noise ratio that [`Quality::Psnr`] means, in dB; infinite for equal planes.
pub(crate) fn psnr(a: &Planes, b: &Planes) -> f64 {
    -10.0 * error(a, b).log10()
}

/// A stream of about this psnr as the optimisation measures it, and what it measured, in dB.
#[cfg(test)]
pub(super) fn predicted(planes: &Planes, transform: Transform, psnr: f64) -> (Encoded, f64) {
    let settings = Settings { transform, quality: Quality::Psnr(psnr), ..Settings::default() };
    let coded = Coded::new(planes, &settings, DEFAULT_UNIT, &Task::default()).unwrap();
    let allowed = 1.0 / power_of_ten(psnr / 10.0);
    let hulls = coded.hulls();
    let choice = last_that_fits(hulls.choices(), |choice| hulls.error(choice) > allowed).map_or(0, |c| c + 1);
    (coded.pack_choice(&settings, &hulls, choice).unwrap(), -10.0 * hulls.error(choice).log10())
}

/// All code-blocks of all components, coded in full; what of them is sent is decided afterwards.
struct Coded {
    header: Header,
    partition: Partition,
    /// One component after another.
    blocks: Vec<CodedBlock>,
    /// One a block.
    weights: Vec<Weight>,
    measured: bool,
}

/// The coefficients of one component after the transform.
enum Transformed {
    Reversible(Coefficients<i32>),
    Irreversible(Coefficients<f32>),
}

/// A component on its way.
struct Component {
    transformed: Transformed,
    /// One a sub-band: what a coefficient is multiplied by to count steps.
    per_step: Vec<f32>,
    /// Which coefficients are shifted up, and by how much.
    region: Option<Vec<bool>>,
    shift: u8,
    quantisation: Quantisation,
}

impl Coded {
    fn new(planes: &Planes, settings: &Settings, unit: f64, task: &Task) -> Result<Self> {
        let shape = planes.shape();
        let levels = settings.levels.min(partition::most_levels(shape));
        let partition = Partition::new(shape, levels, settings.block);
        let region = settings.region.map(|mask| maxshift::coefficients(mask, settings.transform, levels));
        task.step(0.02)?;
        let mut unit = unit;
        let components = loop {
            let components: Result<Vec<Component>> = par::map(planes.len(), |i| {
                Component::new(&planes[i], &partition, settings.transform, levels, unit, region.as_deref())
            })
            .into_iter()
            .collect();
            match components {
                // A region doubles the bit-planes: larger steps may make room for it.
                Err(_) if settings.transform == Transform::Irreversible97 && unit < COARSEST_UNIT => unit *= 2.0,
                other => break other?,
            }
            task.step(0.02)?;
        };
        task.step(0.15)?;

        // Without a choice to make nothing has to be measured.
        let measured = settings.quality != Quality::Lossless || settings.layers > 1;
        let per_component = partition.blocks.len();
        let blocks: Vec<CodedBlock> = par::map(per_component * components.len(), |i| {
            if task.is_over() {
                return CodedBlock::default();
            }
            let component = &components[i / per_component];
            let block = &partition.blocks[i % per_component];
            let style = BlockStyle {
                orientation: partition.bands[block.band].orientation,
                reversible: settings.transform == Transform::Reversible53,
                shift: component.shift.into(),
            };
            bitplane::encode(&component.stripes(block, shape.width(), measured), style)
        });
        task.step(0.9)?;

        let weights = (0..blocks.len())
            .map(|i| {
                let (component, block) = (i / per_component, &partition.blocks[i % per_component]);
                let Component { quantisation, shift, .. } = &components[component];
                let band = &partition.bands[block.band];
                let depth = planes[component].depth();
                let step = quantise::size(settings.transform, quantisation.steps[block.band], band, depth);
                let norm = quantise::norm(settings.transform, band) * step / peak(depth);
                let error = norm * norm / (shape.pixels() * components.len()) as f64;
                let weight = settings.weights.get(component).copied().unwrap_or(1.0);
                Weight { error, importance: error * weight, shift: (*shift).into() }
            })
            .collect();
        let header = Header {
            profile: Profile { shape, depths: planes.depths(), transform: settings.transform, levels, layers: settings.layers },
            block: settings.block,
            shifts: components.iter().map(|c| c.shift).collect(),
            quantisation: components.into_iter().map(|c| c.quantisation).collect(),
        };
        Ok(Self { header, partition, blocks, weights, measured })
    }

    fn hulls(&self) -> Hulls {
        debug_assert!(self.measured);
        Hulls::new(&self.blocks, |i| self.weights[i])
    }

    fn writer(&self) -> PacketWriter<'_> {
        PacketWriter::new(&self.partition, &self.blocks, &self.header.planes())
    }

    /// Bytes of a codestream without its packets.
    fn overhead(&self) -> Result<usize> {
        Ok(self.header.write(&[])?.len())
    }

    fn pack(&self, settings: &Settings, quality: Quality) -> Result<Encoded> {
        let all = |block: usize| self.blocks[block].passes.len() as u32;
        match quality {
            Quality::Bytes(bytes) => self.pack_to_bytes(settings, bytes),
            _ if settings.layers == 1 => self.finish(|_, _, _| Ok(()), all),
            _ => {
                let mut whole = Vec::new();
                self.writer().write(all, &mut whole);
                let hulls = self.hulls();
                self.finish(|writer, layer, out| self.middle_layer(&hulls, writer, whole.len(), layer, out), all)
            }
        }
    }

    fn pack_to_bytes(&self, settings: &Settings, bytes: u64) -> Result<Encoded> {
        let overhead = self.overhead()?;
        let hulls = self.hulls();
        let least = {
            let mut out = Vec::new();
            let mut writer = self.writer();
            (0..settings.layers).for_each(|_| writer.write(|_| 0, &mut out));
            out.len() + overhead
        };
        let Some(room) = usize::try_from(bytes).unwrap_or(usize::MAX).checked_sub(least) else {
            return Err(Error::Parameter(format!("{bytes} bytes for a codestream; this image takes at least {least}")));
        };
        let room = room + least - overhead;
        // Without the layers before the last one, and then with them as they came out.
        let middle =
            |writer: &mut PacketWriter, layer: u8, out: &mut Vec<u8>| self.middle_layer(&hulls, writer, room, layer, out);
        let (mut writer, mut before) = (self.writer(), Vec::new());
        for layer in 0..settings.layers - 1 {
            middle(&mut writer, layer, &mut before)?;
        }
        let choice = last_that_fits(hulls.choices(), |choice| before.len() + size(&writer, &hulls.passes(choice)) <= room);
        let choice = choice.unwrap_or(0);
        let mut passes = hulls.passes(choice);
        // The next steps may be too large for what is left, and those after them not.
        for (block, more) in hulls.after(choice).take(FILLING) {
            let fewer = std::mem::replace(&mut passes[block], more);
            if before.len() + size(&writer, &passes) > room {
                passes[block] = fewer;
            }
        }
        self.finish(middle, |block| passes[block])
    }

    /// The fewest bytes found that leave no more than this error once decoded; none if all bytes leave more.
    ///
    /// The error that the gains add up to is a little off where sub-bands are not orthogonal: the aim is corrected by what
    /// decoding finds, until it is met closely.
    fn pack_to_error(&self, planes: &Planes, settings: &Settings, allowed: f64, task: &Task) -> Result<Option<Encoded>> {
        let hulls = self.hulls();
        let (mut aim, mut best) = (allowed, None);
        // The choice with the fewest passes known to be enough, and the one with the most known not to be.
        let (mut enough, mut too_few) = (hulls.choices() + 1, None);
        for _ in 0..ATTEMPTS {
            let by_gains = last_that_fits(hulls.choices(), |choice| hulls.error(choice) > aim).map_or(0, |c| c + 1);
            let least = too_few.map_or(0, |c: usize| c + 1);
            if least >= enough.min(hulls.choices() + 1) {
                break;
            }
            let choice = by_gains.clamp(least, (enough - 1).min(hulls.choices()));
            let encoded = self.pack_choice(settings, &hulls, choice)?;
            let found = error(planes, &decode_all(&encoded)?);
            task.step(0.95)?;
            task.step(0.95)?;
            if found <= allowed {
                (best, enough) = (Some(encoded), choice);
                if found >= allowed * NEAR_ENOUGH {
                    break;
                }
            } else {
                too_few = Some(choice);
            }
            aim *= allowed / found.max(allowed * 1e-6);
        }
        Ok(best)
    }

    /// One of the hulls' choices, in as many layers as are asked for.
    fn pack_choice(&self, settings: &Settings, hulls: &Hulls, choice: usize) -> Result<Encoded> {
        let passes = hulls.passes(choice);
        let mut whole = Vec::new();
        if settings.layers > 1 {
            self.writer().write(|block| passes[block], &mut whole);
        }
        let middle =
            |writer: &mut PacketWriter, layer: u8, out: &mut Vec<u8>| self.middle_layer(hulls, writer, whole.len(), layer, out);
        self.finish(middle, |block| passes[block])
    }

    /// A layer before the last: the stream up to its end has half the bytes of the one up to the end of the next.
    fn middle_layer(&self, hulls: &Hulls, writer: &mut PacketWriter, whole: usize, layer: u8, out: &mut Vec<u8>) -> Result<()> {
        let room = whole >> (self.header.profile.layers - 1 - layer);
        let choice = last_that_fits(hulls.choices(), |choice| out.len() + size(writer, &hulls.passes(choice)) <= room);
        let passes = hulls.passes(choice.unwrap_or(0));
        writer.write(|block| passes[block], out);
        Ok(())
    }

    /// Writes all layers: those before the last by `middle`, and the last up to `last` passes of each block.
    fn finish(
        &self,
        mut middle: impl FnMut(&mut PacketWriter, u8, &mut Vec<u8>) -> Result<()>,
        last: impl Fn(usize) -> u32,
    ) -> Result<Encoded> {
        let mut writer = self.writer();
        let mut packets = Vec::new();
        let mut layer_ends = Vec::new();
        for layer in 0..self.header.profile.layers - 1 {
            middle(&mut writer, layer, &mut packets)?;
            layer_ends.push(packets.len());
        }
        writer.write(last, &mut packets);
        layer_ends.push(packets.len());
        let bytes = self.header.write(&packets)?;
        let start = bytes.len() - 2 - packets.len();
        layer_ends.iter_mut().for_each(|end| *end += start);
        Ok(Encoded { bytes, profile: self.header.profile.clone(), layer_ends })
    }
}

/// What a next layer would take.
fn size(writer: &PacketWriter, passes: &[u32]) -> usize {
    let mut out = Vec::new();
    writer.clone().write(|block| passes[block], &mut out);
    out.len()
}

impl Component {
    fn new(
        plane: &Plane,
        partition: &Partition,
        transform: Transform,
        levels: u8,
        unit: f64,
        region: Option<&[bool]>,
    ) -> Result<Self> {
        let (width, height) = (plane.shape().width(), plane.shape().height());
        // Samples about zero (Annex G.1).
        let middle = 1 << (plane.depth() - 1);
        let values = plane.samples().iter().map(|s| s - middle);
        let transformed = match transform {
            Transform::Reversible53 => {
                let mut c = Coefficients { width, height, values: values.collect() };
                dwt::forward(&mut c, levels);
                Transformed::Reversible(c)
            }
            Transform::Irreversible97 => {
                let mut c = Coefficients { width, height, values: values.map(|v| v as f32).collect() };
                dwt::forward(&mut c, levels);
                Transformed::Irreversible(c)
            }
        };
        let steps = quantise::steps(transform, &partition.bands, plane.depth(), unit);
        let size = |(step, band)| (1.0 / quantise::size(transform, step, band, plane.depth())) as f32;
        let per_step: Vec<f32> = steps.iter().copied().zip(&partition.bands).map(size).collect();
        let mut component = Self {
            transformed,
            per_step,
            region: region.map(<[bool]>::to_vec),
            shift: 0,
            quantisation: Quantisation { guard: 0, steps },
        };

        // The largest magnitudes of each sub-band decide how many bit-planes the header must state.
        let mut largest = vec![[0u32; 2]; partition.bands.len()];
        for (index, (band, largest)) in partition.bands.iter().zip(&mut largest).enumerate() {
            let whole = Block { band: index, x: band.x, y: band.y, width: band.width, height: band.height };
            component.visit(&whole, width, |_, _, at, _, magnitude, _| {
                let inside = region.is_some_and(|r| r[at]);
                largest[usize::from(inside)] = largest[usize::from(inside)].max(magnitude);
            });
        }
        let [background, inside] = [0, 1].map(|i| largest.iter().map(|l| l[i]).max().unwrap_or(0));
        let planes: Vec<u32> = largest.iter().map(|[a, b]| u32::BITS - (a | b).leading_zeros()).collect();
        // Two guard bits are usual; a region of interest leaves no bit-planes to waste.
        if inside > 0 && background > 0 {
            component.shift = maxshift::shift(inside, background)?;
            component.quantisation = component.quantisation.with_room(&planes, 1);
            maxshift::check_planes(&component.quantisation, component.shift)?;
        } else {
            component.quantisation = component.quantisation.with_room(&planes, 2);
        }
        Ok(component)
    }

    /// Calls `f(row, column, index, negative, magnitude, exact magnitude)` for each coefficient of a block, in steps.
    #[inline(always)]
    fn visit(&self, block: &Block, width: usize, mut f: impl FnMut(usize, usize, usize, bool, u32, f32)) {
        let per_step = self.per_step[block.band];
        for row in 0..block.height {
            let start = (block.y + row) * width + block.x;
            match &self.transformed {
                Transformed::Reversible(c) => {
                    for (column, &v) in c.values[start..][..block.width].iter().enumerate() {
                        f(row, column, start + column, v < 0, v.unsigned_abs(), v.unsigned_abs() as f32);
                    }
                }
                Transformed::Irreversible(c) => {
                    for (column, &v) in c.values[start..][..block.width].iter().enumerate() {
                        let exact = v.abs() * per_step;
                        f(row, column, start + column, v < 0.0, exact as u32, exact);
                    }
                }
            }
        }
    }

    /// A code-block's coefficients, quantised and shifted.
    fn stripes(&self, block: &Block, width: usize, measured: bool) -> Stripes {
        let mut stripes = Stripes::new(block.width, block.height, measured);
        match &self.region {
            Some(region) if self.shift > 0 => self.visit(block, width, |row, column, at, negative, magnitude, exact| {
                let shift = if region[at] { self.shift } else { 0 };
                stripes.set(row, column, negative, magnitude << shift, exact);
            }),
            _ => self.visit(block, width, |row, column, _, negative, magnitude, exact| {
                stripes.set(row, column, negative, magnitude, exact);
            }),
        }
        stripes
    }
}
