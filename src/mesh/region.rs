//! Regions of interest on a mesh: the vertices that matter most.

use super::polygon_mesh::Mesh;
use crate::error::{Error, Result};

/// Vertices of a mesh that matter more than others. A face is part of the region if one of its corners is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Region {
    inside: Vec<bool>,
}

/// A region that is found covers this share of the surface.
const SHARE: f64 = 0.15;
/// Cells along the diagonal of the box in which normals are gathered.
const CELLS: f64 = 32.0;

impl Region {
    /// The vertices of a list.
    pub(crate) fn of_vertices(mesh: &Mesh, list: &[u32]) -> Result<Self> {
        let mut inside = vec![false; mesh.positions.len()];
        for &v in list {
            let count = inside.len();
            let vertex = inside.get_mut(v as usize);
            *vertex.ok_or_else(|| Error::Parameter(format!("a region of interest with vertex {v}; the mesh has {count}")))? =
                true;
        }
        Self { inside }.that_is_not_empty()
    }

    /// The vertices for which something holds.
    pub(crate) fn where_(mesh: &Mesh, holds: impl Fn([f64; 3]) -> bool) -> Result<Self> {
        Self { inside: mesh.positions.iter().map(|&p| holds(p)).collect() }.that_is_not_empty()
    }

    /// Vertices inside a box.
    pub(crate) fn in_box(mesh: &Mesh, [low, high]: [[f64; 3]; 2]) -> Result<Self> {
        Self::where_(mesh, |p| (0..3).all(|i| low[i] <= p[i] && p[i] <= high[i]))
    }

    /// The part of the surface whose normals differ most from each other (paper 000, section 4, chooses by the variation of normals
    /// in the normal image; here by that in space): about 15 % of the area, connected. O(n log n).
    pub(crate) fn found(mesh: &Mesh) -> Result<Self> {
        let cells = Cells::of(mesh)?;
        let grown = cells.grow(SHARE);
        let inside = mesh.positions.iter().map(|&p| grown.binary_search(&cells.of_point(p)).is_ok()).collect();
        Self { inside }.that_is_not_empty()
    }

    fn that_is_not_empty(self) -> Result<Self> {
        if self.inside.contains(&true) {
            Ok(self)
        } else {
            Err(Error::Parameter("a region of interest without a vertex of the mesh".into()))
        }
    }

    /// Whether each vertex is inside.
    #[cfg(test)]
    fn vertices(&self) -> &[bool] {
        &self.inside
    }

    /// Whether each vertex is a corner of a face that is part of the region.
    pub(crate) fn corners(&self, mesh: &Mesh) -> Vec<bool> {
        let mut corners = self.inside.clone();
        for face in mesh.faces.triangles().iter().filter(|face| self.has_face(*face)) {
            face.iter().for_each(|&v| corners[v as usize] = true);
        }
        corners
    }

    /// Whether a face with these corners is part of the region.
    pub(crate) fn has_face(&self, corners: &[u32]) -> bool {
        corners.iter().any(|&v| self.inside[v as usize])
    }
}

type Cell = [i32; 3];

/// Cubes of space, and the areas of the triangles whose middles lie in each.
struct Cells {
    low: [f64; 3],
    side: f64,
    /// Sorted by cell: its area, and the sum of its triangles' normals times their areas.
    areas: Vec<(Cell, f64, [f64; 3])>,
}

impl Cells {
    fn of(mesh: &Mesh) -> Result<Self> {
        let [low, high] = crate::plane::bounding_box(mesh.positions.iter().copied())
            .ok_or_else(|| Error::Parameter("a mesh without vertices has no region of interest".into()))?;
        let diagonal = (0..3).map(|i| (high[i] - low[i]).powi(2)).sum::<f64>().sqrt();
        let mut cells = Self { low, side: (diagonal / CELLS).max(f64::MIN_POSITIVE), areas: Vec::new() };
        for t in mesh.faces.triangles() {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let edge = |p: [f64; 3]| [0, 1, 2].map(|i| p[i] - a[i]);
            let (u, v) = (edge(b), edge(c));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let area = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            cells.areas.push((cells.of_point([0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0)), area, normal));
        }
        cells.areas.sort_by_key(|cell| cell.0);
        cells.areas.dedup_by(|next, first| {
            let same = next.0 == first.0;
            if same {
                first.1 += next.1;
                (0..3).for_each(|i| first.2[i] += next.2[i]);
            }
            same
        });
        Ok(cells)
    }

    fn of_point(&self, p: [f64; 3]) -> Cell {
        [0, 1, 2].map(|i| ((p[i] - self.low[i]) / self.side).floor() as i32)
    }

