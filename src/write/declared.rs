//! Tables of a control whose profile declares how they are written (docs/declared.md).
//!
//! * One table for each pair of axes: of an axis for itself with a column for each direction where the profile
//!   has two, of an axis that follows another with one.
//! * Values are rounded to the last decimal once; increments are differences of rounded values, so that rounding
//!   never adds up.

use crate::control::claims::Precondition;
use crate::control::controller::{
    BesideTable, ControlUnit, DeclaredFacts, Evidence, Mechanism, Order, Outside, RULE, ValueForm,
};
use crate::control::table::Tables;
use crate::control::table::declared::{DeclaredTable, DeclaredTables, Point, name};
use crate::inputs::job::Compensation;
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::units::{Deviation, UM_PER_MM, power_of_ten, rounded};
use crate::text::finding::Finding;
use crate::text::problem::Problems;
use crate::write::compiled::{
    Compiled, Placement, backlash_parameter, backlash_text, column, control_state, whole_below,
};
use crate::write::control_text::fixed;
use crate::write::family::{Emitted, Family, ProofOf};
use crate::write::findings::TableFinding;
use crate::write::grid::LengthDigit;
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};
use serde_json::{Value, json};

impl Family for DeclaredFacts {
    fn expected_name(&self, name: &str) -> Option<&'static str> {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let is_plain = !name.is_empty() && name.chars().all(plain);
        (!is_plain).then_some("letters, digits and `_`")
    }

    /// Positions are in the unit of the profile, whatever the control is in.
    fn length_digit(&self, _unit: ControlUnit) -> LengthDigit {
        match self.millimetre_decimals() {
            Some(decimals) => LengthDigit { unit: ControlUnit::Millimetre, decimals },
            None => LengthDigit { unit: ControlUnit::Inch, decimals: self.position_decimals.value },
        }
    }

    fn takes_directions(&self, term: ErrorTerm) -> bool {
        term.is_positioning() && self.has_two()
    }

    fn replaces_backlash(&self) -> bool {
        self.backlash.value == BesideTable::Replaced
    }

    fn budget(&self, _compensation: &Compensation) -> Option<TableStock> {
        TableStock::of_cross_terms(self.cross_terms.value)
    }

    fn point_limit(&self, _targets: &[&Target]) -> (u32, &'static str) {
        (self.points.value, "a table")
    }

    fn takes_points_beyond(&self) -> bool {
        self.points_beyond_travel.value
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        let backlash_um = |axis| match self.replaces_backlash() {
            true => 0.0,
            false => plan.backlash_um[axis].map_or(0.0, |um| backlash_text(um).1),
        };
        let state = control_state(task, plan, backlash_um);
        let all = |_: &PlannedTable| true;
        let cancels = |planned: &PlannedTable, way| {
            let replaced = self.replaces_backlash() && planned.term.is_positioning();
            let axis = plan.names[planned.term.of].first().and_then(|own| state.axis(own));
            column(plan, planned.term, axis.filter(|_| replaced), way)
        };
        let tables = self.tables(plan, all, cancels);
        self.check(task, &tables)?;
        self.check_ends(task, plan, cancels)?;
        let placed = plan.tables.iter();
        let placed = placed.map(|own| Placement::of(own, place(plan, own), self.count_um()));
        Ok(Compiled {
            placements: placed.collect(),
            preconditions: self.preconditions(task, plan),
            stale: Vec::new(),
            tables: Tables::Declared(DeclaredTables::of(tables)),
            state,
            assumptions: Vec::new(),
            notes: self.form().into_iter().map(Finding::from).collect(),
        })
    }

    fn uses(&self, mechanism: Mechanism, _plan: &Plan, tables: &Tables) -> bool {
        let Tables::Declared(own) = tables else {
            return true;
        };
        match mechanism {
            Mechanism::OwnTable => own.tables.iter().any(DeclaredTable::is_own),
            Mechanism::CrossTable => own.tables.iter().any(|table| !table.is_own()),
            _ => true,
        }
    }

    fn context(&self, emitted: &Emitted<'_>) -> Option<Value> {
        let own: &DeclaredTables = emitted.tables.own()?;
        Some(self.seen(emitted.task, &own.tables))
    }

    fn has(&self, mechanism: Mechanism) -> bool {
        mechanism != Mechanism::CrossTable || self.cross_terms.value > 0
    }

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        table.term.is_cross() == (mechanism == Mechanism::CrossTable)
    }

    /// What the control takes in one section of increments.
    fn section_limits(&self, _mechanism: Mechanism) -> Vec<Option<i64>> {
        let counts = self.largest_value.value * power_of_ten(self.value_decimals.value);
        let is_increment = self.value_form.value == ValueForm::Increment;
        vec![is_increment.then(|| whole_below(counts))]
    }

    fn cut_off_um(&self, _table: &PlannedTable) -> f64 {
        match self.value_form.value {
            ValueForm::Amount => self.largest_value.value * self.value_size.value.um,
            ValueForm::Position | ValueForm::Increment => f64::INFINITY,
        }
    }

    /// Both columns of the tables of the term have the bump.
    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let is_own = |planned: &PlannedTable| self.belongs(proof.mechanism, planned);
        let tables = self.tables(proof.plan, is_own, |planned, _| {
            proof.deviations(planned.term == proof.term, planned.values.len())
        });
        Some(Tables::Declared(DeclaredTables::of(tables)))
    }
}

