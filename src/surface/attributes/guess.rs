//! What geometry and neighbours suggest for a value that is new.

use super::normals::Normals;
use super::octahedral::Octahedron;
use super::{Form, Ground, NONE, Shape, Values};
use crate::mesh::AttributeKind;

/// Guesses that are made of each value.
pub(super) const GUESSES: usize = 4;

/// What is known where a value is new.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scene {
    /// The vertex of the value; any for values of faces.
    pub(super) vertex: u32,
    /// The counted face; [`NONE`] if there is none.
    pub(super) face: u32,
    /// Values of the same sheet and their vertices: the corner before, another that makes an edge with it, a third.
    pub(super) near: [(u32, u32); 3],
    /// Whether the third lies across the edge of the other two, and not on this side.
    pub(super) is_across: bool,
}

impl Scene {
    pub(super) fn new(vertex: u32, face: u32) -> Self {
        Self { vertex, face, near: [(NONE, 0); 3], is_across: false }
    }
}

/// Makes guesses.
#[derive(Debug)]
pub(super) struct Guesser<'a> {
    ground: &'a Ground<'a>,
    shape: &'a Shape,
    normals: Normals,
    /// Which way round texture coordinates ran last: 1 as the face, −1 the other.
    pub(super) turn: f64,
}

impl<'a> Guesser<'a> {
    pub(super) fn new(ground: &'a Ground<'a>, shape: &'a Shape) -> Self {
        let is_octahedral = matches!(shape.form, Form::Octahedral { .. });
        let normals = if is_octahedral { Normals::new(ground) } else { Normals::default() };
        Self { ground, shape, normals, turn: 1.0 }
    }

    /// Guesses, one after the other, in `out`.
    pub(super) fn guess(&self, scene: &Scene, values: &Values, out: &mut Vec<i64>) {
        out.clear();
        if let Form::Octahedral { bits } = self.shape.form {
            self.directions(Octahedron::new(bits), scene, values, out);
        } else {
            self.numbers(scene, values, out);
        }
    }

    fn value<'v>(&self, values: &'v Values, value: u32) -> &'v [i64] {
        let n = self.shape.components;
        &values.integers[value as usize * n..(value as usize + 1) * n]
    }

    /// The vertex's normal in two ways, the face's, and the value before.
    fn directions(&self, octahedron: Octahedron, scene: &Scene, values: &Values, out: &mut Vec<i64>) {
        let of_vertex = |normals: &[[f64; 3]]| octahedron.nearest(normals[scene.vertex as usize]);
        let face = self.normals.faces.get(scene.face as usize).copied().unwrap_or_default();
        out.extend(of_vertex(&self.normals.by_area));
        out.extend(of_vertex(&self.normals.alike));
        out.extend(octahedron.nearest(face));
        match scene.near[0].0 {
            NONE => out.extend([0, 0, octahedron.n()]),
            before => out.extend_from_slice(self.value(values, before)),
        }
    }

    /// An affine or conformal map of the surface, the parallelogram, the value before, and the mean of two.
    fn numbers(&self, scene: &Scene, values: &Values, out: &mut Vec<i64>) {
        let n = self.shape.components;
        let real = |(value, _): (u32, u32), i: usize| self.shape.form.real(self.value(values, value)[i], self.shape.scalar);
        let [a, b, d] = scene.near;
        if a.0 == NONE {
            out.resize(GUESSES * n, 0);
            return;
        }
        if b.0 == NONE {
            (0..GUESSES).for_each(|_| out.extend_from_slice(self.value(values, a.0)));
            return;
        }
        let mut push = |x: f64| out.push(self.shape.form.guessed(x, self.shape.scalar));
        let foot = Foot::new(self.ground, scene);
        for i in 0..n {
            let (ua, ub) = (real(a, i), real(b, i));
            let along = ua + foot.share * (ub - ua);
            push(match foot.third {
                Some((share, ratio)) => along + ratio * (real(d, i) - ua - share * (ub - ua)),
                // A right angle to the edge, turned as the last one was.
                None if self.shape.kind == AttributeKind::TexCoord && n == 2 => {
                    let across = real(b, 1 - i) - real(a, 1 - i);
                    along + foot.height * self.turn * if i == 0 { -across } else { across }
                }
                None => along,
            });
        }
        for i in 0..n {
            let third = if d.0 == NONE { real(b, i) } else { real(d, i) };
            push(real(a, i) + real(b, i) - third);
        }
        out.extend_from_slice(self.value(values, a.0));
        let mut push = |x: f64| out.push(self.shape.form.guessed(x, self.shape.scalar));
        (0..n).for_each(|i| push((real(a, i) + real(b, i)) * 0.5));
    }

    /// Sees which way round texture coordinates run.
    pub(super) fn learn(&mut self, scene: &Scene, values: &Values, value: u32) {
        let [a, b, _] = scene.near;
        if self.shape.kind != AttributeKind::TexCoord || self.shape.components != 2 || b.0 == NONE {
            return;
        }
        let real = |value: u32, i: usize| self.shape.form.real(self.value(values, value)[i], self.shape.scalar);
        let side = |v: u32, i: usize| real(v, i) - real(a.0, i);
        let turn = side(b.0, 0) * side(value, 1) - side(b.0, 1) * side(value, 0);
        if turn != 0.0 {
            self.turn = if turn > 0.0 { 1.0 } else { -1.0 };
        }
    }
}

/// Where a vertex stands above the edge from a to b, in lengths of the edge.
struct Foot {
    share: f64,
    height: f64,
    /// The share of the third vertex, and how much higher this one is than that.
    third: Option<(f64, f64)>,
}

impl Foot {
    fn new(ground: &Ground<'_>, scene: &Scene) -> Self {
        let at = |v: u32| ground.positions[v as usize].map(f64::from);
        let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let [a, b, d] = scene.near;
        let origin = at(a.1);
        let edge = minus(at(b.1), origin);
        let square = dot(edge, edge);
        if square == 0.0 {
            return Self { share: 0.5, height: 0.0, third: None };
        }
        let upright = |p: [f64; 3]| {
            let p = minus(p, origin);
            let share = dot(p, edge) / square;
            (share, minus(p, edge.map(|x| x * share)))
        };
        let (share, up) = upright(at(scene.vertex));
        let height = (dot(up, up) / square).sqrt();
        let mut third = None;
        if d.0 != NONE {
            let (share, other) = upright(at(d.1));
            let other_height = (dot(other, other) / square).sqrt();
            if other_height > 1.0 / 256.0 {
                let ratio = if scene.is_across { -height / other_height } else { dot(up, other) / dot(other, other) };
                third = Some((share, ratio.clamp(-64.0, 64.0)));
            }
        }
        Self { share, height, third }
    }
}
