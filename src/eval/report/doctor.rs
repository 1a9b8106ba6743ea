//! The doctor's report as JSON.

use super::json::Json;
use crate::mesh::{Inspection, Places};

/// Counts under plain names, and under `places` the first places of each fault that occurs.
impl From<&Inspection> for Json {
    fn from(found: &Inspection) -> Self {
        let mut members: Vec<(&str, Json)> = vec![
            ("vertices", found.vertices.into()),
            ("faces", found.faces.into()),
            ("triangles", found.triangles.into()),
            ("polygons", Json::object(found.polygons.iter().map(|&(corners, faces)| (corners.to_string(), faces.into())))),
            ("edges", found.edges.into()),
            ("components", found.components.into()),
            ("boundary_loops", found.boundary_loops.into()),
            ("boundary_edges", found.boundary_edges.into()),
            ("genus", found.genus.into()),
            ("euler", found.euler.into()),
            ("manifold", found.is_manifold().into()),
            ("closed", found.is_closed().into()),
            ("oriented", (found.flipped_edges.count == 0).into()),
            ("orientable", found.orientable.into()),
            ("faces_to_turn", found.faces_to_turn.into()),
        ];
        let edge = |e: &[u32; 2]| Json::list(*e);
        let faults = [
            ("non_manifold_edges", places(&found.non_manifold_edges, edge)),
            ("non_manifold_vertices", places(&found.non_manifold_vertices, |&v| v.into())),
            ("flipped_edges", places(&found.flipped_edges, edge)),
            ("degenerate_faces", places(&found.degenerate_faces, |&f| f.into())),
            ("broken_faces", places(&found.broken_faces, |&f| f.into())),
            ("duplicate_faces", places(&found.duplicate_faces, |&f| f.into())),
            ("flat_faces", places(&found.flat_faces, |&f| f.into())),
            ("isolated_vertices", places(&found.isolated_vertices, |&v| v.into())),
            ("duplicate_positions", places(&found.duplicate_positions, |&v| v.into())),
            ("non_finite_vertices", places(&found.non_finite_vertices, |&v| v.into())),
        ];
        members.extend(faults.iter().map(|(name, (count, _))| (*name, (*count).into())));
        members.push(("flat_triangles", found.flat_triangles.into()));
        members.push(("box", found.bounds.map_or(Json::Null, |b| Json::list(b.map(Json::list)))));
        members.push(("diag", found.diagonal.into()));
        members.push(("cgim", found.can_be_encoded().into()));
        members.push(("manifold", found.obstacle.map_or_else(|| true.into(), |why| why.to_string().into())));
        members.push(("repairs", Json::list(found.repairs())));
        let places = faults.into_iter().filter(|(_, (count, _))| *count > 0).map(|(name, (_, first))| (name, first));
        members.push(("places", Json::object(places)));
        Json::object(members)
    }
}

fn places<T>(places: &Places<T>, one: impl Fn(&T) -> Json) -> (usize, Json) {
    (places.count, Json::List(places.first.iter().map(one).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn faults_have_a_count_and_their_first_places() {
        let mesh = Mesh::from_triangles(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]], [[0, 1, 2], [0, 1, 3]]);
        let json = Json::from(&mesh.inspect());
        assert_eq!(json.get("flipped_edges"), Some(&Json::Integer(1)));
        let places = r#"{"flipped_edges":[[0,1]],"flat_faces":[1],"duplicate_positions":[3]}"#;
        assert_eq!(json.get("places").unwrap().to_string(), places);
    }
}
