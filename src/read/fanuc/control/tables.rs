//! Tables of points: stored pitch error compensation of one axis, and straightness compensation of another (docs/fanuc.md §2.2, §2.3; B-63980EN/01 p. 100).
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
use crate::control::controller::{IntervalForm, NumberRange, StraightnessForm};
use crate::control::table::fanuc::ParameterValue;
use crate::quantity::{Correction, Direction, Millimetres, power_of_ten};
use crate::read::emulate::{Between, CannotEmulate, Emulated, NodeTable, Response, cannot};

/// 3627 is a signed word (B-63530EN).
const REVERSAL_MAX: u32 = 32767;

/// Where the points of an axis lie.
struct Grid {
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
    fn load(from: Loading, axis: u32) -> Emulated<Grid> {
        let stated = from.axis(axis)?;
        if from.memory.parameter(3625, Some(axis)).is_some_and(|travel| !travel.is_zero()) {
            return cannot(format!("axis {axis}: 3625 is not 0; rotary axes are not emulated"));
        }
        let [reference_point, first, last] = point_numbers(from, axis)?;
        let points = NumberRange { first, last };
        if !points.lies_in(&from.facts.pitch_points.value) {
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
        NodeTable::new(self.reference - Millimetres::new(below), self.interval, nodes, between)
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
            let decimals = facts.interval_decimals(from.state.unit);
            f64::from(from.count(3624, Some(axis), u32::MAX)?) / power_of_ten(decimals)
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

/// Sums S of the increments at the nodes Nmin−1 … Nmax, zero at the node `zero_node`.
///
///   S(n) = Σ v(N0+1 … N0+n), n ≥ 0;  S(n) = −Σ v(N0+n+1 … N0), n < 0
///
/// unit   as the increments
/// source docs/fanuc.md §2.2; the figure of B-64303CM-1/01 §1.3.1 fits no other sign
fn node_sums(increments: &[i32], zero_node: u32) -> Vec<f64> {
    let mut sum = 0.0;
    let mut sums = vec![sum];
    for value in increments {
        sum += f64::from(*value);
        sums.push(sum);
    }
    let place = usize::try_from(zero_node).ok();
    let at_reference = place.and_then(|index| sums.get(index)).copied().unwrap_or(0.0);
    sums.iter().map(|sum| sum - at_reference).collect()
}

/// Pitch compensation of an axis in + and in −; magnification 0 gives none.
pub(super) fn load_pitch(
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
        if run.lies_in(&self.from.facts.minus_points.value) {
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
        let is_magnified = self.from.facts.reversal_magnified.value;
        Ok(self.correction(units * if is_magnified { self.magnification } else { 1.0 }))
    }
}

// Straightness compensation: while one axis moves, another is shifted (docs/fanuc.md §2.4, §2.5).
//
// ```text
//   four-point   amounts at the moving axis' points a, b, c, d; straight between, held outside
//   per-point    one increment for each pitch point of the moving axis, like pitch data
// ```
// Both are zero at the reference of the moving axis and count detection units of the
// compensation axis. A set is known by its number s from 1; no axis owns its parameters.

/// Sets that the numbers leave room for: 5731 + 10·(s − 1) reaches the amounts at s = 4, and
/// 5711 + s − 1 ends at 5720.
const FOUR_POINT_SETS: u32 = 3;
const PER_POINT_SETS: u32 = 10;
const FIRST_MOVING: u32 = 5711;
const FIRST_COMPENSATION: u32 = 5721;
const FIRST_POINTS: u32 = 5731;
const FIRST_AMOUNTS: u32 = 5761;

/// What one set does: controlled-axis numbers of the moving axis and of the shifted one, correction over the former.
type Shift = ([u32; 2], NodeTable);

/// The sets in use; the runs of points they look at are noted.
pub(super) fn load_straightness(from: Loading, runs: &mut Vec<Run>) -> Emulated<Vec<Shift>> {
    let sets = from.facts.straightness_sets.value;
    let room = match from.facts.straightness_form.value {
        StraightnessForm::FourPoint => FOUR_POINT_SETS,
        StraightnessForm::PerPoint => PER_POINT_SETS,
    };
    if sets > room {
        return cannot(format!("{sets} straightness sets; the parameters have room for {room}"));
    }
    for number in FIRST_MOVING + sets..FIRST_MOVING + PER_POINT_SETS {
        if from.holds(number, None) && from.integer(number, None)? != 0 {
            return cannot(format!(
                "{} is set, but the control has {sets} sets",
                name(number, None)
            ));
        }
    }
    let mut shifts = Vec::new();
    for index in 0..sets {
        shifts.extend(Set { from, index }.load(runs)?);
    }
    Ok(shifts)
}

#[derive(Clone, Copy)]
struct Set<'a> {
    from: Loading<'a>,
    /// s − 1.
    index: u32,
}

impl Set<'_> {
    fn load(self, runs: &mut Vec<Run>) -> Emulated<Option<Shift>> {
        if self.is_unused()? {
            return Ok(None);
        }
        let moving = self.axis_number(FIRST_MOVING)?;
        let compensation = self.axis_number(FIRST_COMPENSATION)?;
        if moving == compensation {
            return self.refuse(format!("axis {moving} is both moving and compensation axis"));
        }
        let grid = Grid::load(self.from, moving)?;
        let most = self.from.facts.straightness_axis_points.value;
        if grid.count() > most {
            let count = grid.count();
            return self.refuse(format!(
                "moving axis {moving} has {count} points, at most {most} are allowed"
            ));
        }
        let unit_um = self.from.detection_unit_um(self.from.axis(compensation)?)?;
        let table = match self.from.facts.straightness_form.value {
            StraightnessForm::FourPoint => self.four_points(&grid, unit_um)?,
            StraightnessForm::PerPoint => self.per_point(&grid, unit_um, runs)?,
        };
        Ok(Some(([moving, compensation], table)))
    }

    /// Moving axis 0, per-point magnification 0, or a set that the kit does not touch at all.
    fn is_unused(self) -> Emulated<bool> {
        let from = self.from;
        let per_point = from.facts.straightness_form.value == StraightnessForm::PerPoint;
        let magnification = self.magnification_parameter();
        if per_point && from.holds(magnification, None) && from.integer(magnification, None)? == 0 {
            return Ok(true);
        }
        let moving = FIRST_MOVING + self.index;
        if from.holds(moving, None) {
            return Ok(from.integer(moving, None)? == 0);
        }
        if self.other_parameters().into_iter().any(|number| from.holds(number, None)) {
            return self.refuse(format!("{} is missing", name(moving, None)));
        }
        Ok(true)
    }

    fn other_parameters(self) -> Vec<u32> {
        let mut numbers = vec![FIRST_COMPENSATION + self.index];
        match self.from.facts.straightness_form.value {
            StraightnessForm::FourPoint => numbers.extend((0..4).flat_map(|knot| {
                [FIRST_POINTS, FIRST_AMOUNTS].map(|first| first + 10 * self.index + knot)
            })),
            StraightnessForm::PerPoint => {
                numbers.extend([self.magnification_parameter(), self.start_parameter()]);
            }
        }
        numbers
    }

    fn magnification_parameter(self) -> u32 {
        self.from.facts.straightness_magnification_parameter.value + self.index
    }

    fn start_parameter(self) -> u32 {
        self.from.facts.straightness_start_parameter.value + self.index
    }

    fn axis_number(self, first: u32) -> Emulated<u32> {
        let number = first + self.index;
        match self.from.count(number, None, u32::MAX)? {
            0 => self.refuse(format!("{} is 0", name(number, None))),
            axis => Ok(axis),
        }
    }

    fn refuse<T>(self, words: String) -> Emulated<T> {
        cannot(format!("straightness set {}: {words}", self.index + 1))
    }

    fn correction(self, units: f64, unit_um: f64) -> Correction {
        self.from.facts.straightness_sign.value.correction(units * unit_um)
    }

    /// Rounded to whole units at every point, relative to the reference (docs/fanuc.md §2.4).
    fn four_points(self, grid: &Grid, unit_um: f64) -> Emulated<NodeTable> {
        let knots = self.knots(grid)?;
        let at_reference = amount_at(&knots, f64::from(grid.reference_point));
        let first_node = f64::from(grid.points.first) - 1.0;
        let nodes: Vec<Correction> = (0..=grid.count())
            .map(|node| amount_at(&knots, first_node + f64::from(node)) - at_reference)
            .map(|units| self.correction(units.round(), unit_um)) // half away from zero
            .collect();
        grid.table(&nodes, grid.between(self.from, unit_um))
    }

    /// Points a, b, c, d with their amounts.
    fn knots(self, grid: &Grid) -> Emulated<[Knot; 4]> {
        let limit = self.from.facts.straightness_amount_max.value;
        let mut knots = [Knot { point: 0, amount: 0.0 }; 4];
        for (offset, knot) in (10 * self.index..).zip(&mut knots) {
            knot.point = self.from.count(FIRST_POINTS + offset, None, u32::MAX)?;
            knot.amount = self.from.amount(FIRST_AMOUNTS + offset, None, limit)?;
        }
        let points = knots.map(|knot| knot.point);
        if !points.is_sorted() {
            return self.refuse(format!("points {points:?} do not ascend"));
        }
        if !points.iter().all(|point| grid.points.contains(*point)) {
            let NumberRange { first, last } = grid.points;
            return self.refuse(format!("points {points:?} are not all in {first} to {last}"));
        }
        let jump = |pair: &[Knot]| {
            pair[0].point == pair[1].point && (pair[0].amount - pair[1].amount).abs() > 0.0
        };
        if knots.windows(2).any(jump) {
            return self.refuse(format!("one of the points {points:?} has two amounts"));
        }
        Ok(knots)
    }

    /// One increment for each pitch point of the moving axis (docs/fanuc.md §2.5). Its interpolated
    /// form is a function of its own whose switch is not known, so the step form is taken.
    fn per_point(self, grid: &Grid, unit_um: f64, runs: &mut Vec<Run>) -> Emulated<NodeTable> {
        let facts = self.from.facts;
        let magnification =
            self.from.count(self.magnification_parameter(), None, facts.magnification_max.value)?;
        let first = self.from.count(self.start_parameter(), None, u32::MAX - grid.count())?;
        let last = first + grid.count() - 1;
        let run = NumberRange { first, last };
        if !run.lies_in(&facts.straightness_points.value) {
            return self.refuse(format!(
                "points {first} to {last} are not in one block of the control's points"
            ));
        }
        runs.push((format!("straightness set {}", self.index + 1), run));
        let increments = self.from.increments(first, grid.count())?;
        let sums = node_sums(&increments, grid.zero_node()).into_iter();
        let worth = |sum| self.correction(f64::from(magnification) * sum, unit_um);
        let nodes: Vec<Correction> = sums.map(worth).collect();
        grid.table(&nodes, Between::Step { fraction: facts.output_fraction.value })
    }
}

/// A point number of the moving axis and the amount there, detection units.
#[derive(Clone, Copy)]
struct Knot {
    point: u32,
    amount: f64,
}

/// W(p): straight lines through the knots, the end values held outside.
///
/// source B-63522EN/02 §15.5; its slope (β−α)/(a−b) is a misprint for (β−α)/(b−a)
///        (docs/fanuc.md §2.4)
fn amount_at(knots: &[Knot; 4], point: f64) -> f64 {
    let [first, .., last] = knots;
    if point <= f64::from(first.point) {
        return first.amount;
    }
    for pair in knots.windows(2) {
        let (a, b) = (f64::from(pair[0].point), f64::from(pair[1].point));
        if a < point && point <= b {
            // The product first: halves stay exact, so rounding of ties is the reference's.
            return pair[0].amount + (pair[1].amount - pair[0].amount) * (point - a) / (b - a);
        }
    }
    last.amount
}
