//! Positions with learned predictions: the efforts `default` and `best`.
//!
//! For every vertex, in the order of [`order`](super::order): the [`features`] that its neighbours
//! suggest are summed with weights learned by [`least_squares`]; [`scale`] learns how far off that
//! will be, along the normal and across it; each coordinate, given those before it, becomes a
//! density ([`density`]), which [`coordinate`] mixes with adaptive contexts into chances.
//!
//! Everything a reader must repeat is + − × ÷ √ on `f64` in a fixed order. spec/surface.md,
//! "Positions, learned".

#[cfg(feature = "encode")]
mod aim;
mod around;
mod contexts;
mod coordinate;
mod density;
mod features;
mod frame;
mod least_squares;
mod local;
mod math;
mod palette;
mod quadric;
mod ring;
mod scale;
mod slide;
#[cfg(test)]
mod tests;
mod trained;
mod vector;
mod window;

#[cfg(feature = "encode")]
pub(in crate::surface) use self::aim::Aim;
#[cfg(feature = "encode")]
pub(crate) use self::aim::Hold;
use self::around::{Around, Suggestions};
use self::contexts::{Landmarks, Moment};
use self::coordinate::Coordinates;
use self::features::View;
use self::frame::Frame;
pub(in crate::surface) use self::frame::{LONGEST_STRETCH, PARTS, snap};
use self::least_squares::LeastSquares;
use self::local::Local;
use self::math::cot;
use self::palette::Values;
#[cfg(feature = "encode")]
pub(in crate::surface) use self::palette::choices;
use self::ring::{Gate, Ring, Sums};
use self::scale::{Expected, Scale};
use self::trained::Start;
pub(in crate::surface) use self::vector::Vector;
use self::window::Window;
use super::order::Order;
use super::stretch::{Coarse, Sliding, Stretch};
use super::topology::Surface;
use crate::entropy::BitCoder;
use crate::error::{Error, Place, Result};
use crate::mesh::half_edge::{next, prev};
use crate::task::Task;

/// Steps that [`code`] takes, a vertex.
pub(super) const STEPS_A_VERTEX: u64 = 1024;

/// Connectivity as the features see it: the same for all ranges of a surface.
#[derive(Debug)]
pub(super) struct Degrees {
    /// Faces around each vertex; at the boundary twice those of the mesh, as if the other half were there.
    degree: Vec<f64>,
    is_boundary: Vec<bool>,
    /// Cotangents of the angles at two corners of a triangle whose angles are inverse to valences.
    cotangents: Vec<[f64; 2]>,
}

/// Valences from 3 to this have entries of their own in the table of cotangents.
const VALENCE_CAP: usize = 15;

impl Degrees {
    /// Memory a vertex.
    pub(super) const BYTES: usize = size_of::<f64>() + size_of::<bool>();

    pub(super) fn new(surface: &Surface) -> Self {
        let mut is_boundary = vec![false; surface.valence.len()];
        for t in &surface.triangles {
            if t.iter().any(|&v| surface.is_hole[v as usize]) {
                t.iter().for_each(|&v| is_boundary[v as usize] = true);
            }
        }
        let degree = surface.valence.iter().zip(&is_boundary).map(|(&valence, &boundary)| {
            let valence = f64::from(valence);
            if boundary { (2.0 * (valence - 2.0)).max(3.0) } else { valence }
        });
        let degree = degree.collect();
        let range = VALENCE_CAP - 2;
        let cotangents = (0..range * range * range).map(|i| {
            let inverse = [i / range / range, i / range % range, i % range].map(|d| 1.0 / (d + 3) as f64);
            let s = std::f64::consts::PI / (inverse[0] + inverse[1] + inverse[2]);
            [cot(s * inverse[0]), cot(s * inverse[1])]
        });
        Self { degree, is_boundary, cotangents: cotangents.collect() }
    }
}

/// Everything known when a vertex is predicted.
pub(super) struct Scene<'a> {
    surface: &'a Surface,
    outgoing: &'a [u32],
    degrees: &'a Degrees,
    order: Order<'a>,
    first: u32,
    positions: Vec<Vector>,
    residuals: Vec<Vector>,
    /// |residual| along the normal and across it.
    errors: Vec<[f64; 2]>,
    /// No residual is larger.
    largest: f64,
}

