//! The encoder from end to end: planes to a codestream.

use super::bitplane::{self, BlockStyle, CodedBlock};
use super::codestream::{Header, Profile, Transform};
use super::component::Component;
use super::maxshift;
use super::packet::PacketWriter;
use super::partition::{self, Partition};
use super::quantise;
use super::rate::{Hulls, Weight};
use super::target::{COARSEST_UNIT, peak, reach};
use super::weigh::Covered;
use super::{MAX_DEPTH, MAX_LAYERS, MAX_LEVELS};
use crate::error::{Error, Result};
use crate::par;
use crate::plane::{Mask, Planes};
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
    /// How much an error in each pixel counts when bytes are shared out, row by row: what the pixel stands for. It is
    /// averaged over what each code-block covers. Default: 1 for all.
    pub(crate) pixel_weights: Option<&'a [f32]>,
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
            pixel_weights: None,
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
    #[cfg(test)]
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
pub(super) const DEFAULT_UNIT: f64 = 1.0;

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
    if let Some(weights) = settings.pixel_weights {
        if weights.len() != planes.shape().pixels() {
            return refuse(format!("{} weights for an image of {}", weights.len(), planes.shape()));
        }
        if let Some(weight) = weights.iter().find(|w| !(0.0..=1e9).contains(*w)) {
            return refuse(format!("a pixel's weight of {weight}; it must be between 0 and 1e9"));
        }
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

/// All code-blocks of all components, coded in full; what of them is sent is decided afterwards.
pub(super) struct Coded {
    pub(super) header: Header,
    partition: Partition,
    /// One component after another.
    pub(super) blocks: Vec<CodedBlock>,
    /// One a block.
    weights: Vec<Weight>,
    measured: bool,
}

impl Coded {
    /// Codes everything; an error of one quantiser step costs as much as an error of `unit` in one sample.
    pub(super) fn new(planes: &Planes, settings: &Settings, unit: f64, task: &Task) -> Result<Self> {
        let shape = planes.shape();
        let levels = settings.levels.min(partition::most_levels(shape));
        let partition = Partition::new(shape, levels, settings.block);
        let region = settings.region.map(|mask| maxshift::coefficients(mask, settings.transform, levels));
        task.step(0.02)?;
        let mut unit = unit;
        let components = loop {
            let components: Result<Vec<Component>> =
                par::map(planes.len(), |i| Component::new(&planes[i], &partition, settings.transform, unit, region.as_deref()))
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
            bitplane::encode(&component.stripes(block, measured), style)
        });
        task.step(0.9)?;

        let covered = settings.pixel_weights.map(|weights| Covered::new(weights, shape));
        let weights = (0..blocks.len())
            .map(|i| {
                let (component, block) = (i / per_component, &partition.blocks[i % per_component]);
                let Component { quantisation, shift, has_region, .. } = &components[component];
                let band = &partition.bands[block.band];
                let depth = planes[component].depth();
                let step = quantise::size(settings.transform, quantisation.steps[block.band], band, depth);
                let norm = quantise::norm(settings.transform, band) * step / peak(depth);
                let error = norm * norm / (shape.pixels() * components.len()) as f64;
                let pixels = covered.as_ref().map_or(1.0, |covered| covered.mean(block, band));
                let weight = settings.weights.get(component).copied().unwrap_or(1.0) * pixels;
                Weight { error, importance: error * weight, region: has_region.then_some((*shift).into()) }
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

    pub(super) fn hulls(&self) -> Hulls {
        debug_assert!(self.measured);
        Hulls::new(&self.blocks, |i| self.weights[i])
    }

    pub(super) fn writer(&self) -> PacketWriter<'_> {
        PacketWriter::new(&self.partition, &self.blocks, &self.header.planes())
    }

    /// Bytes of a codestream without its packets.
    pub(super) fn overhead(&self) -> Result<usize> {
        Ok(self.header.write(&[])?.len())
    }

    /// Writes all layers: those before the last by `middle`, and the last up to `last` passes of each block.
    pub(super) fn finish(
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
