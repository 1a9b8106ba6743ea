//! The surface of geometry images: vertices and triangles.

use std::borrow::Borrow;

use crate::error::{Error, Place, Result};
use crate::mesh::{Mesh, Scalar, Union};
use crate::plane::GeometryImage;

/// The mesh of images, one after the other: their samples as vertices, those that are glued as one.
pub(crate) fn mesh<I: Borrow<GeometryImage>>(images: &[I], precision: Scalar) -> Result<Mesh> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for image in images {
        let (image, first) = (image.borrow(), positions.len() as u32);
        let (samples, faces) = surface(image);
        let points = samples.iter().map(|&at| image.points()[at as usize]);
        positions.extend(points.map(|p| if precision == Scalar::F64 { p } else { p.map(|x| f64::from(x as f32)) }));
        triangles.extend(faces.into_iter().map(|t| t.map(|v| first + v)));
    }
    if positions.iter().flatten().any(|x| !x.is_finite()) {
        return Err(Error::malformed(Place::Whole, "a point beyond what 32-bit numbers hold"));
    }
    let mut mesh = Mesh::from_triangles(positions, triangles);
    mesh.precision = precision;
    Ok(mesh)
}

/// The sample of each vertex, in rising order, and the triangles.
///
/// A sample that no triangle uses is no vertex. Where holes touch at a corner, the triangles around it form several fans, and each
/// has a vertex of its own, in the order of their first triangles. O(n log n).
pub(crate) fn surface(image: &GeometryImage) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut triangles = image.triangles();
    if image.holes().is_some() {
        return split(triangles);
    }
    let mut number = vec![0_u32; image.points().len()];
    let mut samples = Vec::new();
    for (at, of) in image.representatives().into_iter().enumerate() {
        if of as usize == at {
            number[at] = samples.len() as u32;
            samples.push(of);
        }
    }
    triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
    (samples, triangles)
}

/// One vertex for every fan of triangles.
fn split(mut triangles: Vec<[u32; 3]>) -> (Vec<u32>, Vec<[u32; 3]>) {
    // Corners of one fan: those at the same end of an edge that two triangles share.
    let mut fans = Union::new(3 * triangles.len());
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (f, t) in triangles.iter().enumerate() {
        sides.extend((0..3).map(|k| (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]), (3 * f + k) as u32)));
    }
    sides.sort_unstable();
    let next = |corner: u32| if corner % 3 == 2 { corner - 2 } else { corner + 1 };
    for pair in sides.windows(2).filter(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1)) {
        // The two triangles walk their common edge in opposite directions.
        fans.join(pair[0].2, next(pair[1].2));
        fans.join(next(pair[0].2), pair[1].2);
    }
    let mut corners: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    let mut first = vec![u32::MAX; 3 * triangles.len()];
    for corner in 0..3 * triangles.len() as u32 {
        let fan = fans.find(corner) as usize;
        first[fan] = first[fan].min(corner);
        corners.push((triangles[corner as usize / 3][corner as usize % 3], first[fan], corner));
    }
    corners.sort_unstable();
    let mut samples = Vec::new();
    for fan in corners.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        fan.iter().for_each(|&(_, _, corner)| triangles[corner as usize / 3][corner as usize % 3] = samples.len() as u32);
        samples.push(fan[0].0);
    }
    (samples, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::HalfEdges;
    use crate::plane::{BorderSide, Gluing, Mask, Seams, Shape};

    fn inspect(image: GeometryImage) -> crate::mesh::Inspection {
        let seen = mesh(&[image], Scalar::F64).unwrap();
        assert!(HalfEdges::new(seen.positions.len(), seen.faces.triangles()).is_ok());
        seen.inspect()
    }

    #[test]
    fn the_mesh_of_an_orbifold_has_a_vertex_for_every_point_and_no_more() {
        let mesh = mesh(&[GeometryImage::rough(9, 7, Gluing::Orbifold, 3)], Scalar::F64).unwrap();
        assert_eq!(mesh.positions.len(), 8 * 6 + 2);
        assert_eq!(mesh.faces.len(), 2 * 8 * 6);
    }

    #[test]
    fn holes_of_any_shape_leave_a_manifold() {
        for seed in 0..60 {
            for gluing in [Gluing::Open, Gluing::Orbifold] {
                let image = GeometryImage::rough(9, 9, gluing, seed);
                let hole = |row: usize, column: usize| {
                    ((row * 8 + column) as u64 * 40 + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 60 < 1 + seed % 12
                };
                let holes = Mask::from_fn(Shape::new(8, 8).unwrap(), hole);
                let squares = 64 - holes.count();
                let seen = inspect(image.with_holes(holes).unwrap());
                assert!(seen.is_manifold() && seen.isolated_vertices.count == 0, "seed {seed}: {seen:?}");
                assert_eq!(seen.faces, 2 * squares);
            }
        }
    }

    #[test]
    fn seams_make_a_closed_surface_of_their_genus_whatever_the_points() {
        let polygon = |pairs: &[(usize, usize, u32)], start: u32| {
            let mut sides = vec![BorderSide { length: 0, mate: 0 }; 2 * pairs.len()];
            for &(i, j, length) in pairs {
                sides[i] = BorderSide { length, mate: j as u32 };
                sides[j] = BorderSide { length, mate: i as u32 };
            }
            let grains = pairs.iter().map(|pair| pair.2).sum::<u32>() / 2;
            Seams::new(grains, start, sides).unwrap()
        };
        let torus = [(0, 2, 5), (1, 3, 5)];
        let other_torus = [(0, 3, 5), (1, 4, 6), (2, 5, 7)];
        let double = [(0, 2, 5), (1, 3, 7), (4, 6, 6), (5, 7, 6)];
        for (pairs, genus) in [(&torus[..], 1), (&other_torus, 1), (&double, 2)] {
            for start in 0..9 {
                for scale in [1, 2, 3] {
                    let seams = polygon(pairs, start);
                    let side = (seams.grains() * scale + 1) as usize;
                    let image = GeometryImage::rough(side, side, Gluing::Open, u64::from(start)).with_seams(seams).unwrap();
                    let seen = inspect(image.clone());
                    assert!(seen.is_manifold() && seen.components == 1, "{seen:?}");
                    assert_eq!((seen.boundary_loops, seen.genus, seen.duplicate_faces.count), (0, Some(genus), 0));
                    let holes =
                        Mask::from_fn(Shape::new(side as u32 - 1, side as u32 - 1).unwrap(), |r, c| (r * 3 + c * 5) % 7 == 0);
                    assert!(inspect(image.with_holes(holes).unwrap()).is_manifold());
                }
            }
        }
    }
}
