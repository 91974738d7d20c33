//! Pitch data of each axis and straightness sets: a moving axis shifts another one.
//!
//! ```text
//!   point number   Nmin … N0 │ N0+1 … Nmax          point n is the section from node n−1 to n
//!   node (index)       … −1  0   1   …              node 0 is the reference point, N0 in 3620
//!   data(n) = total(n) − total(n−1),  total = round(correction / count),  total(0) = 0
//! ```
//! Each increment is a difference of rounded **totals**, so rounding never adds up and no node is
//! off by more than half a count (count = magnification × detection unit). N0 and N0+1 are
//! always in the table, zero where there is no travel, so 3621 ≤ 3620 < 3622.

use crate::control::controller::{FanucFacts, IntervalForm, TableSign};
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::inputs::job::AxisSettings;
use crate::quantity::{Axis, Direction};
use crate::text::{Finding, Problem, Problems};
use crate::write::family::Placement;
use crate::write::fanuc::four_point::best_fit;
use crate::write::fanuc::numbers::{Run, Space, is_four_point};
use crate::write::findings::TableFinding;
use crate::write::grid::{Grid, as_number, whole};
use crate::write::refusals;
use crate::write::task::{Plan, PlannedTable, Task, axis_key};

/// What is written so far, and what it is made from.
pub(super) struct Writer<'a> {
    pub(super) task: Task<'a>,
    pub(super) plan: &'a Plan,
    pub(super) facts: &'a FanucFacts,
    pub(super) space: Space,
    pub(super) memory: FanucMemory,
    pub(super) placements: Vec<Placement>,
    pub(super) notes: Vec<Finding>,
    pub(super) problems: Problems,
}

/// One set: a planned table on one physical output axis.
struct Set<'a> {
    number: u32,
    planned: &'a PlannedTable,
    run: &'a Run,
    output: u32,
    unit_um: f64,
}

/// Parameter 3627 is a signed word; parameter manual B-63530EN, from memory.
const LARGEST_REVERSAL: i64 = 32767;

impl<'a> Writer<'a> {
    /// Detection unit of an axis, µm; the plan has checked that it is stated.
    fn unit_um(&self, axis: Axis) -> f64 {
        self.task.detection_unit_um(axis).unwrap_or(f64::NAN)
    }

    /// Notes where a planned table went; a second physical axis of a gantry joins the first.
    fn place(&mut self, points: u32, placement: Placement) {
        let is_known =
            |p: &&mut Placement| (p.term, p.direction) == (placement.term, placement.direction);
        match self.placements.iter_mut().find(is_known) {
            Some(known) => known.place = format!("{}; {}", known.place, placement.place),
            None => self.placements.push(Placement { points: points as usize, ..placement }),
        }
    }

    fn refuse(&mut self, path: &str, wrong: Problem) {
        self.problems.push(self.task.job.source.at(path, wrong));
    }

    fn refuse_steep(&mut self, planned: &PlannedTable, unit_um: f64) {
        let (increment, magnification) =
            (self.facts.increment_max.value, self.facts.magnification_max.value);
        let most = f64::from(increment) * f64::from(magnification) * unit_um;
        let (term, change) = (planned.term, steepest(planned));
        let wrong = refusals::steep(term, change, increment, magnification, unit_um, most);
        self.refuse(&axis_key(term.along, ""), wrong);
    }

    /// Pitch parameters and data of one physical axis.
    pub(super) fn pitch(&mut self, run: &Run) {
        let tables: Vec<&PlannedTable> = self.plan.of_axis(run.axis).collect();
        let unit_um = self.unit_um(run.axis);
        let machine = self.task.job.machine.axes[run.axis];
        let homing = machine.map_or(Direction::Plus, |axis| axis.homing());
        let carries_reversal =
            |planned: &PlannedTable| planned.direction.is_some_and(|own| own != homing);
        let Some((magnification, reversal, totals)) =
            magnify(self.facts, self.facts.pitch_sign.value, &tables, carries_reversal, unit_um)
        else {
            let steepest = tables.iter().max_by(|a, b| steepest(a).total_cmp(&steepest(b)));
            if let Some(planned) = steepest {
                self.refuse_steep(planned, unit_um);
            }
            return;
        };
        if reversal.abs() > LARGEST_REVERSAL {
            let wrong = refusals::large_reversal(run.axis, reversal, unit_um, LARGEST_REVERSAL);
            return self.refuse(&axis_key(run.axis, ".detection_unit_um"), wrong);
        }
        self.pitch_parameters(run, magnification);
        let acts_in = |direction: Direction| {
            let acts = |t: &&PlannedTable| t.direction.is_none_or(|own| own == direction);
            Some(&totals[tables.iter().position(acts)?])
        };
        points(&mut self.memory, run.first, run, acts_in(Direction::Plus));
        if let Some(second) = run.minus_first {
            self.memory.set(3626, Some(run.id), second);
            self.memory.set(3627, Some(run.id), reversal);
            points(&mut self.memory, second, run, acts_in(Direction::Minus));
        }
        self.place_pitch(&tables, run, unit_um * f64::from(magnification));
    }

