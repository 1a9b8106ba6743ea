//! Points of a sweep as comma-separated values (RFC 4180), written and read side by side; lines end in a line feed.
//!
//! What is read is checked: a table of another program, a line with a field too few, a number that is none, and a last line
//! that was cut off are errors that say where.

use std::fmt::Write;

use crate::error::{Error, Place, Result};
use crate::eval::curve::BdRate;
use crate::eval::same::Verdict;
use crate::eval::sweep::{Measured, SweepPoint, SweepTable};

/// The columns of [`points_csv`].
const COLUMNS: &str = "mesh,file,file_bytes,file_crc32,vertices,faces,way,setting,program,method,codec,status,\
    bytes,bpv,rms,rms_max,hausdorff,psnr,psnr_vertex,normal_rms,samples,diag,same_connectivity,vertices_b,faces_b,bound,\
    seconds_encode,seconds_decode,command,reason";

/// The word for a point that was measured.
const DONE: &str = "done";
/// The word for a point that was refused.
const REFUSED: &str = "refused";

/// All points as a table, one line a point; [`read_points`] reads it again.
pub fn points_csv<'a>(points: impl IntoIterator<Item = &'a SweepPoint>) -> String {
    let mut out = format!("{COLUMNS}\n");
    for point in points {
        let SweepPoint { mesh, file, way, setting, program, method, codec, command, .. } = point;
        let mut line = Line(&mut out, true);
        line.texts([mesh, file]);
        line.wholes([point.file_bytes]);
        line.text(&format!("{:08x}", point.file_crc32));
        line.wholes([point.vertices, point.faces]);
        line.texts([way, setting, program, method, codec]);
        match &point.result {
            Ok(m) => {
                line.text(DONE);
                line.wholes([m.bytes]);
                line.numbers([m.bpv, m.rms, m.rms_max, m.hausdorff, m.psnr].map(Some));
                line.numbers([m.psnr_vertex, m.normal_rms]);
                line.wholes([m.samples]);
                line.numbers([Some(m.diag)]);
                line.text(match m.same_connectivity {
                    Verdict::Same => "true",
                    Verdict::Different => "false",
                    Verdict::Undecided => "",
                });
                line.wholes([m.vertices_b, m.faces_b]);
                line.numbers([m.bound, Some(m.seconds[0]), Some(m.seconds[1])]);
                line.texts([command, ""]);
            }
            Err(reason) => {
                line.text(REFUSED);
                (0..16).for_each(|_| line.text(""));
                line.texts([command, reason]);
            }
        }
        out.push('\n');
    }
    out
}

/// Reads what [`points_csv`] wrote.
///
/// # Errors
/// [`Error::Malformed`] with the line, and what was found and expected there.
pub fn read_points(text: &str) -> Result<Vec<SweepPoint>> {
    let mut records = Records { rest: text.strip_prefix('\u{feff}').unwrap_or(text), line: 1 };
    let Some((line, header)) = records.next().transpose()? else {
        return Err(Error::malformed(
            Place::Whole,
            "the table is empty, and a first line with the names of columns was expected",
        ));
    };
    if header.join(",") != COLUMNS {
        let found: String = header.join(",").chars().take(60).collect();
        let why = format!("no table of `gimc sweep`: its first line begins with `{found}`");
        return Err(Error::malformed(Place::Line(line), why));
    }
    let mut points = Vec::new();
    for record in records {
        let (line, fields) = record?;
        points.push(point(line, &fields)?);
    }
    Ok(points)
}

fn point(line: u64, fields: &[String]) -> Result<SweepPoint> {
    let columns = COLUMNS.split(',').count();
    if fields.len() != columns {
        let why = format!("{} fields, {columns} expected", fields.len());
        return Err(Error::malformed(Place::Line(line), why));
    }
    let mut fields = Fields { line, fields: fields.iter().zip(COLUMNS.split(',')) };
    let (mesh, file, file_bytes) = (fields.text(), fields.text(), fields.whole()?);
    let file_crc32 = fields.parse("eight hexadecimal digits", |text| u32::from_str_radix(text, 16).ok())?;
    let [vertices, faces] = [fields.whole()?, fields.whole()?];
    let [way, setting, program, method, codec] = std::array::from_fn(|_| fields.text());
    let is_done = fields.parse("done or refused", |text| match text {
        DONE => Some(true),
        REFUSED => Some(false),
        _ => None,
    })?;
    let measured = if is_done {
        Some(Measured {
            bytes: fields.whole()?,
            bpv: fields.number()?,
            rms: fields.number()?,
            rms_max: fields.number()?,
            hausdorff: fields.number()?,
            psnr: fields.number()?,
            psnr_vertex: fields.perhaps()?,
            normal_rms: fields.perhaps()?,
            samples: fields.whole()?,
            diag: fields.number()?,
            same_connectivity: fields.parse("true, false or nothing", |text| match text {
                "true" => Some(Verdict::Same),
                "false" => Some(Verdict::Different),
                "" => Some(Verdict::Undecided),
                _ => None,
            })?,
            vertices_b: fields.whole()?,
            faces_b: fields.whole()?,
            bound: fields.perhaps()?,
            seconds: [fields.number()?, fields.number()?],
        })
    } else {
        (0..16).try_for_each(|_| fields.parse("nothing for a point that was refused", |text| text.is_empty().then_some(())))?;
        None
    };
    let (command, reason) = (fields.text(), fields.text());
    let result = measured.ok_or(reason);
    Ok(SweepPoint {
        mesh,
        file,
        file_bytes,
        file_crc32,
        vertices,
        faces,
        way,
        setting,
        program,
        method,
        codec,
        command,
        result,
    })
}

