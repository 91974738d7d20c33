//! What `nonius path` shows and writes: the screen, the document for scripts, the samples as CSV (written as they come:
//! whole or not at all) and the worst of the holes that canned cycles drill.

use crate::cli::outcome::Output;
use crate::cli::refusals;
use crate::cli::screen::{More, Screen, list, paragraphs, table};
use crate::cli::show;
use crate::kit::Inputs;
use crate::page::{Ink, Locale, Picture, Trace, path};
use crate::quantity::{Axis, Figure};
use crate::text::{Problem, Problems, Severity, counted, of_severity};
use crate::visit::files::{Begun, Files, Long, Ready, not_put_out, not_written};
use crate::visit::inputs::CorrectedMachine;
use crate::volume::space::pair::dot;
use crate::volume::tool_path::{Channel, Extreme, Outside, Profile, Sample, Summary};
use crate::volume::volume_model::VolumeModel;
use part_program::Ran;
use serde::Serialize;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

/// What is printed.
pub(super) struct Page {
    pub(super) program: String,
    pub(super) inputs: Inputs,
    pub(super) volume: VolumeModel,
    pub(super) ran: Ran,
    pub(super) before: Summary,
    /// With tables.
    pub(super) after: Option<CorrectedMachine<Summary>>,
    pub(super) holes: Holes,
    pub(super) traces: Vec<Trace>,
}

impl Page {
    /// The error along the path, and at the worst holes.
    pub(super) fn picture(&self, locale: Locale<'_>) -> Picture {
        let hole = |hole: &Hole| {
            let of = |[x, y, _]: [f64; 3]| (x, y);
            let before = (Ink::AsFound, of(hole.error_um));
            let after = hole.after_um.map(|um| (Ink::Forecast, of(um)));
            (of(hole.at_mm), std::iter::once(before).chain(after).collect())
        };
        let holes: Vec<_> = self.holes.worst.iter().map(hole).collect();
        let machine = &self.inputs.job.machine.name;
        path(locale, &format!("{machine}: error along {}", self.program), &self.traces, &holes)
    }
}

/// What was found along the path of a program on one machine.
pub(super) fn found(profile: Profile<'_>, program: &str) -> Result<Summary, Problem> {
    let summary = profile.summary();
    if summary.samples == 0 { Err(refusals::no_move(program)) } else { Ok(summary) }
}

fn largest_um(of: &Summary) -> f64 {
    of.range(Channel::Length).map_or(0.0, |range| range.max.um)
}

/// The figure, or what it lies between.
fn accuracy_words(of: &Summary) -> String {
    let (least, most) = (of.profile_accuracy_um, of.profile_accuracy_at_most_um);
    match most > least {
        false => format!("{least:.3} µm"),
        true => {
            format!("between {least:.3} and {most:.3} µm (too many samples to keep all that count)")
        }
    }
}

fn extremes(of: &Summary, name: &str) -> String {
    let cells = |e: &Extreme| {
        let [x, y, z] = e.place.map(Figure);
        format!("{:+.3}\t{x:.3}, {y:.3}, {z:.3}\t{}", Figure(e.um), e.line)
    };
    let rows = Channel::ALL.into_iter().filter_map(|channel| {
        let range = of.range(channel)?;
        let (min, max) = (cells(&range.min), cells(&range.max));
        Some(format!("{}\t{min}\t{max}", channel.word()))
    });
    let heading = "\t>min/µm\tat x, y, z/mm\t>line\t>max/µm\tat x, y, z/mm\t>line";
    format!("{name}\n{}", table(heading, rows))
}

