//! Stored pitch error compensation of one axis (docs/fanuc.md §2.2, §2.3; B-63980EN/01 p. 100).
//!
//! ```text
//!   point          Nmin     …     N0      N0+1     …     Nmax
//!   section     |---------|-…-|---------|---------|-…-|---------|
//!   node      Nmin−1    Nmin  N0−1      N0      N0+1          Nmax
//!   S           …                       0                      …
//! ```
//! Point n is the section between node n−1 and node n; node N0 is the reference position. A value
//! is the step of the curve in its section, seen from − to +.

use super::parameters::{Loading, Run, name};
use crate::control::controller::{ControlUnit, IntervalForm, NumberRange};
use crate::control::table::fanuc::ParameterValue;
use crate::quantity::{Correction, Direction, Millimetres, power_of_ten};
use crate::read::emulate::{Between, CannotEmulate, Emulated, NodeTable, Response, cannot};

/// 3627 is a signed word (B-63530EN).
const REVERSAL_MAX: u32 = 32767;

/// Where the points of an axis lie.
pub(super) struct Grid {
    /// N0, the point of the reference position (3620).
    pub(super) reference_point: u32,
    /// Nmin and Nmax (3621, 3622).
    pub(super) points: NumberRange,
    /// L, mm (3624).
    interval: Millimetres,
    reference: Millimetres,
    /// Interpolated form (3605#1).
    interpolated: bool,
}

impl Grid {
    /// The grid of a controlled axis.
    pub(super) fn load(from: Loading, axis: u32) -> Emulated<Grid> {
        let stated = from.axis(axis)?;
        if from.memory.parameter(3625, Some(axis)).is_some_and(|travel| !travel.is_zero()) {
            return cannot(format!("axis {axis}: 3625 is not 0; rotary axes are not emulated"));
        }
        let [reference_point, first, last] = point_numbers(from, axis)?;
        let points = NumberRange { first, last };
        if !lies_in(points, &from.facts.pitch_points.value) {
            return cannot(format!(
                "axis {axis}: points {first} to {last} (3621, 3622) are not in one block of the control's points"
            ));
        }
        Ok(Grid {
            reference_point,
            points,
            interval: interval(from, axis)?,
            reference: stated.reference,
            interpolated: switch(from, axis, 1)?.unwrap_or(stated.interpolated),
        })
    }

    /// Number of points, Nmin and Nmax included.
    pub(super) fn count(&self) -> u32 {
        self.points.last - self.points.first + 1
    }

    /// Index of the reference among the nodes Nmin−1 … Nmax.
    pub(super) fn zero_node(&self) -> u32 {
        self.reference_point - self.points.first + 1
    }

    /// What happens between two nodes: one step, or pulses of the output axis' unit.
    pub(super) fn between(&self, from: Loading, pulse_um: f64) -> Between {
        if self.interpolated {
            Between::Pulses { pulse_um }
        } else {
            Between::Step { fraction: from.facts.output_fraction.value }
        }
    }

    /// A table with these corrections at the nodes Nmin−1 … Nmax.
    pub(super) fn table(&self, nodes: &[Correction], between: Between) -> Emulated<NodeTable> {
        let below = f64::from(self.zero_node()) * self.interval.mm();
        let start = self.reference - Millimetres::new(below);
        NodeTable::new(start, self.interval, nodes, between)
            .ok_or_else(|| CannotEmulate("the points do not make a table".to_string()))
    }
}

/// 3620, 3621, 3622 in the order that the control requires (docs/fanuc.md §2.1).
fn point_numbers(from: Loading, axis: u32) -> Emulated<[u32; 3]> {
    let read = |number| from.count(number, Some(axis), u32::MAX);
    let (reference, first, last) = (read(3620)?, read(3621)?, read(3622)?);
    if first <= reference && reference < last {
        return Ok([reference, first, last]);
    }
    cannot(format!(
        "axis {axis}: 3621 = {first}, 3620 = {reference}, 3622 = {last}, expected 3621 ≤ 3620 < 3622"
    ))
}

/// 3624 as a length: a real number in mm or inch, or a number of least input increments.
fn interval(from: Loading, axis: u32) -> Emulated<Millimetres> {
    let what = name(3624, Some(axis));
    let facts = from.facts;
    let length = match (facts.interval_form.value, from.memory.parameter(3624, Some(axis))) {
        (_, None) => {
            return cannot(format!(
                "{what} is missing; a parameter left out keeps its old content"
            ));
        }
        (IntervalForm::Real, Some(ParameterValue::Real(length))) => length,
        (IntervalForm::Real, Some(_)) => return cannot(format!("{what} has no decimal point")),
        (IntervalForm::Integer, Some(_)) => {
            let decimals = match from.state.unit {
                ControlUnit::Millimetre => facts.interval_decimals_mm.value,
                ControlUnit::Inch => facts.interval_decimals_inch.value,
            };
            let increments = f64::from(from.count(3624, Some(axis), u32::MAX)?);
            increments / power_of_ten(decimals)
        }
    };
    if length.is_finite() && length > 0.0 {
        return Ok(Millimetres::new(length * from.state.unit.in_mm()));
    }
    cannot(format!("{what} is {length}, expected an interval above 0"))
}

