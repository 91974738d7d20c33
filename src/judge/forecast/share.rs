//! The machine that a verdict is passed on; over which part of each axis, and how much of it was measured.

use crate::inputs::job::Job;
use crate::machine::model::{ErrorModel, Range, within};
use crate::quantity::{
    Axis, Direction, ErrorCurve, ErrorTerm, Figure, Millimetres, PerAxis, USUAL_MM, larger, pitch,
};
use crate::text::joined;

/// Share of a judged range that has to be measured before a limit counts as kept: the offset
/// targets of an acceptance test stay clear of the ends by half a step or so.
const COVERED: f64 = 0.9;
/// Of the judged range: between places farther apart nothing is known.
const WIDEST_GAP: f64 = 0.5;
/// Positions of inch targets are rounded.
const ROUNDING: f64 = 1.0 + 1e-6;
/// From here on a share is called the whole.
const WHOLE: f64 = 0.995;

/// The part of an axis that is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedRange {
    /// The axis.
    pub axis: Axis,
    /// What is judged: as `[acceptance]` states it, else the travel.
    pub judged: Range,
    /// Whether `[acceptance]` states it.
    pub is_stated: bool,
    /// From where to where was measured.
    pub measured: Range,
    /// How much of the judged range lies between measured places that are near enough, 0 to 1.
    pub share: f64,
    /// Largest distance of two neighbouring places, mm.
    pub gap_mm: f64,
    /// Which usual pitches have all of these places at one phase.
    pub unseen: [bool; USUAL_MM.len()],
}

/// The judged range of every axis along which a term was measured.
pub(crate) fn judged_ranges(job: &Job, model: &ErrorModel) -> Vec<JudgedRange> {
    let along = |axis: &Axis| model.measured().any(|(term, _)| term.along == *axis);
    let ranges = Axis::ALL.into_iter().filter(along).filter_map(|axis| {
        let own = model.measured().filter(|(term, _)| term.along == axis);
        let curves = own.flat_map(|(_, measured)| measured.curves());
        let each = curves.filter_map(|curve| range_of(job, axis, curve.knots()));
        each.min_by(|a, b| a.share.total_cmp(&b.share))
    });
    ranges.collect()
}

/// The judged range of an axis that was measured at these places, in ascending order.
pub(crate) fn range_of(job: &Job, axis: Axis, places: &[Millimetres]) -> Option<JudgedRange> {
    let machine = job.machine.axes[axis]?;
    let stated = job.acceptance.range[axis];
    let judged = stated.unwrap_or((machine.low, machine.high));
    let whole = (judged.1 - judged.0).mm();
    let gap_mm = |pair: &[Millimetres]| (pair[1] - pair[0]).mm();
    let near = |pair: &&[Millimetres]| gap_mm(pair) <= WIDEST_GAP * ROUNDING * whole;
    let common = |pair: &[Millimetres]| {
        let (low, high) = within(judged, Some((pair[0], pair[1])));
        larger((high - low).mm(), 0.0)
    };
    Some(JudgedRange {
        axis,
        judged,
        is_stated: stated.is_some(),
        measured: (*places.first()?, *places.last()?),
        share: places.windows(2).filter(near).map(common).fold(0.0, |a, b| a + b) / whole,
        gap_mm: places.windows(2).map(gap_mm).fold(0.0, larger),
        unseen: pitch::unseen(places),
    })
}

impl JudgedRange {
    /// Whether enough of it was measured for a verdict.
    pub(crate) fn is_known(&self) -> bool {
        self.share >= COVERED
    }

    /// Why a verdict is undecided where not enough was measured, in a sentence.
    pub fn missing(&self) -> String {
        let (from, to) = (self.measured.0.mm(), self.measured.1.mm());
        let (low, high) = (self.judged.0.mm(), self.judged.1.mm());
        let (axis, key) = (self.axis, self.axis.key());
        let what = if self.is_stated { "of the range to be judged" } else { "of its travel" };
        // What was measured is known by itself where none of its gaps is too wide for it.
        let help = match self.is_stated || self.gap_mm > WIDEST_GAP * ROUNDING * (to - from) {
            true => "measure the rest".to_string(),
            false => format!(
                "measure the rest, or state the range to be judged in [acceptance], e.g. `range_mm = {{ {key} = [{from}, {to}] }}`"
            ),
        };
        let (gap, share) = (Figure(self.gap_mm).trimmed(3), percent(self.share));
        format!(
            "{axis} was measured from {from} to {to} mm with a target spacing of up to {gap} mm, {share} {what} ({low} to {high} mm; gaps of more than half of it do not count), and less than nine tenths decide nothing: {help}"
        )
    }

