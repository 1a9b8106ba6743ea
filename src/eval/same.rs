//! Do two meshes have the same connectivity?

use super::report::json::Json;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::task::Task;

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Proven by a map of the vertices.
    Same,
    /// Proven by something that no map changes, or by trying all.
    Different,
    /// The search was given up.
    Undecided,
}

impl Verdict {
    /// `true`, `false`, or `null` if undecided.
    pub fn to_json(self) -> Json {
        match self {
            Self::Same => true.into(),
            Self::Different => false.into(),
            Self::Undecided => Json::Null,
        }
    }
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Correspondence {
    /// The answer.
    pub verdict: Verdict,
    /// Where the same: for each vertex of the first mesh the vertex of the second.
    pub map: Option<Vec<u32>>,
}

/// Placeholder until the search lands: the same lists are the same.
pub fn same(a: &Mesh, b: &Mesh, _tolerance: Option<f64>, _task: &Task<'_>) -> Result<Correspondence> {
    if a.faces == b.faces && a.positions.len() == b.positions.len() {
        let map = Some((0..a.positions.len() as u32).collect());
        return Ok(Correspondence { verdict: Verdict::Same, map });
    }
    Ok(Correspondence { verdict: Verdict::Undecided, map: None })
}
