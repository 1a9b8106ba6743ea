//! What the records of a file are asked: the mesh, in the terms of the surface that was coded.

use super::write::Coded;
use crate::mesh::half_edge::next;
use crate::mesh::{Faces, Front, NONE};
use crate::surface::records::{FaceRecord, Kinds, Origin, Source, Totals, point_key};
use crate::surface::renumber::Renumbering;

/// A mesh, its front end, and how its surface was coded.
pub(super) struct Known<'a> {
    front: &'a Front,
    coded: &'a Coded,
    /// The number that each vertex of the mesh gets.
    number: Vec<u32>,
    /// How often each face is repeated, the same way round and the other.
    repeats: Vec<[u32; 2]>,
    points: Vec<[i32; 3]>,
    loose: Vec<Vec<u32>>,
    /// The face of the mesh that each of them is.
    loose_faces: Vec<u32>,
}

impl<'a> Known<'a> {
    pub(super) fn new(front: &'a Front, coded: &'a Coded, faces: &Faces, positions: &[[i32; 3]]) -> Self {
        let mut number = vec![NONE; positions.len()];
        let mut count = 0;
        for &v in &coded.order {
            let number = &mut number[front.vertex[v as usize] as usize];
            if *number == NONE {
                *number = count;
                count += 1;
            }
        }
        let mut apart: Vec<u32> = (0..positions.len() as u32).filter(|&v| number[v as usize] == NONE).collect();
        apart.sort_by_key(|&v| point_key(positions[v as usize]));
        for &v in &apart {
            number[v as usize] = count;
            count += 1;
        }
        let mut repeats = Vec::new();
        if !front.repeats.is_empty() {
            repeats = vec![[0; 2]; faces.len()];
            for repeat in &front.repeats {
                repeats[repeat.of as usize][usize::from(repeat.is_reversed)] += 1;
            }
        }
        let in_numbers = |&f: &u32| {
            let mut face: Vec<u32> = faces.get(f as usize).iter().map(|&v| number[v as usize]).collect();
            let least = (0..face.len()).min_by_key(|&i| face[i]).unwrap_or(0);
            face.rotate_left(least);
            face
        };
        let mut apart_faces: Vec<(Vec<u32>, u32)> = front.loose.iter().map(|f| (in_numbers(f), *f)).collect();
        apart_faces.sort_unstable();
        let (loose, loose_faces) = apart_faces.into_iter().unzip();
        let points = apart.iter().map(|&v| positions[v as usize]).collect();
        Self { front, coded, number, repeats, points, loose, loose_faces }
    }

    pub(super) fn totals(&self, faces: &Faces, vertices: u32) -> Totals {
        Totals {
            vertices,
            faces: faces.len() as u32,
            corners: faces.corners().len() as u32,
            loose: self.loose.len() as u32,
            points: self.points.len() as u32,
        }
    }

    /// How to get from the faces as they are decoded to those of the mesh.
    pub(super) fn renumbering(&self, faces: &Faces, decoded: &Faces, origins: &[Origin]) -> Renumbering {
        let mut order = Renumbering { vertices: vec![0; self.number.len()], ..Renumbering::default() };
        for (v, &number) in self.number.iter().enumerate() {
            order.vertices[number as usize] = v as u32;
        }
        // The repeats of a face: those the same way round first.
        let mut repeats: Vec<_> = self.front.repeats.iter().map(|r| (r.of, r.is_reversed, r.face)).collect();
        repeats.sort_unstable();
        let mut turned = Vec::new();
        for (corners, &origin) in decoded.iter().zip(origins) {
            let f = match origin {
                Origin::Loose(i) => self.loose_faces[i as usize],
                Origin::Surface(h, repeat) => {
                    let f = self.front.face[self.original(h) as usize / 3];
                    let first = repeats.partition_point(|r| r.0 < f);
                    if repeat == 0 { f } else { repeats[first + repeat as usize - 1].2 }
                }
            };
            order.faces.push(f);
            let wanted = faces.get(f as usize);
            turned.clear();
            turned.extend(corners.iter().map(|&v| order.vertices[v as usize]));
            let fits = |turn: &usize| turned[*turn..].iter().chain(&turned[..*turn]).eq(wanted);
            order.turns.push((0..turned.len()).find(fits).unwrap_or(0) as u32);
        }
        order
    }

    /// The half-edge that half-edge `h` of the skin was before it was coded.
    fn original(&self, h: u32) -> u32 {
        let first = self.coded.first[h as usize / 3];
        (0..h % 3).fold(first, |g, _| next(g))
    }
}

impl Source for Known<'_> {
    fn kinds(&self) -> Kinds {
        Kinds {
            copies: self.front.vertex.len() + self.points.len() > self.number.len(),
            polygons: (0..self.coded.skin.opposite.len() as u32).any(|h| self.is_diagonal(h)),
            flips: self.front.is_flipped.contains(&true),
            repeats: !self.repeats.is_empty(),
        }
    }

    fn vertex(&mut self, v: u32, _next: u32) -> u32 {
        self.number[self.front.vertex[self.coded.order[v as usize] as usize] as usize]
    }

    fn is_diagonal(&self, h: u32) -> bool {
        self.front.is_diagonal(self.original(h))
    }

    fn face(&self, h: u32) -> FaceRecord {
        let face = self.front.face[self.original(h) as usize / 3] as usize;
        FaceRecord { is_flipped: self.front.is_flipped[face], repeats: self.repeats.get(face).copied().unwrap_or_default() }
    }

    fn points(&self) -> &[[i32; 3]] {
        &self.points
    }

    fn loose(&self) -> &[Vec<u32>] {
        &self.loose
    }
}