impl DeclaredFacts {
    /// What is to be known of files whose form no manual states.
    fn form(&self) -> Option<TableFinding> {
        (self.lines.evidence == Evidence::Assumed).then(|| TableFinding::FormAssumed {
            source: self.lines.source.clone(),
            if_wrong: self.lines.consequence.clone().unwrap_or_default(),
        })
    }

    /// The last decimal of a value, µm.
    fn count_um(&self) -> f64 {
        self.value_size.value.um / power_of_ten(self.value_decimals.value)
    }

    /// Decimals of the numbers of a table.
    fn decimals(&self) -> u32 {
        let places = self.position_decimals.value;
        match self.value_form.value {
            ValueForm::Position => self.value_decimals.value.max(places),
            _ => self.value_decimals.value,
        }
    }

    /// The tables of some of a plan, one for each pair of axes, from what each column cancels.
    fn tables(
        &self,
        plan: &Plan,
        is_wanted: impl Fn(&PlannedTable) -> bool,
        cancels: impl Fn(&PlannedTable, Direction) -> Vec<Deviation>,
    ) -> Vec<DeclaredTable> {
        let mut tables: Vec<DeclaredTable> = Vec::new();
        for planned in plan.tables.iter().filter(|own| is_wanted(own)) {
            for output in &plan.names[planned.term.of] {
                let base = plan.base_of(planned.term, output);
                if tables.iter().any(|own| own.is_for(base, output)) {
                    continue; // of two directions the first wrote both columns
                }
                let ways = Direction::BOTH.map(|way| cancels(planned, way));
                tables.push(DeclaredTable {
                    base: base.to_string(),
                    output: output.clone(),
                    points: self.points(planned, ways),
                });
            }
        }
        tables
    }

    /// The points of a table in the order of the file; rounded here, once.
    fn points(&self, planned: &PlannedTable, ways: [Vec<Deviation>; 2]) -> Vec<Point> {
        let is_own = planned.term.is_positioning();
        let grid = &planned.grid;
        let place = |at: i64| self.place(grid.written(at));
        let places: Vec<f64> = (grid.first..=grid.last).map(place).collect();
        let [forward, reverse] = ways.map(|values| self.values(is_own, &places, &values));
        let has_two = is_own && self.has_two();
        let rows = places.iter().zip(forward).zip(reverse);
        let point = |((position, forward), reverse): ((&f64, f64), f64)| Point {
            position: *position,
            forward,
            reverse: has_two.then_some(reverse),
        };
        let mut points: Vec<Point> = rows.map(point).collect();
        if self.order.value == Order::Descending {
            points.reverse();
        }
        points
    }

    /// A place of a grid in the unit of the file.
    fn place(&self, written: f64) -> f64 {
        let unit_um = match self.is_inch() {
            true => self.position_size.value.um,
            false => UM_PER_MM,
        };
        let in_file = written * (unit_um / self.position_size.value.um);
        rounded(in_file, self.position_decimals.value) + 0.0
    }