impl Scene<'_> {
    #[inline]
    fn at(&self, v: u32) -> Vector {
        self.positions[(v - self.first) as usize]
    }

    #[inline]
    fn residual(&self, v: u32) -> Vector {
        self.residuals[(v - self.first) as usize]
    }

    /// Whether `v` is a vertex of the range, and no hole.
    fn has(&self, v: u32) -> bool {
        (v.wrapping_sub(self.first) as usize) < self.positions.len() && !self.surface.is_hole[v as usize]
    }

    fn parallelogram(&self, g: &Gate) -> Vector {
        self.at(g.a) + self.at(g.b) - self.at(g.c)
    }

    /// The two other half-edges of the face of `h`.
    fn sides(&self, h: u32) -> [u32; 2] {
        [next(h), prev(h)]
    }

    fn ends(&self, h: u32) -> [Vector; 2] {
        [self.at(self.surface.from(h)), self.at(self.surface.from(next(h)))]
    }

    /// The position of the vertex across `h`, if it is known.
    fn known_apex(&self, h: u32) -> Option<Vector> {
        let apex = self.surface.apex(self.surface.opposite[h as usize]);
        self.order.is_known(apex).then(|| self.at(apex))
    }

    fn is_boundary(&self, v: u32) -> bool {
        self.degrees.is_boundary[v as usize]
    }

    fn degree(&self, v: u32) -> f64 {
        self.degrees.degree[v as usize]
    }

    /// Neighbours that are vertices of the mesh.
    fn neighbours(&self, v: u32) -> u32 {
        self.surface.valence[v as usize] - u32::from(self.is_boundary(v))
    }

    /// Cotangents of the angles at a and b of a triangle (a, b, c) whose angles are inverse to the degrees.
    fn cotangents(&self, a: u32, b: u32, c: u32) -> [f64; 2] {
        let index = |v: u32| (self.degree(v) as usize).clamp(3, VALENCE_CAP) - 3;
        let range = VALENCE_CAP - 2;
        self.degrees.cotangents[(index(a) * range + index(b)) * range + index(c)]
    }

    /// The angle that each unknown face has left at `v`.
    fn free_angle(&self, sums: &Sums, v: u32) -> f64 {
        use std::f64::consts::PI;
        let (known, sum) = sums.angles(v);
        let faces = f64::from(self.surface.valence[v as usize]) - if self.is_boundary(v) { 2.0 } else { 0.0 };
        let full = match (self.is_boundary(v), faces >= 3.0) {
            (false, _) => 2.0 * PI,
            (true, _) => PI * faces / 3.0,
        };
        ((full - sum) / (faces - f64::from(known)).max(1.0)).clamp(0.2, 1.9)
    }

    /// The mean errors of the known neighbours, and, with half the weight, of the vertices across the gates.
    fn mean_errors(&self, ring: &Ring) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for &a in &ring.known {
            let e = self.errors[(a - self.first) as usize];
            (0..2).for_each(|i| sum[i] += e[i]);
        }
        for g in &ring.gates {
            let e = self.errors[(g.c - self.first) as usize];
            (0..2).for_each(|i| sum[i] += 0.5 * e[i]);
        }
        sum.map(|s| s / (ring.known.len() + ring.gates.len()).max(1) as f64)
    }
}

/// The coder of one range, with `F` features (`L` of them local), `N` contexts and `E` densities.
pub(super) struct Coder<'a, const F: usize, const L: usize, const N: usize, const E: usize> {
    scene: Scene<'a>,
    coarse: Option<Coarse<'a>>,
    /// In all stages but the first.
    around: Option<Around>,
    /// Where vertices slide.
    sliding: Option<Sliding<'a>>,
    extent: [i32; 3],
    sums: Sums,
    quadrics: quadric::Fit,
    ring: Ring,
    /// By the number of gates: 1, 2, 3, 4 or more, all neighbours known.
    weights: Vec<LeastSquares<F>>,
    scales: Vec<Scale>,
    coordinates: Coordinates<N, E>,
    values: [Values; 3],
    local: Local<L>,
    /// By class: how much of the learned shift and of the local suggestion to add.
    blends: Vec<LeastSquares<2>>,
    /// The last residuals coded, of any axis; and the last of each axis.
    last: [i64; 2],
    last_of_axis: [i64; 3],
}

