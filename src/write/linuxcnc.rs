//! LinuxCNC: the positioning error of a joint into the table that its `COMP_FILE` names, cross terms into a HAL
//! file (`hal`).
//!
//! * One row for each point; column 2 for travel up, column 3 for travel down, so one table holds both
//!   directions. Without directions both columns are the same.
//! * A joint with a table ignores BACKLASH. So the reversal that a policy leaves to the backlash parameter
//!   stands in the columns too.
//! * No such table moves another joint. A profile with `cross_terms = "hal"` writes a HAL file for straightness
//!   and squareness; else they get none.

mod hal;

use crate::control::claims::Precondition;
use crate::control::control_state::ControlState;
use crate::control::controller::{
    Columns, ControlUnit, CrossTerms, LinuxcncFacts, Listed, MOST_JOINTS, Mechanism,
};
use crate::control::table::{ListedTable, ListedTables, Point, Tables};
use crate::inputs::job::Compensation;
use crate::quantity::{Direction, ErrorTerm};
use crate::text::Problems;
use crate::write::compiled::Compiled;
use crate::write::control_text::{Seen, fixed, seen, trimmed};
use crate::write::family::{Emitted, Family, ProofOf};
use crate::write::grid::LengthDigit;
use crate::write::listed;
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};

impl Family for LinuxcncFacts {
    fn expected_name(&self, name: &str) -> Option<&'static str> {
        let joint = name.parse::<u32>().ok().filter(|n| n.to_string() == name);
        let is_joint = joint.is_some_and(|joint| joint < MOST_JOINTS);
        (!is_joint).then_some("the number of a joint, \"0\" to \"15\"")
    }

    fn length_digit(&self, unit: ControlUnit) -> LengthDigit {
        let decimals = self.position_decimals.value;
        LengthDigit { unit, decimals }
    }

    fn takes_directions(&self, term: ErrorTerm) -> bool {
        term.is_positioning()
    }

    fn replaces_backlash(&self) -> bool {
        true
    }

    fn budget(&self, _compensation: &Compensation) -> Option<TableStock> {
        (!self.has(Mechanism::Hal)).then_some(TableStock {
            resource: "tables for cross terms (COMP_FILE corrects its own joint only)",
            key: "terms",
            ..TableStock::default()
        })
    }

    /// Curves of a HAL file are counted when all are there.
    fn point_limit(&self, targets: &[&Target]) -> (u32, &'static str) {
        match targets.iter().any(|target| target.term.is_positioning()) {
            true => (self.rows.value, "a COMP_FILE"),
            false => {
                let sections = self.curves.value * (self.curve_points.value - 1);
                (sections + 1, "the memory of HAL")
            }
        }
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        let mut compiled = listed::compile(self, task, plan, |planned| {
            place(plan, planned, &plan.names[planned.term.of])
        })?;
        self.pad(&mut compiled.tables);
        self.check_curves(task, tables_of(&compiled.tables))?;
        let preconditions = preconditions(task, tables_of(&compiled.tables));
        Ok(Compiled { preconditions, ..compiled })
    }

    fn uses(&self, mechanism: Mechanism, _plan: &Plan, tables: &Tables) -> bool {
        listed::uses([Mechanism::Comp, Mechanism::Hal], mechanism, tables)
    }

    fn context(&self, emitted: &Emitted<'_>) -> Option<Seen> {
        let unit = emitted.task.job.compensation.control_unit;
        let tables = tables_of(emitted.tables);
        let own = tables.iter().filter(|table| table.is_own());
        let joints = own.map(|table| self.seen(table, unit)).collect();
        Some(self.seen_of_all(joints, tables, emitted.task.reference_text()))
    }

    fn displayed(&self, tables: &Tables, state: &ControlState) -> Vec<String> {
        let (own, cross) = sorted(tables_of(tables));
        let joints = own.into_iter().map(|table| self.shown(table, state));
        joints.chain(self.corrections(&cross, state)).collect()
    }

    fn has(&self, mechanism: Mechanism) -> bool {
        mechanism != Mechanism::Hal || self.cross_terms.value == CrossTerms::Hal
    }

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        table.term.is_cross() == (mechanism == Mechanism::Hal)
    }

    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let is_own = |planned: &PlannedTable| self.belongs(proof.mechanism, planned);
        let mut tables = listed::proof_tables(self, proof, is_own);
        self.pad(&mut tables);
        Some(tables)
    }
}

/// The tables of a memory; a memory of another family holds none.
fn tables_of(tables: &Tables) -> &[ListedTable] {
    tables.own().map_or(&[], |own: &ListedTables| &own.tables)
}

/// Those of joints for themselves, and those of joints by others.
fn sorted(tables: &[ListedTable]) -> (Vec<&ListedTable>, Vec<&ListedTable>) {
    tables.iter().partition(|table| table.is_own())
}

