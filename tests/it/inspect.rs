//! The doctor against a list of what others found in real meshes.

use std::path::{Path, PathBuf};

use gimc::{Inspection, Mesh};

/// Where the list and the doctor count different things, and why.
const OTHERWISE: &[(&str, &str, &str)] = &[
    ("sponza", "boundary_loops", "where edges have more than two faces, what follows what around a loop is a convention"),
    ("nasty_inf_nan_obj", "zero_area", "a triangle whose corners are not finite has no known area, not an area of zero"),
    ("nasty_notenoughindices_obj", "index_degenerate", "a face of two corners is degenerate here"),
];

#[test]
fn the_doctor_agrees_with_the_index_of_a_folder_of_meshes() {
    let Some(folder) = std::env::var_os("GIMC_MESHES").map(PathBuf::from) else {
        eprintln!("skipped: GIMC_MESHES names no folder of meshes");
        return;
    };
    let Ok(index) = std::fs::read_to_string(folder.join("index.tsv")) else {
        eprintln!("skipped: no index.tsv in {}", folder.display());
        return;
    };
    let mut rows = index.lines().map(|line| line.split('\t').collect::<Vec<_>>());
    let names = rows.next().unwrap_or_default();
    let (mut meshes, mut wrong) = (0, Vec::new());
    for row in rows {
        let field = |name: &str| names.iter().position(|n| *n == name).and_then(|i| row.get(i)).copied().unwrap_or_default();
        let Some(path) = find(&folder, field("file")) else { continue };
        let Ok(mesh) = Mesh::open(&path) else { continue };
        meshes += 1;
        // The list counts some polygons by their edges and some by the triangles they are cut into.
        let distinct = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        let triangles = mesh.faces.triangles().into_iter().filter(distinct);
        let cut = counts(&Mesh::from_triangles(mesh.positions.clone(), triangles).inspect());
        for ((name, found), (_, cut)) in counts(&mesh.inspect()).into_iter().zip(cut) {
            let listed = field(name);
            if listed != found
                && listed != cut
                && !OTHERWISE.iter().any(|&(mesh, count, _)| (mesh, count) == (field("name"), name))
            {
                wrong.push(format!("{}: {name} is {found}, {listed} in the index", field("name")));
            }
        }
    }
    assert!(meshes > 20, "only {meshes} meshes of the index were read");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Files are listed with a folder that may differ from where they lie.
fn find(folder: &Path, file: &str) -> Option<PathBuf> {
    let name = Path::new(file).file_name()?;
    [folder.join(name), folder.join("nasty").join(name)].into_iter().find(|path| path.exists())
}

/// The counts under the names of the index.
fn counts(found: &Inspection) -> [(&'static str, String); 15] {
    let manifold = |count: usize| if count == 0 { "yes" } else { "no" };
    let edges_and_vertices =
        format!("{}/{}", manifold(found.non_manifold_edges.count), manifold(found.non_manifold_vertices.count));
    [
        ("V", found.vertices.to_string()),
        ("F", found.faces.to_string()),
        ("components", found.components.to_string()),
        ("boundary_loops", found.boundary_loops.to_string()),
        ("genus", found.genus.map_or("n/a".into(), |g| g.to_string())),
        ("manifold_edge_vertex", edges_and_vertices),
        ("nonmanifold_edges", found.non_manifold_edges.count.to_string()),
        ("nonmanifold_vertices", found.non_manifold_vertices.count.to_string()),
        ("flipped_edges", found.flipped_edges.count.to_string()),
        ("isolated", found.isolated_vertices.count.to_string()),
        ("dup_positions", found.duplicate_positions.count.to_string()),
        ("zero_area", found.flat_triangles.to_string()),
        ("index_degenerate", found.degenerate_faces.count.to_string()),
        ("dup_faces", found.duplicate_faces.count.to_string()),
        ("nonfinite", found.non_finite_vertices.count.to_string()),
    ]
}
