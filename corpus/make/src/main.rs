//! Writes procedural meshes as PLY.
//!
//! ```text
//! corpus-make committed DIR               the meshes of corpus/meshes
//! corpus-make NAME --faces N [--seed S] OUT.ply
//! ```

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("corpus-make: {why}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[String]) -> Result<(), String> {
    let (mut words, mut faces, mut seed) = (Vec::new(), 20_000, 1);
    let mut rest = arguments.iter();
    while let Some(word) = rest.next() {
        let mut number = |what: &str| {
            let text = rest.next().ok_or_else(|| format!("{what} wants a number"))?;
            text.parse::<u64>().map_err(|_| format!("{what} wants a number, found {text}"))
        };
        match word.as_str() {
            "--faces" => faces = number("--faces")? as usize,
            "--seed" => seed = number("--seed")?,
            _ => words.push(word.as_str()),
        }
    }
    let write = |path: &std::path::Path, shape: &corpus_make::Shape| {
        println!("{}: {} vertices, {} triangles", path.display(), shape.positions.len(), shape.triangles.len());
        std::fs::write(path, shape.to_ply()).map_err(|e| format!("{}: {e}", path.display()))
    };
    match *words {
        ["committed", folder] => {
            for (file, name, faces, seed) in corpus_make::COMMITTED {
                if let Some(shape) = corpus_make::by_name(name, faces, seed) {
                    write(&std::path::Path::new(folder).join(file), &shape)?;
                }
            }
            Ok(())
        }
        [name, out] => {
            let shape = corpus_make::by_name(name, faces, seed)
                .ok_or_else(|| format!("no shape is called {name}; there are {}", corpus_make::NAMES.join(", ")))?;
            write(out.as_ref(), &shape)
        }
        _ => Err("use: corpus-make NAME --faces N [--seed S] OUT.ply, or: corpus-make committed DIR".into()),
    }
}
