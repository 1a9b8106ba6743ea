//! Names on stretches of faces: objects, groups, materials, smoothing groups (spec/any-mesh.md, "LABL").
//!
//! Labels cut the faces of a mesh into stretches. As the order of faces is not kept, each face tells its stretch; the
//! reader then puts the faces of a stretch together. Neighbours in the walk and across edges mostly share it.

use std::collections::HashMap;

use super::neighbour::LastFaces;
use crate::entropy::{AdaptiveBit, BitCoder, BitReader, BitWriter, Numbers};
use crate::error::{Error, Place, Result};
use crate::limits::Budget;
use crate::mesh::{Faces, Label, LabelKind};

const KINDS: [LabelKind; 5] =
    [LabelKind::Object, LabelKind::Group, LabelKind::Material, LabelKind::Smoothing, LabelKind::MaterialLibrary];

/// Labels, and the stretch of every face. A label's `first_face` is here the stretch that it begins.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct Labelling {
    labels: Vec<Label>,
    stretch: Vec<u32>,
}

impl Labelling {
    /// The labels of a mesh whose decoded face `i` is its face `old[i]`.
    #[cfg(feature = "encode")]
    pub(crate) fn new(labels: &[Label], old: &[u32]) -> Self {
        let mut starts: Vec<u32> = labels.iter().map(|label| label.first_face).chain([0]).collect();
        starts.sort_unstable();
        starts.dedup();
        let stretch_of = |face: u32| starts.partition_point(|&start| start <= face) as u32 - 1;
        let labels = labels.iter().map(|label| Label { first_face: stretch_of(label.first_face), ..label.clone() });
        Self { labels: labels.collect(), stretch: old.iter().map(|&f| stretch_of(f)).collect() }
    }

    /// The faces in the order of their stretches, and the labels of faces so ordered.
    pub(crate) fn apply(self) -> (Vec<u32>, Vec<Label>) {
        let mut order: Vec<u32> = (0..self.stretch.len() as u32).collect();
        order.sort_by_key(|&f| self.stretch[f as usize]);
        let start = |stretch: u32| order.partition_point(|&f| self.stretch[f as usize] < stretch) as u32;
        let labels = self.labels.into_iter().map(|label| Label { first_face: start(label.first_face), ..label }).collect();
        (order, labels)
    }
}

/// Bytes of the model of names.
const MODEL: u64 = 4 << 16;

/// Bytes that a label takes at most beside its name.
const LABEL: u64 = 64;

/// Bytes of memory that reading takes: for so many labels with so many bytes of names, and for the faces.
pub(crate) fn memory(count: u32, text: u32, vertices: u32, faces: u32, corners: u64) -> u64 {
    MODEL + LABEL * u64::from(count) + 2 * u64::from(text) + 4 * u64::from(vertices) + 24 * u64::from(faces) + 5 * corners
}

/// Steps that reading takes.
pub(crate) fn work(count: u32, text: u32, faces: u32) -> u64 {
    u64::from(count) + 8 * u64::from(text) + u64::from(faces)
}

/// Writes labels; how many there are and the bytes of their names must be told to [`read`].
#[cfg(feature = "encode")]
pub(crate) fn write(labelling: &Labelling, faces: &Faces, vertices: usize) -> Result<(u32, u32, Vec<u8>)> {
    let text: usize = labelling.labels.iter().map(|label| label.name.len()).sum();
    let (Ok(count), Ok(text)) = (u32::try_from(labelling.labels.len()), u32::try_from(text)) else {
        return Err(Error::Parameter("the names of objects, groups and materials are too long".into()));
    };
    let mut coder = BitWriter::default();
    code(&mut coder, count, text, faces, vertices, labelling)?;
    Ok((count, text, coder.finish()))
}

/// Reads what [`write`] wrote. The caller has paid for [`memory`].
pub(crate) fn read(
    bytes: &[u8],
    count: u32,
    text: u32,
    faces: &Faces,
    vertices: usize,
    budget: &mut Budget,
) -> Result<Labelling> {
    budget.spend(work(count, text, faces.len() as u32))?;
    code(&mut BitReader::new(bytes), count, text, faces, vertices, &Labelling::default())
}

#[cold]
fn error(why: &str) -> Error {
    Error::malformed(Place::Chunk(*b"LABL", 0), format!("labels: {why}"))
}

