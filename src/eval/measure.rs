//! Every measure of a pair of meshes, by the names of `measures.md`.
//!
//! | name | what |
//! |---|---|
//! | `rms` | root mean square distance of points spread evenly over both surfaces, both directions pooled |
//! | `rms_max` | the larger of the two one-sided rms values (METRO, MeshLab) |
//! | `hausdorff` | the greatest distance of a sampled point or a vertex; with `exact` a certified upper bound |
//! | `psnr` | 20·log10(diag / rms), diag = box diagonal of the original |
//! | `psnr_vertex` | the same of the root mean square vertex displacement, where the vertices correspond |
//! | `normal_rms` | root mean square angle in degrees between unit normals at closest points |
//!
//! Distances are to the closest point on any triangle, in f64. Polygons are the fans of
//! [`Faces::triangles`](crate::Faces::triangles). Triangles with a corner that is not finite are left out and counted.

use glam::DVec3;

use super::report::json::Json;
use super::same::{Verdict, same};
use crate::distance::{Frame, SampleOptions, Sampled, Surface, certify, sample};
use crate::error::{Error, Result};
use crate::geom::Aabb;
use crate::mesh::{Attribute, AttributeKind, Domain, Mesh, Scalar};
use crate::par;
use crate::task::Task;

/// The psnr of surfaces that are equal to double precision, where the formula would say infinity.
const PSNR_OF_EQUALS: f64 = 999.0;

/// How [`compare`] measures.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct CompareOptions {
    /// Points on each surface; `None` for 10 a triangle and at least 200,000.
    pub samples: Option<usize>,
    /// Which points: the same seed always gives the same ones. Default 1.
    pub seed: u64,
    /// Certify the Hausdorff distance. Default no.
    pub exact: bool,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self { samples: None, seed: 1, exact: false }
    }
}

impl CompareOptions {
    /// The same options, with the Hausdorff distance certified.
    pub fn exact(mut self, exact: bool) -> Self {
        self.exact = exact;
        self
    }

    /// The same options with another number of points on each surface.
    pub fn samples(mut self, samples: usize) -> Self {
        self.samples = Some(samples);
        self
    }
}

/// Distances in one direction, in the units of the meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OneSided {
    /// Root mean square distance.
    pub rms: f64,
    /// Mean distance.
    pub mean: f64,
    /// The greatest distance of a sampled point or a vertex.
    pub hausdorff: f64,
    /// Points sampled.
    pub samples: usize,
    /// Triangles of this surface that were left out, since a corner is not finite or does not exist.
    pub left_out: usize,
}

/// What is certain of the Hausdorff distance.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HausdorffBounds {
    /// Some point is this far from the other surface.
    pub lower: f64,
    /// No point is farther than this.
    pub upper: f64,
}

/// How far two meshes are from each other.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Comparison {
    /// Root mean square distance, both directions pooled.
    pub rms: f64,
    /// The larger of the two one-sided rms values.
    pub rms_max: f64,
    /// The greatest distance seen; the certified upper bound if `exact` was asked for.
    pub hausdorff: f64,
    /// `20·log10(diag / rms)` in dB; 999 if the surfaces are equal to double precision.
    pub psnr: f64,
    /// The same of the vertex displacement; `None` where the vertices do not correspond.
    pub psnr_vertex: Option<f64>,
    /// Root mean square angle between normals in degrees; `None` if no point has both.
    pub normal_rms: Option<f64>,
    /// Points sampled, both directions together.
    pub samples: usize,
    /// Box diagonal of the original.
    pub diag: f64,
    /// Whether the two have the same connectivity up to renumbering.
    pub same_connectivity: Verdict,
    /// Vertices of the original and of the other.
    pub vertices: [usize; 2],
    /// Faces of the original and of the other.
    pub faces: [usize; 2],
    /// From the original to the other.
    pub there: OneSided,
    /// From the other to the original.
    pub back: OneSided,
    /// If `exact` was asked for: what is certain.
    pub certified: Option<HausdorffBounds>,
}

/// `20·log10(diag / rms)` in dB, and 999 where `rms` is zero to double precision.
pub fn psnr(diag: f64, rms: f64) -> f64 {
    if rms <= diag * 1e-15 { PSNR_OF_EQUALS } else { 20.0 * (diag / rms).log10() }
}

/// The box of all finite vertices.
fn finite_box(mesh: &Mesh) -> Aabb {
    Aabb::of(mesh.positions.iter().map(|&p| DVec3::from(p)).filter(|p| p.is_finite()))
}