impl Page {
    pub(super) fn screen(&self) -> Screen {
        let after = self.after.as_ref();
        let disagreements = after.map_or(&[][..], |after| &after.disagreements);
        let with = after.map(|after| extremes(&after.figures, &format!("with {}", after.from)));
        let figures = [extremes(&self.before, "as it is"), with.unwrap_or_default()];
        let missing: Vec<String> = missing(self);
        let left_out = format!("not measured, so left out: {}", missing.join(", "));
        let mut findings = [warnings(self), doubts(self)].concat();
        findings.extend(outside_sentences(self));
        findings.extend((!missing.is_empty()).then_some(left_out));
        findings.extend(show::notes(remarks(self)));
        findings.push(format!("note: {}", how(self)));
        let disagreements = list("job and tables DISAGREE:", disagreements);
        let verdict = [headline(self), heading(self), disagreements];
        Screen {
            figures: paragraphs(&figures),
            findings,
            more: vec![More::new(self.holes.worst.len(), ["hole", "holes"], holes(self))],
            ..Screen::of(verdict.join("\n").trim_end().to_string())
        }
    }
}

/// What scripts read.
#[derive(Serialize)]
pub(super) struct Document<'a> {
    machine: &'a str,
    program: &'a str,
    blocks: u64,
    holes: u64,
    worst_holes: &'a [Hole],
    outside: Vec<String>,
    missing: Vec<String>,
    warnings: Vec<String>,
    notes: Vec<String>,
    after: Option<&'a CorrectedMachine<Summary>>,
    #[serde(flatten)]
    before: &'a Summary,
}

impl Page {
    pub(super) fn document(&self) -> Document<'_> {
        Document {
            machine: &self.inputs.job.machine.name,
            program: &self.program,
            blocks: self.ran.blocks,
            holes: self.ran.holes,
            worst_holes: &self.holes.worst,
            outside: outside_sentences(self),
            missing: missing(self),
            warnings: warnings(self),
            notes: [remarks(self), doubts(self), vec![how(self)]].concat(),
            after: self.after.as_ref(),
            before: &self.before,
        }
    }
}

fn missing(page: &Page) -> Vec<String> {
    page.volume.missing().into_iter().map(|m| m.component.to_string()).collect()
}

/// A number of things.
fn heading(page: &Page) -> String {
    let s = &page.before;
    let mut counts = vec![counted(s.moves.straight, "straight move"), counted(s.moves.arcs, "arc")];
    if page.ran.holes > 0 {
        counts.push(counted(page.ran.holes, "hole"));
    }
    if s.moves.rapid_left_out > 0 {
        counts.push(format!("{} left out", counted(s.moves.rapid_left_out, "rapid move")));
    }
    format!(
        "{} on {}\npath {:.3} mm: {}; places in machine coordinates",
        page.program,
        page.inputs.job.machine.name,
        s.length_mm,
        counts.join(", ")
    )
}

fn headline(page: &Page) -> String {
    let (before, after) = (&page.before, page.after.as_ref());
    let mut lines = vec![
        format!("largest error {:.3} µm", largest_um(before)),
        format!(
            "profile accuracy {}: no two samples of the path differ by more in their error",
            accuracy_words(before)
        ),
    ];
    if let Some(after) = after {
        lines.push(format!(
            "with the tables: largest error {:.3} µm, profile accuracy {}",
            largest_um(&after.figures),
            accuracy_words(&after.figures)
        ));
    }
    let datum = &page.inputs.job.path.datum;
    if !datum.is_empty() {
        lines.push(format!(
            "all of them less the mean error at {} ([[path.datum]])",
            counted(datum.len(), "probed place")
        ));
    }
    lines.join("\n")
}

/// What may make the figures those of another machine.
fn warnings(page: &Page) -> Vec<String> {
    let tool = page.inputs.job.measurement.levers.tool;
    let stated = tool.is_some_and(|tool| Axis::ALL.iter().any(|axis| tool[*axis].mm().abs() > 0.0));
    let twice = stated && page.before.with_tool;
    let words = "CHECK: `tool_offset_mm` of [measurement] and the tool length of G43 both move the tool point; state the way to the tool in one of them only";
    twice.then(|| words.to_string()).into_iter().collect()
}

