//! The measurement afterwards, and what each of its values sees.

use crate::inputs::error_table::is_simulated;
use crate::inputs::job::Job;
use crate::judge::field::Field;
use crate::judge::findings::joined;
use crate::machine::model::{ErrorModel, MeasuredTerm};
use crate::machine::separation::curves::range;
use crate::machine::separation::readings::Walk;
use crate::quantity::{
    AT_PLACE_MM, Deviation, Diagonal, Direction, ErrorCurve, ErrorTerm, Millimetres, Pass,
    PathKind, PerDiagonal, Squared, Volume,
};
use crate::text::Finding;

/// A measurement of the machine with its tables active.
#[derive(Clone, Debug, PartialEq)]
pub enum AfterMeasurement {
    /// Error curves, zero at the reference.
    Errors(Box<ErrorModel>),
    /// Straight runs along the body diagonals.
    Diagonals(StraightRuns),
}

/// Straight runs along the body diagonals: their means and figures.
#[derive(Clone, Debug, PartialEq)]
pub struct StraightRuns {
    /// The box and its nodes.
    pub volume: Volume,
    /// Mean readings of each pass that was walked.
    pub walks: Vec<Walk>,
    /// Max − min along each diagonal, both passes, µm.
    pub range_um: PerDiagonal<f64>,
    /// Standard uncertainty (k = 1) of a mean reading, µm; `None` = neither stated nor repeated.
    pub u_um: Option<f64>,
    /// Degrees of freedom of the estimate behind it; `None` = it is stated.
    pub degrees_of_freedom: Option<f64>,
    /// Standard uncertainty of a length: laser, set-up, beam, µm/m.
    pub scale_um_per_m: f64,
    /// Of it what all diagonals share: the laser's scale, µm/m.
    pub laser_um_per_m: f64,
    /// The reverse passes count from the forward start.
    pub one_zero: bool,
    /// What the readings say of themselves and what their evaluation rests on.
    pub labels: Vec<Finding>,
}

impl AfterMeasurement {
    /// Whether the values say of themselves that they were simulated.
    pub(crate) fn is_simulated(&self) -> bool {
        match self {
            AfterMeasurement::Errors(model) => model.remarks.simulated().next().is_some(),
            AfterMeasurement::Diagonals(runs) => runs.labels.iter().any(is_simulated),
        }
    }

    /// Standard uncertainty (k = 1) of the laser's scale that no u of a value holds, µm/m.
    pub(crate) fn laser_um_per_m(&self) -> f64 {
        match self {
            AfterMeasurement::Errors(model) => model.laser_um_per_m,
            AfterMeasurement::Diagonals(runs) => runs.laser_um_per_m,
        }
    }

    /// The same, with the zero of the forecast where the reference lies outside what was measured: e + correction at the
    /// nearest end less that at the reference, in place of nothing. `before`: the machine without tables.
    pub(crate) fn zeroed(&mut self, before: &ErrorModel, control: &Field, job: &Job) {
        let AfterMeasurement::Errors(model) = self else { return };
        for term in ErrorTerm::ALL {
            let known = (&mut model.terms[term], &before.terms[term]);
            let (Some(own), Some(known)) = known else { continue };
            let Some(machine) = job.machine.axes[term.along] else { continue };
            let (way, reference) = (machine.homing(), machine.reference);
            let zeroed = |of: &MeasuredTerm| of.measured.zeroed(way).1.clone();
            let (curve, (low, high)) = (zeroed(known), zeroed(own).measured_range());
            let way = known.measured.zeroed(way).0.unwrap_or(way);
            let left = |at| (curve.at(at) + control.correction(term, way, at)).um();
            let end = Millimetres::new(reference.mm().clamp(low.mm(), high.mm()));
            if (end - reference).mm().abs() > AT_PLACE_MM {
                own.shift(Deviation::from_um(left(end) - left(reference)));
            }
        }
    }

