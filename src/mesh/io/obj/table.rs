//! Values that statements give one after the other, and who refers to them.

use crate::error::{Error, Place, Result};
use crate::mesh::io::number::{Digits, Number};
use crate::mesh::{Attribute, AttributeKind, Domain};

/// A growing list of values of one kind.
#[derive(Debug, Default)]
pub(super) struct Table {
    pub(super) width: usize,
    values: Vec<f64>,
    digits: Digits,
    /// For each vertex or corner its value; shorter than they are many while the last have none.
    indices: Vec<u32>,
}

impl Table {
    pub(super) fn len(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// Adds a value. A shorter one, now or earlier, is filled up with `fill`.
    pub(super) fn push(&mut self, value: &[Number], fill: f64) {
        if value.len() > self.width {
            self.widen(value.len(), fill);
        }
        for number in value {
            self.digits.see(self.values.len(), number);
            self.values.push(number.value);
        }
        self.values.extend((value.len()..self.width).map(|_| fill));
    }

    /// Once per width, and widths are small.
    fn widen(&mut self, width: usize, fill: f64) {
        if !self.values.is_empty() {
            let old = self.width;
            self.digits.renumber(|index| index / old * width + index % old);
            let rows = self.values.chunks_exact(old);
            self.values = rows.flat_map(|row| row.iter().copied().chain((old..width).map(|_| fill))).collect();
        }
        self.width = width;
    }

    /// Gives vertex or corner `element` the value `index`. Elements come in order; those left out have none.
    pub(super) fn refer(&mut self, element: usize, index: u32) {
        self.indices.resize(element, Attribute::NONE);
        self.indices.push(index);
    }

    /// The attribute of `elements` vertices or corners; nothing if none of them has a value.
    pub(super) fn finish(mut self, kind: AttributeKind, name: &str, domain: Domain, elements: usize) -> Option<Attribute> {
        if self.indices.iter().all(|&index| index == Attribute::NONE) {
            return None;
        }
        self.indices.resize(elements, Attribute::NONE);
        if self.indices.len() == self.len() && self.indices.iter().zip(0..).all(|(&index, i)| index == i) {
            self.indices = Vec::new();
        }
        let scalar = self.digits.settle(&mut self.values);
        let Self { width, values, indices, .. } = self;
        Some(Attribute { kind, name: name.to_owned(), domain, width, scalar, values, indices })
    }

    /// Takes away references beyond the last value; how many there were.
    pub(super) fn drop_dangling(&mut self) -> usize {
        let len = self.len();
        let beyond = self.indices.iter_mut().filter(|i| **i != Attribute::NONE && **i as usize >= len);
        beyond.map(|index| *index = Attribute::NONE).count()
    }
}

/// References to what had not been read yet when they were: legal if it comes later.
#[derive(Debug, Default)]
pub(super) struct Forward {
    /// Index and line of references, each further ahead than all before it.
    references: Vec<(u32, u64)>,
}

impl Forward {
    /// The index from 0 that `reference` means while there are `len` values.
    pub(super) fn resolve(&mut self, reference: i64, len: usize, line: u64) -> Result<u32, String> {
        let index = match reference {
            1.. => reference - 1,
            0 => return Err("index 0, and OBJ counts from 1".to_owned()),
            _ => len as i64 + reference,
        };
        if index < 0 {
            return Err(format!("index {reference}, and there are {len} so far"));
        }
        let index = u32::try_from(index)
            .ok()
            .filter(|&i| i != Attribute::NONE)
            .ok_or_else(|| format!("index {reference} is too great"))?;
        if index as usize >= len && self.references.last().is_none_or(|&(furthest, _)| index > furthest) {
            self.references.push((index, line));
        }
        Ok(index)
    }

    /// The first reference that is still ahead of all `len` values.
    pub(super) fn dangling(&self, len: usize) -> Option<(u32, u64)> {
        self.references.iter().copied().find(|&(index, _)| index as usize >= len)
    }

    /// An error about the first reference that is still ahead of all `len` vertices.
    pub(super) fn check(&self, len: usize) -> Result<()> {
        match self.dangling(len) {
            Some((index, line)) => {
                let why = format!("the face names vertex {}, and the file has {len}", u64::from(index) + 1);
                Err(Error::malformed(Place::Line(line), why))
            }
            None => Ok(()),
        }
    }
}
