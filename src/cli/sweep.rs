//! `gimc sweep MESH... --out DIR`

mod peers;
mod ways;
mod words;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use clap::Args;
use clap::builder::PossibleValuesParser;
use gimc::Error;
use gimc::eval::{
    self, BdRate, Coder, Json, OwnCoder, SweepMesh, SweepPoint, SweepTable, Swept, bd_rate_csv, curves_svg, points_csv,
    read_points, report_html,
};

use super::failure::Failure;
use super::{Common, Outcome, encode, input, output};
use peers::{Found, PEERS};
use ways::{Setting, WAYS};
use words::line;

const POINTS: &str = "points.csv";

/// Measure rate and distortion: every mesh in every way at every setting.
///
/// The folder gets `points.csv` (all measures of every point, and the command that makes its file), `curves.svg`,
/// `bd_rate.csv` and `report.html`. The points are written one by one; called again, the sweep goes on where it stopped, and
/// measures only what is new: other settings, other meshes, meshes that have changed. Files keep the shape alone, without
/// attributes, unless a setting says otherwise. What a mesh cannot be made into is recorded as refused, with the reason.
#[derive(Debug, Args)]
pub(super) struct Sweep {
    /// The meshes: obj, ply, off, stl or glb.
    #[arg(value_name = "MESH", required = true)]
    meshes: Vec<PathBuf>,
    /// The folder for the results; it is made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The ways, with commas between: each is a curve.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        value_parser = PossibleValuesParser::new(ways::names()),
        default_value = "surface,mbcim,j2k,gim,gim-j2k"
    )]
    ways: Vec<String>,
    /// Bits of coordinates to go through, also those of peers.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "6,8,10,12,14")]
    bits: Vec<String>,
    /// Rates of JPEG 2000 to go through, in bits a pixel.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "0.25,0.5,1,2,4")]
    rate: Vec<String>,
    /// Psnr of geometry images to go through, in dB.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "55,60,65,70")]
    psnr: Vec<String>,
    /// Settings of your own: arguments of `gimc encode`, where {8,10,12} stands for several points; NAME= before them names
    /// the way. May be repeated.
    #[arg(long, value_name = "[NAME=]ARGUMENTS", allow_hyphen_values = true)]
    with: Vec<String>,
    /// Also run those other programs that are installed: draco.
    #[arg(long)]
    peers: bool,
    /// The way that the others are compared with [default: the first].
    #[arg(long, value_name = "WAY")]
    reference: Option<String>,
    /// Points to measure at a time. Results do not depend on it, but the seconds do.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: u16,
    /// Measure again what is known.
    #[arg(long)]
    fresh: bool,
    #[command(flatten)]
    common: Common,
}

/// Seconds since the first call.
fn clock() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// A text as a part of a file name.
fn file_name(text: &str) -> String {
    let words = text.split(|c: char| !c.is_alphanumeric() && c != '.' && c != '_').filter(|word| !word.is_empty());
    let name = words.collect::<Vec<_>>().join("-");
    if name.is_empty() { "mesh".into() } else { name }
}