fn holes(page: &Page) -> String {
    let worst = &page.holes.worst;
    if worst.is_empty() {
        return String::new();
    }
    let (shown, all) = (worst.len() as u64, page.ran.holes);
    let what = match shown < all {
        true => format!("the {shown} worst of {all} holes (`-o` writes all)"),
        false => "holes, the worst first".to_string(),
    };
    let column = page.after.as_ref().map_or("", |_| "\t>with tables |e|/µm");
    let heading = ">hole\t>line\tbottom at x, y, z/mm\t>ex/µm\t>ey/µm\t>ez/µm\t>|e|/µm";
    format!("{what}\n{}", table(&format!("{heading}{column}"), worst.iter().map(hole)))
}

fn hole(hole: &Hole) -> String {
    let [x, y, z] = hole.at_mm.map(Figure);
    let [ex, ey, ez] = hole.error_um.map(Figure);
    let after = hole.after_e_um.map_or_else(String::new, |e| format!("\t{e:.3}"));
    format!(
        "{}\t{}\t{x:.3}, {y:.3}, {z:.3}\t{ex:+.3}\t{ey:+.3}\t{ez:+.3}\t{:.3}{after}",
        hole.number, hole.line, hole.e_um
    )
}

fn outside_sentences(page: &Page) -> Vec<String> {
    let sentence = |o: &Outside| {
        let (low, high) = o.measured_mm;
        let below = (o.reached_mm.0 < low).then(|| format!("{:.3} mm", Figure(o.reached_mm.0)));
        let above = (o.reached_mm.1 > high).then(|| format!("{:.3} mm", Figure(o.reached_mm.1)));
        format!(
            "not measured: the path reaches {} = {}, first in line {}, measured is {low} … {high} mm; beyond it each curve, squareness included, is held at its end",
            Axis::ALL[o.axis],
            below.into_iter().chain(above).collect::<Vec<_>>().join(" and "),
            o.line,
        )
    };
    page.before.outside.iter().map(sentence).collect()
}

/// What a reader of the figures has to know.
fn remarks(page: &Page) -> Vec<String> {
    let path = &page.inputs.job.path;
    let s = &page.before;
    let mut notes: Vec<String> = page.ran.notes.clone();
    let mut unstated = Vec::new();
    if !path.has_start {
        unstated.push("`start_mm` (the axes start at the reference)");
    }
    if s.with_tool && path.measured_tool_mm.is_none() {
        unstated
            .push("`measured_tool_mm` (the errors are taken as measured with a tool of length 0)");
    }
    if !unstated.is_empty() {
        notes.push(format!("not stated in [path]: {}", unstated.join(", ")));
    }
    if s.with_tool && !path.datum.is_empty() {
        notes.push("the datum is taken as probed with a tool of the measured length".to_string());
    }
    let labels = page.volume.labels.iter().filter(|label| label.severity() != Severity::Doubt);
    notes.extend(labels.map(ToString::to_string));
    notes.extend(page.after.iter().flat_map(|after| &after.notes).map(ToString::to_string));
    notes
}

/// Why the figures may be wrong.
fn doubts(page: &Page) -> Vec<String> {
    of_severity(&page.volume.labels, Severity::Doubt).iter().map(ToString::to_string).collect()
}

/// What holds for every path.
fn how(page: &Page) -> String {
    let path = &page.inputs.job.path;
    let s = &page.before;
    let mut parts =
        vec![format!("{} at most {} mm apart", counted(s.samples, "sample"), path.sample_mm)];
    if s.moves.arcs > 0 {
        parts.push(format!("arcs on chords within {} mm", path.chord_mm));
    }
    parts.push(
        "without following errors, reversal (mean of the directions) and temperature".to_string(),
    );
    parts.join("; ")
}

/// A file that is being written beside its place; that of standard output is a temporary one.
pub(super) struct Points {
    /// `None` = standard output.
    ready: Option<Box<dyn Ready>>,
    writer: BufWriter<Box<dyn Long>>,
    written: std::io::Result<()>,
}

const COLUMNS: &str =
    "line,s_mm,x_mm,y_mm,z_mm,ex_um,ey_um,ez_um,e_um,tangent_um,normal_um,held,hole";
const AFTER: &str =
    ",after_ex_um,after_ey_um,after_ez_um,after_e_um,after_tangent_um,after_normal_um";