/// The cell of a coarser lattice in which a vertex is known to lie.
#[derive(Debug, Clone, Copy)]
struct Cell {
    place: [i32; 3],
    shift: u32,
}

/// A vertex as it is expected to be.
struct Forecast {
    class: usize,
    view: Option<View>,
    expected: Option<Expected>,
    /// What lies around, in all stages but the first.
    suggestions: Option<Suggestions>,
    /// What the learned weights add to the mean parallelogram, and what the neighbourhood suggests beyond that.
    shift: Vector,
    nearby: Vector,
    /// The learned prediction, the mean parallelogram, the prediction by valences.
    means: [Vector; 3],
    normal: Vector,
    /// Expected |residual| across the normal and along it.
    scale: [f64; 2],
    /// The lattice of the vertex, where vertices slide.
    frame: Option<Frame>,
}

/// Memory that [`code_lean`] takes for so many vertices.
pub(super) fn memory_lean(vertices: usize) -> u64 {
    memory::<LOCAL_LEAN, { contexts::LEAN }>(vertices)
}

/// Memory that [`code_full`] takes for so many vertices.
pub(super) fn memory_full(vertices: usize) -> u64 {
    memory::<LOCAL_FULL, { contexts::ALL }>(vertices)
}

fn memory<const L: usize, const N: usize>(vertices: usize) -> u64 {
    let scene = size_of::<[Vector; 2]>() + size_of::<[f64; 2]>();
    let taken = size_of::<u32>();
    let a_vertex = (scene + taken) as u64 + Order::BYTES + Sums::BYTES + Local::<L>::BYTES;
    vertices as u64 * a_vertex + Coordinates::<N, 0>::memory(vertices)
}

/// Features that the local fit uses, by effort.
const LOCAL_LEAN: usize = 12;
const LOCAL_FULL: usize = 20;

/// Codes the positions of a stretch for effort `default`; see [`plain::code`](super::plain::code).
pub(super) fn code_lean<C: BitCoder>(
    coder: &mut C,
    stretch: Stretch<'_>,
    degrees: &Degrees,
    positions: &mut [[i32; 3]],
    task: Task<'_>,
) -> Result<()> {
    code::<C, _, LOCAL_LEAN, _, _>(coder, stretch, degrees, positions, &trained::LEAN, task)
}

/// The same for effort `best`.
pub(super) fn code_full<C: BitCoder>(
    coder: &mut C,
    stretch: Stretch<'_>,
    degrees: &Degrees,
    positions: &mut [[i32; 3]],
    task: Task<'_>,
) -> Result<()> {
    code::<C, _, LOCAL_FULL, _, _>(coder, stretch, degrees, positions, &trained::ALL, task)
}

fn code<C: BitCoder, const F: usize, const L: usize, const N: usize, const E: usize>(
    coder: &mut C,
    stretch: Stretch<'_>,
    degrees: &Degrees,
    positions: &mut [[i32; 3]],
    start: &Start<F, N, E>,
    task: Task<'_>,
) -> Result<()> {
    let first = stretch.range.start;
    let holes = &stretch.surface.is_hole[first as usize..];
    let real = || positions.iter().zip(holes).filter(|(_, hole)| !**hole).map(|(p, _)| *p);
    let mut values = [0, 1, 2].map(|axis| {
        if stretch.sliding.is_some() {
            return Some(Values::Around { most: slide::farthest(stretch.extent) });
        }
        let (extent, as_palette) = (stretch.extent[axis], stretch.palettes[axis]);
        Values::code(coder, extent, positions.len(), as_palette, real().map(|p| p[axis]))
    });
    let damaged = |what: String| Error::malformed(Place::Whole, format!("positions: {what}"));
    let [Some(x), Some(y), Some(z)] = values.each_mut().map(Option::take) else {
        return Err(damaged("a palette that does not fit the box".into()));
    };
    let values = [x, y, z];
    let mut this = Coder::<F, L, N, E>::new(stretch, degrees, values, start);
    let mut count = 0_usize;
    while let Some(v) = this.scene.order.next() {
        let i = (v - first) as usize;
        let Some(position) = this.vertex(coder, v, positions[i]) else {
            return Err(damaged(format!("a coordinate of vertex {v} is outside the box")));
        };
        positions[i] = position;
        count += 1;
        if count.is_multiple_of(1 << 12) {
            if coder.is_exhausted() {
                break;
            }
            task.step(count as f64 / positions.len() as f64)?;
        }
    }
    if coder.is_exhausted() {
        return Err(damaged(format!("the stream ends after {count} vertices")));
    }
    Ok(())
}