    /// The numbers of a column that cancels deviations.
    fn values(&self, is_own: bool, places: &[f64], deviations: &[Deviation]) -> Vec<f64> {
        let sign = self.sign(is_own).value;
        let decimals = self.value_decimals.value;
        let mut before: Option<f64> = None;
        let value = |(place, deviation): (&f64, &Deviation)| {
            let um = sign.table_um(*deviation);
            let amount = rounded(um / self.value_size.value.um, decimals);
            let last = before.replace(amount).unwrap_or(amount);
            0.0 + match self.value_form.value {
                ValueForm::Amount => amount,
                ValueForm::Position => rounded(place + amount, self.decimals()),
                ValueForm::Increment => rounded(amount - last, decimals),
            }
        };
        places.iter().zip(deviations).map(value).collect()
    }

    /// What the control does not take, or does not say what it does with.
    fn check(&self, task: Task<'_>, tables: &[DeclaredTable]) -> Result<(), Problems> {
        let mut problems = Problems::none();
        let most = self.largest_value.value;
        for table in tables {
            let numbers =
                table.points.iter().flat_map(|point| [Some(point.forward), point.reverse]);
            let largest = numbers.flatten().fold(0.0_f64, |most, number| most.max(number.abs()));
            if largest > most {
                let largest = fixed(largest, self.decimals());
                let message = format!(
                    "the {} would hold {largest}, the control takes {most} at most",
                    table.name()
                );
                let problem = task.job.problem_at("compensation.axes", message);
                problems.push(
                    problem.help(
                        "`largest_value` of the profile; with increments use a smaller spacing",
                    ),
                );
            }
        }
        problems.or_ok(())
    }

    /// Tables that end inside the travel, where what the control adds outside is not known, or nothing and the value at
    /// the end is something.
    fn check_ends(
        &self,
        task: Task<'_>,
        plan: &Plan,
        cancels: impl Fn(&PlannedTable, Direction) -> Vec<Deviation>,
    ) -> Result<(), Problems> {
        let why = match self.outside.value {
            Outside::Hold => return Ok(()),
            Outside::Zero => {
                "this control adds nothing outside a table: the correction would jump at its end"
            }
            Outside::Unknown => "what this control adds outside a table is not known",
        };
        let mut axes: Vec<Axis> = Vec::new();
        for planned in &plan.tables {
            let axis = planned.term.along;
            let Some(machine) = task.job.machine.axes[axis] else {
                continue;
            };
            let (low, high) = planned.grid.range();
            let is_nothing = |end| {
                let mut ways = Direction::BOTH.iter().map(|way| cancels(planned, *way));
                self.outside.value == Outside::Zero && ways.all(|own| self.is_nothing(end, &own))
            };
            let is_short = low.mm() > machine.low.mm() + END_MM && !is_nothing(End::First)
                || high.mm() < machine.high.mm() - END_MM && !is_nothing(End::Last);
            if is_short && !axes.contains(&axis) {
                axes.push(axis);
            }
        }
        let mut problems = Problems::none();
        for axis in axes {
            let key = format!("compensation.axes.{}", axis.key());
            let message = format!("the table of axis {axis} ends inside the travel, and {why}");
            let problem = task.job.problem_at(&key, message);
            problems.push(
                problem.help("leave out `start_mm` and `end_mm`: the table then covers the travel"),
            );
        }
        problems.or_ok(())
    }

    /// Whether a column holds nothing at an end.
    fn is_nothing(&self, end: End, column: &[Deviation]) -> bool {
        let value = match end {
            End::First => column.first(),
            End::Last => column.last(),
        };
        let counts = value.map_or(0.0, |own| own.um() / self.count_um());
        rounded(counts, 0).abs() < 1.0
    }