/// Two meshes as surfaces in one frame around the first.
fn surfaces(a: &Mesh, b: &Mesh) -> Result<(Frame, Surface, Surface)> {
    let frame = Frame::around(finite_box(a), finite_box(b));
    let surface = |mesh: &Mesh| Surface::new(frame, &mesh.positions, &mesh.faces.triangles());
    let (a, b) = par::join(|| surface(a), || surface(b));
    for (which, surface) in [("first", &a), ("second", &b)] {
        if surface.is_empty() {
            return Err(Error::Parameter(format!("the {which} mesh has no face with finite corners: no surface to measure")));
        }
    }
    Ok((frame, a, b))
}

/// Measures how far mesh `b` is from the original `a`.
///
/// O(n log n) in faces and samples; `exact` adds what the certificate needs (measured: as much again).
///
/// # Errors
/// [`Error::Parameter`] if a mesh has no surface; [`Error::Cancelled`] if the task is over.
pub fn compare(a: &Mesh, b: &Mesh, options: &CompareOptions, task: &Task<'_>) -> Result<Comparison> {
    let (frame, from, to) = surfaces(a, b)?;
    task.step(0.1)?;
    let outside = |length: f64| frame.length_outside(length);
    let sampled = |from: &Surface, to: &Surface| {
        let samples = options.samples.unwrap_or_else(|| 200_000.max(10 * from.triangles().len())).max(1);
        sample(from, to, SampleOptions { samples, seed: options.seed }, task)
    };
    let there = sampled(&from, &to)?;
    task.step(0.35)?;
    let back = sampled(&to, &from)?;
    task.step(0.6)?;
    let certified = if options.exact {
        let there = certify(&from, &to, there.max.max(back.max), task)?;
        task.step(0.75)?;
        let back = certify(&to, &from, there.lower, task)?;
        Some(HausdorffBounds { lower: outside(back.lower), upper: outside(there.upper.max(back.upper)) })
    } else {
        None
    };
    task.step(0.9)?;
    let diag = finite_box(a).size().length();
    let correspondence = same(a, b, None, task)?;
    let displacement = correspondence.map.as_ref().map(|map| rms_displacement(a, b, map));
    task.step(1.0)?;

    let one_sided = |s: &Sampled, left_out| OneSided {
        rms: outside((s.sum2 / s.samples as f64).sqrt()),
        mean: outside(s.sum / s.samples as f64),
        hausdorff: outside(s.max),
        samples: s.samples,
        left_out,
    };
    let samples = there.samples + back.samples;
    let rms = outside(((there.sum2 + back.sum2) / samples as f64).sqrt());
    let angles = there.angles + back.angles;
    let (there, back, angle2) =
        (one_sided(&there, from.left_out()), one_sided(&back, to.left_out()), there.angle2 + back.angle2);
    Ok(Comparison {
        rms,
        rms_max: there.rms.max(back.rms),
        hausdorff: certified.map_or(there.hausdorff.max(back.hausdorff), |bounds| bounds.upper),
        psnr: psnr(diag, rms),
        psnr_vertex: displacement.map(|rms| psnr(diag, rms)),
        normal_rms: (angles > 0).then(|| (angle2 / angles as f64).sqrt()),
        samples,
        diag,
        same_connectivity: correspondence.verdict,
        vertices: [a.positions.len(), b.positions.len()],
        faces: [a.faces.len(), b.faces.len()],
        there,
        back,
        certified,
    })
}

/// Root mean square of how far vertices move under a map.
fn rms_displacement(a: &Mesh, b: &Mesh, map: &[u32]) -> f64 {
    let (mut sum2, mut n) = (0.0, 0_usize);
    for (p, &w) in a.positions.iter().zip(map) {
        if let Some(q) = b.positions.get(w as usize) {
            sum2 += DVec3::from(*p).distance_squared(DVec3::from(*q));
            n += 1;
        }
    }
    (sum2 / n.max(1) as f64).sqrt()
}

impl Comparison {
    /// The comparison as a JSON object, under the names of `measures.md`.
    ///
    /// `vertices` and `faces` are those of the original, `vertices_b` and `faces_b` of the other;
    /// `same_connectivity` is `null` where it could not be decided.
    pub fn to_json(&self) -> Json {
        let mut members = vec![
            ("rms", self.rms.into()),
            ("rms_max", self.rms_max.into()),
            ("hausdorff", self.hausdorff.into()),
            ("psnr", self.psnr.into()),
            ("psnr_vertex", self.psnr_vertex.into()),
            ("normal_rms", self.normal_rms.into()),
            ("samples", self.samples.into()),
            ("diag", self.diag.into()),
            ("same_connectivity", self.same_connectivity.to_json()),
            ("vertices", self.vertices[0].into()),
            ("faces", self.faces[0].into()),
            ("vertices_b", self.vertices[1].into()),
            ("faces_b", self.faces[1].into()),
        ];
        for (names, side) in [
            (["rms_ab", "mean_ab", "hausdorff_ab", "samples_ab", "left_out_a"], &self.there),
            (["rms_ba", "mean_ba", "hausdorff_ba", "samples_ba", "left_out_b"], &self.back),
        ] {
            let values: [Json; 5] =
                [side.rms.into(), side.mean.into(), side.hausdorff.into(), side.samples.into(), side.left_out.into()];
            members.extend(names.into_iter().zip(values));
        }
        if let Some(bounds) = self.certified {
            members.push(("hausdorff_lower", bounds.lower.into()));
            members.push(("hausdorff_upper", bounds.upper.into()));
        }
        Json::object(members)
    }
}

