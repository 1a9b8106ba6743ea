//! What a writer and a reader must find alike, number by number.

use super::super::stretch::{Coarse, Sliding, Stretch};
use super::super::topology::Filled;
use super::super::{Census, Effort, original::Original, walk};
use super::*;
use crate::entropy::{BitReader, BitWriter};
use crate::limits::{Budget, Limits};
use crate::mesh::HalfEdges;

/// A coder whose predictions are kept (a writer), or compared with those that were (a reader).
struct Watched<'a, C> {
    coder: C,
    kept: Vec<u64>,
    expected: Option<&'a [u64]>,
}

impl<C: BitCoder> BitCoder for Watched<'_, C> {
    const WRITES: bool = C::WRITES;

    fn code(&mut self, decision: bool, p: u32) -> bool {
        self.coder.code(decision, p)
    }

    fn is_exhausted(&self) -> bool {
        self.coder.is_exhausted()
    }

    fn watch(&mut self, found: impl FnOnce() -> f64) {
        let found = found();
        if let Some(expected) = self.expected {
            let wanted = expected[self.kept.len()];
            assert_eq!(found.to_bits(), wanted, "prediction {}: {found} and {}", self.kept.len(), f64::from_bits(wanted));
        }
        self.kept.push(found.to_bits());
    }
}

fn code<C: BitCoder>(coder: &mut C, effort: Effort, stretch: Stretch<'_>, positions: &mut [[i32; 3]]) {
    let degrees = Degrees::new(stretch.surface);
    let code = if effort == Effort::Best { code_full } else { code_lean };
    code(coder, stretch, &degrees, positions, Task::default()).unwrap();
}

#[test]
fn a_reader_predicts_bit_for_bit_what_the_writer_did() {
    for (i, shape) in
        [corpus_make::bumpy_sphere(600, 3), corpus_make::torus_with_holes(500, 2, 2), corpus_make::genus(600, 2, 3)]
            .into_iter()
            .enumerate()
    {
        let lattice: Vec<[i32; 3]> =
            shape.positions.iter().map(|p| p.map(|x| ((x + 4.0) * 256.0).clamp(0.0, 2047.0) as i32)).collect();
        let half_edges = HalfEdges::new(lattice.len(), shape.triangles.clone()).unwrap();
        let filled = Filled::new(&half_edges);
        let census: Census = filled.census;
        let mut guide = Original::new(&filled);
        let mut budget = Budget::new(Limits::default());
        let surface =
            walk::walk(&mut BitWriter::default(), &mut guide, census, Effort::Default, &mut budget, Task::default()).unwrap();
        let outgoing = surface.outgoing();
        let mut order = guide.order.iter();
        let fine: Vec<[i32; 3]> =
            surface.is_hole.iter().map(|&hole| if hole { [0; 3] } else { lattice[*order.next().unwrap() as usize] }).collect();
        let cells: Vec<[i32; 3]> = fine.iter().map(|p| p.map(|x| x >> 2)).collect();
        for effort in [Effort::Default, Effort::Best] {
            for staged in [false, true] {
                let stretch = Stretch {
                    surface: &surface,
                    outgoing: &outgoing,
                    range: 0..fine.len() as u32,
                    extent: [2047; 3],
                    palettes: [i == 1, false, i == 2],
                    coarse: staged.then_some(Coarse { shift: 2, positions: &cells }),
                    sliding: None,
                };
                let mut writer = Watched { coder: BitWriter::default(), kept: Vec::new(), expected: None };
                code(&mut writer, effort, stretch.clone(), &mut fine.clone());
                let bytes = writer.coder.finish();
                assert!(writer.kept.len() > 10 * lattice.len());
                let mut reader = Watched { coder: BitReader::new(&bytes), kept: Vec::new(), expected: Some(&writer.kept) };
                let mut read = vec![[0; 3]; fine.len()];
                code(&mut reader, effort, stretch, &mut read);
                assert_eq!(read, fine);
                assert_eq!(reader.kept.len(), writer.kept.len());
            }
        }
    }
}

#[test]
fn a_reader_finds_the_places_to_which_the_writer_let_vertices_slide() {
    let shapes = [
        corpus_make::bumpy_sphere(600, 3),
        corpus_make::torus_with_holes(500, 2, 2),
        corpus_make::genus(600, 2, 3),
        corpus_make::block(300),
        flattened(corpus_make::bumpy_sphere(200, 1), 0.0),
        flattened(corpus_make::grid(60), 1e-9),
    ];
    for (i, shape) in shapes.into_iter().enumerate() {
        let half_edges = HalfEdges::new(shape.positions.len(), shape.triangles.clone()).unwrap();
        let filled = Filled::new(&half_edges);
        let (_, walked) = super::super::trace(&filled, Effort::Default, Task::default()).unwrap();
        let surface = &walked.surface;
        let outgoing = surface.outgoing();
        let mut order = walked.order.iter();
        let points: Vec<[f64; 3]> = surface
            .is_hole
            .iter()
            .map(
                |&hole| {
                    if hole { [0.0; 3] } else { shape.positions[*order.next().unwrap() as usize].map(|x| (x + 4.0) * 20.0) }
                },
            )
            .collect();
        let widest = points.iter().flatten().fold(0.0_f64, |most, x| most.max(*x));
        let points: Vec<[f64; 3]> = points.into_iter().map(|p| p.map(|x| x.max(0.0) * 200.0 / widest)).collect();
        let extent = [200 * 16; 3];
        let holds = (0..points.len()).map(|v| [Hold::Point, Hold::Planes, Hold::Free, Hold::Free][v % 4]).collect();
        let aim = Aim::new(surface, points.clone(), holds, 1.5);
        for effort in [Effort::Default, Effort::Best] {
            for fine in [false, true] {
                let stretch = |aim| Stretch {
                    surface,
                    outgoing: &outgoing,
                    range: 0..points.len() as u32,
                    extent,
                    palettes: [false; 3],
                    coarse: None,
                    sliding: Some(Sliding { fine, longest: if fine { 3 } else { LONGEST_STRETCH }, aim }),
                };
                let mut writer = Watched { coder: BitWriter::default(), kept: Vec::new(), expected: None };
                let mut written = vec![[0; 3]; points.len()];
                code(&mut writer, effort, stretch(Some(&aim)), &mut written);
                let bytes = writer.coder.finish();
                let mut reader = Watched { coder: BitReader::new(&bytes), kept: Vec::new(), expected: Some(&writer.kept) };
                let mut read = vec![[0; 3]; points.len()];
                code(&mut reader, effort, stretch(None), &mut read);
                assert_eq!(read, written, "shape {i}");
                // On average vertices are no more than two steps from where they were, plus what they may slide.
                let far: Vec<f64> = (0..points.len())
                    .filter(|&v| !surface.is_hole[v])
                    .map(|v| (Vector(written[v].map(|x| f64::from(x) / PARTS)) - Vector(points[v])).length())
                    .collect();
                let mean = far.iter().sum::<f64>() / far.len() as f64;
                assert!(mean < 6.0, "shape {i}: moved by {mean} steps");
            }
        }
    }
}

/// The shape with all faces as thin as this: frames without a normal, and without a tangent.
fn flattened(mut shape: corpus_make::Shape, height: f64) -> corpus_make::Shape {
    shape.positions.iter_mut().for_each(|p| *p = [p[0], height * p[1], height * p[2]]);
    shape
}
