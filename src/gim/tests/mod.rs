//! The whole chain on the corpus' meshes and, with `GIMC_MESHES`, on real ones.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::eval::{CompareOptions, compare};
use crate::mesh::Mesh;
use crate::plane::Gluing;
use std::collections::HashMap;

fn corpus(name: &str) -> Mesh {
    Mesh::open(format!("{}/corpus/meshes/{name}.ply", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

pub(super) fn atlas(mesh: &Mesh, param: Param) -> Result<Atlas> {
    let edges = HalfEdges::new(mesh.positions.len(), mesh.faces.triangles())?;
    Atlas::new(&edges, &mesh.positions, param, &Task::default())
}

pub(super) fn as_mesh(image: &GeometryImage) -> Mesh {
    Mesh::from_triangles(image.points().to_vec(), image.triangles())
}

pub(super) fn quality(mesh: &Mesh, image: &GeometryImage) -> (f64, f64) {
    let options = CompareOptions::default().samples(100_000);
    let c = compare(mesh, &as_mesh(image), &options, &Task::default()).unwrap();
    (c.psnr, c.hausdorff)
}

#[test]
fn a_closed_surface_stays_closed_and_near() {
    let mesh = corpus("bumpy_sphere");
    for param in [Param::Tutte, Param::Yoshizawa] {
        let atlas = atlas(&mesh, param).unwrap();
        let map = &atlas.maps()[0];
        assert_eq!(map.gluing(), Gluing::Orbifold);
        let image = map.sample(129, Sampling::Regular, &Task::default()).unwrap();
        let triangles = image.triangles();
        let mut edges = HashMap::new();
        for t in &triangles {
            (0..3).for_each(|i| *edges.entry((t[i], t[(i + 1) % 3])).or_insert(0) += 1);
        }
        assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.contains_key(&(b, a))));
        let (psnr, _) = quality(&mesh, &image);
        assert!(psnr > 50.0, "{param:?}: {psnr}");
    }
}

#[test]
fn a_terrain_is_a_disk() {
    let mesh = corpus("terrain");
    let atlas = atlas(&mesh, Param::Yoshizawa).unwrap();
    let map = &atlas.maps()[0];
    let (psnr, _) = quality(&mesh, &map.sample(100, Sampling::Regular, &Task::default()).unwrap());
    assert!(map.gluing() == Gluing::Open && psnr > 50.0, "{psnr}");
}

#[test]
fn real_meshes() {
    let Ok(folder) = std::env::var("GIMC_MESHES") else { return };
    for (file, n) in [
        ("cathead.obj", 45),
        ("venus.off", 70),
        ("camel.ply", 180),
        ("foot.ply", 180),
        ("mannequin.ply", 300),
        ("spot.obj", 129),
        ("bunny_hoppe.ply", 257),
    ] {
        let mesh = Mesh::open(format!("{folder}/{file}")).unwrap();
        for param in [Param::Tutte, Param::MeanValue, Param::Yoshizawa] {
            let start = std::time::Instant::now();
            let atlas = match atlas(&mesh, param) {
                Ok(atlas) => atlas,
                Err(e) => {
                    eprintln!("{file} {param:?}: {e}");
                    continue;
                }
            };
            let flat = start.elapsed();
            let map = &atlas.maps()[0];
            let image = map.sample(n, Sampling::Regular, &Task::default()).unwrap();
            let all = start.elapsed();
            let (psnr, h) = quality(&mesh, &image);
            eprintln!("{file} {n} {param:?}: stretch {:.3}, {psnr:.2} dB, h {h:.4}, {flat:.2?} {all:.2?}", map.stretch());
        }
    }
}
