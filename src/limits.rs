//! What a file may cost: memory and work, refused before they are spent.

use crate::error::{Error, Result};

/// What the caller allows a decoder to spend on one file.
///
/// A hostile file can at most reach these. The defaults keep memory below 8 GiB, which meshes of several million vertices
/// stay within at every effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Bytes of memory, over all buffers whose size comes from the file.
    pub memory: u64,
    /// Vertices of the decoded mesh.
    pub vertices: u64,
    /// Pixels of the decoded planes.
    pub pixels: u64,
    /// Elementary steps (symbols decoded, half-edges turned, pixels visited), not seconds.
    pub work: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { memory: 8 << 30, vertices: 100_000_000, pixels: 1 << 30, work: 200_000_000_000 }
    }
}

impl Limits {
    /// The same limits with another bound on memory, in bytes.
    pub fn memory(mut self, bytes: u64) -> Self {
        self.memory = bytes;
        self
    }

    /// The same limits with another bound on vertices.
    pub fn vertices(mut self, count: u64) -> Self {
        self.vertices = count;
        self
    }

    /// The same limits with another bound on pixels.
    pub fn pixels(mut self, count: u64) -> Self {
        self.pixels = count;
        self
    }

    /// The same limits with another bound on work, in steps.
    pub fn work(mut self, steps: u64) -> Self {
        self.work = steps;
        self
    }
}

/// What is left of the [`Limits`] while one file is decoded.
///
/// [`Budget::vec`] is the only way a decoder makes a vector whose length came from a file.
#[derive(Debug)]
pub(crate) struct Budget {
    limits: Limits,
    memory: u64,
    work: u64,
}

impl Budget {
    pub(crate) fn new(limits: Limits) -> Self {
        Self { limits, memory: limits.memory, work: limits.work }
    }

    /// Takes `steps` from the work that is left.
    #[inline]
    pub(crate) fn spend(&mut self, steps: u64) -> Result<()> {
        match self.work.checked_sub(steps) {
            Some(left) => {
                self.work = left;
                Ok(())
            }
            None => Err(Error::Limit {
                which: "work",
                wanted: (self.limits.work - self.work).saturating_add(steps),
                allowed: self.limits.work,
            }),
        }
    }

    /// Takes `bytes` from the memory that is left.
    pub(crate) fn reserve(&mut self, bytes: u64) -> Result<()> {
        match self.memory.checked_sub(bytes) {
            Some(left) => {
                self.memory = left;
                Ok(())
            }
            None => Err(Error::Limit {
                which: "memory",
                wanted: (self.limits.memory - self.memory).saturating_add(bytes),
                allowed: self.limits.memory,
            }),
        }
    }

    /// Refuses a mesh of more vertices than allowed.
    pub(crate) fn check_vertices(&self, wanted: u64) -> Result<()> {
        Self::check("vertices", wanted, self.limits.vertices)
    }

    /// Refuses images of more pixels than allowed.
    #[allow(dead_code)] // image codecs ask it
    pub(crate) fn check_pixels(&self, wanted: u64) -> Result<()> {
        Self::check("pixels", wanted, self.limits.pixels)
    }

    fn check(which: &'static str, wanted: u64, allowed: u64) -> Result<()> {
        if wanted > allowed { Err(Error::Limit { which, wanted, allowed }) } else { Ok(()) }
    }

    /// A vector of `n` copies of `value`, paid for from the memory that is left.
    pub(crate) fn vec<T: Clone>(&mut self, n: usize, value: T) -> Result<Vec<T>> {
        self.reserve((n as u64).saturating_mul(size_of::<T>() as u64))?;
        let mut v = Vec::new();
        v.try_reserve_exact(n).map_err(|_| Error::Limit {
            which: "memory",
            wanted: (n as u64).saturating_mul(size_of::<T>() as u64),
            allowed: self.limits.memory,
        })?;
        v.resize(n, value);
        Ok(v)
    }
}
