//! Which points of a surface lie in its region of interest.

use glam::DVec3;

use crate::error::Result;
use crate::geom::Bvh;
use crate::mesh::{Mesh, Region};
use crate::par;
use crate::plane::{GeometryImage, Mask, Shape};

/// A region of a mesh, ready to be asked.
pub(crate) struct Interest {
    region: Region,
    tree: Bvh,
    /// Whether each triangle of the tree is part of the region.
    inside: Vec<bool>,
}

impl Interest {
    pub(crate) fn new(mesh: &Mesh, region: Region) -> Self {
        let triangles = mesh.faces.triangles();
        let inside = triangles.iter().map(|t| region.has_face(t)).collect();
        let solid: Vec<_> = triangles.iter().map(|t| t.map(|v| DVec3::from(mesh.positions[v as usize]))).collect();
        Self { region, tree: Bvh::new(&solid), inside }
    }

    /// The region itself.
    pub(crate) fn region(&self) -> &Region {
        &self.region
    }

    /// Whether the triangle nearest to a point is part of it.
    pub(crate) fn has(&self, p: [f64; 3]) -> bool {
        self.tree.closest(p.into(), 0).is_some_and(|hit| self.inside[self.tree.id(hit.slot) as usize])
    }

    /// Which samples of an image are inside.
    pub(crate) fn samples(&self, image: &GeometryImage) -> Mask {
        mask(image.shape(), image.points(), &|p| self.has(p))
    }
}

/// The points, row by row, for which something holds.
pub(super) fn mask(shape: Shape, points: &[[f64; 3]], holds: &(dyn Fn([f64; 3]) -> bool + Sync)) -> Mask {
    let rows = par::map(shape.height(), |row| {
        let points = &points[row * shape.width()..(row + 1) * shape.width()];
        points.iter().map(|&p| holds(p)).collect::<Vec<bool>>()
    });
    Mask::from_fn(shape, |row, column| rows[row][column])
}

/// The vertices of a mesh that are nearest to squares of an image which a mask of any size, laid over it, has inside.
pub(crate) fn region_under(mesh: &Mesh, image: &GeometryImage, over: &Mask) -> Result<Region> {
    let (columns, rows) = (image.width() - 1, image.height() - 1);
    let point = |row: usize, column: usize| DVec3::from(image.point(row, column));
    let mut triangles = Vec::with_capacity(2 * columns * rows);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let [a, b, c, d] = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(i, j)| point(row + i, column + j));
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let tree = Bvh::new(&triangles);
    Region::where_(mesh, |p| {
        tree.closest(p.into(), 0).is_some_and(|hit| {
            let square = tree.id(hit.slot) as usize / 2;
            let under = |at: usize, of: usize, pixels: usize| (2 * at + 1) * pixels / (2 * of);
            let (row, column) = (square / columns, square % columns);
            over.contains(under(row, rows, over.shape().height()), under(column, columns, over.shape().width()))
        })
    })
}