    fn pitch_parameters(&mut self, run: &Run, magnification: u32) {
        let id = Some(run.id);
        self.memory.set(3620, id, run.point(0));
        self.memory.set(3621, id, run.first);
        self.memory.set(3622, id, run.last());
        self.memory.set(3623, id, magnification);
        let interval = match self.facts.interval_form.value {
            IntervalForm::Integer => ParameterValue::Integer(run.grid.spacing_digits),
            IntervalForm::Real => ParameterValue::Real(run.grid.written_spacing()),
        };
        let own = |number| ParameterKey { number, axis: id };
        self.memory.parameters.insert(own(3624), interval);
        let settings = self.task.settings(run.axis);
        if let Some(found) = settings.and_then(|s| s.parameter_3605) {
            let interpolated = settings.is_some_and(AxisSettings::is_interpolated);
            let directed = u8::from(run.minus_first.is_some());
            let bits = (found & !0b11) | directed | (u8::from(interpolated) << 1);
            self.memory.parameters.insert(own(3605), ParameterValue::Bits(bits));
        }
    }

    fn place_pitch(&mut self, tables: &[&PlannedTable], run: &Run, count_um: f64) {
        if tables.is_empty() {
            let (axis, id) = (run.axis, run.id);
            self.notes.push(TableFinding::ZeroPoints { axis, id }.into());
        }
        for planned in tables {
            let first = match planned.direction {
                Some(Direction::Minus) => run.minus_first.unwrap_or(run.first),
                _ => run.first,
            };
            let place = format!("axis {}: points {first}…{}", run.id, first + run.count - 1);
            self.place(run.count, Placement::of(planned, place, count_um));
        }
    }

    /// Parameters and data of all straightness sets, from the first free set on.
    pub(super) fn straightness(&mut self, runs: &[Run]) {
        let mut number = self.task.job.compensation.first_set.unwrap_or(1);
        let plan = self.plan;
        for planned in plan.tables.iter().filter(|t| t.term.is_cross()) {
            let Some(run) = runs.iter().find(|run| run.axis == planned.term.along) else {
                continue;
            };
            for output in &plan.names[planned.term.of] {
                let set = Set {
                    number,
                    planned,
                    run,
                    output: output.parse().unwrap_or(0),
                    unit_um: self.unit_um(planned.term.of),
                };
                self.memory.set(5710 + number, None, run.id);
                self.memory.set(5720 + number, None, set.output);
                if is_four_point(self.facts) {
                    self.four_points(&set);
                } else {
                    self.per_point(&set);
                }
                number += 1;
            }
        }
    }

    fn per_point(&mut self, set: &Set<'_>) {
        let facts = self.facts;
        let Some((magnification, _, totals)) =
            magnify(facts, facts.straightness_sign.value, &[set.planned], |_| false, set.unit_um)
        else {
            return self.refuse_steep(set.planned, set.unit_um);
        };
        let Some(first) = self.block(set) else {
            let wrong = refusals::no_room_for_data(set.run.count, set.planned.term);
            return self.refuse("compensation", wrong);
        };
        let of_set = |first: u32| first + set.number - 1;
        self.memory.set(
            of_set(facts.straightness_magnification_parameter.value),
            None,
            magnification,
        );
        self.memory.set(of_set(facts.straightness_start_parameter.value), None, first);
        points(&mut self.memory, first, set.run, totals.first());
        let last = first + set.run.count - 1;
        let place = format!("{}, data {first}…{last}", set.words());
        let count_um = set.unit_um * f64::from(magnification);
        self.place(set.run.count, Placement::of(set.planned, place, count_um));
    }

    /// The block of the set (each set has one of `straightness_axis_points` numbers), or the first
    /// free one.
    fn block(&mut self, set: &Set<'_>) -> Option<u32> {
        let blocks = &self.facts.straightness_points.value;
        let room = self.facts.straightness_axis_points.value;
        let own = blocks.first()?.first + room * (set.number - 1);
        self.space
            .take_at(blocks, own, set.run.count)
            .or_else(|| self.space.take(blocks, set.run.count))
    }