fn code<C: BitCoder>(
    coder: &mut C,
    count: u32,
    mut text: u32,
    faces: &Faces,
    vertices: usize,
    known: &Labelling,
) -> Result<Labelling> {
    let mut numbers = Numbers::new(6);
    let mut names = Names::default();
    let mut labelling = Labelling::default();
    for i in 0..count as usize {
        if coder.is_exhausted() {
            return Err(error("the stream ends too soon"));
        }
        let label = known.labels.get(i);
        let kind = label.and_then(|l| KINDS.iter().position(|&k| k == l.kind)).unwrap_or(0);
        let Some(&kind) = KINDS.get(numbers.code(coder, kind as u32, 1) as usize) else {
            return Err(error("a label of an unknown kind"));
        };
        // Labels come in the order of the file, which is mostly that of stretches.
        let last = labelling.labels.last().map_or(0, |l: &Label| l.first_face);
        let first = label.map_or(0, |l| l.first_face);
        let step = i64::from(first) - i64::from(last);
        let step = numbers.code(coder, (step << 1 ^ step >> 63) as u32, 2);
        let first = i64::from(last) + (i64::from(step >> 1) ^ -i64::from(step & 1));
        let first_face = u32::try_from(first).map_err(|_| error("a stretch before the first"))?;
        let name = names.code(coder, label.map_or("", |l| &l.name), &mut numbers, &mut text)?;
        labelling.labels.push(Label { kind, name, first_face });
    }
    let mut is_near = [AdaptiveBit::default(); 4];
    let mut is_last = [AdaptiveBit::default(); 4];
    let mut last_at = LastFaces::new(vertices);
    // What the face before has, what was told in full last, whether neighbours agreed and the last answer was yes.
    let (mut last, mut told, mut lately) = (0, 0_u32, 1);
    for (f, face) in faces.iter().enumerate() {
        let stretch = known.stretch.get(f).copied().unwrap_or(0);
        let near = last_at.near(face);
        let context = lately + 2 * usize::from(near == Some(last));
        let is_known = match near {
            Some(near) if is_near[context].code(coder, stretch == near) => Some(near),
            near if near != Some(last) && is_last[lately + 2 * usize::from(near.is_some())].code(coder, stretch == last) => {
                Some(last)
            }
            _ => None,
        };
        lately = usize::from(is_known.is_some());
        last = match is_known {
            Some(stretch) => stretch,
            None => {
                let step = i64::from(stretch) - i64::from(told);
                let step = numbers.code(coder, (step << 1 ^ step >> 63) as u32, 5);
                told = told.wrapping_add((step >> 1) ^ (step & 1).wrapping_neg());
                told
            }
        };
        last_at.set(face, last);
        labelling.stretch.push(last);
        if f % 1024 == 0 && coder.is_exhausted() {
            return Err(error("the stream ends too soon"));
        }
    }
    Ok(labelling)
}

/// Takes the bytes of a name from what is left.
fn take(left: &mut u32, bytes: usize) -> Result<()> {
    let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
    *left = left.checked_sub(bytes).ok_or_else(|| error("names longer than announced"))?;
    Ok(())
}

/// Names: an earlier one again, or bytes, each in the context of the one before.
struct Names {
    known: Vec<String>,
    /// For a writer: where each is in `known`.
    places: HashMap<String, u32>,
    is_new: AdaptiveBit,
    bytes: Vec<AdaptiveBit>,
}

impl Default for Names {
    fn default() -> Self {
        Self {
            known: Vec::new(),
            places: HashMap::new(),
            is_new: AdaptiveBit::default(),
            bytes: vec![AdaptiveBit::default(); 1 << 16],
        }
    }
}

impl Names {
    fn code<C: BitCoder>(&mut self, coder: &mut C, name: &str, numbers: &mut Numbers, left: &mut u32) -> Result<String> {
        let place = self.places.get(name).copied();
        if !self.known.is_empty() && !self.is_new.code(coder, place.is_none()) {
            let place = numbers.code(coder, place.unwrap_or(0), 3);
            let name = self.known.get(place as usize).ok_or_else(|| error("a name that is not there"))?;
            take(left, name.len())?;
            return Ok(name.clone());
        }
        let length = numbers.code(coder, name.len() as u32, 4);
        take(left, length as usize)?;
        let mut text = Vec::new();
        let mut before = 0_usize;
        for i in 0..length as usize {
            let byte = name.as_bytes().get(i).copied().unwrap_or(0);
            let mut node = 1_usize;
            for bit in (0..8).rev() {
                let is_set = self.bytes[before << 8 | node].code(coder, byte >> bit & 1 != 0);
                node = node << 1 | usize::from(is_set);
            }
            before = node & 255;
            text.push(before as u8);
            if coder.is_exhausted() {
                return Err(error("the stream ends too soon"));
            }
        }
        let name = String::from_utf8(text).map_err(|_| error("a name that is not UTF-8"))?;
        if C::WRITES {
            self.places.insert(name.clone(), self.known.len() as u32);
        }
        self.known.push(name.clone());
        Ok(name)
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;

    #[test]
    fn labels_come_back_and_faces_stand_by_their_labels() {
        let label = |kind, name: &str, first_face| Label { kind, name: name.into(), first_face };
        let labels = vec![
            label(LabelKind::MaterialLibrary, "ship.mtl", 0),
            label(LabelKind::Group, "hull", 0),
            label(LabelKind::Material, "wood", 2),
            label(LabelKind::Smoothing, "off", 2),
            label(LabelKind::Group, "sail — été", 5),
            label(LabelKind::Material, "wood", 9),
            label(LabelKind::Object, "", 10),
        ];
        let old: Vec<u32> = (0..10).map(|i| i * 7 % 10).collect();
        let labelling = Labelling::new(&labels, &old);
        let faces: Faces = (0..10).map(|f| [f, f + 1, f + 2]).collect();
        let (count, text, bytes) = write(&labelling, &faces, 12).unwrap();
        let mut budget = Budget::new(crate::Limits::default());
        assert_eq!(read(&bytes, count, text, &faces, 12, &mut budget).unwrap(), labelling);
        let (order, back) = labelling.apply();
        assert_eq!(back, labels);
        let stretch = |f: u32| [0, 2, 5, 9].iter().filter(|&&start| start <= f).count();
        assert!((0..10).all(|f| stretch(f as u32) == stretch(old[order[f] as usize])));
    }
}
