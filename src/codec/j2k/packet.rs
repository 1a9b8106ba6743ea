//! Packets (Annex B.9 and B.10): what one layer adds to one precinct of one resolution of one component.
//!
//! The header tells, for each code-block, whether it is in this packet (a tag tree until it first is, one bit after
//! that), how many of its bit-planes are zero (a tag tree), how many passes are added (Table B.4) and how many bytes
//! they take (Lblock). The body is those bytes.

use super::bitplane::CodedBlock;
use super::partition::{BlockGrid, Partition};
use super::tag_tree::TagTree;

/// Packs bits from the highest down, with a zero bit after a byte of ones (B.10.1).
#[derive(Default)]
pub(super) struct BitWriter {
    bytes: Vec<u8>,
    current: u8,
    used: u8,
}

impl BitWriter {
    pub(super) fn bit(&mut self, bit: u32) {
        let room = if self.bytes.last() == Some(&0xff) { 7 } else { 8 };
        self.current = self.current << 1 | bit as u8;
        self.used += 1;
        if self.used == room {
            self.bytes.push(self.current);
            (self.current, self.used) = (0, 0);
        }
    }

    fn bits(&mut self, value: u32, count: u32) {
        for i in (0..count).rev() {
            self.bit(value >> i & 1);
        }
    }

    /// All bytes, the last one filled up with zeros; a packet header never ends in 0xff.
    fn finish(mut self) -> Vec<u8> {
        while self.used != 0 || self.bytes.last() == Some(&0xff) {
            self.bit(0);
        }
        self.bytes
    }

    #[cfg(test)]
    pub(super) fn text(&self) -> String {
        let whole: String = self.bytes.iter().map(|b| format!("{b:08b}")).collect();
        let stuffed = if self.used > 0 && self.bytes.last() == Some(&0xff) { "0" } else { "" };
        whole + stuffed + &(0..self.used).rev().map(|i| if self.current >> i & 1 == 1 { '1' } else { '0' }).collect::<String>()
    }
}

/// Table B.4: the codeword for a number of coding passes, 1 to 164.
fn write_passes(passes: u32, out: &mut BitWriter) {
    match passes {
        1 => out.bit(0),
        2 => out.bits(0b10, 2),
        3..=5 => out.bits(0b1100 + passes - 3, 4),
        6..=36 => out.bits(0b1111 << 5 | (passes - 6), 9),
        _ => out.bits(0b1_1111_1111 << 7 | (passes - 37), 16),
    }
}

/// Writes the packets of one layer after another, in the order layer, resolution, component, precinct (LRCP).
///
/// What runs from layer to layer (what the tag trees have said, Lblock, passes sent) is its state: a clone of it may
/// try a layer, to see how many bytes it takes.
#[derive(Clone)]
pub(super) struct PacketWriter<'a> {
    blocks: &'a [CodedBlock],
    sent: Vec<Sent>,
    grids: Vec<Grid>,
    /// How many of `grids`, one a sub-band, each packet has.
    packets: Vec<usize>,
    layer: u32,
}

/// What was sent of a code-block.
#[derive(Clone, Copy)]
struct Sent {
    passes: u32,
    bytes: usize,
    lblock: u32,
}

/// The code-blocks of a sub-band in a precinct of a component.
#[derive(Clone)]
struct Grid {
    /// Index of its first block in `blocks`.
    first: usize,
    across: usize,
    down: usize,
    inclusion: TagTree,
    zero_planes: TagTree,
}

impl<'a> PacketWriter<'a> {
    /// `blocks` are those of the partition, for one component after another; `planes` has for each component and each
    /// sub-band the number of bit-planes that the headers state (Mb, of Equation E-2, with the shift of Annex H).
    pub(super) fn new(partition: &Partition, blocks: &'a [CodedBlock], planes: &[Vec<u32>]) -> Self {
        let mut grids = Vec::new();
        let mut packets = Vec::new();
        let mut first_band = 0;
        for precincts in &partition.resolutions {
            for (component, planes) in planes.iter().enumerate() {
                for precinct in precincts {
                    let bands = precinct.iter().zip(&planes[first_band..]);
                    let offset = component * partition.blocks.len();
                    grids.extend(bands.map(|(grid, &planes)| Grid::new(grid, offset, blocks, planes)));
                    packets.push(precinct.len());
                }
            }
            first_band += precincts[0].len();
        }
        Self { blocks, sent: vec![Sent { passes: 0, bytes: 0, lblock: 3 }; blocks.len()], grids, packets, layer: 0 }
    }

