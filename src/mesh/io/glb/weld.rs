//! Vertices that glTF holds several times because their sides differ, made one again.

use std::collections::HashMap;

use super::read::Slot;
use crate::mesh::{Attribute, Domain, Faces};

/// Where a vertex comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Origin {
    /// The first vertex of its accessor.
    pub(super) accessor: u32,
    /// The first object that uses it.
    pub(super) object: u32,
    /// Whether it was given without indices.
    pub(super) is_soup: bool,
}

/// For each vertex its number after welding, and how many there are.
///
/// The `k`-th vertices of the same object, place and attributes in each accessor become one with the
/// `k`-th of other attributes or accessors; in a soup all vertices of a place become one.
pub(super) fn weld(positions: &[[f64; 3]], faces: &Faces, slots: &[Slot], origins: &[Origin]) -> (Vec<u32>, usize) {
    let looks = looks(positions.len(), faces, slots);
    let place = |v: u32| {
        // Adding 0 turns −0 into 0.
        let [x, y, z] = positions[v as usize].map(|x| (x + 0.0).to_bits());
        (x, y, z, origins[v as usize].object)
    };
    let kind = |v: u32| (looks[v as usize], origins[v as usize].accessor);
    // A vertex that no face uses has no attributes and stays for itself.
    let mut order = (0..positions.len() as u32).filter(|&v| looks[v as usize].is_some()).collect::<Vec<_>>();
    order.sort_unstable_by_key(|&v| (place(v), kind(v), v));

    // For each vertex the first of those that it is one with.
    let mut firsts = (0..positions.len() as u32).collect::<Vec<_>>();
    let mut first_copies = Vec::<u32>::new();
    for group in order.chunk_by(|&a, &b| place(a) == place(b)).filter(|group| group.len() > 1) {
        let copies = || {
            let alike = group.chunk_by(|&a, &b| kind(a) == kind(b)).flat_map(|alike| alike.iter().zip(0..));
            alike.map(|(&v, copy)| (v, if origins[v as usize].is_soup { 0 } else { copy }))
        };
        first_copies.clear();
        first_copies.resize(group.len(), u32::MAX);
        for (v, copy) in copies() {
            first_copies[copy] = first_copies[copy].min(v);
        }
        for (v, copy) in copies() {
            firsts[v as usize] = first_copies[copy];
        }
    }

    let mut count = 0;
    let mut map = vec![0; positions.len()];
    for (v, &first) in firsts.iter().enumerate() {
        map[v] = if first as usize == v {
            count += 1;
            count - 1
        } else {
            map[first as usize]
        };
    }
    (map, count as usize)
}

/// A number for each different combination of attributes that vertices have where faces first use them.
fn looks(vertices: usize, faces: &Faces, slots: &[Slot]) -> Vec<Option<u32>> {
    let mut looks = vec![None; vertices];
    let mut known = HashMap::<(usize, u32, u32), u32>::new();
    for (corner, &v) in faces.corners().iter().enumerate() {
        looks[v as usize].get_or_insert_with(|| {
            slots.iter().enumerate().fold(0, |look, (s, slot)| {
                let next = known.len() as u32 + 1;
                *known.entry((s, look, slot.corners[corner])).or_insert(next)
            })
        });
    }
    looks
}

/// For each value the first that is equal to it.
pub(super) fn firsts_of_equal(values: &[f64], width: usize) -> Vec<u32> {
    let bits = |i: u32| values[i as usize * width..][..width].iter().map(|x| (x + 0.0).to_bits());
    let mut order = (0..(values.len() / width) as u32).collect::<Vec<_>>();
    order.sort_unstable_by(|&a, &b| bits(a).cmp(bits(b)).then(a.cmp(&b)));
    let mut firsts = vec![0; order.len()];
    for equal in order.chunk_by(|&a, &b| bits(a).eq(bits(b))) {
        equal.iter().for_each(|&i| firsts[i as usize] = equal[0]);
    }
    firsts
}

impl Slot {
    /// Gives equal values one number, in order of the corners that use them.
    pub(super) fn unite_values(&mut self) {
        let width = self.width;
        let firsts = firsts_of_equal(&self.values, width);
        let mut values = Vec::new();
        let mut map = vec![Attribute::NONE; firsts.len()];
        for corner in self.corners.iter_mut().filter(|corner| **corner != Attribute::NONE) {
            let first = firsts[*corner as usize];
            let slot = &mut map[first as usize];
            if *slot == Attribute::NONE {
                *slot = (values.len() / width) as u32;
                values.extend_from_slice(&self.values[first as usize * width..][..width]);
            }
            *corner = *slot;
        }
        self.values = values;
    }

    /// The attribute: on vertices if no vertex has two values, or else on corners.
    pub(super) fn into_attribute(self, vertices: usize, faces: &Faces) -> Attribute {
        let Self { kind, name, width, scalar, values, corners, .. } = self;
        let mut attribute = Attribute { kind, name, domain: Domain::Corner, width, scalar, values, indices: corners };
        let mut on_vertices = vec![None; vertices];
        let is_function = faces.corners().iter().zip(&attribute.indices).all(|(&v, &index)| {
            let value = on_vertices[v as usize].get_or_insert(index);
            *value == index
        });
        if is_function {
            let has = on_vertices.iter().map(|index| index.filter(|&i| i != Attribute::NONE));
            let indices = has.clone().scan(0, |next, index| {
                *next += u32::from(index.is_some());
                Some(index.map_or(Attribute::NONE, |_| *next - 1))
            });
            let indices = indices.collect::<Vec<_>>();
            let value = |index: u32| &attribute.values[index as usize * width..][..width];
            attribute.values = has.flatten().flat_map(|index| value(index).iter().copied()).collect();
            attribute.indices = indices;
            attribute.domain = Domain::Vertex;
        }
        let in_order = attribute.indices.iter().zip(0..).all(|(&index, i)| index == i);
        if in_order && attribute.indices.len() == attribute.len() {
            attribute.indices = Vec::new();
        }
        attribute
    }
}
