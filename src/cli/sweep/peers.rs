//! Other programs in a sweep: they are run as they are found, on files in a temporary folder, and measured like everything
//! else. What starts here is what `PATH` leads to.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use gimc::eval::{Coder, RoundTrip, SweepMesh};
use gimc::{Error, Format, Mesh, Scalar, Task};

use super::words::line;

/// A program that makes files of meshes, and one that reads them.
#[derive(Debug)]
pub(super) struct Peer {
    name: &'static str,
    /// The two programs, by their names on `PATH`.
    programs: [&'static str; 2],
    /// Where they come from.
    from: &'static str,
    /// The extension of its files.
    extension: &'static str,
    /// What it reads of the formats that are written here.
    reads: &'static [Format],
    /// What is told to the first program for so many bits.
    setting: fn(&str) -> Vec<String>,
    /// All that is told to the first program: input, output, setting.
    encode: fn(&str, &str, &[String]) -> Vec<String>,
    /// All that is told to the second: input, output (a PLY file).
    decode: fn(&str, &str) -> Vec<String>,
}

fn texts<const N: usize>(words: [&str; N]) -> Vec<String> {
    words.map(str::to_owned).to_vec()
}

/// All of them. Another is an entry here.
pub(super) const PEERS: &[Peer] = &[Peer {
    name: "draco",
    programs: ["draco_encoder", "draco_decoder"],
    from: "the package draco of Debian, or github.com/google/draco",
    extension: "drc",
    reads: &[Format::Ply, Format::Obj],
    setting: |bits| texts(["-qp", bits, "-cl", "10"]),
    encode: |input, output, setting| [texts(["-i", input, "-o", output]), setting.to_vec()].concat(),
    decode: |input, output| texts(["-i", input, "-o", output]),
}];

/// A peer that was found.
#[derive(Debug)]
pub(super) struct Found {
    peer: &'static Peer,
    programs: [PathBuf; 2],
}

impl Peer {
    /// Looks for both programs on `PATH`; the error says what is missing.
    pub(super) fn find(&'static self) -> Result<Found, String> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let find = |name: &str| {
            let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
            let found = std::env::split_paths(&path).map(|folder| folder.join(&file)).find(|file| file.is_file());
            found.ok_or_else(|| format!("{} is skipped: there is no {name} on PATH ({})", self.name, self.from))
        };
        let [encoder, decoder] = self.programs;
        Ok(Found { peer: self, programs: [find(encoder)?, find(decoder)?] })
    }
}

/// One point of a peer.
#[derive(Debug)]
pub(super) struct PeerCoder {
    peer: &'static Peer,
    programs: [PathBuf; 2],
    setting: Vec<String>,
    /// The file that it reads itself, if it can.
    original: Option<PathBuf>,
}

impl Found {
    pub(super) fn name(&self) -> &'static str {
        self.peer.name
    }

    /// The point of so many bits of a mesh that was read from `file`: the setting, the command, and what runs it.
    pub(super) fn point(&self, mesh: &SweepMesh, file: &Path, bits: &str) -> (String, String, PeerCoder) {
        let peer = self.peer;
        let setting = (peer.setting)(bits);
        let original = peer.takes(mesh, file).then(|| file.to_owned());
        let stem = super::file_name(&mesh.name);
        let text = super::file_name(&setting.join(" "));
        let output = format!("{stem}-{}-{text}.{}", peer.name, peer.extension);
        let (before, input) = match &original {
            Some(file) => (String::new(), file.display().to_string()),
            None => {
                // The same that `round_trip` writes for it.
                let [bare, plain] = [format!("{stem}-shape.gimc"), format!("{stem}-shape.obj")];
                let file = file.display().to_string();
                let keep = ["gimc", "encode", &file, &bare, "--bits", "exact", "--keep-order", "--attributes", "none"];
                (format!("{} && {} && ", line(keep), line(["gimc", "decode", &bare, &plain])), plain)
            }
        };
        let arguments = (peer.encode)(&input, &output, &setting);
        let words = [peer.programs[0]].into_iter().chain(arguments.iter().map(String::as_str));
        let command = format!("{before}{}", line(words));
        let coder = PeerCoder { peer, programs: self.programs.clone(), setting: setting.clone(), original };
        (setting.join(" "), command, coder)
    }
}

