//! What the geometry says about normals: those of faces, and of vertices as means of faces.

use super::Ground;

/// Normals in floats; null vectors where there is none.
#[derive(Debug, Default)]
pub(super) struct Normals {
    /// By counted face, unit vectors.
    pub(super) faces: Vec<[f64; 3]>,
    /// By vertex: faces weighted by their areas.
    pub(super) by_area: Vec<[f64; 3]>,
    /// By vertex: faces weighted alike.
    pub(super) alike: Vec<[f64; 3]>,
}

impl Normals {
    pub(super) fn new(ground: &Ground<'_>) -> Self {
        let vertices = ground.positions.len();
        let mut normals = Self { faces: Vec::new(), by_area: vec![[0.0; 3]; vertices], alike: vec![[0.0; 3]; vertices] };
        for f in 0..ground.corners.face_count() as u32 {
            let face = ground.corners.of_face(f);
            let area = area(ground, face);
            let length = (area[0] * area[0] + area[1] * area[1] + area[2] * area[2]).sqrt();
            let unit = if length > 0.0 { area.map(|x| x / length) } else { [0.0; 3] };
            for &v in face {
                add(&mut normals.by_area[v as usize], area);
                add(&mut normals.alike[v as usize], unit);
            }
            normals.faces.push(unit);
        }
        normals
    }
}

fn add(to: &mut [f64; 3], what: [f64; 3]) {
    for (to, what) in to.iter_mut().zip(what) {
        *to += what;
    }
}

/// Newell's normal: twice the area long.
fn area(ground: &Ground<'_>, face: &[u32]) -> [f64; 3] {
    let at = |v: u32| ground.positions[v as usize].map(f64::from);
    let mut sum = [0.0; 3];
    for (i, &v) in face.iter().enumerate() {
        let (p, q) = (at(v), at(face[if i + 1 == face.len() { 0 } else { i + 1 }]));
        let turn = |i: usize, j: usize| (p[i] - q[i]) * (p[j] + q[j]);
        add(&mut sum, [turn(1, 2), turn(2, 0), turn(0, 1)]);
    }
    sum
}