impl<'a, const F: usize, const L: usize, const N: usize, const E: usize> Coder<'a, F, L, N, E> {
    fn new(stretch: Stretch<'a>, degrees: &'a Degrees, values: [Values; 3], start: &Start<F, N, E>) -> Self {
        let Stretch { surface, outgoing, range, extent, coarse, sliding, .. } = stretch;
        let len = range.len();
        let scale = if sliding.is_some() { Scale::in_units } else { Scale::new };
        let widest = f64::from(extent.into_iter().max().unwrap_or(0)) / if sliding.is_some() { PARTS } else { 1.0 };
        Self {
            sliding,
            extent,
            coarse,
            around: coarse.map(|_| Around::new(start.predictions.len())),
            sums: Sums::new(&range),
            quadrics: quadric::Fit::new(&range),
            ring: Ring::default(),
            weights: start.predictions.iter().map(|w| LeastSquares::new(*w, 0.9995, 0.03)).collect(),
            scales: start.scales.iter().map(|w| scale(*w)).collect(),
            coordinates: Coordinates::new(len, start.mixing),
            values,
            local: Local::new(len),
            blends: start.blends.iter().map(|w| LeastSquares::new(*w, 0.999, 0.1)).collect(),
            last: [0; 2],
            last_of_axis: [0; 3],
            scene: Scene {
                surface,
                outgoing,
                degrees,
                first: range.start,
                // What is not known yet stands in the middle of its cell.
                positions: coarse
                    .map_or(vec![Vector::ZERO; len], |c| c.positions.iter().map(|p| Vector(c.middle(*p))).collect()),
                residuals: vec![Vector::ZERO; len],
                errors: vec![[0.0; 2]; len],
                largest: widest + 1.0,
                order: Order::new(surface, outgoing, range),
            },
        }
    }

    /// Codes one vertex; `None` if what was read is no position.
    fn vertex<C: BitCoder>(&mut self, coder: &mut C, v: u32, position: [i32; 3]) -> Option<[i32; 3]> {
        self.ring.fill(self.scene.surface, self.scene.outgoing, &self.scene.order, v);
        let forecast = self.forecast(v);
        for axis in 0..3 {
            forecast.means.iter().for_each(|mean| coder.watch(|| mean[axis]));
        }
        forecast.scale.iter().for_each(|&scale| coder.watch(|| scale));
        let position = if let Some(frame) = &forecast.frame {
            #[cfg(feature = "encode")]
            let offsets = if C::WRITES { self.offsets(&forecast, frame, v) } else { [0; 3] };
            #[cfg(not(feature = "encode"))]
            let offsets = [0; 3];
            let position = frame.position(self.places(coder, &forecast, frame, offsets)?, self.extent);
            self.learn(&forecast, v, Vector(position.map(|x| f64::from(x) / PARTS)));
            position
        } else {
            let cell = self.coarse.map(|c| Cell { place: c.positions[(v - self.scene.first) as usize], shift: c.shift });
            let position = self.coordinates(coder, &forecast, cell, position)?;
            self.learn(&forecast, v, Vector(position.map(f64::from)));
            position
        };
        Some(position)
    }