impl Sweep {
    pub(super) fn run(self) -> Outcome {
        let start = Instant::now();
        let settings = self.settings()?;
        let (found, skipped) = self.find_peers();
        let known = self.known()?;
        let reference = self.reference(&settings, &found, &known)?;
        let meshes = self.read_meshes()?;
        let mut sweep = eval::Sweep::new(meshes, known).jobs(self.jobs.into()).fresh(self.fresh);
        self.plan(&mut sweep, &settings, &found);
        if sweep.dropped() > 0 {
            let text = format!("{} points of files that have changed since are dropped", sweep.dropped());
            self.common.notes(&self.out.join(POINTS).display().to_string(), &[text]);
        }
        let folder = self.out.display().to_string();
        std::fs::create_dir_all(&self.out).map_err(|e| Failure::in_file(&folder, e.into()))?;
        let save = |points: &[&SweepPoint]| {
            let text = points_csv(points.iter().copied());
            output::attempt(&self.out.join(POINTS), |out| Ok(out.write_all(text.as_bytes())?))
        };
        let swept =
            self.common.run("measuring", |task| Ok(sweep.run(&save, task))).map_err(|e| Failure::in_file(&folder, e))?;
        let table = SweepTable::new(
            &swept.points,
            Some(&reference).filter(|name| swept.points.iter().any(|p| p.way == **name)).map(String::as_str),
        );
        let table = table.map_err(|e| Failure::in_file(&folder, e))?;
        let files = [
            ("curves.svg", curves_svg(&table)),
            ("bd_rate.csv", bd_rate_csv(&table)),
            ("report.html", report_html(&table, &swept.points)),
        ];
        for (name, text) in &files {
            output::write(&self.out.join(name), |out| Ok(out.write_all(text.as_bytes())?))?;
        }
        self.say_refusals(&table);
        let seconds = start.elapsed().as_secs_f64();
        output::print(&if self.common.json {
            format!("{}\n", self.json(&swept, &table, &skipped, seconds))
        } else {
            text(&table)
        })?;
        let refused = swept.points.iter().filter(|p| p.result.is_err()).count();
        self.common.say(format!(
            "{folder}: {} points, {refused} of them refused; {} measured now, {} known before; {seconds:.1} s",
            swept.points.len(),
            swept.measured,
            swept.kept
        ));
        self.outcome(swept, sweep.meshes())
    }

    /// What every mesh is put through.
    fn settings(&self) -> Result<Vec<Setting>, Failure> {
        let by_name = WAYS.iter().filter(|way| self.ways.iter().any(|name| name == way.name));
        let order = |way: &&ways::Way| self.ways.iter().position(|name| name == way.name);
        let mut by_name: Vec<_> = by_name.collect();
        by_name.sort_by_key(order);
        let mut settings: Vec<Setting> =
            by_name.into_iter().flat_map(|way| way.settings(&self.bits, &self.rate, &self.psnr)).collect();
        for text in &self.with {
            let more = ways::of_text(text).map_err(|why| Failure::wrong_use(format!("--with \"{text}\": {why}"), None))?;
            settings.extend(more);
        }
        for setting in &settings {
            encode::asked(&setting.words)?;
        }
        if settings.is_empty() && !self.peers {
            return Err(Failure::wrong_use(
                "no way to go",
                Some("`--ways surface`, or settings of your own by `--with`".into()),
            ));
        }
        Ok(settings)
    }

    fn find_peers(&self) -> (Vec<Found>, Vec<String>) {
        let (mut found, mut skipped) = (Vec::new(), Vec::new());
        for peer in PEERS.iter().filter(|_| self.peers) {
            match peer.find() {
                Ok(peer) => found.push(peer),
                Err(why) => {
                    self.common.say(format!("gimc: note: {why}"));
                    skipped.push(why);
                }
            }
        }
        (found, skipped)
    }

    /// The points of an earlier sweep.
    fn known(&self) -> Result<Vec<SweepPoint>, Failure> {
        if std::fs::metadata(&self.out).is_ok_and(|m| !m.is_dir()) {
            let text = format!("{}: is a file, and a folder for the results was expected", self.out.display());
            return Err(Failure::Refused { text, hint: None });
        }
        let path = self.out.join(POINTS);
        let name = path.display().to_string();
        let refused = |e: Error| match Failure::in_file(&name, e) {
            Failure::Refused { text, .. } => {
                let hint =
                    "nothing was changed; take another folder for --out, mend the line, or move the file away".to_owned();
                Failure::Refused { text, hint: Some(hint) }
            }
            other => other,
        };
        match std::fs::read(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
            Err(e) => Err(refused(e.into())),
            Ok(bytes) => {
                let text = String::from_utf8(bytes);
                let text = text.map_err(|e| {
                    refused(Error::Parameter(format!("no text: byte {} is not UTF-8", e.utf8_error().valid_up_to())))
                })?;
                read_points(&text).map_err(refused)
            }
        }
    }