    /// What was measured at five places or more and is the same at all of them, to the last digit.
    pub(super) fn flat(&self) -> String {
        let is_flat = |measured: &MeasuredTerm| {
            let um = |c: &ErrorCurve| range(c.knots().iter().map(|at| c.at(*at).um()));
            measured.curves().all(|c| um(c) <= 0.0)
                && measured.curves().any(|c| c.knots().len() >= 5)
        };
        match self {
            AfterMeasurement::Errors(model) => {
                let flat = model.measured().filter(|(_, measured)| is_flat(measured));
                joined(flat.map(|(term, _)| term))
            }
            AfterMeasurement::Diagonals(runs) => {
                let flat = runs.range_um.iter().filter(|(_, um)| **um <= 0.0);
                joined(flat.map(|(diagonal, _)| diagonal))
            }
        }
    }
}

// What each value of the second measurement sees: which deviations, where, with which weight.

/// One deviation that a value sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenDeviation {
    /// Which error.
    pub term: ErrorTerm,
    /// The way its axis travels.
    pub direction: Direction,
    /// Where the axis stands.
    pub at: Millimetres,
    /// Its share: 1 for a term by itself, the direction cosine on a diagonal.
    pub weight: f64,
}

impl SeenDeviation {
    /// The correction there, µm.
    pub(super) fn added_um(&self, control: &Field) -> f64 {
        control.correction(self.term, self.direction, self.at).um()
    }
}

/// One value of the second measurement: Σ weight · deviation, less a zero of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// What it sees.
    pub parts: Vec<SeenDeviation>,
    /// The value, µm.
    pub um: f64,
    /// The same of the machine without tables, from the first measurement: Σ weight · deviation, µm.
    pub found_um: f64,
    /// Standard uncertainty (k = 1) by what the first measurement does not repeat, µm; `None` = not stated.
    pub u_um: Option<f64>,
    /// Variance of what the first measurement says, likewise, µm²; 0 = not stated.
    pub found_variance: f64,
    /// Number of the curve or pass it stands on.
    pub curve: usize,
    /// Values with the same number count from the same zero.
    pub zero: usize,
    /// The diagonal it stands on, if it was measured along one.
    pub diagonal: Option<Diagonal>,
}

impl Observation {
    /// Σ weight · value of each part; `None` where one is unknown.
    pub fn predicted(&self, value: impl Fn(&SeenDeviation) -> Option<f64>) -> Option<f64> {
        weighted(&self.parts, value)
    }

    /// How far it is off what the first measurement and the tables say, µm.
    pub(crate) fn off_um(&self, control: &Field) -> f64 {
        let added_um = self.parts.iter().map(|part| part.weight * part.added_um(control));
        self.um - self.found_um - added_um.sum::<f64>()
    }

    /// Whether it is a value of this term by itself.
    pub(crate) fn is_of(&self, term: ErrorTerm) -> bool {
        self.diagonal.is_none() && self.parts.iter().all(|part| part.term == term)
    }
}

fn weighted(parts: &[SeenDeviation], value: impl Fn(&SeenDeviation) -> Option<f64>) -> Option<f64> {
    parts.iter().map(|part| Some(part.weight * value(part)?)).sum()
}

/// Every value of the second measurement that the first one has an answer to.
pub(crate) fn observations(before: &ErrorModel, after: &AfterMeasurement) -> Vec<Observation> {
    match after {
        AfterMeasurement::Diagonals(runs) => along_diagonals(before, runs),
        AfterMeasurement::Errors(model) => {
            let terms = model.measured().enumerate();
            terms.flat_map(|(zero, own)| of_term(before, model, own, zero)).collect()
        }
    }
}

