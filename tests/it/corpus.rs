//! What lies in `corpus/` is what the documented commands make.

use std::path::PathBuf;

/// A file of the corpus.
pub(crate) fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name)
}

#[test]
fn the_generator_still_makes_the_committed_meshes() {
    for (file, name, faces, seed) in corpus_make::COMMITTED {
        let made = corpus_make::by_name(name, faces, seed).expect("a name of the generator").to_ply();
        let kept = std::fs::read(path("meshes").join(file)).expect(file);
        assert!(made == kept, "{file} differs from what corpus-make makes: run `corpus-make committed corpus/meshes`");
    }
}
