//! From a mesh to one image: a matrix for each connected piece, stacked, and the side information.

use super::align::align;
use super::check::compare;
use super::open::{Recipe, pieces};
use super::rebuild::matrix_triangles;
use super::search::{Found, Search, search, sweep_of};
use super::side::{finish, first_regions, unlimited};
use super::vmatrix::VMatrix;
use crate::error::{Error, Result};
use crate::mesh::{HalfEdges, NONE};
use crate::plane::{Block, SideInformation};
use crate::task::Task;

/// A mesh as an image.
#[derive(Debug)]
pub(crate) struct Image {
    /// Entries are regions, numbered by first occurrence.
    pub(crate) matrix: VMatrix,
    /// The vertex of the mesh that each region is; dummies have numbers from the mesh's vertices on.
    pub(crate) origin: Vec<u32>,
    pub(crate) side: SideInformation,
    /// How each piece was opened and swept.
    pub(crate) recipes: Vec<Recipe>,
}

/// Makes an image of any oriented manifold, as small as the search finds it.
///
/// # Errors
/// If the task is cancelled, or — which would be a fault of this program — the image does not hold the mesh.
pub(crate) fn image(surface: &HalfEdges, options: &Search, task: &Task<'_>) -> Result<Image> {
    let mut parts = Vec::new();
    let pieces = pieces(surface)?;
    for (i, piece) in pieces.iter().enumerate() {
        task.step(i as f64 / pieces.len() as f64)?;
        parts.push(Part::new(piece, search(piece, options, task)?));
    }
    stack(parts, options, surface)
}

/// Makes the same image again, from the recipes that [`image`] found.
pub(crate) fn image_again(surface: &HalfEdges, recipes: &[Recipe], options: &Search) -> Result<Image> {
    let pieces = pieces(surface)?;
    if pieces.len() != recipes.len() {
        let why = format!("recipes for {} pieces, and the mesh has {}", recipes.len(), pieces.len());
        return Err(Error::malformed(crate::error::Place::Whole, why));
    }
    let parts = pieces.iter().zip(recipes).map(|(piece, recipe)| Ok(Part::new(piece, sweep_of(piece, recipe, options)?)));
    stack(parts.collect::<Result<_>>()?, options, surface)
}

/// A piece with its matrix.
struct Part {
    found: Found,
    /// The vertex of the surface, or the dummy, that each vertex of the disk is.
    vertex: Vec<u32>,
    /// What the matrix should hold, in vertices of the surface and dummies.
    triangles: Vec<[u32; 3]>,
}

impl Part {
    fn new(piece: &super::open::Piece, found: Found) -> Self {
        let vertex = found.disk.origin.iter().map(|&v| piece.origin[v as usize]).collect();
        let triangles = piece.triangles().into_iter().map(|t| t.map(|v| piece.origin[v as usize])).collect();
        Self { found, vertex, triangles }
    }
}

/// Puts the matrices one below the other, some of them transposed, so that the image is small.
fn stack(mut parts: Vec<Part>, options: &Search, surface: &HalfEdges) -> Result<Image> {
    let upright = options.simple || options.as_printed;
    let columns = if upright { parts.iter().map(|p| p.found.matrix.columns()).max().unwrap_or(1) } else { best_width(&parts) };
    for part in &mut parts {
        if !upright && turns(&part.found.matrix, columns) {
            let turned = part.found.matrix.transposed();
            part.found.matrix = align(&turned.levels(), options.contact);
            part.found.mirrored ^= true;
        }
    }
    let mut side = SideInformation::default();
    let mut entries = Vec::new();
    let mut origin = Vec::new();
    for part in &parts {
        let matrix = &part.found.matrix;
        let mut region = vec![NONE; part.vertex.len()];
        for i in 0..matrix.rows() {
            for &v in matrix.row(i) {
                if region[v as usize] == NONE {
                    region[v as usize] = origin.len() as u32;
                    origin.push(part.vertex[v as usize]);
                }
                entries.push(region[v as usize]);
            }
            // Equal neighbours make no cells.
            let last = entries[entries.len() - 1];
            entries.resize(entries.len() + columns - matrix.columns(), last);
        }
        side.blocks.push(Block { rows: matrix.rows() as u32, mirrored: part.found.mirrored });
    }
    let recipes = parts.iter().map(|part| part.found.recipe).collect();
    let mut image = Image { matrix: VMatrix::new(columns, entries), origin, side, recipes };
    image.add_escape(&parts);
    let triangles = matrix_triangles(&image.matrix, image.regions(), &image.side, &mut unlimited())?;
    finish(&mut image.side, &image.origin, triangles, surface)?;
    Ok(image)
}

/// Whether a matrix lies better on its side, given the width of the image: upright it would not fit, or be higher.
fn turns(matrix: &VMatrix, width: usize) -> bool {
    let (rows, columns) = (matrix.rows(), matrix.columns());
    columns > width || rows <= width && columns < rows
}

/// The width that makes the stack smallest.
fn best_width(parts: &[Part]) -> usize {
    let sides = |part: &Part| [part.found.matrix.rows(), part.found.matrix.columns()];
    let least = parts.iter().map(|part| sides(part).into_iter().min().unwrap_or(1)).max().unwrap_or(1);
    let height = |&width: &usize| -> usize {
        let high = |part: &Part| if turns(&part.found.matrix, width) { sides(part)[1] } else { sides(part)[0] };
        parts.iter().map(high).sum()
    };
    let widths = parts.iter().flat_map(sides).filter(|&w| w >= least);
    let turned = |width: usize| parts.iter().filter(|part| turns(&part.found.matrix, width)).count();
    widths.min_by_key(|&width| (width * height(&width), turned(width), width)).unwrap_or(least)
}

impl Image {
    pub(crate) fn regions(&self) -> u32 {
        self.origin.len() as u32
    }

    /// Half-cells that are wrong, and triangles that have none, in terms of regions.
    fn add_escape(&mut self, parts: &[Part]) {
        let first_region = first_regions(&self.origin);
        let mut row = 0;
        for part in parts {
            let matrix = &part.found.matrix;
            let turn = |&[a, b, c]: &[u32; 3]| if part.found.mirrored { [a, c, b] } else { [a, b, c] };
            let wanted: Vec<_> = part.triangles.iter().map(turn).collect();
            let escape = compare(matrix, |v| part.vertex[v as usize], &wanted);
            let width = matrix.columns() as u64;
            let place = |half: u64| {
                let pixel = half / 2;
                let (i, j) = (row as u64 + pixel / width, pixel % width);
                2 * (i * self.matrix.columns() as u64 + j) + half % 2
            };
            self.side.extra.extend(escape.extra.into_iter().map(place));
            self.side.missing.extend(escape.missing.iter().map(|t| turn(t).map(|v| first_region[&v])));
            row += matrix.rows();
        }
    }
}
