//! `[program]`: the part programs of a measuring run (contract §2.5, docs/measuring.md).

use crate::inputs::job::diagonals::{DiagonalMeasurement, Reflector, volume};
use crate::inputs::job::measurement::Measurement;
use crate::inputs::refusals;
use crate::quantity::{Axis, Millimetres, PathKind, Volume};
use crate::text::{Places, Section, Word, once, section, words};
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
    /// (screw, gear, scale) meet them at several phases (ISO 230-2: Pi = (i - 1) p + r).
    Offset {
        /// Largest shift, mm; `None` = a quarter of the step.
        shift: Option<Millimetres>,
    },
}

section! {
    /// A measuring run to write programs for. Everything that is `Volume` here is the same volume that
    /// a measurement of diagonals states, so a rehearsal can walk it.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ProgramRequest(section: &Section<'_>, measurement: Option<&Measurement>) {
        /// "straight-diagonal" or "single-axis"
        pub what: RunType = choice(RunType::WORDS), must WHAT;
        /// or "diagonal": straight back, without measuring
        pub way_back as return: WayBack = choice(WayBack::WORDS), or WayBack::Retrace;
        /// whether the return pass is measured; default: true with "retrace", else false
        pub bidirectional: bool = with(|s, key| is_bidirectional(s, key, way_back));
        /// past the end point before the return pass is measured; default 2
        pub overrun as overrun_mm: Millimetres =
            with(|s, key| overrun(s, key, what, bidirectional));
        /// behind node 0 on every axis; default: overrun_mm, or 2 where that is 0
        pub preload as preload_mm: Millimetres = with(length),
            or if overrun.mm() > 0.0 { overrun } else { Millimetres::new(DEFAULT_OVERRUN_MM) };
        /// The measured box, its division and the order of the moves in a cell.
        pub volume: Volume => measured_box(section, what, measurement), must;
        /// Key that the size of the box comes from, for problems.
        pub size_path: &'static str => size_path(section, measurement);
        /// along the path; default 1000
        pub feed_mm_per_min: f64 = between(1e-3..=1e6, "mm/min"), or DEFAULT_FEED_MM_PER_MIN;
        /// standstill at every node, 0.1 … 600; default 3
        pub dwell_s: f64 = between(0.1..=600.0, "s"), or DEFAULT_DWELL_S;
        /// 1 … 100; default 1, single axes 5
        pub runs: u32 = count(1..=MOST_RUNS, "write a number of that range"),
            or if what == Some(RunType::SingleAxis) { DEFAULT_ISO_RUNS } else { 1 };
        /// single axes: which, in the order of the programs
        pub axes: Vec<Axis> = with(|s, key| axes(s, key, what)), or Axis::ALL.to_vec();
        /// single axes: where the others rest; default: the middle of the box
        pub rest as rest_mm: Option<Places> = with(|s, key| rest(s, key, what));
        /// Targets of single axes.
        pub targets: TargetGrid => targets(section, what);
        /// to the far end and back with a halt at both ends, before the laser is zeroed
        pub alignment_pass: bool = flag(), or true;
        /// Fanuc: number of the first program, the others follow
        pub number: Option<u32> =
            count(1..=MOST_NUMBER, "the programs have numbers of four digits");
        /// What reflects the beam.
        pub target: Reflector => target(what, measurement);
    }
}

const WHAT: &str = "`step-diagonal`, `straight-diagonal` or `single-axis`";