    fn get(&self, cell: Cell) -> Option<&(Cell, f64, [f64; 3])> {
        self.areas.binary_search_by_key(&cell, |c| c.0).ok().map(|i| &self.areas[i])
    }

    /// How much normals differ around a cell: 0 for a plane, towards 1 where they cancel.
    fn variation(&self, cell: Cell) -> f64 {
        let (mut area, mut sum) = (0.0, [0.0; 3]);
        for (_, more, normals) in around(cell).filter_map(|c| self.get(c)) {
            area += more;
            (0..3).for_each(|i| sum[i] += normals[i]);
        }
        if area > 0.0 { 1.0 - sum.iter().map(|x| x * x).sum::<f64>().sqrt() / area } else { 0.0 }
    }

    /// Cells, sorted: from the one of most variation on always the neighbour with most, until they have this share of the area.
    fn grow(&self, share: f64) -> Vec<Cell> {
        let scored: Vec<(f64, Cell)> = self.areas.iter().map(|&(cell, ..)| (self.variation(cell), cell)).collect();
        let mut order: std::collections::BinaryHeap<Scored> = std::collections::BinaryHeap::new();
        let score = |cell: Cell| scored.binary_search_by_key(&cell, |s| s.1).ok().map(|i| Scored(scored[i].0, cell));
        let best = scored
            .iter()
            .fold(None::<Scored>, |best, &(s, cell)| Some(best.map_or(Scored(s, cell), |b| b.max(Scored(s, cell)))));
        order.extend(best);
        let total: f64 = self.areas.iter().map(|cell| cell.1).sum();
        let (mut taken, mut seen, mut area) = (Vec::new(), std::collections::BTreeSet::new(), 0.0);
        seen.extend(order.iter().map(|s| s.1));
        while let Some(Scored(_, cell)) = order.pop() {
            taken.push(cell);
            area += self.get(cell).map_or(0.0, |c| c.1);
            if area >= share * total {
                break;
            }
            order.extend(around(cell).filter(|&c| seen.insert(c)).filter_map(score));
        }
        taken.sort_unstable();
        taken
    }
}

/// A cell and its 26 neighbours.
fn around([x, y, z]: Cell) -> impl Iterator<Item = Cell> {
    (-1..=1).flat_map(move |i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])))
}

/// Ordered by score, then by cell.
#[derive(PartialEq)]
struct Scored(f64, Cell);

impl Eq for Scored {}

impl Ord for Scored {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for Scored {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet of `n` × `n` squares that is rough where x and y are below a quarter.
    fn rough_in_a_corner(n: u32) -> Mesh {
        let at = |i: u32, j: u32| {
            let rough = 4 * i < n && 4 * j < n;
            let z = if rough && (i + j).is_multiple_of(2) { 0.003 } else { 0.0 };
            [f64::from(i) / f64::from(n), f64::from(j) / f64::from(n), z]
        };
        let positions = (0..=n).flat_map(|i| (0..=n).map(move |j| at(i, j))).collect();
        let v = |i: u32, j: u32| i * (n + 1) + j;
        let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let faces =
            squares.flat_map(|(i, j)| [[v(i, j), v(i + 1, j), v(i + 1, j + 1)], [v(i, j), v(i + 1, j + 1), v(i, j + 1)]]);
        Mesh::from_triangles(positions, faces)
    }

    #[test]
    fn what_is_rough_is_found_and_is_about_15_percent() {
        let mesh = rough_in_a_corner(80);
        let region = Region::found(&mesh).unwrap();
        let inside = |v: usize| region.vertices()[v];
        let rough = |v: usize| mesh.positions[v][0] < 0.25 && mesh.positions[v][1] < 0.25;
        let count = (0..mesh.positions.len()).filter(|&v| inside(v)).count() as f64 / mesh.positions.len() as f64;
        assert!((0.12..0.2).contains(&count), "{count}");
        let hit = (0..mesh.positions.len()).filter(|&v| rough(v)).all(inside);
        assert!(hit);
    }

    #[test]
    fn regions_are_of_vertices_or_in_a_box_and_never_empty() {
        let mesh = rough_in_a_corner(4);
        let list = Region::of_vertices(&mesh, &[3, 7]).unwrap();
        assert!(list.has_face(&[1, 2, 3]) && !list.has_face(&[1, 2, 4]));
        let by_box = Region::in_box(&mesh, [[0.0, 0.0, -1.0], [0.3, 0.3, 1.0]]).unwrap();
        assert_eq!(by_box.vertices().iter().filter(|inside| **inside).count(), 4);
        assert!(Region::of_vertices(&mesh, &[25]).is_err() && Region::of_vertices(&mesh, &[]).is_err());
        assert!(Region::in_box(&mesh, [[2.0; 3], [3.0; 3]]).is_err());
    }
}