    fn forecast(&mut self, v: u32) -> Forecast {
        let scene = &self.scene;
        let ring = &self.ring;
        if ring.gates.is_empty() {
            let largest = scene.largest;
            let (base, length) = match (ring.edge, ring.known.first()) {
                (Some([a, b]), _) => ((scene.at(a) + scene.at(b)) * 0.5, (scene.at(b) - scene.at(a)).length() + 1.0),
                (None, Some(&a)) => (scene.at(a), largest / 16.0),
                (None, None) => (Vector([largest / 2.0; 3]), largest / 4.0),
            };
            let scale = [0.6 * length; 2].map(|s| s.clamp(0.05, largest.max(0.05)));
            let frame = self.sliding.map(|_| Frame { centre: self.in_box(base), ..Frame::plain() });
            return Forecast {
                class: 0,
                suggestions: None,
                view: None,
                expected: None,
                shift: Vector::ZERO,
                nearby: Vector::ZERO,
                means: [frame.map_or(base, |frame| frame.centre), base, base],
                normal: Vector([0.0, 0.0, 1.0]),
                scale,
                frame,
            };
        }
        let view = features::view::<F>(scene, ring, &self.sums, &mut self.quadrics, v);
        let all_known = ring.known.len() as u32 >= scene.neighbours(v);
        let class = if all_known { 4 } else { ring.gates.len().min(5) - 1 };
        let mut shift = Vector::ZERO;
        for axis in 0..3 {
            shift.0[axis] = self.weights[class].predict(&inputs(&view, axis, 1.0)) * view.length;
        }
        let size = shift.length();
        // A prediction that runs off means nothing.
        if !(size <= scene.largest) {
            shift = Vector::ZERO;
        }
        let mut frame = self.sliding.map(|sliding| Frame::new(scene, ring, &view, v, &sliding));
        let units = frame.map_or([1.0; 2], |frame| [frame.steps[0], frame.steps[2]]);
        let expected = self.scales[class].expect(scene, ring, &view, shift.length(), units, v);
        let longest = 2.0 * expected.across + 1.0;
        let nearby = self.local.suggest(scene, self.quadrics.points(), &view, class, longest);
        let mut blended = shift;
        for axis in 0..3 {
            let x = [shift[axis] / view.length, nearby[axis] / view.length];
            blended.0[axis] += self.blends[class].predict(&x) * view.length;
        }
        let mut prediction = view.base + blended;
        let suggestions = self.around.as_ref().map(|around| {
            let suggestions = Suggestions::new(scene, ring, v, prediction);
            prediction = around.correct(class, &suggestions, view.length, scene.largest);
            suggestions
        });
        if let Some(frame) = &mut frame {
            frame.centre = self.in_box(prediction);
            prediction = frame.centre;
        }
        Forecast {
            class,
            means: [prediction, view.base, view.by_valence],
            frame,
            suggestions,
            shift,
            nearby,
            normal: view.normal,
            scale: [expected.across, expected.along],
            view: Some(view),
            expected: Some(expected),
        }
    }

    /// Codes the three coordinates, the one nearest to the normal last, each given those before it.
    fn coordinates<C: BitCoder>(
        &mut self,
        coder: &mut C,
        forecast: &Forecast,
        cell: Option<Cell>,
        position: [i32; 3],
    ) -> Option<[i32; 3]> {
        let n = forecast.normal;
        let steepest = (0..3).fold(0, |best, axis| if n[axis].abs() > n[best].abs() { axis } else { best });
        let mut axes = [0, 1, 2];
        axes.swap(2, steepest);
        let [across, along] = forecast.scale;
        let (across, along) = (0.55 * across * across, 1.2 * along * along);
        let covariance = |i: usize, j: usize| (if i == j { across + 0.05 } else { 0.0 }) + (along - across) * n[i] * n[j];
        let landmarks = Landmarks::new(&self.scene, &self.ring);
        let mut coded = [0; 3];
        let mut surprise = 0.0_f64;
        for (rank, &axis) in axes.iter().enumerate() {
            let mut variance = covariance(axis, axis);
            let mut given = [0.0; 3];
            let off = |mean: usize, axis: usize, coded: &[i32; 3]| f64::from(coded[axis]) - forecast.means[mean][axis];
            match rank {
                1 => {
                    let p = axes[0];
                    let g = covariance(axis, p) / covariance(p, p);
                    variance -= g * covariance(axis, p);
                    (0..3).for_each(|m| given[m] = g * off(m, p, &coded));
                }
                2 => {
                    let (p, r) = (axes[0], axes[1]);
                    let (a, b, d) = (covariance(p, p), covariance(p, r), covariance(r, r));
                    let inverse = 1.0 / (a * d - b * b);
                    let g = [
                        (covariance(axis, p) * d - covariance(axis, r) * b) * inverse,
                        (covariance(axis, r) * a - covariance(axis, p) * b) * inverse,
                    ];
                    variance -= g[0] * covariance(axis, p) + g[1] * covariance(axis, r);
                    (0..3).for_each(|m| given[m] = g[0] * off(m, p, &coded) + g[1] * off(m, r, &coded));
                }
                _ => {}
            }
            let deviation = variance.max(0.02).sqrt();
            let means = [0, 1, 2].map(|m| forecast.means[m][axis] + given[m]);
            let window = match cell {
                Some(Cell { place, shift }) => Window::cell(&self.values[axis], place[axis], shift)?,
                None => Window::all(&self.values[axis]),
            };
            let centre = window.nearest(means[0]);
            let moment = Moment {
                base: forecast.means[1][axis],
                frame: None,
                landmarks: &landmarks,
                window,
                axis,
                rank,
                centre,
                means,
                deviation,
                surprise,
                last: self.last,
                last_of_axis: self.last_of_axis[axis],
            };
            let densities = moment.densities::<E>();
            let index = if C::WRITES { window.index(position[axis]) } else { 0 };
            let index = self.coordinates.code(coder, index, centre, window, &densities, moment.contexts(), rank);
            coded[axis] = window.value(index)?;
            let z = (f64::from(coded[axis]) - means[0]).abs() / deviation.max(0.3);
            surprise = if rank == 0 { z } else { z.max(0.7 * surprise) };
            self.last = [index - centre, self.last[0]];
            self.last_of_axis[axis] = index - centre;
        }
        Some(coded)
    }

