//! Reading arguments that name files: meshes, `.gimc` files, `-` for stdin.

use std::io::Read;
use std::path::Path;

use gimc::{Decoder, Format, Limits, Loaded, Mesh, Task};

use super::failure::Failure;

/// How a file argument is called in messages.
pub(super) fn name(file: &Path) -> String {
    if file == Path::new("-") { "stdin".into() } else { file.display().to_string() }
}

/// All bytes of a file, or of stdin.
pub(super) fn bytes(file: &Path) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let read = if file == Path::new("-") {
        std::io::stdin().lock().read_to_end(&mut bytes).map(|_| ())
    } else {
        std::fs::read(file).map(|read| bytes = read)
    };
    read.map_err(|e| Failure::in_file(&name(file), e.into()))?;
    Ok(bytes)
}

/// A mesh, with what its file held and the mesh does not. A `.gimc` file is decoded.
pub(super) fn mesh(file: &Path, format: Option<Format>) -> Result<(Mesh, Vec<String>), Failure> {
    mesh_of(file, &bytes(file)?, format)
}

/// The same of a file that was read.
pub(super) fn mesh_of(file: &Path, bytes: &[u8], format: Option<Format>) -> Result<(Mesh, Vec<String>), Failure> {
    let read = || {
        if format.is_none() && bytes.starts_with(b"gimc") {
            let mesh = Decoder::with_limits(bytes, Limits::default())?.decode_with(Task::default())?;
            return Ok((mesh, Vec::new()));
        }
        // What the content proves comes before the name: a wrong extension is not the content's fault.
        let format = format.or_else(|| named_otherwise(file, bytes));
        let Loaded { mesh, notes, .. } = Mesh::read(bytes, format)?;
        Ok((mesh, notes))
    };
    read().map_err(|e| Failure::in_file(&name(file), e))
}

/// The format by the extension, unless the content proves that it is PLY or GLB.
fn named_otherwise(file: &Path, bytes: &[u8]) -> Option<Format> {
    if bytes.starts_with(b"ply") || bytes.starts_with(b"glTF") { None } else { Format::from_path(file) }
}

/// A format by name, for `--format`.
pub(super) fn format(text: &str) -> Result<Format, String> {
    Format::from_name(text).ok_or_else(|| "one of obj, ply, off, stl, glb is expected".into())
}
