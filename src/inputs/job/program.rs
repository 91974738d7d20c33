//! `[program]`: the part programs of a measuring run (contract §2.3, docs/program.md).

use crate::inputs::job::diagonals::{DiagonalMeasurement, Reflector, volume};
use crate::inputs::job::measurement::{MeasuredData, Measurement};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::diagonal::{PathKind, Volume};
use crate::quantity::units::Millimetres;
use crate::text::document::Section;
use crate::text::words::{Word, words};
use std::ops::RangeInclusive;

words! {
    /// What the measuring run is.
    pub enum RunType {
        /// The four body diagonals, one axis at a time (flat mirror).
        StepDiagonal = "step-diagonal",
        /// The four body diagonals, all axes together (retroreflector; ISO 230-6 motion).
        StraightDiagonal = "straight-diagonal",
        /// Single axes along their length (ISO 230-2 motion).
        SingleAxis = "single-axis",
    }
}

impl RunType {
    /// How the diagonals are walked; `None` for single axes.
    pub const fn path(self) -> Option<PathKind> {
        match self {
            RunType::StepDiagonal => Some(PathKind::Step),
            RunType::StraightDiagonal => Some(PathKind::Straight),
            RunType::SingleAxis => None,
        }
    }
}

words! {
    /// How the target comes back to the start of a run that is measured in one direction.
    pub enum WayBack {
        /// Over the same nodes in the opposite order.
        Retrace = "retrace",
        /// Straight, all axes together.
        Diagonal = "diagonal",
    }
}

/// Where the targets of a single axis lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TargetGrid {
    /// Equal steps: the targets are the points of a table.
    Equal,
    /// Each target shifted by up to this length, so that errors that repeat with a period
    /// (screw, gear, scale) are not aliased (ISO 230-2: Pi = (i - 1) p + r).
    Offset {
        /// Largest shift, mm; `None` = a quarter of the step.
        shift: Option<Millimetres>,
    },
}

/// A measuring run to write programs for. Everything that is `Volume` here is the same volume that
/// a measurement of diagonals states, so a rehearsal can walk it.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramRequest {
    /// What is run.
    pub what: RunType,
    /// The measured box, its division and the order of the moves in a cell.
    pub volume: Volume,
    /// Key that the size of the box comes from, for problems.
    pub size_path: &'static str,
    /// The axes of single-axis runs, in the order of the programs.
    pub axes: Vec<Axis>,
    /// Where the other axes rest in single-axis runs; `None` = the middle of the box.
    pub rest: Option<PerAxis<Millimetres>>,
    /// Feed along the path, mm/min.
    pub feed_mm_per_min: f64,
    /// Standstill at every node, s.
    pub dwell_s: f64,
    /// How far every axis runs past the end point before the return pass is measured; 0 = it turns there.
    pub overrun: Millimetres,
    /// How far behind the first node every axis begins, so that it arrives in its own direction.
    pub preload: Millimetres,
    /// Number of runs.
    pub runs: u32,
    /// Whether the return pass is measured too.
    pub bidirectional: bool,
    /// The way back where it is not measured.
    pub way_back: WayBack,
    /// Targets of single axes.
    pub targets: TargetGrid,
    /// Whether the target first goes to the far end and back, so that the beam can be aligned.
    pub alignment_pass: bool,
    /// Fanuc: number of the first program, where it is stated.
    pub number: Option<u32>,
    /// What reflects the beam.
    pub target: Reflector,
}

/// Number of the first program where none is stated.
const DEFAULT_NUMBER: u32 = 1001;

impl ProgramRequest {
    /// The run of a measurement of which the job states no motion: with the usual feed and standstill, and with
    /// a return pass where `overrun` speaks of one.
    pub(crate) fn of_measurement(measurement: &DiagonalMeasurement) -> ProgramRequest {
        let overrun = match measurement.overrun {
            Some(false) => 0.0,
            _ => DEFAULT_OVERRUN_MM,
        };
        ProgramRequest {
            what: RunType::StepDiagonal,
            volume: measurement.volume.clone(),
            size_path: "measurement.step_diagonal.size_mm",
            axes: Axis::ALL.to_vec(),
            rest: None,
            feed_mm_per_min: DEFAULT_FEED_MM_PER_MIN,
            dwell_s: DEFAULT_DWELL_S,
            overrun: Millimetres::new(overrun),
            preload: Millimetres::new(DEFAULT_OVERRUN_MM),
            runs: 1,
            bidirectional: measurement.overrun.is_some(),
            way_back: WayBack::Retrace,
            targets: TargetGrid::Equal,
            alignment_pass: true,
            number: None,
            target: measurement.target,
        }
    }

