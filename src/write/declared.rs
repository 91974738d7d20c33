//! Tables of a control whose profile declares how they are written (docs/own-control.md).
//!
//! How a plan becomes numbers stands in [`listed`].

mod typed;

use crate::control::claims::Precondition;
use crate::control::control_state::ControlState;
use crate::control::controller::{
    ControlUnit, DeclaredFacts, Evidence, Factor, Mechanism, Pattern, PointLists, RULE, ValueForm,
};
use crate::control::table::{ListedTable, ListedTables, Point, Tables, name};
use crate::inputs::job::Compensation;
use crate::quantity::{
    Axis, Deviation, Direction, ErrorTerm, Millimetres, Nodes, UM_PER_MM, power_of_ten, residual,
    rounded,
};
use crate::text::{Problems, joined};
use crate::write::control_text::{Seen, fixed, seen, with};
use crate::write::family::{
    Compiled, Family, FileSource, Placement, ProofOf, backlash_parameter, backlash_text,
    control_state, whole_below,
};
use crate::write::findings::TableFinding;
use crate::write::grid::LengthDigit;
use crate::write::listed;
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};

impl Family for DeclaredFacts {
    fn expected_name(&self, axis: Axis, name: &str) -> Option<&'static str> {
        if self.factors.is_some() {
            return (axis.key() != name).then(|| axis.key());
        }
        if self.typed.is_some() {
            return None;
        }
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if name.is_empty() || !name.chars().all(plain) {
            return Some("letters, digits and `_`");
        }
        let takes = |all: &[Pattern]| {
            let mut own = all.iter().filter_map(|pattern| pattern.takes_axis(name)).peekable();
            own.peek().is_none() || own.any(|is_taken| is_taken)
        };
        let is_taken = takes(&self.lines.value) && takes(&self.file_name.value);
        (!is_taken).then_some("one that the patterns of its profile take")
    }

    /// A factor has the names of its axes in its own, and the generic table reaches no axis.
    fn names_reach_axes(&self) -> bool {
        self.factors.is_none() && self.typed.is_none()
    }

    fn refuses(&self, term: ErrorTerm) -> Option<String> {
        let mut factors = self.factors.as_ref()?.value.iter();
        let why = match &self.no_factor {
            _ if term.is_positioning() => "a skew correction holds squareness alone",
            Some(why) => &why.value,
            None => "no factor of this control takes it; a squareness in this slope stays",
        };
        (!factors.any(|own| own.term == term)).then(|| why.to_string())
    }

    /// Positions are in the unit of the profile, whatever the control is in.
    fn length_digit(&self, _unit: ControlUnit) -> LengthDigit {
        match self.millimetre_decimals() {
            Some(decimals) => LengthDigit { unit: ControlUnit::Millimetre, decimals },
            None => LengthDigit { unit: ControlUnit::Inch, decimals: self.position_decimals.value },
        }
    }

    fn takes_directions(&self, term: ErrorTerm) -> bool {
        match &self.typed {
            Some(typed) => typed.takes_directions(),
            None => term.is_positioning() && self.has_two(),
        }
    }

    fn replaces_backlash(&self) -> bool {
        self.replaces_parameter()
    }

    fn budget(&self, _compensation: &Compensation) -> Option<TableStock> {
        TableStock::of_cross_terms(self.cross_terms.value)
    }

    fn point_limit(&self, _targets: &[&Target]) -> (u32, &'static str) {
        if self.factors.is_some() { (u32::MAX, "a factor") } else { (self.points.value, "a table") }
    }

    fn takes_points_beyond(&self) -> bool {
        self.points_beyond_travel.value
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        let mut compiled = match self.factors.is_some() {
            true => self.compile_factors(task, plan),
            false => Compiled {
                preconditions: self.preconditions(task, plan),
                ..listed::compile(self, task, plan, |own| self.place(plan, own))?
            },
        };
        if self.lines.evidence == Evidence::Assumed {
            let source = self.lines.source.clone();
            let if_wrong = self.lines.consequence.clone().unwrap_or_default();
            compiled.notes.push(TableFinding::FormAssumed { source, if_wrong }.into());
        }
        Ok(compiled)
    }

    fn context(&self, emitted: &FileSource<'_>) -> Seen {
        let own: &ListedTables = emitted.tables.own();
        let seen = match &self.typed {
            Some(typed) => typed::of_tables(typed, emitted, own),
            None => self.seen(emitted.task, &own.tables),
        };
        match &own.set {
            Some(set) => with(seen, "set", set.as_str().into()),
            None => seen,
        }
    }

    fn displayed(&self, tables: &Tables, _state: &ControlState) -> Vec<String> {
        const SHOWN: u32 = 6; // decimals
        let Some(form) = &self.shown else {
            return Vec::new();
        };
        let shown = |own: &Factor| {
            let axes = form.value.replace("{of}", &own.term.of.to_string());
            let axes = axes.replace("{by}", &own.term.along.to_string());
            axes.replace("{value}", &fixed(number(tables.own(), own), SHOWN))
        };
        self.factors().iter().map(shown).collect()
    }

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        match mechanism {
            Mechanism::OwnTable => table.term.is_positioning(),
            Mechanism::CrossTable => table.term.is_cross() && self.factors.is_none(),
            Mechanism::Skew => self.factors.is_some(),
            _ => true,
        }
    }

    fn proves_by_slope(&self) -> bool {
        self.factors.is_some()
    }

    /// What the control takes in one section of increments.
    fn section_limits(&self, _mechanism: Mechanism) -> Vec<Option<i64>> {
        let counts = self.largest_value.value * power_of_ten(self.value_decimals.value);
        vec![(self.value_form.value == ValueForm::Increment).then(|| whole_below(counts))]
    }

    fn cut_off_um(&self, task: Task<'_>, table: &PlannedTable) -> f64 {
        match self.value_form.value {
            ValueForm::Amount => {
                self.largest_value.value * listed::form_of(self, task, table).value_um
            }
            ValueForm::Position | ValueForm::Increment => f64::INFINITY,
        }
    }

    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        if self.factors.is_some() {
            let [from, peak, _] = proof.bump.places();
            let slope = Deviation::from_um(proof.bump.height().um() / (peak - from).mm());
            let gain = |term| if term == proof.term { slope } else { Deviation::ZERO };
            return Some(Tables::Listed(self.in_numbers("_sign", gain)));
        }
        Some(listed::proof_tables(self, proof))
    }
}