/// A copy of `mesh` that shows how far each vertex is from the surface of `other`.
///
/// The distance is an attribute named `distance` and a colour: blue where it is zero, over green
/// to red at the greatest distance. Vertex colours that `mesh` had are replaced. Vertices that are
/// not finite get the distance NaN and the colour grey.
///
/// # Errors
/// As [`compare`].
pub fn heatmap(mesh: &Mesh, other: &Mesh, task: &Task<'_>) -> Result<Mesh> {
    const CHUNK: usize = 4096;
    let (frame, _, to) = surfaces(mesh, other)?;
    let n = mesh.positions.len();
    let distances: Vec<f64> = par::map(n.div_ceil(CHUNK), |chunk| {
        let mut hint = 0;
        let measure = |p: &[f64; 3]| {
            let p = DVec3::from(*p);
            if !p.is_finite() || task.is_over() {
                return f64::NAN;
            }
            let hit = to.closest(frame.inside(p), hint);
            hint = hit.slot;
            frame.length_outside(hit.distance2.sqrt())
        };
        mesh.positions[chunk * CHUNK..n.min((chunk + 1) * CHUNK)].iter().map(measure).collect::<Vec<_>>()
    })
    .concat();
    task.step(1.0)?;
    let greatest = distances.iter().copied().fold(0.0, f64::max);
    let colours = distances.iter().flat_map(|&d| colour(if greatest > 0.0 { d / greatest } else { d })).collect();
    let mut painted = mesh.clone();
    painted.attributes.retain(|a| {
        a.domain != Domain::Vertex
            || (a.kind != AttributeKind::Colour && (a.kind != AttributeKind::Other || a.name != "distance"))
    });
    let attribute = |kind, name: &str, width, scalar, values| Attribute {
        kind,
        name: name.into(),
        domain: Domain::Vertex,
        width,
        scalar,
        values,
        indices: Vec::new(),
    };
    painted.attributes.push(attribute(AttributeKind::Colour, "red green blue", 3, Scalar::U8, colours));
    painted.attributes.push(attribute(AttributeKind::Other, "distance", 1, Scalar::F32, distances));
    Ok(painted)
}

