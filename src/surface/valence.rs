//! Valences: how many neighbours a vertex has, guessed from the part of the surface already known.

use super::Effort;
use super::topology::Surface;
use crate::entropy::{BitCoder, Mixer, MixerOptions, Start, hash};

/// What is known around a vertex when it is met beyond a gate.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Neighbourhood {
    /// The vertices of the gate.
    pub(super) ends: [Option<u32>; 2],
    /// The third vertex of the known face at the gate.
    pub(super) old: Option<u32>,
    /// The vertices before and after the gate on its loop.
    pub(super) beside: [Option<u32>; 2],
    /// The vertices before and after those.
    pub(super) beyond: [Option<u32>; 2],
    /// Missing edges: at the two ends of the gate, then at the nodes beside it.
    pub(super) free: [u32; 4],
}

/// Codes valences with 4, 8 or 24 contexts, as the effort has it.
pub(super) enum Valences {
    Four(Model<4>),
    Eight(Model<8>),
    TwentyFour(Model<24>),
}

pub(super) struct Model<const N: usize> {
    mixer: Mixer<N, 0>,
    /// The last eight valences, four bits each.
    history: u32,
}

/// A valence above 15 counts as 14, and one of a hole vertex as 15, in contexts.
const HOLE: u32 = 15;

impl Valences {
    pub(super) fn new(effort: Effort, vertices: u64) -> Self {
        match effort {
            Effort::Fast => Self::Four(Model::new(vertices)),
            Effort::Default => Self::Eight(Model::new(vertices)),
            Effort::Best => Self::TwentyFour(Model::new(vertices)),
        }
    }

    /// Codes a valence between 2 and `most`.
    pub(super) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        valence: u32,
        most: u64,
        around: &Neighbourhood,
        surface: &Surface,
    ) -> u32 {
        match self {
            Self::Four(model) => model.code(coder, valence, most, around, surface),
            Self::Eight(model) => model.code(coder, valence, most, around, surface),
            Self::TwentyFour(model) => model.code(coder, valence, most, around, surface),
        }
    }
}

impl<const N: usize> Model<N> {
    fn new(vertices: u64) -> Self {
        let options = MixerOptions {
            lines_log2: (vertices.max(1).ilog2()).clamp(6, 12),
            rate_shift: if N <= 4 { 5 } else { 6 },
            count_limit: 400,
        };
        Self { mixer: Mixer::new(options, &[Start::even(120 / N as i32); 16]), history: 0 }
    }

    /// Decisions: is it 6? less? then 5, 4, 3 (else 2); or 7, 8, 9, …
    fn code<C: BitCoder>(&mut self, coder: &mut C, valence: u32, most: u64, around: &Neighbourhood, surface: &Surface) -> u32 {
        let contexts = contexts(around, surface, self.history);
        let set = around.free[1].min(15) as usize;
        let mut chosen = [0; N];
        chosen.copy_from_slice(&contexts[..N]);
        self.mixer.choose(chosen, set);
        let mut is = |decision, node| self.mixer.code(coder, decision, node, []);
        let valence = if is(valence == 6, 0) {
            6
        } else if is(valence < 6, 1) {
            (3..=5).rev().zip(2..).find(|&(v, node)| is(valence == v, node)).map_or(2, |(v, _)| v)
        } else {
            let mut v = 7;
            while u64::from(v) < most && !is(valence == v, (v as usize - 2).min(15)) {
                v += 1;
            }
            v
        };
        self.history = self.history << 4 | valence.min(14);
        valence
    }
}

/// The contexts, the most useful first: four of them lose 2.4 % of the connectivity, eight 1.4 %.
#[inline]
fn contexts(around: &Neighbourhood, surface: &Surface, history: u32) -> [u32; 24] {
    let valence = |v: Option<u32>| match v {
        None => 0,
        Some(v) if surface.is_hole[v as usize] => HOLE,
        Some(v) => surface.valence[v as usize].min(14),
    };
    let [a, b] = around.ends.map(valence);
    let o = valence(around.old);
    let [p, n] = around.beside.map(valence);
    let [pp, nn] = around.beyond.map(valence);
    let [fa, fb, fp, fn_] = around.free.map(|free| free.min(15));
    let ab = a << 4 | b;
    let abo = ab << 4 | o;
    let pn = p << 4 | n;
    let free_ab = fa << 4 | fb;
    let free_pn = fp << 4 | fn_;
    let abopn = abo << 8 | pn;
    let sum = a + b + o;
    [
        abo,
        free_pn << 8 | free_ab,
        history & 0xfff,
        abopn,
        ab,
        free_ab << 8 | ab,
        (history & 0xff) << 8 | ab,
        abopn << 8 | pp << 4 | nn,
        0,
        free_ab,
        sum,
        sum + p + n,
        pn,
        history & 0xff,
        history & 0xff_ffff,
        ab << 8 | pn,
        b << 8 | n << 4 | fb,
        a << 8 | p << 4 | fa,
        o << 4 | fb,
        a << 8 | fa << 4 | o,
        sum << 4 | history & 0xf,
        free_pn,
        hash(n << 12 | nn << 8 | b << 4 | fn_, 23),
        history,
    ]
}
