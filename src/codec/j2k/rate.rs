//! Post-compression rate–distortion optimisation (Annex J.14): how many passes of each code-block each layer holds.
//!
//! The passes of a block make a curve of error against bytes. Only points on its lower convex hull are worth stopping
//! at; there, what is gained per byte (the slope) falls from point to point. A stream that stops in every block
//! at the same slope, in all sub-bands and components, has the least error for its bytes. So one number decides everything,
//! and it is found by bisection over the slopes that occur.

use super::bitplane::CodedBlock;

/// What a stream that stops at a slope takes of one code-block.
#[derive(Clone, Copy, Debug)]
struct Stop {
    /// Error taken away per byte, since the stop before.
    slope: f64,
    /// Passes up to here.
    passes: u32,
    /// Bytes since the stop before.
    bytes: usize,
    /// Error taken away since the stop before.
    gain: f64,
}

/// The convex hulls of all code-blocks.
pub(super) struct Hulls {
    stops: Vec<Vec<Stop>>,
    /// All slopes that occur, steepest first.
    slopes: Vec<f64>,
    /// The error of a stream of no passes.
    energy: f64,
}

/// Regions of interest come first, however little they gain. A power of two, so that it does not round.
const REGION_FIRST: f64 = (1u64 << 60) as f64 * (1u64 << 60) as f64;

/// How a code-block is weighed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weight {
    /// What a squared error of one step counts in the image's error.
    pub(super) error: f64,
    /// What it counts for the choice of passes: the same, times what the caller thinks of it.
    pub(super) importance: f64,
    /// Bit-planes from here up are those of a region of interest.
    pub(super) region: Option<u32>,
}

impl Hulls {
    pub(super) fn new(blocks: &[CodedBlock], weight: impl Fn(usize) -> Weight) -> Self {
        let stops: Vec<Vec<Stop>> = blocks.iter().enumerate().map(|(i, block)| hull(block, weight(i))).collect();
        let mut slopes: Vec<f64> = stops.iter().flatten().map(|s| s.slope).collect();
        slopes.sort_unstable_by(|a, b| b.total_cmp(a));
        slopes.dedup();
        let energy = blocks.iter().enumerate().map(|(i, b)| b.energy * weight(i).error).sum();
        Self { stops, slopes, energy }
    }

    /// How many streams there are to choose from: 0 has no pass at all, each next one has more, this one has all that gain.
    pub(super) fn choices(&self) -> usize {
        self.slopes.len()
    }

    fn taken(&self, block: usize, choice: usize) -> &[Stop] {
        let stops = &self.stops[block];
        match choice.checked_sub(1).map(|i| self.slopes[i]) {
            Some(least) => &stops[..stops.partition_point(|s| s.slope >= least)],
            None => &[],
        }
    }

    /// The passes of each code-block in a stream.
    pub(super) fn passes(&self, choice: usize) -> Vec<u32> {
        (0..self.stops.len()).map(|block| self.taken(block, choice).last().map_or(0, |s| s.passes)).collect()
    }

    /// The steps, steepest first, that a stream has not taken: a block, and how many passes it would then have.
    pub(super) fn after(&self, choice: usize) -> impl Iterator<Item = (usize, u32)> {
        let first = self.stops.iter().enumerate().filter_map(|(block, stops)| {
            let next = stops.get(self.taken(block, choice).len())?;
            Some((next.slope, block, next.passes))
        });
        let mut first: Vec<_> = first.collect();
        first.sort_by(|a, b| b.0.total_cmp(&a.0));
        first.into_iter().map(|(_, block, passes)| (block, passes))
    }

    /// The bytes of a stream without its headers.
    #[cfg(test)]
    fn bytes(&self, choice: usize) -> usize {
        (0..self.stops.len()).flat_map(|block| self.taken(block, choice)).map(|s| s.bytes).sum()
    }

    /// The error that a stream leaves.
    pub(super) fn error(&self, choice: usize) -> f64 {
        let gained: f64 = (0..self.stops.len()).flat_map(|block| self.taken(block, choice)).map(|s| s.gain).sum();
        self.energy - gained
    }
}