    /// Pitches at which the target spacing hides a periodic error: `5, 10 mm (X); 6 mm (YZ)`; empty = none.
    pub(crate) fn hidden_pitches(ranges: &[Self], (each, unit): (f64, &str)) -> String {
        let of = |alike: &[Self]| {
            let hidden = USUAL_MM.iter().zip(alike[0].unseen).filter(|(_, unseen)| *unseen);
            let hidden = joined(hidden.map(|(mm, _)| Figure(mm * each).trimmed(4)));
            let axes: Vec<Axis> = alike.iter().map(|range| range.axis).collect();
            (!hidden.is_empty()).then(|| format!("{hidden} {unit} ({})", Axis::letters(&axes)))
        };
        let alike = ranges.chunk_by(|a, b| a.unseen == b.unseen);
        alike.filter_map(of).collect::<Vec<String>>().join("; ")
    }

    /// Whether the whole of it was measured.
    pub(crate) fn is_whole(&self) -> bool {
        self.share >= WHOLE
    }
}

fn percent(share: f64) -> String {
    match share * 100.0 {
        small if small > 0.0 && small < 1.0 => "less than 1 %".to_string(),
        percent => format!("{percent:.0} %"),
    }
}

/// Largest distance of two neighbouring places on any axis, mm.
pub(crate) fn widest_gap_mm(ranges: &[JudgedRange]) -> f64 {
    ranges.iter().map(|range| range.gap_mm).fold(0.0, larger)
}

/// Whether the whole travel of every axis was measured and is judged.
pub(crate) fn is_whole_travel(ranges: &[JudgedRange]) -> bool {
    ranges.iter().all(|range| range.is_whole() && !range.is_stated)
}

/// On which part of the machine a verdict rests, for its line.
pub(crate) fn words(ranges: &[JudgedRange]) -> String {
    let gap = format!(", target spacing up to {} mm", Figure(widest_gap_mm(ranges)).trimmed(3));
    if is_whole_travel(ranges) {
        return format!("over the whole travel{gap}");
    }
    let one = |range: &JudgedRange| {
        let (low, high) = (range.judged.0.mm(), range.judged.1.mm());
        let share = percent(range.share);
        match (range.is_stated, range.is_whole()) {
            (true, true) => format!("{} from {low} to {high} mm", range.axis),
            (true, false) => format!("{share} of {} from {low} to {high} mm", range.axis),
            (false, _) => format!("{share} of the travel of {}", range.axis),
        }
    };
    format!("over {}{gap}", joined(ranges.iter().map(one)))
}

/// The stated ranges; `None` = all that was measured is judged.
pub(super) fn stated(ranges: &[JudgedRange]) -> PerAxis<Option<Range>> {
    PerAxis::from_fn(|axis| {
        let own = ranges.iter().find(|r| r.axis == axis && r.is_stated)?;
        let (low, high) = within(own.measured, Some(own.judged));
        (low < high).then_some(own.judged)
    })
}

/// One machine, before and without compensation. Both are the same model where no table was
/// active while measuring.
#[derive(Clone, Copy, Debug)]
pub struct Machine<'a> {
    /// As it was measured: what the forecast compares with, and the range that is known.
    pub as_measured: &'a ErrorModel,
    /// Without any table: what corrections are added to.
    pub uncompensated: &'a ErrorModel,
}

impl<'a> Machine<'a> {
    /// A machine that was measured without any table.
    pub fn alone(model: &'a ErrorModel) -> Machine<'a> {
        Machine { as_measured: model, uncompensated: model }
    }

    /// Whether tables were active while measuring.
    pub(super) fn was_under_tables(self) -> bool {
        !std::ptr::eq(self.as_measured, self.uncompensated)
    }

    /// The curves of a term in a direction: as measured, and without tables.
    pub(super) fn curves(
        self,
        term: ErrorTerm,
        direction: Direction,
    ) -> Option<(&'a ErrorCurve, &'a ErrorCurve)> {
        let of = |model: &'a ErrorModel| model.terms[term].as_ref()?.measured.curve(direction);
        Some((of(self.as_measured)?, of(self.uncompensated)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_proposed_where_what_was_measured_would_be_known_by_itself() {
        let range = |from, to| (Millimetres::new(from), Millimetres::new(to));
        let proposed = |to, gap_mm| {
            let (judged, measured) = (range(0.0, 400.0), range(0.0, to));
            let unseen = [false; USUAL_MM.len()];
            let (axis, is_stated, share) = (Axis::X, false, 0.0);
            let of = JudgedRange { axis, judged, is_stated, measured, share, gap_mm, unseen };
            of.missing().contains("range_mm")
        };
        assert!(proposed(300.0, 150.0) && !proposed(300.0, 200.0));
        assert!(!proposed(400.0, 400.0), "it is the one that is judged");
    }
}
