//! One chart of a surface, ready to be sampled.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};

use super::adjust::adjust;
use super::fit::{Damping, Target};
use super::interest;
use super::rim::Rim;
use super::spread::Sample;
use super::{Adjust, Sampler};
use crate::error::{Error, Result};
use crate::geom::{Aabb, Bvh};
use crate::mesh::HalfEdges;
use crate::par;
use crate::param::{self, Chart, Flattening, area};
use crate::plane::{GeometryImage, Gluing, Mask, Shape};
use crate::task::Task;

/// Rounds of [`Adjust::Fit`].
const FITS: usize = 2;

/// Lengths of about one around the origin, whatever the units of the mesh.
#[derive(Debug, Clone, Copy)]
struct Frame {
    centre: DVec3,
    /// A power of two, so that scaling is exact.
    scale: f64,
}

impl Frame {
    fn around(positions: &[[f64; 3]]) -> Self {
        let aabb = Aabb::of(positions.iter().map(|&p| DVec3::from(p)));
        let reach = if aabb.is_empty() { 0.0 } else { (aabb.hi - aabb.lo).max_element() };
        let exponent = if reach > 0.0 && reach.is_finite() { reach.log2().ceil().clamp(-1000.0, 1000.0) } else { 0.0 };
        Self { centre: if reach.is_finite() { aabb.centre() } else { DVec3::ZERO }, scale: (-exponent).exp2() }
    }

    fn inside(&self, p: [f64; 3]) -> DVec3 {
        (DVec3::from(p) - self.centre) * self.scale
    }

    fn outside(&self, p: DVec3) -> [f64; 3] {
        (p / self.scale + self.centre).to_array()
    }
}

/// A chart and what finds its triangles in the square.
pub(crate) struct Map {
    chart: Chart,
    frame: Frame,
    /// The triangles that cover the square, in the plane z = 0.
    cover: Bvh,
    /// The chart's triangle that each of them is a copy of.
    origin: Vec<u32>,
    area: f64,
    /// Where filled holes begin, if there are any.
    rim: Option<Rim>,
    /// The surface itself, for whoever moves samples.
    target: OnceLock<Target>,
}

impl Map {
    /// Flattens a connected surface.
    pub(crate) fn new(mesh: &HalfEdges, positions: &[[f64; 3]], how: Flattening, task: &Task<'_>) -> Result<Self> {
        let frame = Frame::around(positions);
        let scaled: Vec<DVec3> = positions.iter().map(|&p| frame.inside(p)).collect();
        let chart = param::flatten(mesh.clone(), scaled, how, task)?;
        let (cover, origin) = chart.cover();
        let rim = Rim::new(&chart, &cover, &origin);
        let cover = Bvh::new(&cover.iter().map(|t| t.map(|p| p.extend(0.0))).collect::<Vec<_>>());
        let area = chart.solids().map(area).sum::<f64>() / (frame.scale * frame.scale);
        Ok(Self { chart, frame, cover, origin, area, rim, target: OnceLock::new() })
    }

    /// How images of the chart are glued.
    pub(crate) fn gluing(&self) -> Gluing {
        self.chart.gluing
    }

    /// Squares a side are a multiple of this.
    pub(crate) fn grains(&self) -> usize {
        self.chart.seams.as_ref().map_or(1, |seams| seams.grains() as usize)
    }

    /// The stretch of the chart from the square to the surface: 1 if it only scales.
    pub(crate) fn stretch(&self) -> f64 {
        self.chart.stretch()
    }

    /// The area of the surface, in the square of the mesh's units.
    pub(crate) fn area(&self) -> f64 {
        self.area
    }

    /// An image of so many samples.
    pub(crate) fn sample(&self, shape: Shape, sampler: Sampler<'_>, task: &Task<'_>) -> Result<GeometryImage> {
        let (width, height) = (shape.width(), shape.height());
        if width < 2 || height < 2 {
            return Err(Error::Parameter(format!("{shape} samples; at least 2 a side are needed")));
        }
        let grains = self.grains();
        if grains > 1 && (width != height || !(width - 1).is_multiple_of(grains)) {
            let next = (width - 1).div_ceil(grains) * grains + 1;
            return Err(Error::Parameter(format!(
                "{shape} samples; the seams of this surface need a square of one more than a multiple of {grains} a side, \
                 such as {next}"
            )));
        }
        let mut points = sampler.sampling.points(shape, self.gluing(), || self.chart.flat_vertices());
        // Seams lie where they are: samples of both sides must meet.
        if let Some(focus) = sampler.focus.filter(|_| self.chart.seams.is_none()) {
            let inside = interest::mask(shape, &self.at_all(&points, shape, task)?, &|p| focus.interest.has(p));
            focus.closer.draw(&mut points, &inside, self.gluing(), || self.chart.flat_vertices());
        }
        let squares = Shape::new(width as u32 - 1, height as u32 - 1)?;
        let mut holes = None;
        if let Some(rim) = &self.rim {
            let holes = holes.insert(self.holes(&points, squares)?);
            rim.draw(&mut points, holes);
        }
        let mut image = GeometryImage::new(width, height, self.gluing(), self.at_all(&points, shape, task)?)?;
        if let Some(seams) = &self.chart.seams {
            image = image.with_seams(seams.clone())?;
        }
        match holes {
            Some(holes) if holes.count() == squares.pixels() => {
                Err(Error::Parameter(format!("{shape} samples are too few to see the surface between its holes")))
            }
            Some(holes) => image.with_holes(holes),
            None => Ok(image),
        }
    }

