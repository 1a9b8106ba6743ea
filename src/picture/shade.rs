//! A shaded view of a mesh by a z-buffer of our own: no graphics card, the same picture everywhere.
//!
//! Parallel projection; each pixel is sampled at four places, triangles are shaded by the angle
//! between their normal and the line of sight, smooth across edges that are not sharp.

use crate::error::Result;
use crate::mesh::{Mesh, vertex_normals};
use crate::plane::{Plane, Planes, Shape, bounding_box, write_png};

/// From where a mesh is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Turned about the upright (y) axis, in degrees.
    pub azimuth: f64,
    /// Raised above the horizon, in degrees.
    pub elevation: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self { azimuth: 30.0, elevation: 20.0 }
    }
}

/// Samples a pixel, on each axis.
const SAMPLES: usize = 2;
/// The share of the picture that is left free on each side.
const MARGIN: f64 = 0.04;
/// Faces at a larger angle (its cosine) to a vertex's normal are shaded flat there.
const SHARP: f64 = 0.7;
const BACKGROUND: [f64; 3] = [1.0, 1.0, 1.0];
const FRONT: [f64; 3] = [0.62, 0.72, 0.86];
const BACK: [f64; 3] = [0.86, 0.66, 0.52];

/// Renders a mesh into a PNG picture of `width` by `height` pixels.
///
/// # Errors
/// A picture without pixels, or one that is too large.
pub fn shade(mesh: &Mesh, width: u32, height: u32, camera: Camera) -> Result<Vec<u8>> {
    let shape = Shape::new(width, height)?;
    let view = View::new(mesh, shape, camera);
    let (columns, rows) = (shape.width() * SAMPLES, shape.height() * SAMPLES);
    let mut buffer = vec![(f64::NEG_INFINITY, BACKGROUND); columns * rows];
    let points: Vec<[f64; 3]> = mesh.positions.iter().map(|&p| view.project(p)).collect();
    let normals: Vec<[f64; 3]> = vertex_normals(mesh).into_iter().map(|n| view.turn(n)).collect();
    for t in mesh.faces.triangles() {
        draw(&mut buffer, columns, t.map(|v| points[v as usize]), t.map(|v| normals[v as usize]));
    }
    let mean = |at: usize, channel: usize| {
        let (row, column) = (at / shape.width() * SAMPLES, at % shape.width() * SAMPLES);
        let samples = (0..SAMPLES * SAMPLES).map(|k| buffer[(row + k / SAMPLES) * columns + column + k % SAMPLES].1[channel]);
        let linear = samples.sum::<f64>() / (SAMPLES * SAMPLES) as f64;
        (linear.clamp(0.0, 1.0) * 255.0 + 0.5) as i32
    };
    let planes = (0..3).map(|channel| Plane::new(shape, 8, (0..shape.pixels()).map(|at| mean(at, channel)).collect()));
    write_png(&Planes::new(planes.collect::<Result<_>>()?)?)
}

/// How space becomes the picture: x to the right, y down, z towards the eye.
struct View {
    axes: [[f64; 3]; 3],
    centre: [f64; 3],
    scale: f64,
    middle: [f64; 2],
}

impl View {
    fn new(mesh: &Mesh, shape: Shape, camera: Camera) -> Self {
        let (a, e) = (camera.azimuth.to_radians(), camera.elevation.to_radians());
        let axes = [
            [a.cos(), 0.0, -a.sin()],
            [-a.sin() * e.sin(), e.cos(), -a.cos() * e.sin()],
            [a.sin() * e.cos(), e.sin(), a.cos() * e.cos()],
        ];
        let turned = mesh.positions.iter().map(|&p| axes.map(|axis| dot(axis, p)));
        let [low, high] = bounding_box(turned).unwrap_or([[0.0; 3]; 2]);
        let size = [(shape.width() * SAMPLES) as f64, (shape.height() * SAMPLES) as f64];
        let fit = |i: usize| if high[i] > low[i] { size[i] * (1.0 - 2.0 * MARGIN) / (high[i] - low[i]) } else { f64::INFINITY };
        let scale = fit(0).min(fit(1));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        Self { axes, centre: [0, 1, 2].map(|i| (low[i] + high[i]) / 2.0), scale, middle: size.map(|s| s / 2.0) }
    }

    fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, v))
    }

    fn project(&self, p: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.turn(p);
        let [cx, cy, cz] = self.centre;
        [self.middle[0] + (x - cx) * self.scale, self.middle[1] - (y - cy) * self.scale, (z - cz) * self.scale]
    }
}

fn draw(buffer: &mut [(f64, [f64; 3])], columns: usize, points: [[f64; 3]; 3], normals: [[f64; 3]; 3]) {
    let [a, b, c] = points;
    // Twice the area, positive if the triangle shows its front (y runs down).
    let area = (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1]);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let rows = buffer.len() / columns;
    let range = |axis: usize, end: usize| {
        let low = a[axis].min(b[axis]).min(c[axis]).max(0.0) as usize;
        let high = (a[axis].max(b[axis]).max(c[axis]).max(0.0) as usize + 1).min(end);
        low..high
    };
    let face = face_normal(points);
    let side = if area > 0.0 { 1.0 } else { -1.0 };
    let smooth = normals.map(|n| if dot(n, face).abs() < SHARP { face } else { n });
    for row in range(1, rows) {
        for column in range(0, columns) {
            let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
            let part = |p: [f64; 3], q: [f64; 3]| ((q[0] - x) * (p[1] - y) - (p[0] - x) * (q[1] - y)) / area;
            let weights = [part(b, c), part(c, a), part(a, b)];
            if weights.iter().any(|&w| w < 0.0) {
                continue;
            }
            let z = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
            let pixel = &mut buffer[row * columns + column];
            if z > pixel.0 {
                let n = [0, 1, 2].map(|i| (0..3).map(|k| weights[k] * smooth[k][i]).sum::<f64>());
                let length = dot(n, n).sqrt().max(f64::MIN_POSITIVE);
                // One lamp at the eye, one above to the left.
                let facing = (n[2] / length * side).max(0.0);
                let above = ((0.6 * n[1] - 0.4 * n[0] + 0.7 * n[2]) / length * side).max(0.0);
                let light = 0.18 + 0.5 * facing + 0.32 * above;
                let colour = if area > 0.0 { FRONT } else { BACK };
                *pixel = (z, colour.map(|x| x * light));
            }
        }
    }
}

/// The unit normal of a projected triangle, y up.
fn face_normal(points: [[f64; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = points.map(|p| [p[0], -p[1], p[2]]);
    let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = dot(n, n).sqrt().max(f64::MIN_POSITIVE);
    n.map(|x| x / length)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The grey value of a pixel, and whether it is the background.
    fn pixel(png: &[u8], x: u32, y: u32) -> ([u8; 3], bool) {
        let picture = crate::plane::read_rgb(png);
        let p = picture[(y * 40 + x) as usize];
        (p, p == [255; 3])
    }

    #[test]
    fn the_nearer_of_two_triangles_is_seen_and_fronts_differ_from_backs() {
        let camera = Camera { azimuth: 0.0, elevation: 0.0 };
        let near = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
        let far = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let both = Mesh::from_triangles([near, far].concat(), [[0, 1, 2], [3, 4, 5]]);
        let back = Mesh::from_triangles(far.to_vec(), [[0, 1, 2]]);
        let (both, back) = (shade(&both, 40, 40, camera).unwrap(), shade(&back, 40, 40, camera).unwrap());
        let (front_colour, _) = pixel(&both, 10, 30);
        let (back_colour, _) = pixel(&back, 10, 30);
        assert!(front_colour[2] > front_colour[0], "{front_colour:?} is not the colour of fronts");
        assert!(back_colour[0] > back_colour[2], "{back_colour:?} is not the colour of backs");
        assert!(pixel(&both, 35, 5).1, "nothing is drawn beside the triangles");
    }
}