impl LinuxcncFacts {
    /// What templates see of a table.
    fn seen(&self, table: &ListedTable, unit: ControlUnit) -> Seen {
        let decimals = self.form(true, unit).decimals();
        let position = |number: f64| fixed(number, self.position_decimals.value);
        let row = |point: &Point| {
            seen! {
                "nominal": position(point.position),
                "forward": fixed(point.forward, decimals),
                "reverse": fixed(point.reverse.unwrap_or(point.forward), decimals),
            }
        };
        let ends = [table.points.first(), table.points.last()];
        let [first, last] = ends.map(|own| own.map_or(String::new(), |own| position(own.position)));
        seen! {
            "number": table.output.as_str(),
            "type": self.columns.value.number().to_string(),
            "first": first,
            "last": last,
            "count": table.points.len().to_string(),
            "rows": table.points.iter().map(row).collect::<Vec<Seen>>(),
        }
    }

    /// `joint.0.backlash-corr: -0.018 mm at 900 mm moving up; …`, where the table holds most.
    fn shown(&self, table: &ListedTable, state: &ControlState) -> String {
        let trim = |point: &Point| match self.columns.value {
            Columns::Trims => point.forward,
            Columns::Reached => point.position - point.forward,
        };
        let by_size = |a: &&Point, b: &&Point| trim(a).abs().total_cmp(&trim(b).abs());
        let largest = table.points.iter().max_by(by_size);
        let decimals = self.form(true, state.unit).decimals();
        let [value, place] = [largest.map_or(0.0, trim), largest.map_or(0.0, |own| own.position)]
            .map(|number| trimmed(number, decimals));
        let (joint, unit) = (&table.output, state.unit.word());
        format!(
            "joint.{joint}.backlash-corr: {value} {unit} at {place} {unit}, having come there moving up; 0 at the reference point, having come there as homing does"
        )
    }
}

/// `JOINT_0`, or `JOINT_0, JOINT_3 moving up`; of a cross term `HAL: joint 1 by joint 0`.
fn place(plan: &Plan, planned: &PlannedTable, joints: &[String]) -> String {
    if planned.term.is_cross() {
        let base = joints.first().map_or("", |own| plan.base_of(planned.term, own));
        return format!("HAL: joint {} by joint {base}", joints.join(", "));
    }
    let names: Vec<String> = joints.iter().map(|joint| format!("JOINT_{joint}")).collect();
    let column = match planned.direction {
        None => "",
        Some(Direction::Plus) => " moving up",
        Some(Direction::Minus) => " moving down",
    };
    format!("{}{column}", names.join(", "))
}

/// Where these facts were seen.
const SEEN: &str = "LinuxCNC 2.9.0~pre1, seen: docs/linuxcnc.md §2";

fn preconditions(task: Task<'_>, tables: &[ListedTable]) -> Vec<Precondition> {
    let (joints, cross) = sorted(tables);
    let unit = task.job.compensation.control_unit.word();
    let mut list = vec![Precondition::new(
        "[TRAJ]LINEAR_UNITS",
        unit,
        "positions and values of the tables are in the machine unit; in another one every movement is 25.4 times as large or as small",
        "LinuxCNC documentation, INI Configuration",
    ).dangerous()];
    list.extend(joints.iter().map(|table| {
        Precondition::new(
            format!("BACKLASH of [JOINT_{}]", table.output),
            "removed",
            "a joint with a COMP_FILE ignores it: the table holds the whole reversal that is corrected",
            SEEN,
        )
    }));
    let is_step = |own: &Point| own.reverse.is_some_and(|down| (own.forward - down).abs() > 0.0);
    let has_step = |table: &&&ListedTable| table.points.iter().any(is_step);
    list.extend(joints.iter().filter(has_step).map(|table| {
        Precondition::new(
            format!("STEPGEN_MAXACCEL of [JOINT_{}], where there is one", table.output),
            "1.5 to 2 times MAX_ACCELERATION",
            "at a reversal the table is added to the move within a few milliseconds; without headroom a following error stops the machine",
            "LinuxCNC documentation, INI Configuration (from memory)",
        )
    }));
    list.push(Precondition::new(
        "reference points: HOME_OFFSET of each joint",
        task.reference_text(),
        "the tables are zero there, in the direction of homing; where they are not, homing shifts the machine zero by the value there",
        SEEN,
    ).dangerous());
    list.push(
        Precondition::new(
            "NO_FORCE_HOMING of [TRAJ]",
            "absent or 0",
            "the tables act before homing too, on a position that is not that of the machine",
            SEEN,
        )
        .dangerous(),
    );
    if !cross.is_empty() {
        list.extend(hal::preconditions());
    }
    list
}
