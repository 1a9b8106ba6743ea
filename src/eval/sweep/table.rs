//! Points of a sweep as curves, one for each mesh and way, compared with those of a reference way.

use super::{Measured, SweepPoint};
use crate::error::{Error, Result};
use crate::eval::curve::{BdRate, RatePoint, bd_rate, pareto, percent};

/// All curves of a sweep.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SweepTable<'a> {
    /// The meshes, in the order of their first points.
    pub meshes: Vec<MeshCurves<'a>>,
    /// The ways, in the order of their first points.
    pub ways: Vec<&'a str>,
    /// The way that all others are compared with.
    pub reference: &'a str,
    /// For each way the mean over the meshes where it has a delta rate.
    pub means: Vec<WayMean>,
}

/// The curves of one mesh.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct MeshCurves<'a> {
    /// The mesh.
    pub mesh: &'a str,
    /// Its vertices.
    pub vertices: u64,
    /// Its curves, by the order of [`SweepTable::ways`]; ways that were not tried are missing.
    pub ways: Vec<WayCurve<'a>>,
    /// The points that none of this mesh beats, by growing bytes.
    pub front: Vec<&'a SweepPoint>,
}

/// One way over one mesh.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct WayCurve<'a> {
    /// Its place in [`SweepTable::ways`].
    pub way: usize,
    /// Its points by growing bytes.
    pub points: Vec<(&'a SweepPoint, &'a Measured)>,
    /// Settings that were refused, and why.
    pub refused: Vec<(&'a SweepPoint, &'a str)>,
    /// The delta rate against the reference; `None` for the reference itself and where that was not tried.
    pub bd_rate: Option<BdRate>,
}

/// The delta rate of a way over all meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct WayMean {
    /// The delta rate in percent, by the mean of the logarithms; `None` where no mesh has one.
    pub percent: Option<f64>,
    /// The meshes that have one.
    pub meshes: usize,
}

impl<'a> SweepTable<'a> {
    /// Curves of all points; `reference` is one of their ways, and the first if none is named.
    ///
    /// # Errors
    /// [`Error::Parameter`] if no point is of that way.
    pub fn new(points: &'a [SweepPoint], reference: Option<&str>) -> Result<Self> {
        let mut ways: Vec<&str> = Vec::new();
        let mut meshes: Vec<(&str, Vec<&SweepPoint>)> = Vec::new();
        for point in points {
            if !ways.contains(&&*point.way) {
                ways.push(&point.way);
            }
            match meshes.iter_mut().find(|(mesh, _)| *mesh == point.mesh) {
                Some((_, points)) => points.push(point),
                None => meshes.push((&point.mesh, vec![point])),
            }
        }
        let place = match reference {
            None => 0,
            Some(name) => ways.iter().position(|way| *way == name).ok_or_else(|| {
                Error::Parameter(format!(
                    "no point is of the way {name}, which is to be the reference; there are {}",
                    ways.join(", ")
                ))
            })?,
        };
        let meshes: Vec<MeshCurves> =
            meshes.into_iter().map(|(mesh, points)| MeshCurves::new(mesh, &points, &ways, place)).collect();
        let means = (0..ways.len()).map(|way| WayMean::over(&meshes, way)).collect();
        Ok(Self { reference: ways.get(place).copied().unwrap_or(""), meshes, ways, means })
    }
}

impl<'a> MeshCurves<'a> {
    fn new(mesh: &'a str, points: &[&'a SweepPoint], ways: &[&str], reference: usize) -> Self {
        let of_way = |way: usize| {
            let points = points.iter().copied().filter(|p| p.way == ways[way]);
            let (mut good, mut refused) = (Vec::new(), Vec::new());
            for point in points {
                match &point.result {
                    Ok(measured) => good.push((point, measured)),
                    Err(why) => refused.push((point, &**why)),
                }
            }
            good.sort_by(|a, b| a.1.bytes.cmp(&b.1.bytes).then(a.1.psnr.total_cmp(&b.1.psnr)));
            let was_tried = !good.is_empty() || !refused.is_empty();
            was_tried.then_some(WayCurve { way, points: good, refused, bd_rate: None })
        };
        let mut curves: Vec<WayCurve> = (0..ways.len()).filter_map(of_way).collect();
        let rates = |curve: &WayCurve| -> Vec<RatePoint> { curve.points.iter().map(|(_, m)| m.rate()).collect() };
        if let Some(first) = curves.iter().find(|curve| curve.way == reference).map(rates) {
            for curve in curves.iter_mut().filter(|curve| curve.way != reference) {
                curve.bd_rate = Some(bd_rate(&first, &rates(curve)));
            }
        }
        let measured: Vec<(&SweepPoint, RatePoint)> =
            points.iter().filter_map(|&p| p.result.as_ref().ok().map(|m| (p, m.rate()))).collect();
        let all: Vec<RatePoint> = measured.iter().map(|(_, rate)| *rate).collect();
        let front = pareto(&all).into_iter().map(|i| measured[i].0).collect();
        Self { mesh, vertices: points.first().map_or(0, |p| p.vertices), ways: curves, front }
    }
}

impl WayMean {
    fn over(meshes: &[MeshCurves<'_>], way: usize) -> Self {
        let of_mesh = |mesh: &MeshCurves<'_>| match mesh.ways.iter().find(|curve| curve.way == way)?.bd_rate? {
            BdRate::Over { log_ratio, .. } => Some(log_ratio),
            _ => None,
        };
        let logs: Vec<f64> = meshes.iter().filter_map(of_mesh).collect();
        let mean = (!logs.is_empty()).then(|| logs.iter().sum::<f64>() / logs.len() as f64);
        Self { percent: mean.map(percent), meshes: logs.len() }
    }
}