/// The colour of a share, 0 to 1: blue, cyan, green, yellow, red; grey if it is NaN.
fn colour(share: f64) -> [f64; 3] {
    if share.is_nan() {
        return [128.0; 3];
    }
    let ramp = |centre: f64| (1.5 - (4.0 * share - centre).abs()).clamp(0.0, 1.0);
    [ramp(3.5), ramp(2.0), ramp(0.5)].map(|x| (255.0 * x).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of `n × n` cells at height `z(x, y)`.
    fn sheet(n: u32, z: impl Fn(f64, f64) -> f64) -> Mesh {
        let at = |i: u32| f64::from(i) / f64::from(n);
        let positions = (0..(n + 1) * (n + 1)).map(|k| (at(k % (n + 1)), at(k / (n + 1)))).map(|(x, y)| [x, y, z(x, y)]);
        let cells = (0..n * n).map(|k| k % n + k / n * (n + 1));
        let triangles = cells.flat_map(|k| [[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]]);
        Mesh::from_triangles(positions.collect(), triangles)
    }

    fn quick(exact: bool) -> CompareOptions {
        CompareOptions::default().samples(20_000).exact(exact)
    }

    #[test]
    fn sheets_at_an_even_distance_have_that_distance_in_every_measure() {
        let (a, b) = (sheet(8, |_, _| 0.0), sheet(8, |_, _| 0.25));
        let c = compare(&a, &b, &quick(true), &Task::default()).unwrap();
        for x in [c.rms, c.rms_max, c.hausdorff, c.there.mean, c.back.mean, c.certified.unwrap().lower] {
            assert!((x - 0.25).abs() < 1e-12, "{c:?}");
        }
        let psnr = 20.0 * (2.0_f64.sqrt() / 0.25).log10();
        assert!((c.psnr - psnr).abs() < 1e-9 && (c.psnr_vertex.unwrap() - psnr).abs() < 1e-9);
        assert_eq!((c.normal_rms, c.same_connectivity, c.samples), (Some(0.0), Verdict::Same, 40_000));
    }

    #[test]
    fn rms_over_a_slope_is_the_integral_that_paper_gives() {
        // Distances of a sheet tilted by the angle α to the plane below it, seen from the tilted side:
        // sin α · s for s uniform in [0, length], so that the mean square is sin²α · length² / 3.
        let (flat, tilted) = (sheet(1, |_, _| 0.0), sheet(1, |x, _| 0.1 * x));
        let c = compare(&tilted, &flat, &quick(true), &Task::default()).unwrap();
        assert!((c.there.rms - 0.1 / 3.0_f64.sqrt()).abs() < 1e-5, "{c:?}");
        assert!((c.hausdorff - 0.1).abs() < 1e-9);
        assert!((c.normal_rms.unwrap() - 0.1_f64.atan().to_degrees()).abs() < 1e-9);
    }

    #[test]
    fn a_mesh_is_at_distance_zero_from_itself_however_far_from_the_origin_or_small_it_is() {
        for scale in [1.0, 1e-150, 1e150] {
            let mut a = sheet(9, |x, y| (x * 5.0).sin() * y);
            for p in a.positions.iter_mut().flatten() {
                *p = (*p + 4e6) * scale;
            }
            let c = compare(&a, &a, &quick(true), &Task::default()).unwrap();
            assert_eq!((c.hausdorff, c.psnr, c.psnr_vertex), (0.0, 999.0, Some(999.0)), "scale {scale}: {c:?}");
        }
    }

    #[test]
    fn distances_grow_with_the_units() {
        let (a, b) = (sheet(9, |x, y| (x * 5.0).sin() * y), sheet(7, |x, y| x * y));
        let one = compare(&a, &b, &quick(true), &Task::default()).unwrap();
        // A power of two, so that no coordinate is rounded anew.
        let unit = 400.0_f64.exp2();
        let grow = |m: &Mesh| Mesh { positions: m.positions.iter().map(|p| p.map(|x| x * unit)).collect(), ..m.clone() };
        let big = compare(&grow(&a), &grow(&b), &quick(true), &Task::default()).unwrap();
        assert_eq!((big.rms / unit, big.hausdorff / unit), (one.rms, one.hausdorff));
        assert!((big.psnr - one.psnr).abs() < 1e-7);
    }

    #[test]
    fn faces_that_are_not_finite_are_left_out_and_counted() {
        let a = sheet(4, |_, _| 0.0);
        let mut b = a.clone();
        b.positions.push([f64::NAN, 0.0, 0.0]);
        b.faces.push(&[0, 1, 25]);
        b.faces.push(&[0, 1, 99]);
        let c = compare(&a, &b, &quick(false), &Task::default()).unwrap();
        assert_eq!((c.there.left_out, c.back.left_out, c.hausdorff), (0, 2, 0.0));
    }

    #[test]
    fn without_a_surface_there_is_an_error_that_says_which() {
        let error = compare(&sheet(1, |_, _| 0.0), &Mesh::default(), &quick(false), &Task::default()).unwrap_err();
        assert!(error.to_string().contains("second mesh has no face"), "{error}");
    }

    #[test]
    fn json_uses_the_names_of_the_measures() {
        let a = sheet(2, |_, _| 0.0);
        let json = compare(&a, &a, &quick(false), &Task::default()).unwrap().to_json();
        let names = "rms rms_max hausdorff psnr psnr_vertex normal_rms samples diag same_connectivity vertices faces";
        assert!(names.split(' ').all(|name| json.get(name).is_some()));
        assert_eq!(json.get("vertices"), Some(&Json::Integer(9)));
    }

    #[test]
    fn a_heatmap_is_red_where_the_distance_is_greatest() {
        let (a, b) = (sheet(4, |_, _| 0.0), sheet(4, |x, _| 0.5 * x));
        let map = heatmap(&b, &a, &Task::default()).unwrap();
        let [colours, distances] = &map.attributes[..] else { panic!("{:?}", map.attributes) };
        assert_eq!(distances.values[4], 0.5);
        assert_eq!(&colours.values[..3], &[0.0, 0.0, 255.0]);
        assert_eq!(&colours.values[12..15], &[255.0, 0.0, 0.0]);
        assert_eq!(heatmap(&map, &a, &Task::default()).unwrap().attributes.len(), 2);
    }

    #[cfg(feature = "parallel")]
    #[test]
    fn one_thread_and_three_measure_the_same_bits() {
        let (a, b) = (sheet(40, |x, y| (x * 5.0).sin() * y), sheet(33, |x, y| x * y));
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| compare(&a, &b, &quick(true), &Task::default()).unwrap())
        };
        assert_eq!(with(1), with(3));
    }
}