/// The delta rates of all meshes and ways, and their means.
pub fn bd_rate_csv(table: &SweepTable<'_>) -> String {
    let mut out = "mesh,way,reference,bd_rate_percent,psnr_low,psnr_high,meshes,note\n".to_owned();
    for mesh in &table.meshes {
        for curve in &mesh.ways {
            let Some(bd_rate) = curve.bd_rate else { continue };
            let mut line = Line(&mut out, true);
            line.texts([mesh.mesh, table.ways[curve.way], table.reference]);
            match bd_rate {
                BdRate::Over { psnr: [low, high], .. } => line.numbers([bd_rate.percent(), Some(low), Some(high)]),
                _ => line.texts([""; 3]),
            }
            line.texts(["1", note(bd_rate)]);
            out.push('\n');
        }
    }
    for (way, mean) in table.ways.iter().zip(&table.means).filter(|(_, mean)| mean.percent.is_some()) {
        let mut line = Line(&mut out, true);
        line.texts(["(mean)", way, table.reference]);
        line.numbers([mean.percent, None, None]);
        line.wholes([mean.meshes as u64]);
        line.text("");
        out.push('\n');
    }
    out
}

/// Why there is no number, if there is none.
pub(super) fn note(bd_rate: BdRate) -> &'static str {
    match bd_rate {
        BdRate::Over { .. } => "",
        BdRate::NoOverlap => "no overlap",
        BdRate::TooFewPoints => "fewer than two points",
    }
}

/// A line that is being written.
struct Line<'a>(&'a mut String, bool);

impl Line<'_> {
    fn text(&mut self, text: &str) {
        if !std::mem::take(&mut self.1) {
            self.0.push(',');
        }
        if text.contains([',', '"', '\n', '\r']) {
            let _ = write!(self.0, "\"{}\"", text.replace('"', "\"\""));
        } else {
            self.0.push_str(text);
        }
    }

    fn texts<const N: usize>(&mut self, texts: [&str; N]) {
        texts.iter().for_each(|text| self.text(text));
    }

    fn wholes<const N: usize>(&mut self, numbers: [u64; N]) {
        numbers.iter().for_each(|n| self.text(&n.to_string()));
    }

    /// The shortest digits that read back the same; nothing for what is not known.
    fn numbers<const N: usize>(&mut self, numbers: [Option<f64>; N]) {
        numbers.iter().for_each(|x| self.text(&x.map_or(String::new(), |x| format!("{x:?}"))));
    }
}

/// The fields of a record, asked for one after the other.
struct Fields<I> {
    line: u64,
    fields: I,
}

impl<'a, I: Iterator<Item = (&'a String, &'static str)>> Fields<I> {
    fn text(&mut self) -> String {
        self.fields.next().map_or(String::new(), |(field, _)| field.clone())
    }

    fn parse<T>(&mut self, expected: &str, read: impl FnOnce(&str) -> Option<T>) -> Result<T> {
        let (field, column) = self.fields.next().map_or(("", ""), |(field, column)| (&**field, column));
        let found = || Error::malformed(Place::Line(self.line), format!("{column} is `{field}`, and {expected} was expected"));
        read(field).ok_or_else(found)
    }

    fn whole(&mut self) -> Result<u64> {
        self.parse("a whole number", |text| text.parse().ok())
    }

    fn number(&mut self) -> Result<f64> {
        self.parse("a number", |text| text.parse().ok().filter(|x: &f64| x.is_finite()))
    }

    fn perhaps(&mut self) -> Result<Option<f64>> {
        self.parse("a number or nothing", |text| match text {
            "" => Some(None),
            text => text.parse().ok().filter(|x: &f64| x.is_finite()).map(Some),
        })
    }
}

/// The records of a table, each with the line where it starts.
struct Records<'a> {
    rest: &'a str,
    line: u64,
}

impl Iterator for Records<'_> {
    type Item = Result<(u64, Vec<String>)>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let start = self.line;
        let record = self.record();
        if record.is_err() {
            self.rest = "";
        }
        Some(record.map(|fields| (start, fields)))
    }
}

