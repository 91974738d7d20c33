//! One way to make a visit, and what it costs and gives.

use crate::inputs::job::{Acceptance, ProgramRequest};
use crate::judge::forecast::JudgedRange;
use crate::machine::model::ErrorModel;
use crate::machine::separation::{MeasuredLine, Part, Separation};
use crate::quantity::{Axis, Direction, ErrorTerm, Millimetres, Rotation, larger, rounded};
use crate::text::joined;
use crate::write::program::MirrorSize;
use serde::Serialize;

/// Digits of a figure that many draws have made, µm.
pub(super) const DIGITS: u32 = 4;

/// A part of U.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Share {
    /// What makes it.
    pub what: String,
    /// As much of U, µm.
    pub um: f64,
    /// What makes it, for other words.
    #[serde(skip)]
    pub part: Part,
    /// The axis of a linear measurement.
    #[serde(skip)]
    pub linear: Option<Axis>,
}

impl Share {
    pub(super) fn new(part: Part, linear: Option<Axis>, um: f64) -> Share {
        let what = match (part, linear) {
            (Part::Noise, _) => "noise of the readings".to_string(),
            (Part::Laser, _) => "scale of the laser".to_string(),
            (Part::Mirror, _) => "tilt of the mirror".to_string(),
            (Part::SetUps, _) => "scale from set-up to set-up".to_string(),
            (Part::Beam, _) => "beam".to_string(),
            (Part::Stated, _) => "u of the error table".to_string(),
            (Part::Line(_), None) => "other beam".to_string(),
            (Part::Line(_), Some(axis)) => format!("slope of linear {axis}"),
            (Part::Angle(angle), _) => {
                format!("{angle} (rotation of {} about {})", angle.along, angle.about)
            }
        };
        Share { what, um: rounded(um, DIGITS), part, linear }
    }
}

/// Parts in words.
pub(crate) fn listed(parts: &[Share]) -> String {
    let parts = joined(parts.iter().map(|of| format!("{} {:.2} µm", of.what, of.um)));
    format!("{parts} (they add as squares)")
}

/// One way to make the visit.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// The run of the diagonals.
    pub run: ProgramRequest,
    /// Axes that are measured along their length beside those that the job names.
    pub linear: Vec<Axis>,
    /// Angles that are measured beside those that the job names.
    pub angles: Vec<Rotation>,
}

impl Variant {
    /// The same with another run.
    pub(super) fn run_as(&self, change: impl FnOnce(&mut ProgramRequest)) -> Variant {
        let mut other = self.clone();
        change(&mut other.run);
        other
    }

    /// The diagonals walked back too, without overrun.
    pub(super) fn turning(&self) -> Variant {
        self.run_as(|run| {
            run.bidirectional = true;
            run.overrun = Millimetres::new(0.0);
        })
    }

    pub(super) fn in_runs(&self, runs: u32) -> Variant {
        self.run_as(|run| run.runs = runs)
    }

    pub(super) fn with(&self, linear: &[Axis], angles: &[Rotation]) -> Variant {
        Variant { run: self.run.clone(), linear: linear.to_vec(), angles: angles.to_vec() }
    }

    /// This, with what another one measures in addition.
    pub(super) fn and(&self, other: &Variant) -> Variant {
        let mut both = self.clone();
        both.linear.extend(&other.linear);
        both.angles.extend(&other.angles);
        both.linear.sort();
        both.linear.dedup();
        both.angles.sort();
        both.angles.dedup();
        both
    }

    /// What it does otherwise.
    pub(crate) fn change(&self, base: &Variant) -> String {
        let [own, of_base] = [self, base].map(parts);
        if self == base {
            return format!("as described: {}", joined(own));
        }
        let linear = Axis::letters(&self.linear);
        let linear = (!linear.is_empty()).then(|| format!("+ linear {linear}"));
        let angles = match self.angles.as_slice() {
            [] => None,
            [one] => Some(format!("+ {one} measured")),
            all => Some(format!("+ {} angles measured", all.len())),
        };
        let pairs = own.into_iter().zip(of_base);
        let others = pairs.filter_map(|(own, base)| (own != base).then_some(own));
        joined(linear.into_iter().chain(angles).chain(others))
    }

    /// Largest distance of two targets of an axis, mm.
    pub(crate) fn target_spacing_mm(&self) -> f64 {
        Axis::ALL.map(|axis| self.run.volume.step_mm(axis)).into_iter().fold(0.0, larger)
    }
}

