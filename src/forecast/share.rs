//! Over which part of each axis a verdict is passed, and how much of it was measured.

use crate::axis::{Axis, PerAxis};
use crate::job::Job;
use crate::model::ErrorModel;
use crate::units::Millimetres;

/// Share of a judged range that has to be measured before a limit counts as kept: the offset
/// targets of an acceptance test stay clear of the ends by half a step or so.
const COVERED: f64 = 0.9;
/// From here on a share is called the whole.
const WHOLE: f64 = 0.995;

type Range = (Millimetres, Millimetres);

/// The part of an axis that is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedRange {
    /// The axis.
    pub axis: Axis,
    /// What is judged: as `[acceptance]` states it, else the travel.
    pub judged: Range,
    /// Whether `[acceptance]` states it.
    pub is_stated: bool,
    /// What was measured.
    pub measured: Range,
}

/// The judged range of every axis along which a term was measured.
pub fn judged_ranges(job: &Job, model: &ErrorModel) -> Vec<JudgedRange> {
    let along = |axis: &Axis| model.measured().any(|(term, _)| term.along == *axis);
    let axes = Axis::ALL.into_iter().filter(along);
    let ranges = axes.filter_map(|axis| range_of(job, axis, model.ranges[axis]?));
    ranges.collect()
}

/// The judged range of an axis that was measured from `measured.0` to `measured.1`.
pub(crate) fn range_of(job: &Job, axis: Axis, measured: Range) -> Option<JudgedRange> {
    let machine = job.machine.axes[axis]?;
    let stated = job.acceptance.range[axis];
    Some(JudgedRange {
        axis,
        judged: stated.unwrap_or((machine.low, machine.high)),
        is_stated: stated.is_some(),
        measured,
    })
}

impl JudgedRange {
    /// How much of it was measured, 0 to 1.
    fn share(&self) -> f64 {
        let (low, high) = super::within(self.judged, Some(self.measured));
        let whole = (self.judged.1 - self.judged.0).mm();
        let common = (high - low).mm();
        if common > 0.0 { common / whole } else { 0.0 }
    }

    /// Whether enough of it was measured for a verdict.
    pub fn is_known(&self) -> bool {
        self.share() >= COVERED
    }

    /// Why the verdict is undecided, in a sentence; `None` = enough was measured.
    pub fn missing(&self) -> Option<String> {
        let (from, to) = (self.measured.0.mm(), self.measured.1.mm());
        let (low, high) = (self.judged.0.mm(), self.judged.1.mm());
        let (axis, key) = (self.axis, self.axis.key());
        let what = match self.is_stated {
            true => "of the range to be judged",
            false => "of its travel",
        };
        let help = match self.is_stated {
            true => "measure the rest".to_string(),
            false => format!(
                "measure the rest, or state the range to be judged in [acceptance], e.g. `range_mm = {{ {key} = [{from}, {to}] }}`"
            ),
        };
        (!self.is_known()).then(|| {
            format!(
                "{axis} was measured from {from} to {to} mm, {} {what} ({low} to {high} mm), and less than nine tenths decide nothing: {help}",
                percent(self.share())
            )
        })
    }
}

fn percent(share: f64) -> String {
    match share * 100.0 {
        small if small > 0.0 && small < 1.0 => "less than 1 %".to_string(),
        percent => format!("{percent:.0} %"),
    }
}

/// On which part of the machine a verdict rests, for its line.
pub(super) fn words(ranges: &[JudgedRange]) -> String {
    let whole = |range: &JudgedRange| range.share() >= WHOLE;
    if ranges.iter().all(|range| whole(range) && !range.is_stated) {
        return "over the whole travel".to_string();
    }
    let one = |range: &JudgedRange| {
        let (low, high) = (range.judged.0.mm(), range.judged.1.mm());
        let share = percent(range.share());
        match (range.is_stated, whole(range)) {
            (true, true) => format!("{} from {low} to {high} mm", range.axis),
            (true, false) => format!("{share} of {} from {low} to {high} mm", range.axis),
            (false, _) => format!("{share} of the travel of {}", range.axis),
        }
    };
    format!(
        "over {}",
        ranges.iter().map(one).collect::<Vec<_>>().join(", ")
    )
}

/// The stated ranges; `None` = all that was measured is judged.
pub(super) fn stated(ranges: &[JudgedRange]) -> PerAxis<Option<Range>> {
    PerAxis::from_fn(|axis| {
        let own = ranges.iter().find(|r| r.axis == axis && r.is_stated)?;
        let (low, high) = super::within(own.measured, Some(own.judged));
        (low < high).then_some(own.judged)
    })
}
