//! Surfaces with handles: cut open to a disk along short paths, whose border goes around the square side by side.
//!
//! The cut is the greedy one of Erickson and Whittlesey (2005): the shortest paths from one vertex, and of the edges that are left, besides
//! a tree of them that joins all triangles, those that close the shortest loops. What remains of their paths without dead ends is a
//! graph; its branches are the *seams*. Both sides of a seam get equally much of the border, in whole grains, so that samples on
//! one side of it are the samples on the other.

use std::cmp::Reverse;

use glam::{DVec2, DVec3};

use super::border::{at_border, prepare, rounds};
use super::chart::{Chart, Freedom};
use super::cones::{Reach, far_apart};
use super::sheet::Sheet;
use super::{Param, refused, yoshizawa};
use crate::error::Result;
use crate::mesh::{CutGraph, HalfEdges, Union, boundary_loops};
use crate::plane::{BorderSide, Gluing, Seams};
use crate::task::Task;

/// Vertices that are tried as the root of the shortest paths, on surfaces of so many triangles at most.
const ROOTS: usize = 4;
const ROOTED: usize = 200_000;

/// Grains of a side of the square at least and at most, and for each seam on average.
const GRAINS: std::ops::RangeInclusive<u32> = 8..=1024;
const GRAINS_A_SEAM: u32 = 3;

/// An edge of the border is split if it takes more than this share of a side of the square.
const LONGEST: f64 = 0.4;

/// A surface cut open, and its border.
#[derive(Clone)]
struct Opened {
    sheet: Sheet,
    /// The vertices at which sides begin, in their order around the border, and the side that each is glued to.
    sides: Vec<(u32, u32)>,
}

/// Lays out a closed surface with handles.
pub(super) fn lay_out(sheet: Sheet, param: Param, task: &Task<'_>) -> Result<Chart> {
    let opened = open(sheet)?;
    let seams = opened.sides.len() as u32 / 2;
    let grains = GRAINS.start().max(&(GRAINS_A_SEAM * seams)).next_power_of_two();
    if !GRAINS.contains(&grains) {
        return Err(refused(format!(
            "a component that is cut along {seams} seams to lie flat (at most {})",
            GRAINS.end() / GRAINS_A_SEAM
        )));
    }
    let lengths = grains_of_sides(&opened, grains)?;
    let opened = without_long_edges(opened, &lengths, grains)?;
    let mut best: Option<(f64, Chart)> = None;
    let tries = rounds(param, opened.sheet.mesh.triangles().len());
    for start in 0..tries {
        let start = start as u32 * grains / tries as u32;
        let mut chart = pinned(&opened, &lengths, grains, start)?;
        yoshizawa::lay_out(&mut chart, param, task)?;
        let stretch = chart.stretch();
        if best.as_ref().is_none_or(|(least, _)| stretch < *least) {
            best = Some((stretch, chart));
        }
    }
    best.map(|(_, chart)| chart).ok_or_else(|| refused("a surface without a layout".into()))
}

/// Cuts a closed surface along the shortest graph that is found.
fn open(sheet: Sheet) -> Result<Opened> {
    let Sheet { mesh, positions, .. } = &sheet;
    let mut roots = far_apart(mesh, positions).to_vec();
    roots.truncate(if mesh.triangles().len() <= ROOTED { ROOTS } else { 1 });
    let length = |cut: &CutGraph| -> f64 {
        let marked = (0..3 * mesh.triangles().len() as u32).filter(|&h| cut.has(h));
        marked.map(|h| positions[mesh.from(h) as usize].distance(positions[mesh.to(h) as usize])).sum()
    };
    let cuts = roots.into_iter().map(|root| cut(mesh, positions, root)).map(|cut| (length(&cut), cut));
    let cut = cuts.fold(None, |best: Option<(f64, CutGraph)>, new| match best {
        Some(best) if best.0 <= new.0 => Some(best),
        _ => Some(new),
    });
    let (_, cut) = cut.ok_or_else(|| refused("a surface without a cut".into()))?;
    let degree = |v: u32| mesh.fan(v).filter(|&h| cut.has(h)).count();
    let (opened, origin) = cut.open(mesh);
    let loops = boundary_loops(&opened);
    let [around] = &loops[..] else { return Err(refused(format!("a cut that leaves {} borders", loops.len()))) };
    // Sides begin where the cut branches.
    let begins: Vec<usize> = (0..around.len()).filter(|&i| degree(origin[opened.from(around[i]) as usize]) != 2).collect();
    let mut side_of = vec![0; 3 * mesh.triangles().len()];
    for (i, &h) in around.iter().enumerate() {
        let before = begins.partition_point(|&b| b <= i);
        side_of[h as usize] = (before + begins.len() - 1) % begins.len().max(1);
    }
    let side = |&begin: &usize| {
        let mate = mesh.opposite(around[begin]).map_or(0, |g| side_of[g as usize]);
        (opened.from(around[begin]), mate as u32)
    };
    let sides = begins.iter().map(side).collect();
    let positions = origin.iter().map(|&v| positions[v as usize]).collect();
    // Corners on the border keep their numbers when edges are split.
    let sheet = prepare(Sheet { mesh: opened, positions, filling: sheet.filling })?;
    Ok(Opened { sheet, sides })
}