/// Steps, passes and runs of a variant.
fn parts(variant: &Variant) -> [String; 3] {
    let run = &variant.run;
    let back = match run.runs_over() {
        None => "one direction",
        Some(true) => "return pass after overrun",
        Some(false) => "return pass without overrun",
    };
    let runs = match run.runs {
        1 => "1 run".to_string(),
        runs => format!("{runs} runs"),
    };
    [format!("{} steps", run.volume.steps), back.to_string(), runs]
}

/// What a variant costs and gives.
#[derive(Clone, Debug)]
pub struct Visit {
    /// The variant.
    pub variant: Variant,
    /// Motion, standstills and set-ups, min.
    pub minutes: f64,
    /// What the mirror has to cover.
    pub mirror: Option<MirrorSize>,
    /// Linear axes and beams with their uncertainties.
    pub lines: Vec<MeasuredLine>,
    /// What the separation will say of readings: uncertainties and what stays open.
    pub expected: Separation,
    /// What the forecast of all determined terms is at most where neither machine nor tables leave anything: the smallest
    /// `max_deviation_um` that it can pass, µm; `None` = an uncertainty is not known.
    pub at_most_um: Option<f64>,
    /// The same of max − min along the diagonals, µm; `None` also where no limit is asked for, or some error that they
    /// add up is not known, or in one direction only.
    pub(super) diagonals_at_most_um: Option<f64>,
    /// The error that is at most most.
    pub(super) worst: Option<ErrorTerm>,
    /// How much of what is judged is measured.
    pub(crate) ranges: Vec<JudgedRange>,
    /// Terms that the job wants and that are not determined, or without a known U.
    pub open: Vec<ErrorTerm>,
    /// Probability that a second measurement made likewise passes; `None` = not computed, or nothing is asked.
    pub chance: Option<f64>,
}

impl Visit {
    /// U of a term where it is largest, µm; `None` = not determined, or not known.
    pub(crate) fn expanded_um(&self, term: ErrorTerm) -> Option<f64> {
        expanded_um(&self.expected, term)
    }

    /// The three largest parts of U.
    pub(super) fn most(&self, parts: Vec<(Part, f64)>) -> Vec<Share> {
        let linear = |part: Part| {
            let Part::Line(index) = part else { return None };
            Axis::ALL.into_iter().find(|axis| self.lines[index].direction[*axis] > 0.999)
        };
        let share = |(part, um)| Share::new(part, linear(part), um);
        parts.into_iter().take(3).map(share).collect()
    }

    /// Axes whose reversal is determined.
    pub fn reversals(&self) -> Vec<Axis> {
        let known = |axis: &Axis| self.expected.is_directed(*axis);
        Axis::ALL.into_iter().filter(known).collect()
    }

    /// Whether all wanted terms are determined and their U alone keeps the acceptance.
    pub fn reaches(&self, acceptance: Acceptance) -> bool {
        let Acceptance { max_deviation_um, max_diagonal_um, .. } = acceptance;
        let is_asked = max_deviation_um.is_some() || max_diagonal_um.is_some();
        let is_silent = !self.expected.silence.not_stated.is_empty();
        let keeps = |at_most_um: Option<f64>, limit_um: Option<f64>| {
            limit_um.is_none_or(|limit_um| at_most_um.is_some_and(|um| um <= limit_um))
        };
        self.open.is_empty()
            && !(is_silent && max_deviation_um.is_some())
            && keeps(self.at_most_um, max_deviation_um)
            && keeps(self.diagonals_at_most_um, max_diagonal_um)
            && !(is_asked && self.ranges.iter().any(|range| !range.is_known()))
    }
}

/// What a model holds of an error, µm; 0 where nothing.
pub(super) fn value_um(model: &ErrorModel) -> impl Fn(ErrorTerm, Direction, Millimetres) -> f64 {
    |term, way, at| {
        let curve = model.terms[term].as_ref().and_then(|of| of.measured.curve(way));
        curve.map_or(0.0, |curve| curve.at(at).um())
    }
}

/// U of a term where it is largest, without regard to direction, µm.
pub(super) fn expanded_um(expected: &Separation, term: ErrorTerm) -> Option<f64> {
    let found = expected.errors.mean[term].as_ref()?;
    let indices = 0..found.deviation_um.len();
    let all = indices.map(|index| found.expanded_um(index));
    let all: Option<Vec<f64>> = all.collect();
    all?.into_iter().reduce(larger)
}
