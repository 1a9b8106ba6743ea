//! The tree of nodes (glTF 2.0, section 3.5): which meshes stand where.

use glam::{DMat4, DQuat, DVec3};
use serde_json::Value;

use super::accessor::{error, item, whole};
use crate::error::Result;

/// A mesh in the scene.
pub(super) struct Placed {
    /// Its number in `meshes`.
    pub(super) mesh: u64,
    /// The node's name, or else the mesh's.
    pub(super) name: String,
    /// From the mesh to the scene.
    pub(super) transform: DMat4,
}

/// All meshes of the default scene, parents first; without scenes, all meshes.
pub(super) fn placed(scene: &Value) -> Result<Vec<Placed>> {
    let name = |of: &Value| of.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
    let list = |of: &Value, list: &str| of.get(list).and_then(Value::as_array).cloned().unwrap_or_default();
    let chosen = whole(scene, "scene", "glTF")?.unwrap_or(0);
    let Some(roots) = scene.get("scenes").and_then(Value::as_array).filter(|scenes| !scenes.is_empty()) else {
        let meshes = list(scene, "meshes").into_iter().enumerate();
        return Ok(meshes.map(|(i, mesh)| Placed { mesh: i as u64, name: name(&mesh), transform: DMat4::IDENTITY }).collect());
    };
    let roots = usize::try_from(chosen).ok().and_then(|i| roots.get(i));
    let roots = roots.ok_or_else(|| error("glTF", format!("scene {chosen} is named, and there is none")))?;

    let nodes = scene.get("nodes").and_then(Value::as_array).map_or(0, Vec::len);
    let mut seen = vec![false; nodes];
    let mut found = Vec::new();
    let mut open = list(roots, "nodes").into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect::<Vec<_>>();
    while let Some((index, parent)) = open.pop() {
        let index = index.as_u64().ok_or_else(|| error("glTF", format!("expected the number of a node, found {index}")))?;
        let node = item(scene, "nodes", index)?;
        if std::mem::replace(&mut seen[index as usize], true) {
            return Err(error("glTF", format!("nodes[{index}] is reached twice: the nodes are no tree")));
        }
        let transform = parent * local(node, index)?;
        if let Some(mesh) = whole(node, "mesh", &format!("nodes[{index}]"))? {
            let mut name = name(node);
            if name.is_empty() {
                name = item(scene, "meshes", mesh)?.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
            }
            found.push(Placed { mesh, name, transform });
        }
        open.extend(list(node, "children").into_iter().rev().map(|child| (child, transform)));
    }
    Ok(found)
}

/// A node's own transform: a matrix, or a scale, then a rotation, then a translation.
fn local(node: &Value, index: u64) -> Result<DMat4> {
    if node.get("matrix").is_some() {
        return Ok(DMat4::from_cols_array(&numbers(node, "matrix", index, [0.0; 16])?));
    }
    let scale = numbers(node, "scale", index, [1.0; 3])?;
    let rotation = numbers(node, "rotation", index, [0.0, 0.0, 0.0, 1.0])?;
    let translation = numbers(node, "translation", index, [0.0; 3])?;
    let rotation = DQuat::from_array(rotation);
    if !rotation.is_normalized() && (rotation.length() - 1.0).abs() > 0.01 {
        return Err(error(&format!("nodes[{index}]"), format!("expected a rotation of length 1, found {}", rotation.length())));
    }
    Ok(DMat4::from_scale_rotation_translation(DVec3::from_array(scale), rotation.normalize(), DVec3::from_array(translation)))
}

fn numbers<const N: usize>(node: &Value, name: &str, index: u64, default: [f64; N]) -> Result<[f64; N]> {
    let Some(value) = node.get(name) else { return Ok(default) };
    let numbers = value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect::<Option<Vec<_>>>());
    let numbers = numbers.and_then(|list| list.try_into().ok());
    numbers.ok_or_else(|| error(&format!("nodes[{index}]"), format!("expected {N} numbers for {name}")))
}