    /// The way that all others are compared with.
    fn reference(&self, settings: &[Setting], found: &[Found], known: &[SweepPoint]) -> Result<String, Failure> {
        let mut ways: Vec<&str> = settings.iter().map(|s| &*s.way).collect();
        ways.extend(found.iter().map(|peer| -> &str { peer.name() }));
        ways.extend(known.iter().map(|p| &*p.way));
        match &self.reference {
            None => Ok(ways.first().copied().unwrap_or_default().to_owned()),
            Some(name) if ways.contains(&&**name) => Ok(name.clone()),
            Some(name) => {
                let ways: BTreeSet<&str> = ways.into_iter().collect();
                let there_are = ways.into_iter().collect::<Vec<_>>().join(", ");
                Err(Failure::wrong_use(format!("--reference {name}: there is no such way among {there_are}"), None))
            }
        }
    }

    fn read_meshes(&self) -> Result<Vec<SweepMesh>, Failure> {
        let mut meshes = Vec::new();
        let mut seen = BTreeSet::new();
        for path in self.meshes.iter().filter(|path| seen.insert(*path)) {
            let file = input::name(path);
            let content = input::bytes(path)?;
            let (mesh, notes) = input::mesh_of(path, &content, None)?;
            self.common.notes(&file, &notes);
            let mut mesh = SweepMesh::new(path.display().to_string(), &content, mesh);
            if mesh.file == "-" {
                mesh.name = file;
            }
            meshes.push(mesh);
        }
        Ok(meshes)
    }

    fn plan(&self, sweep: &mut eval::Sweep, settings: &[Setting], found: &[Found]) {
        for i in 0..sweep.meshes().len() {
            let mesh = &sweep.meshes()[i];
            let has_more = !mesh.mesh.attributes.is_empty() || !mesh.mesh.labels.is_empty();
            let mut points: Vec<(String, String, String, Arc<dyn Coder>)> = Vec::new();
            for setting in settings {
                let mut words = setting.words.clone();
                let says = |flag: &str| words.iter().any(|word| word == flag || word.starts_with(&format!("{flag}=")));
                if has_more && !says("--attributes") {
                    words.extend(["--attributes", "none"].map(String::from));
                }
                // Checked before; with `--attributes none` it is understood as well.
                let Ok((options, repair)) = encode::asked(&words) else { continue };
                let mut coder = OwnCoder::new(options, clock);
                coder.repair = repair;
                let text = line(words.iter().map(String::as_str));
                let out = format!("{}-{}.gimc", file_name(&mesh.name), file_name(&text));
                let command = format!("{} {text}", line(["gimc", "encode", &mesh.file, &out]));
                points.push((setting.way.clone(), text, command, Arc::new(coder)));
            }
            for peer in found {
                for bits in self.bits.iter().filter(|bits| *bits != "exact") {
                    let (text, command, coder) = peer.point(mesh, Path::new(&mesh.file), bits);
                    points.push((peer.name().to_owned(), text, command, Arc::new(coder)));
                }
            }
            for (way, setting, command, coder) in points {
                sweep.add(i, way, setting, command, coder);
            }
        }
    }

    /// One line a mesh and way.
    fn say_refusals(&self, table: &SweepTable<'_>) {
        for mesh in &table.meshes {
            for curve in &mesh.ways {
                if let Some((_, why)) = curve.refused.first() {
                    let tried = curve.refused.len() + curve.points.len();
                    let text = format!("{} refused {} of {tried} settings: {why}", table.ways[curve.way], curve.refused.len());
                    self.common.notes(mesh.mesh, &[text]);
                }
            }
        }
    }