impl Peer {
    /// Whether the peer is given the file as it is: it reads the format, and nothing but the shape is in the file.
    fn takes(&self, mesh: &SweepMesh, file: &Path) -> bool {
        let shape_alone = mesh.mesh.attributes.is_empty() && mesh.mesh.labels.is_empty();
        let format = Format::from_path(file).filter(|format| self.reads.contains(format));
        // PLY files of doubles are not for everyone.
        shape_alone && format.is_some_and(|format| format != Format::Ply || mesh.mesh.precision == Scalar::F32)
    }
}

impl PeerCoder {
    /// Runs one of the two programs; the seconds that it took.
    fn run(&self, which: usize, arguments: &[String], folder: &Path, task: &Task<'_>) -> gimc::Result<f64> {
        let name = self.peer.programs[which];
        let refused = |why: String| Error::Parameter(format!("{name} {why}"));
        let said = folder.join("said");
        let log = File::create(&said)?;
        let start = Instant::now();
        let mut command = Command::new(&self.programs[which]);
        command.args(arguments).stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
        let mut child = command.spawn().map_err(|e| refused(format!("does not start: {e}")))?;
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break status;
            }
            if task.is_over() {
                // Gone already, perhaps.
                let _ = child.kill();
                child.wait()?;
                return Err(Error::Cancelled);
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        let seconds = start.elapsed().as_secs_f64();
        if status.success() {
            return Ok(seconds);
        }
        let said = fs::read(&said).unwrap_or_default();
        let said = String::from_utf8_lossy(&said);
        let last = said.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("it said nothing");
        Err(refused(format!("failed ({status}): {last}")))
    }
}

impl Coder for PeerCoder {
    fn program(&self) -> String {
        self.peer.programs[0].into()
    }

    fn method(&self) -> String {
        "peer".into()
    }

    fn codec(&self) -> String {
        self.peer.name.into()
    }

    fn round_trip(&self, mesh: &SweepMesh, task: Task<'_>) -> gimc::Result<RoundTrip> {
        let folder = Scratch::new()?;
        let path = |name: &str| folder.0.join(name).display().to_string();
        let input = match &self.original {
            Some(file) => file.display().to_string(),
            None => {
                let mut shape = Mesh::default();
                shape.positions.clone_from(&mesh.mesh.positions);
                shape.faces.clone_from(&mesh.mesh.faces);
                shape.precision = mesh.mesh.precision;
                shape.save(path("shape.obj"))?;
                path("shape.obj")
            }
        };
        let [coded, back] = [path(&format!("coded.{}", self.peer.extension)), path("back.ply")];
        let encode = self.run(0, &(self.peer.encode)(&input, &coded, &self.setting), &folder.0, &task)?;
        let bytes = fs::metadata(&coded).map_err(|_| missing(self.peer.programs[0]))?.len();
        let decode = self.run(1, &(self.peer.decode)(&coded, &back), &folder.0, &task)?;
        if !Path::new(&back).exists() {
            return Err(missing(self.peer.programs[1]));
        }
        Ok(RoundTrip { bytes, mesh: Mesh::open(&back)?, bound: None, seconds: [encode, decode] })
    }
}

fn missing(program: &str) -> Error {
    Error::Parameter(format!("{program} ended well and made no file"))
}

/// A temporary folder, removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> std::io::Result<Self> {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        loop {
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let path = std::env::temp_dir().join(format!("gimc-sweep-{}-{number}", std::process::id()));
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Self(path)),
                Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed is left to the system.
        let _ = fs::remove_dir_all(&self.0);
    }
}