/// The lower convex hull of a code-block's error against bytes.
fn hull(block: &CodedBlock, weight: Weight) -> Vec<Stop> {
    let mut stops: Vec<Stop> = Vec::new();
    let mut length = 0;
    for (i, pass) in block.passes.iter().enumerate() {
        let first = weight.region.is_some_and(|lowest| pass.plane >= lowest);
        let importance = weight.importance * if first { REGION_FIRST } else { 1.0 };
        let mut worth = pass.gain * importance;
        let mut stop = Stop { slope: 0.0, passes: i as u32 + 1, bytes: pass.length - length, gain: pass.gain * weight.error };
        length = pass.length;
        // A stop that gains less per byte than the next one is not on the hull: go on to the next.
        loop {
            // A pass without bytes costs nothing, but a header may grow: count it as a small part of a byte.
            stop.slope = worth / (stop.bytes as f64).max(1.0 / 64.0);
            match stops.last() {
                Some(last) if last.slope <= stop.slope => {
                    worth += last.slope * (last.bytes as f64).max(1.0 / 64.0);
                    stop.bytes += last.bytes;
                    stop.gain += last.gain;
                    stops.pop();
                }
                _ => break,
            }
        }
        stops.push(stop);
    }
    // What gains nothing is not worth a byte.
    stops.truncate(stops.partition_point(|s| s.slope > 0.0));
    stops
}

/// The largest `choice` of 0 to `choices` for which `fits` holds, which it does up to some choice and not beyond.
pub(super) fn last_that_fits(choices: usize, mut fits: impl FnMut(usize) -> bool) -> Option<usize> {
    let (mut low, mut high) = (0, choices + 1);
    while low < high {
        let middle = low.midpoint(high);
        if fits(middle) {
            low = middle + 1
        } else {
            high = middle
        }
        if low > choices {
            break;
        }
    }
    low.checked_sub(1)
}

#[cfg(test)]
mod tests {
    use super::super::bitplane::Pass;
    use super::*;
    use proptest::prelude::*;

    fn block(passes: &[(usize, f64)]) -> CodedBlock {
        let mut length = 0;
        let passes = passes
            .iter()
            .map(|&(bytes, gain)| {
                length += bytes;
                Pass { length, plane: 0, gain }
            })
            .collect();
        CodedBlock { planes: 1, passes, bytes: vec![0; length], energy: 1000.0 }
    }

    const PLAIN: Weight = Weight { error: 1.0, importance: 1.0, region: None };

    proptest! {
        #[test]
        fn no_choice_of_passes_of_as_few_bytes_has_less_error(
            a in prop::collection::vec((0usize..9, -3.0..20.0f64), 0..6),
            b in prop::collection::vec((0usize..9, -3.0..20.0f64), 0..6),
        ) {
            let blocks = [block(&a), block(&b)];
            let hulls = Hulls::new(&blocks, |_| PLAIN);
            // All pairs of truncation points.
            let mut all = Vec::new();
            for i in 0..=a.len() {
                for j in 0..=b.len() {
                    let taken = a[..i].iter().chain(&b[..j]);
                    let (bytes, gain) = taken.fold((0, 0.0), |(n, g), &(bytes, gain)| (n + bytes, g + gain));
                    all.push((bytes, 2000.0 - gain));
                }
            }
            for choice in 0..=hulls.choices() {
                let (bytes, error) = (hulls.bytes(choice), hulls.error(choice));
                let best = all.iter().filter(|s| s.0 < bytes).map(|s| s.1).fold(f64::INFINITY, f64::min);
                prop_assert!(error <= best + 1e-6, "{} bytes leave {}, and fewer could leave {}", bytes, error, best);
                let passes = hulls.passes(choice);
                prop_assert!(passes[0] as usize <= a.len() && passes[1] as usize <= b.len());
            }
        }
    }

    #[test]
    fn the_planes_of_a_region_come_before_all_others() {
        let mut inside = block(&[(100, 0.001), (1, 500.0)]);
        inside.passes[0].plane = 9;
        let blocks = [block(&[(1, 900.0)]), inside];
        let hulls = Hulls::new(&blocks, |_| Weight { region: Some(5), ..PLAIN });
        assert_eq!(hulls.passes(1), [0, 1]);
        assert_eq!(hulls.passes(3), [1, 2]);
    }

    #[test]
    fn bisection_finds_the_last_that_fits() {
        for choices in 0..9 {
            for last in 0..=choices {
                assert_eq!(last_that_fits(choices, |c| c <= last), Some(last));
            }
            assert_eq!(last_that_fits(choices, |_| false), None);
        }
    }
}
