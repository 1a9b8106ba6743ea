//! Targets: how much of what was coded a stream of so many bytes, or of such a quality, holds, and how layers share it.

use super::codestream::Transform;
use super::encode::{Coded, DEFAULT_UNIT, Encoded, Quality, Settings};
use super::packet::PacketWriter;
use super::rate::{Hulls, last_that_fits};
use crate::error::{Error, Result};
use crate::limits::{Budget, Limits};
use crate::plane::{Plane, Planes};
use crate::task::Task;

/// Below this the rounding of samples to integers is all that is left of the error.
const FINEST_UNIT: f64 = 1.0 / 16.0;
/// Above this the deepest samples have a handful of steps left.
pub(super) const COARSEST_UNIT: f64 = 1024.0;
/// How many single steps are tried for the last bytes of a rate.
const FILLING: usize = 24;
/// How often a stream is decoded to correct the aim.
const ATTEMPTS: usize = 8;
/// A mean squared error this near to the allowed one (0.03 dB) is near enough.
const NEAR_ENOUGH: f64 = 0.993;

/// Lowers the error until the decoded planes have the psnr that is asked for.
pub(super) fn reach(planes: &Planes, settings: &Settings, psnr: f64, task: &Task) -> Result<Encoded> {
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

impl Coded {
    /// The stream that reaches what is asked for.
    pub(super) fn pack(&self, settings: &Settings, quality: Quality) -> Result<Encoded> {
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
}

/// What a next layer would take.
fn size(writer: &PacketWriter, passes: &[u32]) -> usize {
    let mut out = Vec::new();
    writer.clone().write(|block| passes[block], &mut out);
    out.len()
}

/// The largest sample of a depth.
pub(super) fn peak(depth: u8) -> f64 {
    f64::from((1u32 << depth) - 1)
}

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

fn decode_all(encoded: &Encoded) -> Result<Planes> {
    let unlimited = Limits::default().memory(u64::MAX).pixels(u64::MAX).work(u64::MAX);
    super::decode(&encoded.bytes, &encoded.profile, &mut Budget::new(unlimited))
}

/// The mean squared error relative to each component's peak.
fn error(a: &Planes, b: &Planes) -> f64 {
    let of = |(a, b): (&Plane, &Plane)| {
        let squares = a.samples().iter().zip(b.samples()).map(|(x, y)| f64::from(x - y) * f64::from(x - y));
        squares.sum::<f64>() / (peak(a.depth()) * peak(a.depth()))
    };
    a.iter().zip(b.iter()).map(of).sum::<f64>() / (a.len() * a.shape().pixels()) as f64
}

/// The peak signal-to-noise ratio that [`Quality::Psnr`] means, in dB; infinite for equal planes.
#[cfg(any(test, feature = "inner"))]
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
