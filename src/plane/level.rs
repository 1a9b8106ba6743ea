//! Levels and the strips between them (CGIM §3, §4.1).
//!
//! A level is a path across a disk. Two neighbouring levels span a strip of triangles, and a word
//! over three steps says how: reading from left to right, [`Step::Top`] goes on to the next vertex
//! of the upper level, [`Step::Bottom`] to that of the lower one, [`Step::Both`] goes along an edge
//! that the two levels share. A step of one side from `a` to `b` makes a triangle with the vertex
//! on which the other side stands, if the three differ.

/// Which side of a strip goes on to its next vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    /// The upper level.
    Top,
    /// The lower level.
    Bottom,
    /// Both, along a shared edge.
    Both,
}

/// The levels of a disk from top to bottom, and the word of each strip between two of them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Levels {
    vertices: Vec<u32>,
    /// `vertex_ends[i]` is one past the last vertex of level `i`.
    vertex_ends: Vec<usize>,
    steps: Vec<Step>,
    step_ends: Vec<usize>,
}

impl Levels {
    /// Adds a level below the others.
    pub(crate) fn push_level(&mut self, vertices: impl IntoIterator<Item = u32>) {
        self.vertices.extend(vertices);
        self.vertex_ends.push(self.vertices.len());
    }

    /// Adds the word of the strip above the last level.
    pub(crate) fn push_strip(&mut self, word: impl IntoIterator<Item = Step>) {
        self.steps.extend(word);
        self.step_ends.push(self.steps.len());
    }

    /// The number of levels.
    pub(crate) fn len(&self) -> usize {
        self.vertex_ends.len()
    }

    /// The vertices of level `i`, from left to right.
    pub(crate) fn level(&self, i: usize) -> &[u32] {
        &self.vertices[self.level_start(i)..self.vertex_ends[i]]
    }

    /// The word of the strip between the levels `i` and `i + 1`.
    pub(crate) fn strip(&self, i: usize) -> &[Step] {
        let start = if i == 0 { 0 } else { self.step_ends[i - 1] };
        &self.steps[start..self.step_ends[i]]
    }

    /// How many vertices the levels above `i` have together.
    pub(crate) fn level_start(&self, i: usize) -> usize {
        if i == 0 { 0 } else { self.vertex_ends[i - 1] }
    }

    /// The same levels with other names for their vertices, asked for level by level from left to right.
    pub(crate) fn map(mut self, rename: impl FnMut(u32) -> u32) -> Self {
        self.vertices = self.vertices.into_iter().map(rename).collect();
        self
    }

    /// The same levels read from right to left: as valid, but aligned to other columns.
    pub(crate) fn mirrored(&self) -> Self {
        let mut mirrored = Self::default();
        for i in 0..self.len() {
            mirrored.push_level(self.level(i).iter().rev().copied());
            if i + 1 < self.len() {
                mirrored.push_strip(self.strip(i).iter().rev().copied());
            }
        }
        mirrored
    }

    /// The triangles of all strips, in the order of the steps.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        (1..self.len()).flat_map(|i| {
            let (top, bottom) = (self.level(i - 1), self.level(i));
            let (mut t, mut b) = (0, 0);
            self.strip(i - 1).iter().filter_map(move |step| {
                let triangle = match step {
                    Step::Top => [top[t], top[t + 1], bottom[b]],
                    Step::Bottom => [top[t], bottom[b + 1], bottom[b]],
                    Step::Both => [top[t]; 3],
                };
                t += usize::from(*step != Step::Bottom);
                b += usize::from(*step != Step::Top);
                let [x, y, z] = triangle;
                (x != y && y != z && z != x).then_some(triangle)
            })
        })
    }
}
