//! Normals of vertices: those of the file, or the mean over the faces around each.

use super::attribute::{Attribute, AttributeKind, Domain};
use super::polygon_mesh::Mesh;

/// A unit normal for every vertex: the file's if it has one for each vertex, otherwise the mean of the faces'
/// normals, weighted by area. Zero where no face is.
pub(crate) fn vertex_normals(mesh: &Mesh) -> Vec<[f64; 3]> {
    let of_file =
        mesh.attributes.iter().find(|a| a.kind == AttributeKind::Normal && a.domain == Domain::Vertex && a.width == 3);
    let normals = match of_file {
        Some(attribute) => (0..mesh.positions.len()).map(|v| value(attribute, v)).collect(),
        None => sums_over_faces(mesh),
    };
    normals.into_iter().map(unit).collect()
}

fn value(attribute: &Attribute, element: usize) -> [f64; 3] {
    let index = match attribute.indices.get(element) {
        Some(&Attribute::NONE) => return [0.0; 3],
        Some(&index) => index as usize,
        None => element,
    };
    [0, 1, 2].map(|i| attribute.values.get(3 * index + i).copied().unwrap_or(0.0))
}

fn sums_over_faces(mesh: &Mesh) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; mesh.positions.len()];
    for [a, b, c] in mesh.faces.triangles() {
        let at = |v: u32| mesh.positions[v as usize];
        let edge = |from: u32, to: u32| [0, 1, 2].map(|i| at(to)[i] - at(from)[i]);
        let (u, v) = (edge(a, b), edge(a, c));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        for corner in [a, b, c] {
            (0..3).for_each(|i| sums[corner as usize][i] += normal[i]);
        }
    }
    sums
}

fn unit(n: [f64; 3]) -> [f64; 3] {
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 0.0 && length.is_finite() { n.map(|x| x / length) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normals_of_a_flat_square_all_point_up() {
        let corners = vec![[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [2.0, 2.0, 5.0], [0.0, 2.0, 5.0]];
        let mesh = Mesh::from_triangles(corners, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(vertex_normals(&mesh), vec![[0.0, 0.0, 1.0]; 4]);
    }

    #[test]
    fn normals_of_the_file_come_first() {
        let mut mesh = Mesh::from_triangles(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]]);
        mesh.attributes.push(Attribute {
            kind: AttributeKind::Normal,
            name: "normal".into(),
            domain: Domain::Vertex,
            width: 3,
            scalar: super::super::Scalar::F32,
            values: vec![0.0, 3.0, 0.0, 1.0, 0.0, 0.0],
            indices: vec![1, 0, Attribute::NONE],
        });
        assert_eq!(vertex_normals(&mesh), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]]);
    }
}