    fn json(&self, swept: &Swept, table: &SweepTable<'_>, skipped: &[String], seconds: f64) -> Json {
        let refused = swept.points.iter().filter(|p| p.result.is_err()).count();
        let file = |name: &str| Json::from(self.out.join(name).display().to_string());
        let mut rates = Vec::new();
        for mesh in &table.meshes {
            for curve in &mesh.ways {
                let Some(found) = curve.bd_rate else { continue };
                let interval = match found {
                    BdRate::Over { psnr, .. } => Json::list(psnr),
                    _ => Json::Null,
                };
                rates.push(Json::object([
                    ("mesh", mesh.mesh.into()),
                    ("way", table.ways[curve.way].into()),
                    ("percent", found.percent().into()),
                    ("psnr", interval),
                ]));
            }
        }
        let means = table.ways.iter().zip(&table.means).filter(|(way, _)| **way != table.reference);
        let means = means.map(|(way, mean)| {
            Json::object([("way", (*way).into()), ("percent", mean.percent.into()), ("meshes", mean.meshes.into())])
        });
        Json::object([
            ("points", file(POINTS)),
            ("curves", file("curves.svg")),
            ("bd_rates", file("bd_rate.csv")),
            ("report", file("report.html")),
            ("measured", swept.measured.into()),
            ("known", swept.kept.into()),
            ("refused", refused.into()),
            ("left", swept.left.into()),
            ("meshes", Json::list(table.meshes.iter().map(|mesh| mesh.mesh))),
            ("ways", Json::list(table.ways.iter().copied())),
            ("reference", table.reference.into()),
            ("bd_rate", Json::List(rates)),
            ("bd_rate_mean", Json::List(means.collect())),
            ("skipped_peers", Json::list(skipped.iter().map(String::as_str))),
            ("seconds", seconds.into()),
        ])
    }

    fn outcome(&self, swept: Swept, meshes: &[SweepMesh]) -> Outcome {
        let folder = self.out.display();
        match swept.stopped {
            Some(Error::Cancelled) => {
                let text = format!("{folder}: stopped: the deadline passed; {} points are missing", swept.left);
                return Err(Failure::Refused { text, hint: Some("the same command goes on from there".into()) });
            }
            Some(error) => return Err(Failure::in_file(&folder.to_string(), error)),
            None => {}
        }
        for mesh in meshes {
            let mut of_mesh = swept.points.iter().filter(|p| p.mesh == mesh.name).peekable();
            let first = of_mesh.peek().and_then(|p| p.result.as_ref().err());
            if let Some(why) = first.filter(|_| of_mesh.clone().all(|p| p.result.is_err())) {
                let text = format!("{}: refused in every way: {why}", mesh.file);
                return Err(Failure::Refused { text, hint: None });
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// The delta rates in columns.
fn text(table: &SweepTable<'_>) -> String {
    let others: Vec<usize> = (0..table.ways.len()).filter(|&way| table.ways[way] != table.reference).collect();
    let mut rows =
        vec![std::iter::once(String::new()).chain(others.iter().map(|&way| table.ways[way].to_owned())).collect::<Vec<_>>()];
    let signed = |percent: f64| format!("{percent:+.1} %");
    for mesh in &table.meshes {
        let cell = |way: usize| match mesh.ways.iter().find(|curve| curve.way == way).and_then(|curve| curve.bd_rate) {
            None => "-".to_owned(),
            Some(BdRate::NoOverlap) => "no overlap".into(),
            Some(BdRate::TooFewPoints) => "too few points".into(),
            Some(found) => found.percent().map_or(String::new(), signed),
        };
        rows.push(std::iter::once(mesh.mesh.to_owned()).chain(others.iter().map(|&way| cell(way))).collect());
    }
    if table.meshes.len() > 1 {
        let mean = |way: usize| table.means[way].percent.map_or("-".into(), signed);
        rows.push(std::iter::once("mean".to_owned()).chain(others.iter().map(|&way| mean(way))).collect());
    }
    let widths: Vec<usize> =
        (0..=others.len()).map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)).collect();
    let mut out = format!("bytes at equal psnr, against {} (Bjøntegaard delta rate)\n", table.reference);
    for row in rows {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(i, (cell, width))| if i == 0 { format!("{cell:width$}") } else { format!("{cell:>width$}") })
            .collect();
        out.push_str(cells.join("  ").trim_end());
        out.push('\n');
    }
    out
}
