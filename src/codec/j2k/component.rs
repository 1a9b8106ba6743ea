//! One component on its way to code-blocks: transformed, quantised, and shifted where its region of interest is.

use super::bitplane::Stripes;
use super::codestream::Transform;
use super::dwt::{self, Coefficients};
use super::maxshift;
use super::partition::{Block, Partition};
use super::quantise::{self, Quantisation};
use crate::error::Result;
use crate::plane::Plane;

/// The coefficients of one component after the transform.
enum Transformed {
    Reversible(Coefficients<i32>),
    Irreversible(Coefficients<f32>),
}

/// A component, transformed.
pub(super) struct Component<'a> {
    transformed: Transformed,
    width: usize,
    /// One a sub-band: what a coefficient is multiplied by to count steps.
    per_step: Vec<f32>,
    /// Which coefficients are those of the region of interest.
    region: Option<&'a [bool]>,
    /// By how many bits they are shifted up; 0 if there is nothing to tell them from.
    pub(super) shift: u8,
    /// Whether any of them is not zero.
    pub(super) has_region: bool,
    pub(super) quantisation: Quantisation,
}

impl<'a> Component<'a> {
    /// Transforms a plane into the sub-bands of the partition, and decides how they are quantised and shifted.
    ///
    /// An error of one step costs as much as an error of `unit` in one sample.
    pub(super) fn new(
        plane: &Plane,
        partition: &Partition,
        transform: Transform,
        unit: f64,
        region: Option<&'a [bool]>,
    ) -> Result<Self> {
        let (width, height) = (plane.shape().width(), plane.shape().height());
        let levels = partition.levels();
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
            width,
            per_step,
            region,
            shift: 0,
            has_region: false,
            quantisation: Quantisation { guard: 0, steps },
        };

        // The largest magnitudes of each sub-band decide how many bit-planes the header must state.
        let mut largest = vec![[0u32; 2]; partition.bands.len()];
        for (index, (band, largest)) in partition.bands.iter().zip(&mut largest).enumerate() {
            let whole = Block { band: index, x: band.x, y: band.y, width: band.width, height: band.height };
            component.visit(&whole, |_, _, at, _, magnitude, _| {
                let inside = region.is_some_and(|r| r[at]);
                largest[usize::from(inside)] = largest[usize::from(inside)].max(magnitude);
            });
        }
        let [background, inside] = [0, 1].map(|i| largest.iter().map(|l| l[i]).max().unwrap_or(0));
        let planes: Vec<u32> = largest.iter().map(|[a, b]| u32::BITS - (a | b).leading_zeros()).collect();
        component.has_region = inside > 0;
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
    fn visit(&self, block: &Block, mut f: impl FnMut(usize, usize, usize, bool, u32, f32)) {
        let per_step = self.per_step[block.band];
        for row in 0..block.height {
            let start = (block.y + row) * self.width + block.x;
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

    /// A code-block's coefficients, quantised and shifted; `measured` if distortions will be asked for.
    pub(super) fn stripes(&self, block: &Block, measured: bool) -> Stripes {
        let mut stripes = Stripes::new(block.width, block.height, measured);
        match self.region {
            Some(region) if self.shift > 0 => self.visit(block, |row, column, at, negative, magnitude, exact| {
                let shift = if region[at] { self.shift } else { 0 };
                stripes.set(row, column, negative, magnitude << shift, exact);
            }),
            _ => self.visit(block, |row, column, _, negative, magnitude, exact| {
                stripes.set(row, column, negative, magnitude, exact);
            }),
        }
        stripes
    }
}
