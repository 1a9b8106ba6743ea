//! What `gimc encode` can be told about regions of interest.

use clap::Args;
use gimc::{Closer, Limits, Roi, RoiPlace};

use super::failure::Failure;
use super::input;

/// Flags of regions of interest.
#[derive(Debug, Args)]
#[command(next_help_heading = "Regions of interest")]
pub(super) struct RoiFlags {
    /// What matters most: a file of vertices' numbers (from 0), or with `box` and six numbers, or a PNG picture of the square that the
    /// surface is flattened onto; or auto, where normals differ most.
    #[arg(long, value_name = "FILE|auto")]
    roi: Option<String>,
    /// Exact connectivity: bits of the lattice at all corners of its faces; --bits are those of the rest.
    #[arg(long, value_name = "N", requires = "roi", value_parser = clap::value_parser!(u32).range(2..=24))]
    roi_bits: Option<u32>,
    /// gim: the grid's lines are so many times as dense there [default: 2].
    #[arg(long, value_name = "TIMES", requires = "roi", value_parser = super::positive)]
    roi_lines: Option<f64>,
    /// gim: samples move as in paper 000, section 4: the weights of the four parts of the square around the region, and of itself.
    #[arg(long, value_name = "A,B,C,D,E", requires = "roi", conflicts_with = "roi_lines", value_parser = weights)]
    roi_weights: Option<[f64; 5]>,
    /// gim: away from it steps are 2^K times as large; the codec j2k always has 2 [default: 2].
    #[arg(long, value_name = "K", requires = "roi", value_parser = clap::value_parser!(u8).range(0..=8))]
    roi_coarser: Option<u8>,
}

/// Five numbers.
fn weights(text: &str) -> Result<[f64; 5], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|s| s.trim().parse().ok()).collect();
    let numbers = numbers.and_then(|n| <[f64; 5]>::try_from(n).ok());
    numbers
        .filter(|n| n.iter().all(|w| *w > 0.0 && w.is_finite()))
        .ok_or_else(|| "five positive numbers are expected, with commas between".into())
}

/// `auto`, or what a file says.
pub(super) fn place(name: Option<&str>) -> Result<Option<RoiPlace>, Failure> {
    match name {
        None => Ok(None),
        Some("auto") => Ok(Some(RoiPlace::Auto)),
        Some(file) => {
            let bytes = input::bytes(file.as_ref())?;
            RoiPlace::read(&bytes, Limits::default()).map(Some).map_err(|e| Failure::in_file(file, e))
        }
    }
}

impl RoiFlags {
    /// The region, read from its file.
    pub(super) fn region(&self) -> Result<Option<Roi>, Failure> {
        let Some(place) = place(self.roi.as_deref())? else { return Ok(None) };
        let mut roi = Roi::new(place);
        roi.bits = self.roi_bits;
        roi.coarser = self.roi_coarser.unwrap_or(roi.coarser);
        roi.closer = match (self.roi_weights, self.roi_lines) {
            (Some(weights), _) => Closer::Weights(weights),
            (None, Some(times)) => Closer::Lines(times),
            (None, None) => roi.closer,
        };
        Ok(Some(roi))
    }
}