impl Records<'_> {
    fn record(&mut self) -> Result<Vec<String>> {
        let start = self.line;
        let fault = |why: &str| Err(Error::malformed(Place::Line(start), why));
        let mut fields = Vec::new();
        loop {
            let field = if let Some(quoted) = self.rest.strip_prefix('"') {
                let mut field = String::new();
                let mut rest = quoted;
                loop {
                    let Some((before, after)) = rest.split_once('"') else {
                        return fault("a quoted field does not end");
                    };
                    field.push_str(before);
                    rest = after;
                    match rest.strip_prefix('"') {
                        Some(more) => rest = more,
                        None => break,
                    }
                    field.push('"');
                }
                self.line += field.matches('\n').count() as u64;
                self.rest = rest;
                field
            } else {
                let end = self.rest.find([',', '\n', '\r', '"']).unwrap_or(self.rest.len());
                let field = self.rest[..end].to_owned();
                self.rest = &self.rest[end..];
                field
            };
            fields.push(field);
            if let Some(rest) = self.rest.strip_prefix(',') {
                self.rest = rest;
                continue;
            }
            let Some(rest) = self.rest.strip_prefix('\n').or_else(|| self.rest.strip_prefix("\r\n")) else {
                let why = if self.rest.is_empty() {
                    "the last line is cut off: it has no end"
                } else {
                    "a quotation mark or a line break stands where a comma or the end of the line was expected"
                };
                return fault(why);
            };
            self.rest = rest;
            self.line += 1;
            return Ok(fields);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), Just(999.0), -1e3..1e3, 1e-300..1e-290, Just(f64::MAX)]
    }

    fn measured() -> impl Strategy<Value = Measured> {
        let verdict = prop_oneof![Just(Verdict::Same), Just(Verdict::Different), Just(Verdict::Undecided)];
        let numbers = proptest::collection::vec(number(), 9);
        let maybe = proptest::collection::vec(proptest::option::of(number()), 3);
        (numbers, maybe, verdict, any::<[u64; 4]>()).prop_map(|(x, maybe, same_connectivity, n)| Measured {
            bytes: n[0],
            bpv: x[0],
            rms: x[1],
            rms_max: x[2],
            hausdorff: x[3],
            psnr: x[4],
            psnr_vertex: maybe[0],
            normal_rms: maybe[1],
            samples: n[1],
            diag: x[5],
            same_connectivity,
            vertices_b: n[2],
            faces_b: n[3],
            bound: maybe[2],
            seconds: [x[6], x[7]],
        })
    }

    fn points() -> impl Strategy<Value = Vec<SweepPoint>> {
        let text = "[a-z\",\n\r é-]{0,8}";
        let texts = proptest::collection::vec(text, 8);
        let result = prop_oneof![measured().prop_map(Ok), text.prop_map(Err)];
        let point = (texts, any::<[u64; 3]>(), any::<u32>(), result).prop_map(|(t, n, file_crc32, result)| SweepPoint {
            mesh: t[0].clone(),
            file: t[1].clone(),
            file_bytes: n[0],
            file_crc32,
            vertices: n[1],
            faces: n[2],
            way: t[2].clone(),
            setting: t[3].clone(),
            program: t[4].clone(),
            method: t[5].clone(),
            codec: t[6].clone(),
            command: t[7].clone(),
            result,
        });
        proptest::collection::vec(point, 0..5)
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(points in points()) {
            let text = points_csv(&points);
            prop_assert_eq!(&read_points(&text).unwrap(), &points);
            // As spreadsheets write it again.
            let theirs = format!("\u{feff}{}", text.replace("\r\n", "\n").replace('\n', "\r\n"));
            prop_assert_eq!(read_points(&theirs).unwrap().len(), points.len());
        }

        #[test]
        fn a_table_that_was_cut_off_is_never_taken_for_whole(points in points(), cut in any::<proptest::sample::Index>()) {
            let text = points_csv(&points);
            let cut = cut.index(text.len());
            prop_assume!(text.is_char_boundary(cut));
            if let Ok(found) = read_points(&text[..cut]) {
                // Only between two records, and then those before are as they were.
                prop_assert!(text[..cut].ends_with('\n'));
                prop_assert_eq!(&found[..], &points[..found.len()]);
            }
        }

        #[test]
        fn any_text_is_a_table_or_an_error(text in "[a-z\",\n\r0-9]{0,60}") {
            let _ = read_points(&text);
            let _ = read_points(&format!("{COLUMNS}\n{text}"));
        }
    }

    #[test]
    fn quotes_are_those_of_rfc_4180() {
        let mut out = String::new();
        let mut line = Line(&mut out, true);
        line.texts(["plain", "with, comma", "say \"x\"", "two\nlines", ""]);
        assert_eq!(out, "plain,\"with, comma\",\"say \"\"x\"\"\",\"two\nlines\",");
    }

    #[test]
    fn errors_say_which_line_and_what_was_expected() {
        let said = |text: &str| read_points(text).unwrap_err().to_string();
        assert!(said("").contains("the table is empty"));
        assert_eq!(said("name,age\nx,1\n"), "line 1: no table of `gimc sweep`: its first line begins with `name,age`");
        assert_eq!(said(&format!("{COLUMNS}\na,b\n")), "line 2: 2 fields, 30 expected");
        assert!(said(&format!("{COLUMNS}\na,b")).contains("line 2: the last line is cut off"));
        let line = format!(",,many{}", ",".repeat(27));
        let expected = "line 2: file_bytes is `many`, and a whole number was expected";
        assert_eq!(said(&format!("{COLUMNS}\n{line}\n")), expected);
    }
}