/// A bit of 3605, if the kit writes it.
fn switch(from: Loading, axis: u32, bit: u8) -> Emulated<Option<bool>> {
    let bits = from.bits(3605, Some(axis))?;
    Ok(bits.map(|bits| bits & (1 << bit) != 0))
}

/// Whether one of the control's blocks holds all points of a run.
pub(super) fn lies_in(run: NumberRange, blocks: &[NumberRange]) -> bool {
    blocks.iter().any(|block| block.contains(run.first) && block.contains(run.last))
}

/// Sums S of the increments at the nodes Nmin−1 … Nmax, zero at the node `zero_node`.
///
///   S(n) = Σ v(N0+1 … N0+n), n ≥ 0;  S(n) = −Σ v(N0+n+1 … N0), n < 0
///
/// unit   as the increments
/// source docs/fanuc.md §2.2; the figure of B-64303CM-1/01 §1.3.1 fits no other sign
pub(super) fn node_sums(increments: &[i32], zero_node: u32) -> Vec<f64> {
    let mut sum = 0.0;
    let mut sums = vec![sum];
    for value in increments {
        sum += f64::from(*value);
        sums.push(sum);
    }
    let place = usize::try_from(zero_node).ok();
    let at_reference = place.and_then(|index| sums.get(index)).copied();
    let at_reference = at_reference.unwrap_or(0.0);
    sums.iter().map(|sum| sum - at_reference).collect()
}

/// Pitch compensation of an axis in + and in −; magnification 0 gives none.
pub(super) fn load(
    from: Loading,
    axis: u32,
    runs: &mut Vec<Run>,
) -> Emulated<Option<[Response; 2]>> {
    let state = from.axis(axis)?;
    let magnification = from.count(3623, Some(axis), from.facts.magnification_max.value)?;
    if magnification == 0 {
        return Ok(None);
    }
    let pitch = Pitch {
        from,
        axis,
        grid: Grid::load(from, axis)?,
        unit_um: from.detection_unit_um(state)?,
        magnification: f64::from(magnification),
    };
    runs.push((format!("axis {axis}"), pitch.grid.points));
    let table = pitch.table(pitch.grid.points.first)?;
    let ways = |plus, minus| {
        [plus, minus].map(|table: NodeTable| Response::new(vec![table], Correction::ZERO))
    };
    if !switch(from, axis, 0)?.unwrap_or(state.bidirectional) {
        return Ok(Some(ways(table.clone(), table)));
    }
    let run = pitch.second_run()?;
    runs.push((format!("axis {axis}, travel in -"), run));
    let mut ways = ways(table, pitch.table(run.first)?);
    // 3627 belongs to the direction opposite to the reference return.
    let against_return = usize::from(state.reference_direction == Direction::Plus);
    ways[against_return].shift(pitch.reversal()?);
    Ok(Some(ways))
}

struct Pitch<'a> {
    from: Loading<'a>,
    axis: u32,
    grid: Grid,
    unit_um: f64,
    magnification: f64,
}

impl Pitch<'_> {
    /// The table whose values begin at point `first`.
    fn table(&self, first: u32) -> Emulated<NodeTable> {
        let increments = self.from.increments(first, self.grid.count())?;
        let sums = node_sums(&increments, self.grid.zero_node()).into_iter();
        let nodes: Vec<Correction> =
            sums.map(|sum| self.correction(self.magnification * sum)).collect();
        self.grid.table(&nodes, self.grid.between(self.from, self.unit_um))
    }

    fn correction(&self, units: f64) -> Correction {
        self.from.facts.pitch_sign.value.correction(units * self.unit_um)
    }

    /// Points of the table for travel in − (3626), as many as of the other one.
    fn second_run(&self) -> Emulated<NumberRange> {
        let first = self.from.count(3626, Some(self.axis), u32::MAX - self.grid.count())?;
        let last = first + self.grid.count() - 1;
        let run = NumberRange { first, last };
        if lies_in(run, &self.from.facts.minus_points.value) {
            return Ok(run);
        }
        cannot(format!(
            "axis {}: points {first} to {last} from 3626 on are not in one block of the control's points",
            self.axis
        ))
    }

    /// 3627: the value at the reference of the curve against the reference return.
    fn reversal(&self) -> Emulated<Correction> {
        let units = self.from.amount(3627, Some(self.axis), REVERSAL_MAX)?;
        let magnified = self.from.facts.reversal_magnified.value;
        let factor = if magnified { self.magnification } else { 1.0 };
        Ok(self.correction(units * factor))
    }
}
