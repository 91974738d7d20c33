//! Squareness into the factors of a control that has no tables for it.
//!
//! * A factor is the slope of a cross term between the ends of its curve. Nothing else has a place: no positioning, no
//!   shape of a straightness, no slope without a factor.
//! * The correction is zero at position 0 of all axes, not at the reference. The difference is a shift of all
//!   positions, which a note names; what the terms are judged by, the error against the reference, is without it.

use crate::control::controller::{DeclaredFacts, Factor};
use crate::control::table::{ListedTable, ListedTables, Tables};
use crate::quantity::{
    Axis, Deviation, ErrorTerm, Millimetres, Nodes, UM_PER_MM, power_of_ten, residual, rounded,
};
use crate::text::Problems;
use crate::write::compiled::{Compiled, Placement, control_state};
use crate::write::control_text::fixed;
use crate::write::family::ProofOf;
use crate::write::findings::TableFinding;
use crate::write::task::{Plan, PlannedTable, Task};

impl DeclaredFacts {
    /// Why a term has no factor; none where it has one, or where the control has tables.
    pub(super) fn without_factor(&self, term: ErrorTerm) -> Option<String> {
        let mut factors = self.factors.as_ref()?.value.iter();
        let why = match &self.no_factor {
            _ if term.is_positioning() => "a skew correction holds squareness alone",
            Some(why) => &why.value,
            None => "no factor of this control takes it; a squareness in this slope stays",
        };
        (!factors.any(|own| own.term == term)).then(|| why.to_string())
    }

    /// A plan in factors; those of which nothing is planned are 0.
    pub(super) fn compile_factors(
        &self,
        task: Task<'_>,
        plan: &Plan,
    ) -> Result<Compiled, Problems> {
        check_names(task, plan)?;
        let planned = |term| plan.tables.iter().find(|own| own.term == term);
        let tables = self.in_numbers("", |term| planned(term).map_or(Deviation::ZERO, slope));
        let placed = plan.tables.iter().map(|own| self.placement(task, own));
        Ok(Compiled {
            placements: placed.collect(),
            notes: self.shifts(task, &tables).map(Into::into).collect(),
            tables: Tables::Listed(tables),
            state: control_state(task, plan, |_| 0.0),
            assumptions: Vec::new(),
            preconditions: Vec::new(),
            stale: Vec::new(),
        })
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

    /// One factor that is not 0: to the peak of the bump of a sign proof.
    pub(super) fn proof_factors(&self, proof: &ProofOf<'_>) -> Tables {
        let [from, peak, _] = proof.bump.places();
        let slope = Deviation::from_um(proof.bump.height().um() / (peak - from).mm());
        let gain = |term| if term == proof.term { slope } else { Deviation::ZERO };
        Tables::Listed(self.in_numbers("_sign", gain))
    }

    /// What the control shows of them.
    pub(super) fn shown_factors(&self, tables: &Tables) -> Vec<String> {
        const SHOWN: u32 = 6; // decimals
        let (Some(form), Tables::Listed(held)) = (&self.shown, tables) else {
            return Vec::new();
        };
        let shown = |own: &Factor| {
            let axes = form.value.replace("{of}", &own.term.of.to_string());
            let axes = axes.replace("{by}", &own.term.along.to_string());
            axes.replace("{value}", &fixed(number(held, own), SHOWN))
        };
        self.factors().iter().map(shown).collect()
    }

    /// A line: what it leaves of the curve, and its last decimal at the end of the travel.
    fn placement(&self, task: Task<'_>, planned: &PlannedTable) -> Placement {
        let own = self.factors().iter().find(|own| own.term == planned.term);
        let name = own.map_or(String::new(), |own| own.name.clone());
        let travel = task.job.machine.axes[planned.term.along];
        let (low, high) = travel.map_or_else(|| planned.grid.range(), |own| (own.low, own.high));
        let far = (high - low).mm().max(1.0);
        let at = |place: Millimetres| {
            let way = place - planned.grid.reference;
            Deviation::from_um(slope(planned).um() * way.mm())
        };
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

/// A factor names its axes: each has its own name.
fn check_names(task: Task<'_>, plan: &Plan) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for (axis, names) in plan.names.iter() {
        if names.iter().any(|name| name != axis.key()) {
            let key = format!("compensation.axes.{}.id", axis.key());
            let message = format!("this control calls the axis `{}`", axis.key());
            problems.push(task.job.problem_at(&key, message).help("leave `id` out"));
        }
    }
    problems.or_ok(())
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