section! {
    pub(super) struct TargetKeys(section: &Section<'_>) {
        /// single axes: or "offset", each target shifted by up to shift_mm
        targets: bool = choice(&[("equal", false), ("offset", true)]), or false;
        /// default: a quarter of the step
        shift_mm: Option<Millimetres> = with(length);
    }
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

    /// The measurement of this run of diagonals, of which the job states nothing else; `None` = of single axes.
    pub(crate) fn measured(&self) -> Option<DiagonalMeasurement> {
        Some(DiagonalMeasurement {
            target: self.target,
            overrun: Some(self.overrun.mm() > 0.0),
            ..DiagonalMeasurement::along(self.what.path()?, self.volume.clone())
        })
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

/// Notes a key that has no effect on runs of another kind.
fn only_of(section: &Section<'_>, key: &'static str, what: Option<RunType>, own: RunType) {
    let with = format!("`what = \"{}\"`", own.word());
    section.only_with(key, what.is_none_or(|what| what == own), &with);
}

fn size_path(section: &Section<'_>, measurement: Option<&Measurement>) -> &'static str {
    match section.has("size_mm") || measurement.and_then(Measurement::diagonals).is_none() {
        true => "program.size_mm",
        false => "measurement.step_diagonal.size_mm",
    }
}

/// The box as stated here, else as stated for the measurement.
fn measured_box(
    section: &Section<'_>,
    what: Option<RunType>,
    measurement: Option<&Measurement>,
) -> Option<Volume> {
    only_of(section, "order", what, RunType::StepDiagonal);
    let measured = measurement.and_then(Measurement::diagonals).map(|measured| &measured.volume);
    let kind = what.and_then(RunType::path).unwrap_or(PathKind::Straight);
    volume(section, kind, measured, measured.is_none() && measurement.is_some())
}

/// What the job states for the same kind of run, else what is usual for it.
fn target(what: Option<RunType>, measurement: Option<&Measurement>) -> Reflector {
    let kind = what.and_then(RunType::path);
    let same = measurement.and_then(Measurement::diagonals).filter(|own| Some(own.kind) == kind);
    let usual = || Reflector::usual(kind.unwrap_or(PathKind::Straight));
    same.map_or_else(usual, |measured| measured.target)
}

fn axes(section: &Section<'_>, key: &'static str, what: Option<RunType>) -> Option<Vec<Axis>> {
    only_of(section, key, what, RunType::SingleAxis);
    let names = section.texts(key)?;
    let axes: Vec<Axis> = names.iter().filter_map(|name| Axis::from_letter(name)).collect();
    if axes.is_empty() || once(axes.clone()).len() < names.len() {
        section.refuse(key, refusals::other_axes());
    }
    Some(axes)
}

fn rest(section: &Section<'_>, key: &'static str, what: Option<RunType>) -> Option<Places> {
    only_of(section, key, what, RunType::SingleAxis);
    section.place(key)
}

/// Whether the return pass is measured: a way back along the diagonal meets no node, so it is not measured.
fn is_bidirectional(section: &Section<'_>, key: &'static str, way_back: WayBack) -> bool {
    let is_retraced = way_back == WayBack::Retrace;
    let stated = section.flag(key);
    section.only_with("return", stated != Some(true) || is_retraced, "`bidirectional = false`");
    stated.unwrap_or(is_retraced)
}

fn overrun(
    section: &Section<'_>,
    key: &'static str,
    what: Option<RunType>,
    bidirectional: bool,
) -> Millimetres {
    let overrun = section.between(key, 0.0..=*LENGTHS_MM.end(), "mm");
    section.only_with(key, bidirectional, "`bidirectional = true`");
    let turns = overrun.is_some_and(|mm| mm <= 0.0) && bidirectional;
    if turns && what != Some(RunType::StepDiagonal) {
        section.refuse(key, refusals::no_overrun());
    }
    Millimetres::new(overrun.unwrap_or(DEFAULT_OVERRUN_MM))
}

fn length(section: &Section<'_>, key: &'static str) -> Option<Millimetres> {
    section.between(key, LENGTHS_MM, "mm").map(Millimetres::new)
}

fn targets(section: &Section<'_>, what: Option<RunType>) -> TargetGrid {
    match TargetKeys::read(section) {
        Some(TargetKeys { targets: true, shift_mm: shift }) => {
            only_of(section, "targets", what, RunType::SingleAxis);
            TargetGrid::Offset { shift }
        }
        _ => {
            section.only_with("shift_mm", false, "`targets = \"offset\"`");
            TargetGrid::Equal
        }
    }
}
