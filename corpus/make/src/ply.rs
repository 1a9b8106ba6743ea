//! Binary little-endian PLY with `float` coordinates and `uchar int` faces.

use crate::Shape;

pub(crate) fn write(shape: &Shape) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        shape.positions.len(),
        shape.triangles.len()
    )
    .into_bytes();
    for x in shape.positions.iter().flatten() {
        out.extend((*x as f32).to_le_bytes());
    }
    for triangle in &shape.triangles {
        out.push(3);
        triangle.iter().for_each(|v| out.extend((*v as i32).to_le_bytes()));
    }
    out
}
