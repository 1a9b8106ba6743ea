//! Hostile and damaged files: a mesh or an error, within limits, never a panic.

use corpus_make::random::Random;
use gimc::{Decoder, Effort, EncodeOptions, Error, Limits, Mesh};
use trials::seal;

/// Small files of every sort: closed, open, with handles, in parts, at every effort.
fn files() -> Vec<Vec<u8>> {
    let shapes = [
        corpus_make::sphere(80),
        corpus_make::bumpy_sphere(120, 1),
        corpus_make::torus_with_holes(160, 2, 2),
        corpus_make::genus(300, 2, 3),
        corpus_make::components(240, 4, 4),
        corpus_make::block(120),
        corpus_make::terrain(120, 5),
        corpus_make::any(42, 30),
    ];
    let efforts = [Effort::Fast, Effort::Default, Effort::Best];
    let encode = |(i, shape): (usize, corpus_make::Shape)| {
        let mesh = Mesh::from_triangles(shape.positions, shape.triangles);
        let options = EncodeOptions::cgim().effort(efforts[i % 3]);
        let options = if i % 2 == 0 { options.bits(7) } else { options.step(0.013) };
        options.encode(&mesh).unwrap()
    };
    let mut files: Vec<_> = shapes.into_iter().enumerate().map(encode).collect();
    files.extend(trials::worn::files().unwrap());
    files
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    for file in files() {
        for end in 0..file.len() {
            assert!(trials::decode(&file[..end]).is_err(), "cut at {end} of {}", file.len());
        }
        assert!(trials::decode(&file).is_ok());
    }
}

#[test]
fn a_file_with_one_bit_changed_is_refused() {
    for file in files() {
        for bit in 0..8 * file.len() {
            let mut changed = file.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(trials::decode(&changed).is_err(), "bit {bit}");
        }
    }
}

#[test]
fn payloads_cut_anywhere_and_sealed_again_do_no_harm() {
    for file in files() {
        let chunks = seal::open(&file);
        for (i, (_, payload)) in chunks.iter().enumerate() {
            for end in 0..payload.len() {
                drop(trials::decode(&seal::changed(&file, |c| c[i].1.truncate(end))));
            }
        }
    }
}

#[test]
fn payloads_with_one_bit_changed_and_sealed_again_do_no_harm() {
    let (mut refused, mut accepted) = (0, 0);
    for file in files() {
        for (i, (_, payload)) in seal::open(&file).iter().enumerate() {
            for bit in 0..8 * payload.len() {
                let changed = seal::changed(&file, |c| c[i].1[bit / 8] ^= 1 << (bit % 8));
                if trials::decode(&changed).is_err() { refused += 1 } else { accepted += 1 }
            }
        }
    }
    // Both must happen, or the damage does not reach what it is meant for.
    assert!(refused > 100 && accepted > 100, "{refused} refused, {accepted} accepted");
}

#[test]
fn payloads_of_random_bytes_and_of_other_files_do_no_harm() {
    let files = files();
    let mut random = Random::new(7);
    for round in 0..600 {
        let file = &files[round % files.len()];
        let other = &files[random.below(files.len() as u64) as usize];
        let broken = seal::changed(file, |chunks| {
            let body = chunks.len() - 1;
            match round % 3 {
                // Noise from some byte on.
                0 => {
                    let from = random.below(chunks[body].1.len() as u64) as usize;
                    chunks[body].1[from..].iter_mut().for_each(|b| *b = random.bits() as u8);
                }
                // The body of another file under this header.
                1 => chunks[body] = seal::open(other)[1].clone(),
                // Numbers of the header and the body made large.
                _ => {
                    let chunk = random.below(2) as usize;
                    let at = random.below(12.min(chunks[chunk].1.len() as u64)) as usize;
                    let huge = [0xff_u8, 0xff, 0xff, 0xff, random.bits() as u8 & 0x0f];
                    chunks[chunk].1.splice(at..at + 1, huge);
                }
            }
        });
        drop(trials::decode(&broken));
    }
}