fn of_term(
    before: &ErrorModel,
    after: &ErrorModel,
    (term, measured): (ErrorTerm, &MeasuredTerm),
    zero: usize,
) -> Vec<Observation> {
    let mut seen = Vec::new();
    let Some(first) = &before.terms[term] else {
        return seen;
    };
    let ways = measured.measured.ways();
    let u_um = after.u_anew_um(before, term);
    for (number, (way, curve)) in ways.enumerate() {
        for at in curve.knots() {
            let parts = parts_of(term, first, way, *at);
            if let Some(found_um) = found_um(before, &parts) {
                seen.push(Observation {
                    found_variance: variance(&parts, |term| before.u_anew_um(after, term)),
                    parts,
                    um: curve.at(*at).um(),
                    found_um,
                    u_um,
                    curve: 2 * zero + number,
                    zero,
                    diagonal: None,
                });
            }
        }
    }
    seen
}

/// Σ (weight · u)² over the errors that a value sees; parts of one term move together.
fn variance(parts: &[SeenDeviation], u_um: impl Fn(ErrorTerm) -> Option<f64>) -> f64 {
    let of = |term: ErrorTerm| {
        let weight: f64 = parts.iter().filter(|part| part.term == term).map(|p| p.weight).sum();
        (weight * u_um(term).unwrap_or(0.0)).squared()
    };
    ErrorTerm::ALL.into_iter().map(of).sum()
}

/// What the first measurement says of a value; `None` where it has no answer.
fn found_um(before: &ErrorModel, parts: &[SeenDeviation]) -> Option<f64> {
    weighted(parts, |part| before_um(before, part)).filter(|_| !parts.is_empty())
}

/// A value without direction is the mean of the directions that were measured first; none where
/// the first measurement has no answer.
fn parts_of(
    term: ErrorTerm,
    first: &MeasuredTerm,
    way: Option<Direction>,
    at: Millimetres,
) -> Vec<SeenDeviation> {
    let known = |direction: &Direction| {
        let curve = first.measured.curve(*direction);
        curve.is_some_and(|curve| {
            let (low, high) = curve.measured_range();
            at >= low && at <= high
        })
    };
    let ways = Direction::BOTH.into_iter();
    let ways: Vec<Direction> = ways
        .filter(|direction| way.is_none_or(|way| way == *direction) && known(direction))
        .collect();
    let weight = if ways.len() == 2 { 0.5 } else { 1.0 };
    ways.into_iter().map(|direction| SeenDeviation { term, direction, at, weight }).collect()
}

fn along_diagonals(before: &ErrorModel, runs: &StraightRuns) -> Vec<Observation> {
    let mut seen = Vec::new();
    for (number, walk) in runs.walks.iter().enumerate() {
        let (laser, is_back) = (runs.volume.laser(walk.diagonal), walk.pass == Pass::Reverse);
        for (node, um) in walk.um.iter().enumerate() {
            let place = runs.volume.place(walk.diagonal, PathKind::Straight, node);
            let part = |term: ErrorTerm| SeenDeviation {
                term,
                direction: walk.diagonal.travelled(term.along, walk.pass),
                at: place[term.along],
                weight: laser[term.of],
            };
            let parts: Vec<SeenDeviation> = ErrorTerm::ALL.into_iter().map(part).collect();
            let Some(found_um) = found_um(before, &parts) else {
                continue; // refused before: every term was measured in every direction walked
            };
            let u_um =
                |term: ErrorTerm| before.terms[term].as_ref().and_then(MeasuredTerm::u_value_um);
            seen.push(Observation {
                found_variance: variance(&parts, u_um),
                parts,
                um: *um,
                found_um,
                u_um: runs.u_um,
                curve: number,
                // Passes share a zero where the reverse pass counts from the forward start.
                zero: 2 * walk.diagonal as usize + usize::from(is_back && !runs.one_zero),
                diagonal: Some(walk.diagonal),
            });
        }
    }
    seen
}

/// The deviation as found where a part of an observation looks, µm; `None` = not measured in this
/// direction.
pub fn before_um(before: &ErrorModel, part: &SeenDeviation) -> Option<f64> {
    let measured = before.terms[part.term].as_ref()?;
    Some(measured.measured.curve(part.direction)?.at(part.at).um())
}
