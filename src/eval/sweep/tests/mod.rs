//! Sweeps with coders whose answers are known beforehand.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::*;
use crate::eval::{BdRate, curves_svg, points_csv};

/// Says that a file has so many bytes and moves the mesh up by so much; or refuses.
struct Fake {
    bytes: u64,
    up: f64,
    calls: Arc<AtomicUsize>,
}

impl Coder for Fake {
    fn program(&self) -> String {
        "fake 1".into()
    }

    fn method(&self) -> String {
        "none".into()
    }

    fn codec(&self) -> String {
        "none".into()
    }

    fn round_trip(&self, mesh: &SweepMesh, task: Task<'_>) -> Result<RoundTrip> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        task.step(0.5)?;
        if self.bytes == 0 {
            return Err(Error::Parameter("not\nthis one".into()));
        }
        let mut moved = mesh.mesh.clone();
        moved.positions.iter_mut().for_each(|p| p[2] += self.up);
        Ok(RoundTrip { bytes: self.bytes, mesh: moved, bound: Some(self.up), seconds: [0.25, 0.125] })
    }
}

/// A flat square whose diagonal is the square root of 2.
fn square(file: &str) -> SweepMesh {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    SweepMesh::new(file, file.as_bytes(), Mesh::from_triangles(positions, [[0, 1, 2], [0, 2, 3]]))
}

/// Two ways over each mesh; the second has four fifths of the bytes, and a setting that is refused.
fn planned(meshes: Vec<SweepMesh>, known: Vec<SweepPoint>, calls: &Arc<AtomicUsize>) -> Sweep {
    let mut sweep = Sweep::new(meshes, known);
    let fake = |bytes, up| Arc::new(Fake { bytes, up, calls: Arc::clone(calls) });
    for i in 0..sweep.meshes().len() {
        for (k, up) in [(1, 0.1), (2, 0.05), (3, 0.02)] {
            sweep.add(i, "a", format!("-a {k}"), "make a", fake(100 * k, up));
            sweep.add(i, "b", format!("-b {k}"), "make b", fake(80 * k, up));
        }
        sweep.add(i, "b", "-b 0", "make b", fake(0, 0.0));
        sweep.add(i, "b", "-b 1", "a second time", fake(1, 1.0));
    }
    sweep
}

fn ignore(_: &[&SweepPoint]) -> Result<()> {
    Ok(())
}

#[test]
fn points_have_the_measures_of_what_came_back() {
    let calls = Arc::new(AtomicUsize::new(0));
    let swept = planned(vec![square("x/flat.ply")], Vec::new(), &calls).run(&ignore, Task::default());
    assert_eq!((swept.points.len(), swept.measured, swept.kept, swept.left), (7, 7, 0, 0));
    let first = swept.points[0].result.as_ref().unwrap();
    assert_eq!((first.bytes, first.bpv, first.bound, first.seconds), (100, 200.0, Some(0.1), [0.25, 0.125]));
    assert!((first.rms - 0.1).abs() < 1e-12 && (first.psnr - 20.0 * (2.0_f64.sqrt() / 0.1).log10()).abs() < 1e-9);
    assert_eq!(swept.points[6].result.as_ref().unwrap_err(), "not this one");
    let table = SweepTable::new(&swept.points, None).unwrap();
    assert_eq!((table.reference, &table.ways[..]), ("a", &["a", "b"][..]));
    let Some(BdRate::Over { .. }) = table.meshes[0].ways[1].bd_rate else { panic!("{:?}", table.meshes[0].ways[1]) };
    assert!((table.means[1].percent.unwrap() + 20.0).abs() < 1e-9);
    // Those of b beat those of a everywhere.
    assert!(table.meshes[0].front.iter().all(|p| p.way == "b") && table.meshes[0].front.len() == 3);
    assert!(curves_svg(&table).contains("b refused 1 of 4: not this one"));
    assert!(SweepTable::new(&swept.points, Some("c")).is_err());
    assert!(SweepTable::new(&[], None).unwrap().meshes.is_empty());
}

