//! The image of vertices (V-matrix) of a file, and its planes as pictures.
//!
//! The position plane is the paper's CGIM array, the normal plane its CNIM; the index plane shows
//! which pixels are one vertex, each in a colour of its own, and in white the vertices that the cuts doubled.

use crate::cgim::{Recipe, Search, image, image_again};
use crate::decode::Decoder;
use crate::error::{Error, Place, Result};
use crate::mesh::{HalfEdges, Mesh, vertex_normals};
use crate::plane::{Plane, Planes, Shape, bounding_box, write_png};
use crate::task::Task;

/// An image whose pixels are vertices: four neighbouring pixels `a b / d e` stand for the triangles
/// `(a, b, d)` and `(b, e, d)`, each where its three vertices differ.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct VertexImage {
    /// Columns.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// The vertex of each pixel, row by row; [`VertexImage::NONE`] where a hole was filled.
    pub vertices: Vec<u32>,
    /// The oriented manifold that the vertices are of; where the mesh is none, some of its vertices are there several times.
    pub mesh: Mesh,
    /// Which pixels belong to vertices that a cut doubled.
    doubled: Vec<bool>,
}

impl VertexImage {
    /// No vertex.
    pub const NONE: u32 = u32::MAX;

    /// The image that a file says how to make; the paper's choice if it says nothing.
    ///
    /// # Errors
    /// As [`Decoder::decode_with`], or a file that speaks of another mesh.
    pub fn of_file(decoder: &Decoder<'_>, task: Task<'_>) -> Result<Self> {
        let (mesh, pixels) = decoder.decode_image(task)?;
        if let Some(pixels) = pixels {
            let (columns, vertices) = (pixels.columns, pixels.vertices);
            let doubled = doubled(&vertices, columns, mesh.positions.len());
            return Ok(Self { columns, rows: vertices.len() / columns.max(1), vertices, mesh, doubled });
        }
        let half_edges = HalfEdges::new(mesh.positions.len(), mesh.faces.triangles())?;
        let image = match decoder.recipe() {
            Some(chunk) => {
                let recipes: Option<Vec<_>> = chunk.recipes.iter().map(|&packed| Recipe::unpack(packed)).collect();
                let recipes =
                    recipes.ok_or_else(|| Error::malformed(Place::Whole, "a recipe that opens a surface in no known way"))?;
                image_again(&half_edges, &recipes, &Search::default())?
            }
            None => image(&half_edges, &Search::default(), &task)?,
        };
        let count = mesh.positions.len();
        let vertex = |&region: &u32| {
            let v = image.origin[region as usize];
            if (v as usize) < count { v } else { Self::NONE }
        };
        let vertices: Vec<u32> = image.matrix.entries().iter().map(vertex).collect();
        let columns = image.matrix.columns();
        let doubled = doubled(&vertices, columns, count);
        Ok(Self { columns, rows: image.matrix.rows(), vertices, mesh, doubled })
    }

    /// The positions as a 16-bit picture: red, green and blue are x, y and z, one scale for all three.
    ///
    /// # Errors
    /// An image that is too large for a picture.
    pub fn positions_png(&self) -> Result<Vec<u8>> {
        let [low, high] = bounding_box(self.mesh.positions.iter().copied()).unwrap_or([[0.0; 3]; 2]);
        let side = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let scale = if side > 0.0 { 65535.0 / side } else { 0.0 };
        self.picture(16, |v| [0, 1, 2].map(|i| ((self.mesh.positions[v][i] - low[i]) * scale + 0.5) as i32))
    }

    /// The normals as a picture: −1 is black and 1 is bright in each of red, green and blue.
    ///
    /// # Errors
    /// An image that is too large for a picture.
    pub fn normals_png(&self) -> Result<Vec<u8>> {
        let normals = vertex_normals(&self.mesh);
        self.picture(8, |v| normals[v].map(|x| ((x + 1.0) * 127.5 + 0.5).clamp(0.0, 255.0) as i32))
    }

    /// Every vertex in a colour of its own; white where a cut doubled it.
    ///
    /// # Errors
    /// An image that is too large for a picture.
    pub fn index_png(&self) -> Result<Vec<u8>> {
        let pixels = self.vertices.iter().zip(&self.doubled).map(|(&v, &doubled)| match (v, doubled) {
            (Self::NONE, _) => [0; 3],
            (_, true) => [255; 3],
            (v, false) => colour(v),
        });
        self.rgb(8, pixels)
    }

    fn picture(&self, depth: u8, value: impl Fn(usize) -> [i32; 3]) -> Result<Vec<u8>> {
        self.rgb(depth, self.vertices.iter().map(|&v| if v == Self::NONE { [0; 3] } else { value(v as usize) }))
    }

    fn rgb(&self, depth: u8, pixels: impl Iterator<Item = [i32; 3]>) -> Result<Vec<u8>> {
        let shape = Shape::new(self.columns as u32, self.rows as u32)?;
        let mut planes = [0; 3].map(|_| Vec::with_capacity(shape.pixels()));
        for pixel in pixels {
            planes.iter_mut().zip(pixel).for_each(|(plane, x)| plane.push(x));
        }
        let planes = planes.into_iter().map(|samples| Plane::new(shape, depth, samples)).collect::<Result<_>>()?;
        write_png(&Planes::new(planes)?)
    }
}

/// Which pixels belong to vertices in several places of the image: those that a cut doubled.
fn doubled(vertices: &[u32], columns: usize, count: usize) -> Vec<bool> {
    let rows = vertices.len() / columns.max(1);
    let mut places = vec![0_u8; count];
    let mut seen = vec![false; vertices.len()];
    let mut stack = Vec::new();
    for start in 0..vertices.len() {
        let v = vertices[start];
        if v == VertexImage::NONE || seen[start] {
            continue;
        }
        places[v as usize] = places[v as usize].saturating_add(1);
        seen[start] = true;
        stack.push(start);
        while let Some(p) = stack.pop() {
            let (i, j) = ((p / columns) as isize, (p % columns) as isize);
            // Along the slash, too, as the pixels of a vertex hang together.
            for (i, j) in [(i, j - 1), (i, j + 1), (i - 1, j), (i + 1, j), (i - 1, j + 1), (i + 1, j - 1)] {
                if (0..rows as isize).contains(&i) && (0..columns as isize).contains(&j) {
                    let q = i as usize * columns + j as usize;
                    if vertices[q] == v && !std::mem::replace(&mut seen[q], true) {
                        stack.push(q);
                    }
                }
            }
        }
    }
    vertices.iter().map(|&v| v != VertexImage::NONE && places[v as usize] > 1).collect()
}

/// A colour that neighbouring numbers do not share, neither black nor white.
fn colour(v: u32) -> [i32; 3] {
    let h = v.wrapping_add(1).wrapping_mul(0x9E37_79B1);
    [h >> 24, h >> 16, h >> 8].map(|x| 32 + (x & 0xff) as i32 * 191 / 255)
}