/// The cut of the shortest loops through a vertex. O(n log n).
fn cut(mesh: &HalfEdges, positions: &[DVec3], root: u32) -> CutGraph {
    let reach = Reach::new(mesh, positions, &[root], |_| true);
    let mut tree = CutGraph::empty(mesh);
    for v in 0..mesh.vertices() as u32 {
        reach.back_from(mesh, v).take(1).for_each(|h| tree.mark(mesh, h));
    }
    let around = |h: u32| {
        let (a, b) = (mesh.from(h) as usize, mesh.to(h) as usize);
        reach.distance[a] + reach.distance[b] + positions[a].distance(positions[b])
    };
    // Triangles are joined over the edges of the longest loops.
    let mut edges: Vec<(Reverse<u64>, u32, u32)> = (0..3 * mesh.triangles().len() as u32)
        .filter(|&h| !tree.has(h))
        .filter_map(|h| Some((Reverse(around(h).to_bits()), h, mesh.opposite(h).filter(|&g| g > h)?)))
        .collect();
    edges.sort_unstable();
    let mut joined = Union::new(mesh.triangles().len());
    let mut cut = CutGraph::empty(mesh);
    let mut on_path = vec![false; mesh.vertices()];
    for (_, h, g) in edges {
        if joined.find(h / 3) != joined.find(g / 3) {
            joined.join(h / 3, g / 3);
            continue;
        }
        cut.mark_loop(mesh, h, &mut on_path, |v| reach.back_from(mesh, v));
    }
    cut.prune(mesh, None);
    cut
}

/// The border's vertices in order from where the first side begins, and at which of them sides begin.
fn border(opened: &Opened) -> Result<(Vec<u32>, Vec<usize>)> {
    let mesh = &opened.sheet.mesh;
    let lost = || refused("a surface whose seams are lost".into());
    let around = boundary_loops(mesh).into_iter().next().ok_or_else(lost)?;
    let vertices: Vec<u32> = around.iter().map(|&h| mesh.from(h)).collect();
    let first = opened.sides.first().and_then(|side| vertices.iter().position(|&v| v == side.0)).ok_or_else(lost)?;
    let vertices = [&vertices[first..], &vertices[..first]].concat();
    let mut begins = Vec::with_capacity(opened.sides.len());
    for &(v, _) in &opened.sides {
        let from = begins.last().map_or(0, |&b| b + 1);
        begins.push(from + vertices[from..].iter().position(|&w| w == v).ok_or_else(lost)?);
    }
    Ok((vertices, begins))
}

/// How far along the border each of its vertices is, in the lengths of its edges; one more at the end.
fn reach_along(sheet: &Sheet, vertices: &[u32]) -> Vec<f64> {
    let at = |i: usize| sheet.positions[vertices[i % vertices.len()] as usize];
    let mut reach = vec![0.0];
    for i in 0..vertices.len() {
        // A border without length is laid out by its vertices.
        reach.push(reach[i] + at(i).distance(at(i + 1)).max(1e-12));
    }
    reach
}

/// Grains of each side: by length, the same for both sides of a seam.
fn grains_of_sides(opened: &Opened, grains: u32) -> Result<Vec<u32>> {
    let (vertices, begins) = border(opened)?;
    let reach = reach_along(&opened.sheet, &vertices);
    let end = |i: usize| begins.get(i + 1).copied().unwrap_or(vertices.len());
    let seams: Vec<(usize, usize)> =
        opened.sides.iter().enumerate().map(|(i, side)| (i, side.1 as usize)).filter(|(i, j)| i < j).collect();
    let total = reach[vertices.len()];
    let spare = (2 * grains).saturating_sub(Seams::SHORTEST * seams.len() as u32);
    let wanted = |&(i, _): &(usize, usize)| {
        ((reach[end(i)] - reach[begins[i]]) / total * f64::from(4 * grains) - f64::from(Seams::SHORTEST)).max(1e-3)
    };
    let sum: f64 = seams.iter().map(wanted).sum();
    // The largest remainders are rounded up.
    let shares: Vec<f64> = seams.iter().map(|seam| wanted(seam) / sum * f64::from(spare)).collect();
    let mut given: Vec<u32> = shares.iter().map(|s| s.floor() as u32).collect();
    let mut order: Vec<usize> = (0..seams.len()).collect();
    order.sort_by(|&a, &b| shares[b].fract().total_cmp(&shares[a].fract()));
    let left = spare - given.iter().sum::<u32>().min(spare);
    order.iter().cycle().take(left as usize).for_each(|&i| given[i] += 1);
    let mut lengths = vec![0; opened.sides.len()];
    for (&(i, j), more) in seams.iter().zip(given) {
        (lengths[i], lengths[j]) = (Seams::SHORTEST + more, Seams::SHORTEST + more);
    }
    Ok(lengths)
}