    fn four_points(&mut self, set: &Set<'_>) {
        let sign = self.facts.straightness_sign.value;
        let units = set.planned.values.iter().map(|value| sign.table_um(*value) / set.unit_um);
        let units: Vec<f64> = units.collect();
        let grid = &set.run.grid;
        let most = self.facts.straightness_amount_max.value;
        let Some(fit) = best_fit(&units, grid.reference_node(), most) else {
            return self.refuse("limits", refusals::large_amount(set.planned.term, most));
        };
        let group = 10 * (set.number - 1);
        for (index, (node, amount)) in (0..).zip(fit.nodes.iter().zip(fit.amounts)) {
            let node = grid.first + i64::try_from(*node).unwrap_or(0);
            self.memory.set(5731 + group + index, None, set.run.point(node));
            self.memory.set(5761 + group + index, None, amount);
        }
        let place = format!("{}, four points", set.words());
        let placement = Placement {
            fit_residual_um: Some(fit.residual * set.unit_um),
            ..Placement::of(set.planned, place, set.unit_um)
        };
        self.place(4, placement);
    }
}

impl Set<'_> {
    fn words(&self) -> String {
        format!("set {}: axis {} by {}", self.number, self.output, self.run.id)
    }
}

/// All points of a run; zero where nothing is compensated.
pub(super) fn points(memory: &mut FanucMemory, first: u32, run: &Run, totals: Option<&Totals>) {
    for offset in 0..run.count {
        let increment = totals.map_or(0, |t| t.increment(run.lowest + i64::from(offset)));
        memory.points.insert(first + offset, i32::try_from(increment).unwrap_or(0));
    }
}

/// The smallest magnification with which every increment of these tables is legal, and the totals with it.
///
/// Returns the detection units of 3627 as well: the value at the reference of the table that carries the reversal.
fn magnify(
    facts: &FanucFacts,
    sign: TableSign,
    tables: &[&PlannedTable],
    carries_reversal: impl Fn(&PlannedTable) -> bool,
    unit_um: f64,
) -> Option<(u32, i64, Vec<Totals>)> {
    let steepest = tables.iter().map(|planned| steepest(planned));
    let legal = i64::from(facts.increment_max.value);
    // Rounding of two totals can add or save one count, so the search begins a little below.
    let per_count = unit_um * as_number(legal + 1);
    let least = whole((steepest.fold(0.0, f64::max) / per_count).floor()).max(1);
    let least = u32::try_from(least).unwrap_or(u32::MAX);
    (least..=facts.magnification_max.value).find_map(|magnification| {
        let count_um = unit_um * f64::from(magnification);
        let step_um = if facts.reversal_magnified.value { count_um } else { unit_um };
        let mut reversal = 0.0;
        let totals = tables.iter().map(|planned| {
            let at_reference = planned.values[planned.grid.reference_node()];
            let carried = f64::from(carries_reversal(planned));
            let units = carried * (sign.table_um(at_reference) / step_um).round();
            reversal += units;
            Totals::round(planned, sign, units * step_um, count_um)
        });
        let totals: Vec<Totals> = totals.collect();
        let fits = totals.iter().all(|t| t.largest_increment() <= legal);
        fits.then(|| (magnification, whole(reversal), totals))
    })
}

/// Largest change between two points, µm; of either sense of the table.
fn steepest(planned: &PlannedTable) -> f64 {
    planned.values.windows(2).map(|pair| (pair[1] - pair[0]).um().abs()).fold(0.0, f64::max)
}

/// Totals at the nodes of a grid in counts.
pub(super) struct Totals {
    pub(super) grid: Grid,
    pub(super) counts: Vec<i64>,
}

impl Totals {
    /// What the table is to stand for at each node; `zero_um`: what is already there at the reference
    /// (parameter 3627).
    fn round(planned: &PlannedTable, sign: TableSign, zero_um: f64, count_um: f64) -> Totals {
        let (grid, values) = (planned.grid, planned.values.iter());
        let counts = values.map(|value| ((sign.table_um(*value) - zero_um) / count_um).round());
        let mut counts: Vec<i64> = counts.map(whole).collect();
        counts[grid.reference_node()] = 0;
        Totals { grid, counts }
    }

    /// The increment of the section that ends at a node; zero outside the grid.
    fn increment(&self, node: i64) -> i64 {
        if node <= self.grid.first || node > self.grid.last {
            return 0;
        }
        let at = |node: i64| self.counts[usize::try_from(node - self.grid.first).unwrap_or(0)];
        at(node) - at(node - 1)
    }

    fn largest_increment(&self) -> i64 {
        self.counts.windows(2).map(|pair| (pair[1] - pair[0]).abs()).max().unwrap_or(0)
    }
}