impl DeclaredFacts {
    fn preconditions(&self, task: Task<'_>, plan: &Plan) -> Vec<Precondition> {
        let source = match self.typed.is_some() {
            true => "contract of the generic table",
            false => "the profile, fact `backlash`",
        };
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
            false => plan.sets_backlash(*axis),
        };
        let axes = Axis::ALL.into_iter().filter(is_set);
        let reference = Precondition::new(
            "reference points",
            task.reference_text(),
            "the tables are zero there; if they are elsewhere, switching the tables on moves axes",
            RULE,
        )
        .dangerous();
        axes.map(of_axis).chain(self.typed.is_none().then_some(reference)).collect()
    }

    /// What templates see.
    fn seen(&self, task: Task<'_>, tables: &[ListedTable]) -> Seen {
        let all = tables.iter().map(|table| (table, self.seen_table(table)));
        let all: Vec<(&ListedTable, Seen)> = all.collect();
        let of = |is_wanted: &dyn Fn(&ListedTable) -> bool| {
            let own = all.iter().filter(|(table, _)| is_wanted(table));
            own.map(|(_, seen)| seen.clone()).collect::<Vec<Seen>>()
        };
        let listed = |is_own: bool| of(&|table| table.is_own() == is_own);
        let mut axes: Vec<&str> = Vec::new();
        for table in tables {
            if !axes.contains(&table.output.as_str()) {
                axes.push(&table.output);
            }
        }
        let axis = |name: &&str| {
            let of_axis = |is_own: bool| of(&|own| own.output == *name && own.is_own() == is_own);
            seen! { "name": *name, "own": of_axis(true), "cross": of_axis(false) }
        };
        let sense = |is_own: bool| self.sign(is_own).value.words();
        let evidence = |is_own: bool| self.sign(is_own).evidence.of_sense();
        seen! {
            "tables": of(&|_| true),
            "own": listed(true),
            "cross": listed(false),
            "axes": axes.iter().map(axis).collect::<Vec<Seen>>(),
            "own_sense": sense(true),
            "own_sense_evidence": evidence(true),
            "cross_sense": sense(false),
            "cross_sense_evidence": evidence(false),
            "controller_reference": task.reference_text(),
        }
    }

    fn seen_table(&self, table: &ListedTable) -> Seen {
        let position = |number: f64| fixed(number, self.position_decimals.value);
        let value =
            |number: f64| fixed(number, self.form(true, ControlUnit::Millimetre).decimals());
        let first = self.first_point.value as usize;
        let point = |(index, point): (usize, &Point)| {
            seen! {
                "number": (first + index).to_string(),
                "padded": format!("{:03}", first + index),
                "position": position(point.position),
                "value": value(point.forward),
                "forward": value(point.forward),
                "reverse": value(point.reverse.unwrap_or(point.forward)),
            }
        };
        let places: Vec<f64> = table.points.iter().map(|point| point.position).collect();
        let spacing = places.get(1).zip(places.first()).map_or(0.0, |(b, a)| b - a);
        let end = |place: Option<&f64>| place.map_or(String::new(), |place| position(*place));
        seen! {
            "base": table.base.as_str(),
            "output": table.output.as_str(),
            "start": end(places.first()),
            "end": end(places.last()),
            "spacing": position(spacing),
            "count": places.len().to_string(),
            "last": (first + places.len().saturating_sub(1)).to_string(),
            "points": table.points.iter().enumerate().map(point).collect::<Vec<Seen>>(),
        }
    }

    /// `table of X`, or `table of Y by X`; with `moving up` or `moving down` one column of it.
    fn place(&self, plan: &Plan, planned: &PlannedTable) -> String {
        if self.typed.is_some() {
            return "rows".to_string();
        }
        let names = plan.names[planned.term.of].iter();
        let names = names.map(|output| name(plan.base_of(planned.term, output), output));
        let column = match planned.direction {
            None => "",
            Some(Direction::Plus) => " moving in +",
            Some(Direction::Minus) => " moving in -",
        };
        joined(names) + column
    }
}