    /// The squares whose middle is in a filled hole.
    fn holes(&self, points: &[DVec2], squares: Shape) -> Result<Mask> {
        let (columns, side) = (squares.width(), squares.width() + 1);
        let rows = par::map(squares.height(), |row| {
            let mut hint = 0;
            let mut filled = |column: usize| {
                let at = row * side + column;
                let middle = 0.25 * (points[at] + points[at + 1] + points[at + side] + points[at + side + 1]);
                self.face(middle, &mut hint).is_some_and(|(_, face)| self.chart.is_filling(face))
            };
            (0..columns).map(&mut filled).collect::<Vec<bool>>()
        });
        Mask::from_bits(squares, rows.into_iter().flatten())
    }

    /// The copy that lies at a point of the square, and the triangle of the chart that it is a copy of.
    fn face(&self, u: DVec2, hint: &mut u32) -> Option<(u32, usize)> {
        let hit = self.cover.closest(u.extend(0.0), *hint)?;
        *hint = hit.slot;
        Some((hit.slot, self.origin[self.cover.id(hit.slot) as usize] as usize))
    }

    /// The surface's points at points of the square, row by row.
    fn at_all(&self, points: &[DVec2], shape: Shape, task: &Task<'_>) -> Result<Vec<[f64; 3]>> {
        let width = shape.width();
        let rows = par::map(shape.height(), |row| {
            let mut hint = 0;
            if task.is_over() {
                return Vec::new();
            }
            points[row * width..(row + 1) * width].iter().map(|&u| self.at(u, &mut hint)).collect::<Vec<_>>()
        });
        task.step(1.0)?;
        Ok(rows.into_iter().flatten().collect())
    }

    /// The surface's point at a point of the square.
    fn at(&self, u: DVec2, hint: &mut u32) -> [f64; 3] {
        let Some((slot, face)) = self.face(u, hint) else { return [0.0; 3] };
        let [a, b, c] = self.cover.triangles()[slot as usize].map(DVec3::truncate);
        let weights = [(c - b).perp_dot(u - b), (a - c).perp_dot(u - c), (b - a).perp_dot(u - a)].map(|x| x.max(0.0));
        let sum: f64 = weights.iter().sum();
        let solid = self.chart.solid(face);
        let point = if sum > 0.0 { (0..3).map(|k| solid[k] * (weights[k] / sum)).sum() } else { solid[0] };
        self.frame.outside(point)
    }

    /// The image with its samples moved. [`Adjust::Rate`] starts from an image that has been fitted, or from the last one of a
    /// coarser or finer shrinking.
    pub(crate) fn adjust(&self, image: GeometryImage, how: Adjust<'_>, task: &Task<'_>) -> Result<GeometryImage> {
        if let Adjust::None = how {
            return Ok(image);
        }
        let target = self.target();
        let samples = target.samples(image.points().len());
        let mut image = image;
        match how {
            Adjust::None => {}
            Adjust::Hausdorff(focus) => {
                let solids: Vec<_> = self.chart.solids().collect();
                let inside = focus.map(|focus| focus.interest.samples(&image));
                image = self.framed(&image, |framed| adjust(target, &solids, framed, inside.as_ref(), task))?;
            }
            Adjust::Fit => {
                for _ in 0..FITS {
                    image = self.fit(&image, &samples, Damping::NEAR, task)?;
                }
            }
            Adjust::Rate { shrink, rounds } => {
                for _ in 0..rounds {
                    image = self.fit(&shrink(&image)?, &samples, Damping::CHEAP, task)?;
                }
                image = self.fit(&image, &samples, Damping::CHEAP, task)?;
            }
        }
        Ok(image)
    }

    fn target(&self) -> &Target {
        self.target.get_or_init(|| Target::new(&self.chart.solids().collect::<Vec<_>>()))
    }

    fn fit(&self, image: &GeometryImage, samples: &[Sample], damping: Damping, task: &Task<'_>) -> Result<GeometryImage> {
        self.framed(image, |inside| self.target().fit(inside, samples, damping, task))
    }

    /// Does something to an image in the frame of the map.
    fn framed(
        &self,
        image: &GeometryImage,
        what: impl FnOnce(&GeometryImage) -> Result<GeometryImage>,
    ) -> Result<GeometryImage> {
        let inside = image.points().iter().map(|&p| self.frame.inside(p).to_array()).collect();
        let done = what(&image.with_points(inside)?)?;
        let outside = done.points().iter().map(|&p| self.frame.outside(p.into())).collect();
        image.with_points(outside)
    }
}