    /// The usual run along one axis at the same feed and with the same standstill, at the positions of the
    /// diagonals.
    pub(crate) fn along(&self, axis: Axis) -> ProgramRequest {
        ProgramRequest {
            what: RunType::SingleAxis,
            axes: vec![axis],
            overrun: Millimetres::new(DEFAULT_OVERRUN_MM),
            runs: DEFAULT_ISO_RUNS,
            bidirectional: true,
            targets: TargetGrid::Equal,
            ..self.clone()
        }
    }

    /// Fanuc: number of the program with this index; they follow each other.
    pub(crate) fn number_of(&self, index: usize) -> u32 {
        self.number.unwrap_or(DEFAULT_NUMBER) + u32::try_from(index).unwrap_or(0)
    }

    /// Whether the axes run past the end point before a way back that is measured: what `overrun`
    /// has to state with readings of this run of diagonals. `None` = no such way back.
    pub(crate) fn runs_over(&self) -> Option<bool> {
        let back = self.bidirectional && self.what.path().is_some();
        back.then(|| self.overrun.mm() > 0.0)
    }

    /// Where an axis rests while another one is measured.
    pub(crate) fn rest_of(&self, axis: Axis) -> Millimetres {
        let volume = &self.volume;
        let middle = volume.start[axis].mm() + volume.size[axis].mm() / 2.0;
        self.rest.map_or(Millimetres::new(middle), |rest| rest[axis])
    }
}

const DEFAULT_FEED_MM_PER_MIN: f64 = 1000.0; // a step of 30 mm in two seconds, without swinging
const DEFAULT_DWELL_S: f64 = 3.0; // 2 … 5 s is usual: to settle, and to average the laser
const DEFAULT_OVERRUN_MM: f64 = 2.0; // a hundred times the reversal of a sound axis
const DEFAULT_ISO_RUNS: u32 = 5; // ISO 230-2, axes up to 2 m
const LENGTHS_MM: RangeInclusive<f64> = 0.01..=100.0; // preload and shift: no machine has more to spare
const MOST_RUNS: u32 = 100;
const MOST_NUMBER: u32 = 9990; // four digits on every Fanuc control, with room for four programs

/// The section; `measurement` is `None` where the job's measurement could not be read.
pub(super) fn program(
    section: &Section<'_>,
    measurement: Option<&Measurement>,
) -> Option<ProgramRequest> {
    section.require("what", "`step-diagonal`, `straight-diagonal` or `single-axis`");
    let what = section.choice("what", RunType::WORDS);
    refuse_other_runs(section, what);
    let (bidirectional, way_back) = directions(section);
    let (overrun, preload) = run_out(section, what, bidirectional);
    let (volume, size_path) = measured_box(section, what, measurement).unzip();
    let usual_runs = match what {
        Some(RunType::SingleAxis) => DEFAULT_ISO_RUNS,
        _ => 1,
    };
    let feed = section.between("feed_mm_per_min", 1e-3..=1e6, "mm/min");
    let dwell = section.between("dwell_s", 0.1..=600.0, "s");
    let runs = section.count("runs", 1..=MOST_RUNS, "write a number of that range");
    let four = "the programs have numbers of four digits";
    Some(ProgramRequest {
        axes: axes(section),
        rest: section.place("rest_mm"),
        feed_mm_per_min: feed.unwrap_or(DEFAULT_FEED_MM_PER_MIN),
        dwell_s: dwell.unwrap_or(DEFAULT_DWELL_S),
        overrun: Millimetres::new(overrun),
        preload: Millimetres::new(preload),
        runs: runs.unwrap_or(usual_runs),
        bidirectional,
        way_back,
        targets: targets(section),
        alignment_pass: section.flag("alignment_pass").unwrap_or(true),
        number: section.count("number", 1..=MOST_NUMBER, four),
        target: target(what, measurement),
        what: what?, // what stands above is read for its problems
        volume: volume?,
        size_path: size_path?,
    })
}

