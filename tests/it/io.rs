//! Mesh files in and out, over files that others made.

use std::path::PathBuf;

use gimc::{Error, Format, Loaded, Mesh, Scalar};

/// The folder of real meshes, if the environment names one: `index.tsv` and the files beside it.
fn real_meshes() -> Option<Vec<(PathBuf, Option<[usize; 2]>)>> {
    let Some(folder) = std::env::var_os("GIMC_MESHES").map(PathBuf::from) else {
        eprintln!("skipped: GIMC_MESHES names no folder of meshes");
        return None;
    };
    let index = std::fs::read_to_string(folder.join("index.tsv")).unwrap();
    let mut lines = index.lines().map(|line| line.split('\t').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let column = |name: &str| header.iter().position(|&h| h == name).unwrap();
    let [file, vertices, faces] = ["file", "V", "F"].map(column);
    let meshes = lines.map(|row| {
        let name = PathBuf::from(row[file]);
        let name = name.file_name().unwrap();
        let path = [folder.join(name), folder.join("nasty").join(name)].into_iter().find(|path| path.exists()).unwrap();
        (path, row[vertices].parse().ok().zip(row[faces].parse().ok()).map(|(v, f)| [v, f]))
    });
    Some(meshes.collect())
}

#[test]
fn real_meshes_have_as_many_vertices_and_faces_as_others_count() {
    let Some(meshes) = real_meshes() else { return };
    assert!(meshes.len() > 60);
    for (path, counts) in meshes {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let read = Mesh::load(&path);
        match (name.as_str(), read) {
            // Faces that name a vertex that is not there are an error here; the counts were made by a reader that keeps them.
            ("nasty_malformed_obj.obj", Err(error)) => {
                assert!(error.to_string().ends_with("obj: line 28: vertex index 0, and OBJ counts from 1"), "{error}");
            }
            (_, Ok(loaded)) => {
                let found = [loaded.mesh.positions.len(), loaded.mesh.faces.len()];
                assert_eq!(Some(found), counts, "{name} {:?}", loaded.notes);
            }
            (_, Err(error)) => {
                assert_eq!(counts, None, "{error}");
                assert!(matches!(error, Error::InFile { .. }), "{error}");
                eprintln!("{error}");
            }
        }
    }
}

#[test]
fn real_meshes_come_back_from_what_is_written() {
    for (path, _) in real_meshes().unwrap_or_default() {
        let Ok(Loaded { mesh, .. }) = Mesh::load(&path) else { continue };
        for format in [Format::Obj, Format::Ply, Format::Off] {
            let mut bytes = Vec::new();
            let notes = mesh.write(format, &mut bytes).unwrap();
            let again = Mesh::read(&bytes, None).unwrap_or_else(|e| panic!("{} as {format}: {e}", path.display()));
            assert_eq!(again.format, format);
            let same = |a: &[f64; 3], b: &[f64; 3]| {
                a == b || a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan())
            };
            let what = format!("{} as {format}", path.display());
            // Text cannot tell f64 values from f32 where they are the same.
            let are_single = format != Format::Ply && mesh.positions.as_flattened().iter().all(|&x| f64::from(x as f32) == x);
            assert_eq!(again.mesh.precision, if are_single { Scalar::F32 } else { mesh.precision }, "{what}");
            assert!(again.mesh.positions.iter().zip(&mesh.positions).all(|(a, b)| same(a, b)), "{what}");
            assert_eq!(again.mesh.faces, mesh.faces, "{what}");
            assert_eq!(again.notes, [] as [&str; 0], "{what}");
            if mesh.attributes.is_empty() && mesh.labels.is_empty() {
                assert_eq!(notes, [] as [&str; 0], "{what}");
            }
        }
    }
}