#[test]
fn noise_beside_the_surface_does_no_harm() {
    let files = trials::worn::files().unwrap();
    let mut random = Random::new(11);
    for round in 0..4000_u32 {
        let mut bytes: Vec<u8> = (0..3 + random.below(80)).map(|_| random.bits() as u8).collect();
        // Mostly behind the counts, where the streams are.
        bytes[2] %= 60;
        bytes[1] = round as u8;
        trials::worn::decode(&files, &bytes);
    }
}

#[test]
fn limits_are_held_before_memory_is_asked_for() {
    let shape = corpus_make::sphere(5000);
    let mesh = Mesh::from_triangles(shape.positions, shape.triangles);
    let file = EncodeOptions::cgim().encode(&mesh).unwrap();
    let under = |limits: Limits| match Decoder::with_limits(&file, limits).and_then(|d| d.decode()) {
        Err(Error::Limit { which, wanted, allowed }) => {
            assert!(wanted > allowed);
            which
        }
        Err(_) => "another error",
        Ok(_) => "no error",
    };
    assert_eq!(under(Limits::default().vertices(2000)), "vertices");
    assert_eq!(under(Limits::default().memory(10_000)), "memory");
    assert_eq!(under(Limits::default().work(1000)), "work");
    let info = Decoder::new(&file).unwrap().info().clone();
    assert_eq!(under(Limits::default().memory(info.memory).vertices(info.vertices.into())), "no error");
    assert_eq!(under(Limits::default().work(info.work)), "no error");
}

#[test]
fn a_small_file_that_promises_a_huge_mesh_is_refused_at_once() {
    let tiny = Mesh::from_triangles(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]]);
    let file = EncodeOptions::cgim().bits(4).encode(&tiny).unwrap();
    // HEAD: codec, number type, then the vertices as a varint.
    let huge = seal::changed(&file, |chunks| {
        assert_eq!(chunks[0].1[2], 3);
        chunks[0].1.splice(2..3, [0x80, 0x80, 0x80, 0x10]);
    });
    // Allowed by the caller's limits, impossible for so few bytes: the bytes are what must refuse it.
    let limits = Limits::default().vertices(1 << 40).memory(1 << 50).work(1 << 50);
    assert!(Decoder::with_limits(&huge, limits).and_then(|d| d.decode()).is_err());
}

#[test]
fn a_cancelled_task_stops_both_ways() {
    let shape = corpus_make::sphere(200_000);
    let mesh = Mesh::from_triangles(shape.positions, shape.triangles);
    let stop = std::sync::atomic::AtomicBool::new(true);
    let task = gimc::Task::default().with_cancel(&stop);
    assert!(matches!(EncodeOptions::cgim().encode_with(&mesh, task), Err(Error::Cancelled)));
    let file = EncodeOptions::cgim().encode(&mesh).unwrap();
    assert!(matches!(Decoder::new(&file).unwrap().decode_with(task), Err(Error::Cancelled)));
}

#[test]
fn handles_that_would_need_more_memory_than_allowed_are_refused_before_the_walk() {
    let shape = corpus_make::sphere(80);
    let mesh = Mesh::from_triangles(shape.positions, shape.triangles);
    let file = EncodeOptions::cgim().bits(8).effort(Effort::Fast).encode(&mesh).unwrap();
    for handles in [1_u32 << 28, u32::MAX] {
        let changed = trials::seal::changed(&file, |chunks| {
            // Effort, holes, components, handles: the last three are one byte each.
            let varint = (0..5).map(|i| (handles >> (7 * i)) as u8 & 0x7f | if i < 4 { 0x80 } else { 0 });
            chunks[1].1.splice(3..4, varint);
        });
        let refused = Decoder::new(&changed).unwrap().decode();
        assert!(matches!(refused, Err(Error::Limit { which: "memory", .. })), "{handles} handles: {refused:?}");
    }
}