/// Where each vertex of the border lies, in grains from where the first side begins.
fn places(opened: &Opened, lengths: &[u32]) -> Result<(Vec<u32>, Vec<f64>)> {
    let (vertices, begins) = border(opened)?;
    let reach = reach_along(&opened.sheet, &vertices);
    let (mut places, mut from) = (Vec::with_capacity(vertices.len() + 1), 0);
    for (i, &length) in lengths.iter().enumerate() {
        let (first, last) = (begins[i], begins.get(i + 1).copied().unwrap_or(vertices.len()));
        let share = |v: usize| (reach[v] - reach[first]) / (reach[last] - reach[first]);
        places.extend((first..last).map(|v| f64::from(from) + share(v) * f64::from(length)));
        from += length;
    }
    places.push(f64::from(from));
    Ok((vertices, places))
}

/// Splits edges of the border that would go around more than one corner of the square.
fn without_long_edges(mut opened: Opened, lengths: &[u32], grains: u32) -> Result<Opened> {
    loop {
        let (vertices, places) = places(&opened, lengths)?;
        let mut long = vec![false; opened.sheet.positions.len()];
        let mut any = false;
        for (i, &v) in vertices.iter().enumerate() {
            long[v as usize] = places[i + 1] - places[i] > LONGEST * f64::from(grains);
            any |= long[v as usize];
        }
        if !any {
            return Ok(opened);
        }
        let mesh = &opened.sheet.mesh;
        let wanted = |h: u32| mesh.opposite(h).is_none() && long[mesh.from(h) as usize];
        opened.sheet = opened.sheet.split(wanted)?;
    }
}

/// The chart with its border around the square, the first side `start` grains after the first corner.
fn pinned(opened: &Opened, lengths: &[u32], grains: u32, start: u32) -> Result<Chart> {
    let mut opened = opened.clone();
    cut_at_corners(&mut opened, lengths, grains, start)?;
    let (vertices, places) = places(&opened, lengths)?;
    let Opened { sheet: Sheet { mesh, positions, filling }, sides } = opened;
    let mut w = vec![DVec2::splat(0.5); positions.len()];
    let mut freedom = vec![Freedom::Free; positions.len()];
    for (i, &v) in vertices.iter().enumerate() {
        w[v as usize] = at_border((places[i] + f64::from(start)) / f64::from(grains));
        freedom[v as usize] = Freedom::Fixed;
    }
    let sides = sides.iter().zip(lengths).map(|(&(_, mate), &length)| BorderSide { length, mate }).collect();
    let seams = Some(Seams::new(grains, start, sides)?);
    Ok(Chart { mesh, positions, filling, gluing: Gluing::Open, seams, lifts: Vec::new(), w, freedom })
}

/// How near to a corner of the square, in grains, a vertex is as good as there.
const NEAR: f64 = 1e-9;

/// Gives the border a vertex at every corner of the square.
fn cut_at_corners(opened: &mut Opened, lengths: &[u32], grains: u32, start: u32) -> Result<()> {
    let (vertices, places) = places(opened, lengths)?;
    let mesh = &opened.sheet.mesh;
    let half_edge: Vec<u32> = vertices.iter().filter_map(|&v| mesh.outgoing(v)).collect();
    let mut cuts: Vec<(u32, f64)> = Vec::new();
    for corner in 1..=4 {
        let at = f64::from((corner * grains + 4 * grains - start) % (4 * grains));
        let edge = places.partition_point(|&p| p <= at + NEAR).saturating_sub(1);
        if edge >= vertices.len() || at - places[edge] <= NEAR {
            continue;
        }
        cuts.push((half_edge[edge], (at - places[edge]) / (places[edge + 1] - places[edge])));
    }
    // New vertices are numbered in the order of the half-edges.
    cuts.sort_unstable_by_key(|cut| cut.0);
    let before = opened.sheet.positions.len();
    let ends: Vec<_> = cuts.iter().map(|&(h, t)| (mesh.from(h), mesh.to(h), t)).collect();
    let mut sheet = opened.sheet.split(|h| cuts.binary_search_by_key(&h, |cut| cut.0).is_ok())?;
    for (i, (a, b, t)) in ends.into_iter().enumerate() {
        sheet.positions[before + i] = sheet.positions[a as usize].lerp(sheet.positions[b as usize], t);
    }
    opened.sheet = sheet;
    Ok(())
}