    /// Learns from a vertex that is known now.
    fn learn(&mut self, forecast: &Forecast, v: u32, position: Vector) {
        let i = (v - self.scene.first) as usize;
        let residual = position - forecast.means[0];
        let along = residual.dot(forecast.normal).abs();
        let across = (residual.dot(residual) - along * along).max(0.0).sqrt();
        self.scene.positions[i] = position;
        self.scene.residuals[i] = residual;
        self.scene.errors[i] = [1.0; 2];
        if let (Some(view), Some(expected)) = (&forecast.view, &forecast.expected) {
            self.scene.errors[i] = [along, across];
            self.scales[forecast.class].learn(expected, across, along);
            let plain = position - view.base - forecast.shift;
            self.local.learn(i, view, forecast.class, plain);
            // Certain vertices teach more, and no vertex teaches more than its expected error allows.
            let weight = (1.0 / (0.02 + (expected.across + 0.5) / view.length)).min(20.0).sqrt();
            let most = (6.0 * expected.across + 2.0) / view.length * weight;
            let scale = weight / view.length;
            for axis in 0..3 {
                learn(
                    &mut self.weights[forecast.class],
                    &inputs(view, axis, weight),
                    (position[axis] - view.base[axis]) * scale,
                    most,
                );
                let x = [forecast.shift[axis] * scale, forecast.nearby[axis] * scale];
                learn(&mut self.blends[forecast.class], &x, plain[axis] * scale, most);
            }
            if let (Some(around), Some(suggestions)) = (&mut self.around, &forecast.suggestions) {
                around.learn(forecast.class, suggestions, position, scale, most);
            }
        }
        self.scene.order.learn(v);
        let scene = &self.scene;
        self.sums.learn(scene.surface, scene.outgoing, &scene.order, |v| scene.at(v), v);
    }
}

/// Learns that `x` gave `y`, but moves as if the error were at most `most`.
fn learn<const M: usize>(model: &mut LeastSquares<M>, x: &[f64; M], y: f64, most: f64) {
    if !(most >= 0.0) {
        return; // weights that ran off gave no bound
    }
    let error = (y - model.predict(x)).clamp(-most, most);
    if error.is_finite() {
        model.learn(x, error);
    }
}

/// The features of one axis, in units of the edge length, times a weight.
fn inputs<const F: usize>(view: &View, axis: usize, weight: f64) -> [f64; F] {
    let mut x = [0.0; F];
    let scale = weight / view.length;
    for (x, feature) in x.iter_mut().zip(&view.features) {
        *x = feature[axis] * scale;
    }
    x
}