impl Points {
    pub(super) fn create(
        files: &dyn Files,
        output: &Output,
        has_after: bool,
    ) -> Result<Points, Problems> {
        let (long, ready) = files.begin(output.place(), output.force)?;
        let mut writer = BufWriter::with_capacity(1 << 18, long);
        let after = if has_after { AFTER } else { "" };
        let written = writeln!(writer, "{COLUMNS}{after}");
        Ok(Points { ready, writer, written })
    }

    /// Writes one sample; `after_um` = the error with tables.
    pub(super) fn write(&mut self, sample: &Sample, after_um: Option<[f64; 3]>) {
        if self.written.is_ok() {
            self.written = row(&mut self.writer, sample, after_um);
        }
    }

    /// All samples, to be delivered.
    pub(super) fn content(mut self, place: Option<&Path>) -> Result<Begun, Problems> {
        let written = self.written.and_then(|()| self.writer.flush());
        let (mut long, _) = self.writer.into_parts();
        written.and_then(|()| long.rewind()).map_err(|error| match place {
            Some(place) => not_written("cannot write", place, &error),
            None => not_put_out(&error).into(),
        })?;
        Ok((long, self.ready))
    }
}

fn row(out: &mut impl Write, sample: &Sample, after_um: Option<[f64; 3]>) -> std::io::Result<()> {
    let [x, y, z] = sample.place.map(Figure);
    write!(out, "{},{:.4},{x:.4},{y:.4},{z:.4},", sample.line, sample.s_mm)?;
    error(out, sample, sample.error_um)?;
    write!(out, ",{},", if sample.is_held { "yes" } else { "no" })?;
    if let Some(hole) = sample.hole {
        write!(out, "{hole}")?;
    }
    if let Some(after_um) = after_um {
        write!(out, ",")?;
        error(out, sample, after_um)?;
    }
    writeln!(out)
}

/// The vector, its length, its parts along the path and across it.
fn error(out: &mut impl Write, sample: &Sample, error: [f64; 3]) -> std::io::Result<()> {
    let (size, tangent) = (length(error), dot(&sample.ahead, &error));
    let [x, y, z] = error.map(Figure);
    write!(out, "{x:.6},{y:.6},{z:.6},{size:.6},{:.6},", Figure(tangent))?;
    sample.left.map_or(Ok(()), |left| write!(out, "{:.6}", Figure(dot(&left, &error))))
}

/// Holes that are kept; the CSV has all of them.
const MOST_HOLES: usize = 20;

/// A hole at its bottom.
#[derive(Serialize)]
pub(super) struct Hole {
    #[serde(rename = "hole")]
    pub(super) number: u64,
    pub(super) line: usize,
    /// Machine coordinates.
    pub(super) at_mm: [f64; 3],
    pub(super) error_um: [f64; 3],
    pub(super) e_um: f64,
    /// With tables.
    pub(super) after_um: Option<[f64; 3]>,
    pub(super) after_e_um: Option<f64>,
}

/// The holes with the largest errors, the worst first; of equal ones the first.
#[derive(Default)]
pub(super) struct Holes {
    worst: Vec<Hole>,
}

impl Holes {
    /// Takes a sample if it is the bottom of a hole; `after_um` = the error with tables.
    pub(super) fn take(&mut self, sample: &Sample, after_um: Option<[f64; 3]>) {
        let Some(number) = sample.hole else { return };
        let size = length(sample.error_um);
        let place = self.worst.partition_point(|hole| hole.e_um >= size);
        if place == MOST_HOLES {
            return;
        }
        self.worst.truncate(MOST_HOLES - 1);
        let hole = Hole {
            number,
            line: sample.line,
            at_mm: sample.place,
            error_um: sample.error_um,
            e_um: size,
            after_um,
            after_e_um: after_um.map(length),
        };
        self.worst.insert(place, hole);
    }
}

/// Of an error vector.
fn length(error: [f64; 3]) -> f64 {
    dot(&error, &error).sqrt()
}