#[test]
fn the_table_is_saved_after_every_point_in_its_final_order() {
    let calls = Arc::new(AtomicUsize::new(0));
    let saved = Mutex::new(Vec::new());
    let save = |points: &[&SweepPoint]| {
        saved.lock().unwrap().push(points_csv(points.iter().copied()));
        Ok(())
    };
    let sweep = planned(vec![square("a.ply"), square("b.ply")], Vec::new(), &calls).jobs(3);
    let swept = sweep.run(&save, Task::default());
    let saved = saved.into_inner().unwrap();
    assert_eq!(saved.len(), 15);
    let last: Vec<&str> = saved[14].lines().collect();
    assert_eq!(saved[14], points_csv(&swept.points));
    for (n, text) in saved.iter().enumerate() {
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), n + 1);
        let mut rest = last.iter();
        assert!(lines.iter().all(|line| rest.any(|l| l == line)), "a part of the whole, in its order");
    }
    // Known points cost nothing and give the same table.
    let again = planned(vec![square("a.ply"), square("b.ply")], swept.points.clone(), &calls);
    assert_eq!(again.counts(), [14, 0]);
    assert_eq!(again.run(&ignore, Task::default()).points, swept.points);
    assert_eq!(calls.load(Ordering::Relaxed), 14);
}

#[test]
fn a_sweep_that_is_stopped_keeps_what_it_has() {
    let calls = Arc::new(AtomicUsize::new(0));
    let stop = AtomicBool::new(false);
    let save = |points: &[&SweepPoint]| {
        stop.store(points.len() == 3, Ordering::Relaxed);
        Ok(())
    };
    let swept = planned(vec![square("a.ply")], Vec::new(), &calls).run(&save, Task::default().with_cancel(&stop));
    assert_eq!((swept.points.len(), swept.left), (3, 4));
    assert!(matches!(swept.stopped, Some(Error::Cancelled)));
    let full = |points: &[&SweepPoint]| match points.len() {
        2 => Err(Error::Io(std::io::Error::other("the disk is full"))),
        _ => Ok(()),
    };
    let swept = planned(vec![square("a.ply")], Vec::new(), &calls).run(&full, Task::default());
    assert_eq!(swept.points.len(), 2);
    assert!(matches!(swept.stopped, Some(Error::Io(_))));
}

#[test]
fn meshes_that_are_not_the_same_never_share_a_name() {
    let calls = Arc::new(AtomicUsize::new(0));
    let first = planned(vec![square("x/m.ply"), square("y/m.ply")], Vec::new(), &calls);
    let names = |sweep: &Sweep| sweep.meshes().iter().map(|mesh| mesh.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&first), ["m", "y/m.ply"]);
    let known = first.run(&ignore, Task::default()).points;
    // The same mesh from elsewhere is known; another of that name is not.
    let mut moved = square("x/m.ply");
    moved.file = "z/m.ply".into();
    let second = planned(vec![moved, square("w/m.ply")], known.clone(), &calls);
    assert_eq!((names(&second), second.counts(), second.dropped()), (vec!["m".into(), "w/m.ply".into()], [14, 7], 0));
    // Copies keep their names, also when they are known; a mesh that is given twice counts once.
    let copies = || {
        let mut copy = square("x/m.ply");
        (copy.name, copy.file) = ("copy".into(), "x/copy.ply".into());
        vec![square("x/m.ply"), copy, square("x/m.ply")]
    };
    let swept = planned(copies(), Vec::new(), &calls).run(&ignore, Task::default());
    assert_eq!(names(&planned(copies(), swept.points, &calls)), ["m", "copy"]);
    // A file that has changed takes its name over from its old points.
    let changed = SweepMesh::new("x/m.ply", b"other bytes", square("x/m.ply").mesh);
    let third = planned(vec![changed], known, &calls);
    assert_eq!((names(&third), third.counts(), third.dropped()), (vec!["m".into()], [7, 7], 7));
}

#[test]
fn progress_grows_to_the_end() {
    let calls = Arc::new(AtomicUsize::new(0));
    let shares = Mutex::new(Vec::new());
    let report = |share| shares.lock().unwrap().push(share);
    planned(vec![square("a.ply")], Vec::new(), &calls).run(&ignore, Task::default().with_progress(&report));
    let shares = shares.into_inner().unwrap();
    assert!(shares.windows(2).all(|w| w[1] >= w[0]) && *shares.last().unwrap() > 0.8, "{shares:?}");
}
