//! Straightness compensation: while one axis moves, another is shifted (docs/fanuc.md §2.4, §2.5).
//!
//! ```text
//!   four-point   amounts at the moving axis' points a, b, c, d; straight between, held outside
//!   per-point    one increment for each pitch point of the moving axis, like pitch data
//! ```
//! Both are zero at the reference of the moving axis and count detection units of the
//! compensation axis. A set is known by its number s from 1; no axis owns its parameters.

use super::parameters::{Loading, Run, name};
use super::pitch::{Grid, lies_in, node_sums};
use crate::control::controller::{NumberRange, StraightnessForm};
use crate::quantity::Correction;
use crate::read::emulate::{Between, Emulated, NodeTable, cannot};

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
pub(super) fn load(from: Loading, runs: &mut Vec<Run>) -> Emulated<Vec<Shift>> {
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
        let touched = self.other_parameters().into_iter().any(|number| from.holds(number, None));
        if touched {
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
        let sign = self.from.facts.straightness_sign.value;
        sign.correction(units * unit_um)
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
            let what = format!("points {points:?} are not all in {first} to {last}");
            return self.refuse(what);
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
        if !lies_in(run, &facts.straightness_points.value) {
            return self.refuse(format!(
                "points {first} to {last} are not in one block of the control's points"
            ));
        }
        runs.push((format!("straightness set {}", self.index + 1), run));
        let increments = self.from.increments(first, grid.count())?;
        let sums = node_sums(&increments, grid.zero_node()).into_iter();
        let worth = |sum| self.correction(f64::from(magnification) * sum, unit_um);
        let nodes: Vec<Correction> = sums.map(worth).collect();
        let fraction = facts.output_fraction.value;
        grid.table(&nodes, Between::Step { fraction })
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