    fn preconditions(&self, task: Task<'_>, plan: &Plan) -> Vec<Precondition> {
        let source = "the profile, fact `backlash`";
        let named = |um| backlash_text(um).0;
        let of_axis = |axis: Axis| {
            let what = format!("backlash parameter of {axis}");
            match self.replaces_backlash() {
                true => Precondition::new(
                    what,
                    "0",
                    "the table holds the whole reversal that is corrected; beside it the parameter does nothing, so its value cannot matter, and 0 is right too if it does",
                    source,
                ),
                false => backlash_parameter(task, plan, axis, what, named, source),
            }
        };
        let has_table = |axis: &Axis| plan.of_axis(*axis).next().is_some();
        let is_set = |axis: &Axis| match self.replaces_backlash() {
            true => has_table(axis),
            false => plan.backlash_um[*axis].is_some() || plan.has_two_tables(*axis),
        };
        let axes = Axis::ALL.into_iter().filter(is_set);
        let reference = Precondition::new(
            "reference points",
            task.reference_text(),
            "the tables are zero there; if they are elsewhere, switching the tables on moves axes",
            RULE,
        )
        .dangerous();
        axes.map(of_axis).chain([reference]).collect()
    }

    /// What templates see.
    fn seen(&self, task: Task<'_>, tables: &[DeclaredTable]) -> Value {
        let listed = |is_own: bool| {
            let own = tables.iter().filter(|table| table.is_own() == is_own);
            own.map(|table| self.seen_table(table)).collect::<Vec<Value>>()
        };
        let mut axes: Vec<&str> = Vec::new();
        for table in tables {
            if !axes.contains(&table.output.as_str()) {
                axes.push(&table.output);
            }
        }
        let axis = |name: &&str| {
            let of_axis = |is_own: bool| {
                let own = tables.iter().filter(|own| own.output == *name && own.is_own() == is_own);
                own.map(|table| self.seen_table(table)).collect::<Vec<Value>>()
            };
            json!({ "name": name, "own": of_axis(true), "cross": of_axis(false) })
        };
        let sense = |is_own: bool| self.sign(is_own).value.words();
        let evidence = |is_own: bool| self.sign(is_own).evidence.of_sense();
        json!({
            "tables": tables.iter().map(|table| self.seen_table(table)).collect::<Vec<Value>>(),
            "own": listed(true),
            "cross": listed(false),
            "axes": axes.iter().map(axis).collect::<Vec<Value>>(),
            "own_sense": sense(true),
            "own_sense_evidence": evidence(true),
            "cross_sense": sense(false),
            "cross_sense_evidence": evidence(false),
            "controller_reference": task.reference_text(),
        })
    }

    fn seen_table(&self, table: &DeclaredTable) -> Value {
        let position = |number: f64| fixed(number, self.position_decimals.value);
        let value = |number: f64| fixed(number, self.decimals());
        let first = self.first_point.value as usize;
        let point = |(index, point): (usize, &Point)| {
            json!({
                "number": (first + index).to_string(),
                "padded": format!("{:03}", first + index),
                "position": position(point.position),
                "value": value(point.forward),
                "forward": value(point.forward),
                "reverse": value(point.reverse.unwrap_or(point.forward)),
            })
        };
        let places: Vec<f64> = table.points.iter().map(|point| point.position).collect();
        let spacing = places.get(1).zip(places.first()).map_or(0.0, |(b, a)| b - a);
        let end = |place: Option<&f64>| place.map_or(String::new(), |place| position(*place));
        json!({
            "base": table.base,
            "output": table.output,
            "start": end(places.first()),
            "end": end(places.last()),
            "spacing": position(spacing),
            "count": places.len().to_string(),
            "last": (first + places.len().saturating_sub(1)).to_string(),
            "points": table.points.iter().enumerate().map(point).collect::<Vec<Value>>(),
        })
    }
}

/// An end of a table.
#[derive(Clone, Copy)]
enum End {
    First,
    Last,
}

/// A table may end short of the travel by this much (rounding of positions), mm.
const END_MM: f64 = 1e-3;

/// `table of X`, or `table of Y by X`; with `moving up` or `moving down` one column of it.
fn place(plan: &Plan, planned: &PlannedTable) -> String {
    let names = plan.names[planned.term.of].iter();
    let names = names.map(|output| name(plan.base_of(planned.term, output), output));
    let column = match planned.direction {
        None => "",
        Some(Direction::Plus) => " moving in +",
        Some(Direction::Minus) => " moving in -",
    };
    names.collect::<Vec<String>>().join(", ") + column
}