    /// Appends the packets of the next layer, which brings each block up to `cut` passes in all.
    pub(super) fn write(&mut self, cut: impl Fn(usize) -> u32, out: &mut Vec<u8>) {
        let mut grids = self.grids.as_mut_slice();
        for &count in &self.packets {
            let mut header = BitWriter::default();
            let packet;
            (packet, grids) = std::mem::take(&mut grids).split_at_mut(count);
            let added = |block: usize| cut(block) > self.sent[block].passes;
            if packet.iter().any(|grid| grid.blocks().any(added)) {
                header.bit(1);
                for grid in packet.iter_mut() {
                    grid.write_header(self.layer, self.blocks, &mut self.sent, &cut, &mut header);
                }
            } else {
                header.bit(0);
            }
            out.append(&mut header.finish());
            for block in packet.iter().flat_map(|grid| grid.blocks()) {
                let passes = cut(block);
                let sent = &mut self.sent[block];
                if passes > sent.passes {
                    let end = self.blocks[block].passes[passes as usize - 1].length;
                    out.extend_from_slice(&self.blocks[block].bytes[sent.bytes..end]);
                    (sent.passes, sent.bytes) = (passes, end);
                }
            }
        }
        self.layer += 1;
    }
}

impl Grid {
    fn new(grid: &BlockGrid, offset: usize, blocks: &[CodedBlock], planes: u32) -> Self {
        let (across, down) = (grid.across, grid.down);
        let first = offset + grid.first;
        let mut zero_planes = TagTree::new(across, down);
        for i in 0..across * down {
            zero_planes.set(i % across, i / across, planes - blocks[first + i].planes);
        }
        Self { first, across, down, inclusion: TagTree::new(across, down), zero_planes }
    }

    fn blocks(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.across * self.down
    }

    /// The part of a packet header that tells of this sub-band.
    fn write_header(
        &mut self,
        layer: u32,
        blocks: &[CodedBlock],
        sent: &mut [Sent],
        cut: &impl Fn(usize) -> u32,
        out: &mut BitWriter,
    ) {
        let range = self.blocks();
        for block in range.clone() {
            let i = block - range.start;
            if sent[block].passes == 0 && cut(block) > 0 {
                self.inclusion.set(i % self.across, i / self.across, layer);
            }
        }
        for block in range.clone() {
            let i = block - range.start;
            let (x, y) = (i % self.across, i / self.across);
            let Sent { passes: before, bytes, lblock } = sent[block];
            let passes = cut(block);
            if before == 0 {
                self.inclusion.encode(x, y, layer + 1, out);
            } else {
                out.bit(u32::from(passes > before));
            }
            if passes <= before {
                continue;
            }
            if before == 0 {
                self.zero_planes.tell(x, y, out);
            }
            let added = passes - before;
            write_passes(added, out);
            let length = (blocks[block].passes[passes as usize - 1].length - bytes) as u32;
            // B.10.7.1: the length has Lblock + floor(log2(passes added)) bits; ones raise Lblock.
            let needed = u32::BITS - length.leading_zeros();
            let enough = lblock.max(needed.saturating_sub(added.ilog2()));
            for _ in lblock..enough {
                out.bit(1);
            }
            out.bit(0);
            out.bits(length, enough + added.ilog2());
            sent[block].lblock = enough;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_passes_are_written_as_in_table_b_4() {
        for (passes, expected) in [
            (1, "0"),
            (2, "10"),
            (3, "1100"),
            (5, "1110"),
            (6, "111100000"),
            (36, "111111110"),
            (37, "1111111110000000"),
            (164, "1111111111111111"),
        ] {
            let mut out = BitWriter::default();
            write_passes(passes, &mut out);
            // A byte of ones is followed by a stuffed zero.
            let mut plain = out.text();
            if plain.starts_with("11111111") && plain.len() > 8 {
                assert_eq!(plain.remove(8), '0');
            }
            assert_eq!(plain, expected, "{passes} passes");
        }
    }

    #[test]
    fn a_header_does_not_end_in_a_byte_of_ones() {
        let mut out = BitWriter::default();
        out.bits(0xff, 8);
        assert_eq!(out.finish(), [0xff, 0x00]);
        let mut out = BitWriter::default();
        out.bits(0x7ff, 11);
        assert_eq!(out.finish(), [0xff, 0b0111_0000]);
    }
}
