//! Klipper: squareness into the three factors of its skew correction.
//!
//! * A factor is the slope of a cross term between its ends: X by Y (`EXY`), X by Z (`EXZ`), Y by Z (`EYZ`).
//!   Nothing else has a place: no positioning, no shape of a straightness, no slope of `EYX`, `EZX`, `EZY`.
//! * The correction is zero at position 0 of all axes, not at the reference. The difference is a shift of all
//!   positions, which a note names; what the terms are judged by, the error against the reference, is without it.

use crate::control::claims::Precondition;
use crate::control::control_state::ControlState;
use crate::control::controller::{ControlUnit, KlipperFacts};
use crate::control::table::Tables;
use crate::control::table::klipper::{FACTORS, KlipperTables, Skew, factor_name};
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::fit::{Nodes, residual};
use crate::quantity::units::{Deviation, Millimetres, UM_PER_MM, power_of_ten, rounded};
use crate::text::problem::{Problem, Problems};
use crate::write::compiled::{Compiled, Placement, control_state};
use crate::write::control_text::fixed;
use crate::write::family::{Emitted, Family, ProofOf};
use crate::write::findings::TableFinding;
use crate::write::grid::LengthDigit;
use crate::write::seen::{Seen, seen};
use crate::write::task::{Plan, PlannedTable, Target, Task};

/// Under which names the factors are loaded.
const NAME: &str = "nonius";
const PROOF: &str = "nonius_sign";

impl Family for KlipperFacts {
    fn expected_name(&self, name: &str) -> Option<&'static str> {
        let is_axis = Axis::ALL.iter().any(|axis| axis.key() == name);
        (!is_axis).then_some("x, y or z")
    }

    fn names_reach_axes(&self) -> bool {
        false // the axes of a printer are called x, y, z
    }

    fn length_digit(&self, _unit: ControlUnit) -> LengthDigit {
        LengthDigit { unit: ControlUnit::Millimetre, decimals: 6 }
    }

    fn refuses(&self, term: ErrorTerm) -> Option<&'static str> {
        match factor_name(term) {
            Some(_) => None,
            None if term.is_positioning() => Some("a skew correction holds squareness alone"),
            None => Some(
                "a skew correction moves X by Y and Z, and Y by Z; a squareness in this slope stays (frame in which X is the primary axis: docs/klipper.md §2)",
            ),
        }
    }

    fn point_limit(&self, _targets: &[&Target]) -> (u32, &'static str) {
        (u32::MAX, "a factor")
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        check_names(task, plan)?;
        let factor = |term: ErrorTerm| {
            let planned = plan.tables.iter().find(|planned| planned.term == term);
            planned.map_or(0.0, |planned| self.factor(slope(planned)))
        };
        let skew = Skew::none(NAME).with(FACTORS.map(|(term, _)| factor(term)));
        let placed = plan.tables.iter().map(|planned| self.placement(task, planned));
        Ok(Compiled {
            placements: placed.collect(),
            notes: shifts(task, self, &skew).map(Into::into).collect(),
            tables: Tables::Klipper(KlipperTables { skew: Some(skew) }),
            state: control_state(task, plan, |_| 0.0),
            assumptions: Vec::new(),
            preconditions: preconditions(),
            stale: Vec::new(),
        })
    }

    fn context(&self, emitted: &Emitted<'_>) -> Option<Seen> {
        let tables: &KlipperTables = emitted.tables.own()?;
        let skew = tables.skew.as_ref()?;
        let factors = FACTORS.iter().zip(skew.factors());
        let factors = factors.map(|((_, name), factor)| {
            seen! { "name": *name, "value": fixed(factor, self.value_decimals.value) }
        });
        let factors: Vec<Seen> = factors.collect();
        Some(seen! { "skew": seen! { "name": skew.name.as_str(), "factors": factors } })
    }

    fn displayed(&self, tables: &Tables, _state: &ControlState) -> Vec<String> {
        const SHOWN: u32 = 6; // decimals of GET_CURRENT_SKEW
        let Tables::Klipper(KlipperTables { skew: Some(skew) }) = tables else {
            return Vec::new();
        };
        let planes = ["XY", "XZ", "YZ"].into_iter().zip(skew.factors());
        let shown = |(plane, factor)| format!("{plane} Skew: {} radians", fixed(factor, SHOWN));
        planes.map(shown).collect()
    }

    fn proves_by_slope(&self) -> bool {
        true
    }

    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let [from, peak, _] = proof.bump.places();
        let slope = proof.bump.height().um() / (peak - from).mm();
        let factor = self.factor(Deviation::from_um(slope));
        let factors = FACTORS.map(|(own, _)| if own == proof.term { factor } else { 0.0 });
        let skew = Some(Skew::none(PROOF).with(factors));
        Some(Tables::Klipper(KlipperTables { skew }))
    }
}

impl KlipperFacts {
    /// The factor for a deviation in a mm; rounded here, once.
    fn factor(&self, in_a_mm: Deviation) -> f64 {
        let factor = self.skew_sign.value.table_um(in_a_mm) / UM_PER_MM;
        rounded(factor, self.value_decimals.value) + 0.0 // −0 is 0
    }

    /// A line: what it leaves of the curve, and its last decimal at the end of the travel.
    fn placement(&self, task: Task<'_>, planned: &PlannedTable) -> Placement {
        let name = factor_name(planned.term).unwrap_or_default();
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
            ..Placement::of(planned, name.to_string(), count_um)
        }
    }
}

/// The deviation that a term gains in a mm, between the ends of its curve.
fn slope(planned: &PlannedTable) -> Deviation {
    Deviation::from_um(planned.curve.end_point_slope_um_per_m() / UM_PER_MM)
}

/// One name for each axis.
fn check_names(task: Task<'_>, plan: &Plan) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for (axis, names) in plan.names.iter() {
        if names.iter().any(|name| name != axis.key()) {
            let key = format!("compensation.axes.{}.id", axis.key());
            let message = format!("Klipper calls this axis `{}`", axis.key());
            let problem: Problem = task.job.problem_at(&key, message);
            problems.push(problem.help("leave `id` out"));
        }
    }
    problems.or_ok(())
}

/// How far all positions are shifted, because the correction is not zero at the reference.
fn shifts<'a>(
    task: Task<'a>,
    facts: &'a KlipperFacts,
    skew: &Skew,
) -> impl Iterator<Item = TableFinding> + 'a {
    let at = |axis: Axis| task.job.machine.axes[axis].map_or(0.0, |own| own.reference.mm());
    let added = |factor: f64, along: Axis| {
        let um = facts.skew_sign.value.correction(factor * UM_PER_MM).um();
        um * at(along)
    };
    let x = added(skew.xy, Axis::Y) + added(skew.xz - skew.xy * skew.yz, Axis::Z);
    let y = added(skew.yz, Axis::Z);
    let shifts = [(Axis::X, x), (Axis::Y, y)].into_iter();
    shifts.filter(|(_, um)| um.abs() >= 0.1).map(|(axis, um)| TableFinding::Shifted { axis, um })
}

fn preconditions() -> Vec<Precondition> {
    vec![
        Precondition::new(
            "GET_CURRENT_SKEW while measuring",
            "0 in all planes",
            "a skew correction that was on is part of what was measured",
            "docs/klipper.md §3",
        ),
        Precondition::new(
            "other [skew_correction NAME] that a start G-code or macro loads",
            "not loaded",
            "the profile that was loaded last acts alone",
            "docs/klipper.md §3",
        ),
    ]
}