// Squareness into the factors of a control that has no tables for it.
//
// * A factor is the slope of a cross term between the ends of its curve. Nothing else has a place: no positioning, no
//   shape of a straightness, no slope without a factor.
// * The correction is zero at position 0 of all axes, not at the reference. The difference is a shift of all
//   positions, which a note names; what the terms are judged by, the error against the reference, is without it.

impl DeclaredFacts {
    /// A plan in factors; those of which nothing is planned are 0.
    fn compile_factors(&self, task: Task<'_>, plan: &Plan) -> Compiled {
        let planned = |term| plan.tables.iter().find(|own| own.term == term);
        let tables = self.in_numbers("", |term| planned(term).map_or(Deviation::ZERO, slope));
        let placed = plan.tables.iter().map(|own| self.placement(task, own)).collect();
        Compiled {
            notes: self.shifts(task, &tables).map(Into::into).collect(),
            ..Compiled::of(Tables::Listed(tables), placed, control_state(task, plan, |_| 0.0))
        }
    }

    /// The factors for what terms gain in a mm; rounded here, once.
    fn in_numbers(&self, ending: &str, gain: impl Fn(ErrorTerm) -> Deviation) -> ListedTables {
        let table = |own: &Factor| {
            let factor = self.cross_sign.value.table_um(gain(own.term)) / UM_PER_MM;
            let forward = rounded(factor, self.value_decimals.value) + 0.0; // −0 is 0
            ListedTable::of_factor(own.axes(), forward)
        };
        let set = self.set_name.as_ref().map(|own| format!("{}{ending}", own.value));
        ListedTables { set, ..ListedTables::of(self.factors().iter().map(table).collect()) }
    }

    /// A line: what it leaves of the curve, and its last decimal at the end of the travel.
    fn placement(&self, task: Task<'_>, planned: &PlannedTable) -> Placement {
        let own = self.factors().iter().find(|own| own.term == planned.term);
        let name = own.map_or(String::new(), |own| own.name.clone());
        let travel = task.job.machine.axes[planned.term.along];
        let (low, high) = travel.map_or_else(|| planned.grid.range(), |own| (own.low, own.high));
        let far = (high - low).mm().max(1.0);
        let way = |place: Millimetres| (place - planned.grid.reference).mm();
        let at = |place| Deviation::from_um(slope(planned).um() * way(place));
        let ends = Nodes { first: low, step: high - low, count: 2, reference_node: 0 };
        let count_um = far * UM_PER_MM / power_of_ten(self.value_decimals.value);
        Placement {
            points: ends.count,
            grid_residual_um: residual(&planned.curve, &ends, &[at(low), at(high)], low, high),
            ..Placement::of(planned, name, count_um)
        }
    }

    /// How far all positions are shifted, because the correction is not zero at the reference.
    fn shifts(&self, task: Task<'_>, tables: &ListedTables) -> impl Iterator<Item = TableFinding> {
        let sum = |of: Axis, at: &dyn Fn(Axis) -> f64| {
            let own = self.factors().iter().filter(|own| own.term.of == of);
            let added = own.map(|own| number(tables, own) * at(own.term.along));
            self.cross_sign.value.correction(added.sum::<f64>() * UM_PER_MM).um()
        };
        let at = |axis: Axis| task.job.machine.axes[axis].map_or(0.0, |own| own.reference.mm());
        let shifts = Axis::ALL.map(|axis| (axis, sum(axis, &at))).into_iter();
        shifts
            .filter(|(_, um)| um.abs() >= 0.1)
            .map(|(axis, um)| TableFinding::Shifted { axis, um })
    }
}

/// What stands for a factor.
fn number(tables: &ListedTables, own: &Factor) -> f64 {
    let [base, output] = own.axes();
    tables.factor(base, output)
}

/// The deviation that a term gains in a mm, between the ends of its curve.
fn slope(planned: &PlannedTable) -> Deviation {
    Deviation::from_um(planned.curve.end_point_slope_um_per_m() / UM_PER_MM)
}