/// Keys that have no effect on runs of this kind.
fn refuse_other_runs(section: &Section<'_>, what: Option<RunType>) {
    let Some(what) = what else { return };
    let is_single = what == RunType::SingleAxis;
    let single = "`what = \"single-axis\"`";
    section.only_with("axes", is_single, single);
    section.only_with("rest_mm", is_single, single);
    if section.text("targets").is_some_and(|word| word == "offset") {
        section.only_with("targets", is_single, single);
    }
    let step = "`what = \"step-diagonal\"`";
    section.only_with("order", what == RunType::StepDiagonal, step);
}

/// The box as stated here, else as stated for the measurement, and the key of its size.
fn measured_box(
    section: &Section<'_>,
    what: Option<RunType>,
    measurement: Option<&Measurement>,
) -> Option<(Volume, &'static str)> {
    let measured = measurement.and_then(|m| match &m.data {
        MeasuredData::Diagonals(diagonals) => Some(&diagonals.volume),
        MeasuredData::Errors(_) => None,
    });
    let size_path = if section.has("size_mm") || measured.is_none() {
        "program.size_mm"
    } else {
        "measurement.step_diagonal.size_mm"
    };
    let kind = what.and_then(RunType::path).unwrap_or(PathKind::Straight);
    let is_required = measured.is_none() && measurement.is_some();
    let volume = volume(section, kind, measured, is_required)?;
    Some((volume, size_path))
}

/// What the job states for the same kind of run, else what is usual for it.
fn target(what: Option<RunType>, measurement: Option<&Measurement>) -> Reflector {
    let kind = what.and_then(RunType::path);
    match measurement.map(|m| &m.data) {
        Some(MeasuredData::Diagonals(measured)) if Some(measured.kind) == kind => measured.target,
        _ => Reflector::usual(kind.unwrap_or(PathKind::Straight)),
    }
}

fn axes(section: &Section<'_>) -> Vec<Axis> {
    let Some(names) = section.texts("axes") else {
        return Axis::ALL.to_vec();
    };
    let axes = names.iter().filter_map(|name| Axis::from_letter(name));
    let axes: Vec<Axis> = axes.collect();
    let is_twice = |(n, axis): (usize, &Axis)| axes[..n].contains(axis);
    if axes.is_empty() || axes.len() < names.len() || axes.iter().enumerate().any(is_twice) {
        section.problem(
            "axes",
            "`program.axes` names each of `x`, `y`, `z` at most once, and at least one",
            "for instance `axes = [\"x\", \"z\"]`",
        );
    }
    axes
}

/// Whether the return pass is measured, and how it goes where it is not: a way back along the
/// diagonal meets no node, so it is not measured.
fn directions(section: &Section<'_>) -> (bool, WayBack) {
    let way_back = section.choice("return", WayBack::WORDS).unwrap_or(WayBack::Retrace);
    let is_retraced = way_back == WayBack::Retrace;
    let stated = section.flag("bidirectional");
    let fits = stated != Some(true) || is_retraced;
    section.only_with("return", fits, "`bidirectional = false`");
    (stated.unwrap_or(is_retraced), way_back)
}

/// Overrun and preload, mm.
fn run_out(section: &Section<'_>, what: Option<RunType>, bidirectional: bool) -> (f64, f64) {
    let overrun = section.between("overrun_mm", 0.0..=*LENGTHS_MM.end(), "mm");
    section.only_with("overrun_mm", bidirectional, "`bidirectional = true`");
    let stated = overrun.filter(|mm| *mm > 0.0);
    let turns = overrun.is_some() && stated.is_none() && bidirectional;
    if turns && what != Some(RunType::StepDiagonal) {
        section.problem(
            "overrun_mm",
            "`overrun_mm` is 0, so the last target would be approached from one side only",
            "give an overrun larger than the reversal of every axis, e.g. `overrun_mm = 2.0`",
        );
    }
    let preload = section.between("preload_mm", LENGTHS_MM, "mm");
    let usual_preload = stated.unwrap_or(DEFAULT_OVERRUN_MM);
    (overrun.unwrap_or(DEFAULT_OVERRUN_MM), preload.unwrap_or(usual_preload))
}

fn targets(section: &Section<'_>) -> TargetGrid {
    let is_offset = section.choice("targets", &[("equal", false), ("offset", true)]);
    let is_offset = is_offset.unwrap_or(false);
    let shift = section.between("shift_mm", LENGTHS_MM, "mm").map(Millimetres::new);
    section.only_with("shift_mm", is_offset, "`targets = \"offset\"`");
    match is_offset {
        true => TargetGrid::Offset { shift },
        false => TargetGrid::Equal,
    }
}
