//! Trials: functions that take anything and panic only where the library broke a promise.
//!
//! The fuzz targets call them with what the fuzzer invents, the tests with what is known to be difficult, so that a finding
//! of the one becomes a regression test of the other.

mod same;
pub mod seal;
pub mod worn;

use corpus_make::Shape;
use gimc::{Boundaries, Codec, Decoder, Effort, EncodeOptions, Error, Format, J2kChoices, Limits, Mesh, Quality};

pub use same::assert_same;

/// What a trial allows a file to cost.
pub fn limits() -> Limits {
    Limits::default().memory(64 << 20).vertices(1 << 20).work(1 << 28)
}

/// Decodes any bytes. What comes out keeps the limits and is a mesh; whether it comes out is not judged.
///
/// # Panics
/// If the decoder broke a promise.
pub fn decode(bytes: &[u8]) -> Result<Mesh, Error> {
    let decoder = Decoder::with_limits(bytes, limits())?;
    let info = decoder.info();
    assert_eq!(info.parts.iter().map(|p| p.1).sum::<u64>(), bytes.len() as u64, "the parts do not add up to the file");
    let mesh = decoder.decode()?;
    assert!(mesh.positions.len() as u64 <= limits().vertices, "more vertices than allowed");
    assert_eq!(mesh.positions.len(), info.vertices as usize, "the header counts other vertices");
    assert_eq!(mesh.faces.len(), info.faces as usize, "the header counts other faces");
    if let Err(why) = mesh.check() {
        panic!("not a mesh: {why}");
    }
    Ok(mesh)
}

/// Reads any bytes as a mesh file. What is read can be written, and what is written can be read.
///
/// # Panics
/// If that does not hold.
pub fn read(bytes: &[u8], format: Format) {
    let Ok(loaded) = Mesh::read(bytes, Some(format)) else { return };
    let mesh = loaded.mesh;
    let mut written = Vec::new();
    match mesh.write(format, &mut written) {
        Err(Error::Mesh(_) | Error::Parameter(_) | Error::Unsupported { .. }) => return,
        Err(error) => panic!("writing to memory failed: {error}"),
        Ok(_) => {}
    }
    let again = match Mesh::read(&written, Some(format)) {
        Ok(again) => again.mesh,
        // Text formats have no word for what is not finite.
        Err(_) if mesh.positions.iter().flatten().any(|x| !x.is_finite()) => return,
        Err(error) => panic!("what was written cannot be read: {error}"),
    };
    // Triangles without indices are welded, and scenes are taken apart.
    if !matches!(format, Format::Stl | Format::Glb) {
        assert_eq!(again.positions.len(), mesh.positions.len(), "vertices were lost");
        assert_eq!(again.faces, mesh.faces, "faces changed");
    }
    // Encoding may refuse the mesh, but not fall over it.
    if mesh.positions.len() < 10_000 && mesh.faces.len() < 20_000 {
        drop(EncodeOptions::cgim().bits(8).encode(&mesh));
        drop(mesh.inspect());
    }
}

/// Encodes a mesh that the bytes choose, decodes it, and compares slowly.
///
/// # Panics
/// If the mesh that comes back is another.
pub fn roundtrip(bytes: &[u8]) {
    let mut seed = [0; 8];
    let n = bytes.len().min(8);
    seed[..n].copy_from_slice(&bytes[..n]);
    let choice = |i: usize, of: u8| bytes.get(i).map_or(0, |b| b % of);
    let shape = corpus_make::any(u64::from_le_bytes(seed), 20 + 4 * usize::from(choice(10, 255)));
    let effort = [Effort::Fast, Effort::Default, Effort::Best][usize::from(choice(9, 3))];
    roundtrip_of(&shape, 1 + u32::from(choice(8, 24)), effort);
}

/// Keeps a mesh that the bytes choose as an image of vertices (any codec, any form of its borders), decodes the file,
/// compares slowly, and decodes it again with what is left of the bytes written over parts of it.
///
/// # Panics
/// If another mesh comes back, or the decoder breaks a promise.
pub fn image(bytes: &[u8]) {
    let choice = |i: usize, of: u8| bytes.get(i).map_or(0, |b| b % of);
    let shape = corpus_make::any(u64::from(choice(0, 255)), 4 + usize::from(choice(1, 120)));
    let mesh = Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied());
    let bits = 1 + u32::from(choice(2, 12));
    let mut options = EncodeOptions::cgim().bits(bits).effort(Effort::Fast);
    let kind = choice(3, 7);
    options.codec = [Codec::Mbcim, Codec::Mbcim, Codec::Raw, Codec::Raw, Codec::J2k, Codec::J2k, Codec::J2k][usize::from(kind)];
    match kind {
        0 => options.image.stages = vec![1 + choice(4, 3); usize::from(choice(5, 3))],
        1 | 3 => options.image.paper = true,
        _ => options.image.search = 1 + usize::from(choice(4, 3)),
    }
    if kind >= 2 && choice(5, 2) == 1 {
        options.image.normals = Some(2 + choice(4, 8));
    }
    let mut j2k = J2kChoices::default();
    if kind >= 5 {
        j2k.boundaries = Boundaries::Implied;
    }
    if kind == 6 || kind == 4 && choice(6, 2) == 1 {
        j2k.quality = Quality::BitsPerPixel(1.0 + f64::from(choice(7, 20)));
    }
    options = options.j2k(j2k);
    let file = match options.encode(&mesh) {
        Ok(file) => file,
        // Rates may be too low for a stream, and stages finer than the coordinates.
        Err(Error::Parameter(_)) => return,
        Err(error) => panic!("a manifold mesh of {} faces was refused: {error}", shape.triangles.len()),
    };
    let back = match Decoder::new(&file).and_then(|decoder| decoder.decode()) {
        Ok(back) => back,
        Err(error) => panic!("the file cannot be decoded: {error}"),
    };
    if j2k.quality == Quality::Lossless {
        assert_same(&on_lattice(&shape, bits), &back);
    }
    let hostile = seal::changed(&file, |chunks| {
        for change in bytes.get(8..).unwrap_or(&[]).chunks_exact(4) {
            let at = chunks.len() - 1 - usize::from(change[0]) % (chunks.len() - 1).max(1);
            let payload = &mut chunks[at].1;
            let place = (usize::from(change[1]) | usize::from(change[2]) << 8) % payload.len().max(1);
            if let Some(byte) = payload.get_mut(place) {
                *byte = change[3];
            }
        }
    });
    drop(decode(&hostile));
}

/// Encodes a mesh with so many bits, decodes it, and compares slowly.
///
/// # Panics
/// If the mesh that comes back is another, or the bound does not hold.
pub fn roundtrip_of(shape: &Shape, bits: u32, effort: Effort) {
    let mesh = Mesh::from_triangles(shape.positions.clone(), shape.triangles.iter().copied());
    let options = EncodeOptions::cgim().bits(bits).effort(effort);
    let bytes = match options.encode(&mesh) {
        Ok(bytes) => bytes,
        Err(error) => panic!("a manifold mesh of {} faces was refused: {error}", shape.triangles.len()),
    };
    let decoder = match Decoder::new(&bytes) {
        Ok(decoder) => decoder,
        Err(error) => panic!("the file cannot be opened: {error}"),
    };
    match decoder.decode() {
        Ok(back) => assert_same(&on_lattice(shape, bits), &back),
        Err(error) => panic!("the file cannot be decoded: {error}"),
    }
    let half_steps = 0.5 * decoder.info().step * 3_f64.sqrt();
    let size = shape.positions.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(decoder.info().bound <= half_steps * 1.000001 + 2.0 * size * f64::from(f32::EPSILON), "the bound is too wide");
}

/// Where positions belong by the rule of the format: one step for all axes, the longest side of the box over 2^bits − 1,
/// coordinates rounded half up, and decoded in `f32`.
pub fn on_lattice(shape: &Shape, bits: u32) -> Shape {
    let side = |axis: usize| {
        let low = shape.positions.iter().fold(f64::INFINITY, |m, p| m.min(p[axis]));
        (low, shape.positions.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[axis])) - low)
    };
    let sides = [side(0), side(1), side(2)];
    let longest = sides.iter().fold(0.0_f64, |m, s| m.max(s.1));
    let step = if longest > 0.0 { longest / (2_f64.powi(bits as i32) - 1.0) } else { 1.0 };
    let place = |x: f64, axis: usize| {
        let q = ((x - sides[axis].0) / step + 0.5).floor();
        f64::from((sides[axis].0 + q * step) as f32)
    };
    let positions = shape.positions.iter().map(|p| [0, 1, 2].map(|axis| place(p[axis], axis))).collect();
    Shape { positions, triangles: shape.triangles.clone() }
}

/// A number for everything that a mesh holds, bit for bit: FNV-1a over coordinates and corners.
pub fn fingerprint(mesh: &Mesh) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |bytes: &[u8]| {
        for &byte in bytes {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    };
    mesh.positions.iter().flatten().for_each(|x| add(&x.to_le_bytes()));
    for face in mesh.faces.iter() {
        add(&(face.len() as u32).to_le_bytes());
        face.iter().for_each(|v| add(&v.to_le_bytes()));
    }
    hash
}
