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
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{ControlUnit, CrossTerms, LinuxcncFacts, Mechanism};
use crate::control::table::Tables;
use crate::control::table::linuxcnc::{
    Columns, CompTable, CrossTable, LinuxcncTables, MOST_JOINTS, Row,
};
use crate::inputs::job::Compensation;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::units::{Deviation, power_of_ten, rounded};
use crate::text::problem::Problems;
use crate::write::compiled::{Compiled, Placement, column, control_state};
use crate::write::control_text::{fixed, trimmed};
use crate::write::family::{Emitted, Family, ProofOf};
use crate::write::grid::LengthDigit;
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};
use serde_json::{Value, json};

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
            tables: 0,
            used: 0,
            resource: "tables for cross terms (COMP_FILE corrects its own joint only)",
            key: "terms",
            takes_pairs: false,
            masters: None,
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
        let state = control_state(task, plan, |_| 0.0);
        let mut joints: Vec<CompTable> = Vec::new();
        let names = plan.tables.iter().map(|planned| (planned, &plan.names[planned.term.of]));
        let own = names.clone().filter(|(p, _)| p.term.is_positioning());
        for (planned, output) in own.flat_map(|(p, all)| all.iter().map(move |o| (p, o))) {
            let joint = output.parse().unwrap_or(MOST_JOINTS); // `expected_name` let it through
            if joints.iter().all(|table| table.joint != joint) {
                let axis = state.axis(output);
                joints.push(self.table(task, plan, joint, (planned, axis)));
            }
        }
        joints.sort_by_key(|table| table.joint);
        let cross = self.cross_tables(task, plan, |table| table.values.clone());
        self.check_curves(task, &cross)?;
        let count_um = self.count_um(task);
        let placed =
            names.map(|(planned, all)| Placement::of(planned, place(plan, planned, all), count_um));
        Ok(Compiled {
            placements: placed.collect(),
            preconditions: preconditions(task, &joints, &cross),
            stale: Vec::new(),
            tables: Tables::Linuxcnc(LinuxcncTables { joints, cross }),
            state,
            assumptions: Vec::new(),
            notes: Vec::new(),
        })
    }

    fn uses(&self, mechanism: Mechanism, _plan: &Plan, tables: &Tables) -> bool {
        match (mechanism, tables) {
            (Mechanism::Comp, Tables::Linuxcnc(tables)) => !tables.joints.is_empty(),
            (Mechanism::Hal, Tables::Linuxcnc(tables)) => !tables.cross.is_empty(),
            _ => true,
        }
    }

    fn context(&self, emitted: &Emitted<'_>) -> Option<Value> {
        let tables: &LinuxcncTables = emitted.tables.own()?;
        let joints = tables.joints.iter().map(|table| self.seen(table));
        let mut seen = self.hal_context(&tables.cross);
        seen["joints"] = joints.collect::<Vec<Value>>().into();
        seen["controller_reference"] = emitted.task.reference_text().into();
        Some(seen)
    }

    fn displayed(&self, tables: &Tables, state: &ControlState) -> Vec<String> {
        let Tables::Linuxcnc(tables) = tables else {
            return Vec::new();
        };
        let joints = tables.joints.iter().map(|table| self.shown(table, state));
        joints.chain(self.corrections(&tables.cross, state)).collect()
    }

    fn has(&self, mechanism: Mechanism) -> bool {
        mechanism != Mechanism::Hal || self.cross_terms.value == CrossTerms::Hal
    }

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        table.term.is_cross() == (mechanism == Mechanism::Hal)
    }

    /// Both columns of every joint of the term have the bump, so that the two sides of a gantry move alike.
    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let kit: &LinuxcncTables = proof.kit.own()?;
        if proof.mechanism == Mechanism::Hal {
            let cross = self.cross_tables(proof.task, proof.plan, |table| {
                proof.deviations(table.term == proof.term, table.values.len())
            });
            let joints = Vec::new();
            return Some(Tables::Linuxcnc(LinuxcncTables { joints, cross }));
        }
        let own = &proof.plan.names[proof.term.of];
        let of_kit = kit.joints.iter().map(|table| {
            let has_bump = own.contains(&table.joint.to_string());
            let deviations = proof.deviations(has_bump, table.rows.len());
            let rows = table.rows.iter().zip(deviations);
            let row = |(row, d): (&Row, Deviation)| self.row(proof.task, row.nominal, [d, d]);
            CompTable { rows: rows.map(row).collect(), ..table.clone() }
        });
        let (joints, cross) = (of_kit.collect(), Vec::new());
        Some(Tables::Linuxcnc(LinuxcncTables { joints, cross }))
    }
}

impl LinuxcncFacts {
    /// The last decimal of a trim, µm.
    fn count_um(&self, task: Task<'_>) -> f64 {
        task.um_per_unit() / power_of_ten(self.value_decimals.value)
    }

    /// Decimals of columns 2 and 3.
    fn column_decimals(&self) -> u32 {
        match self.columns.value {
            Columns::Trims => self.value_decimals.value,
            Columns::Reached => self.value_decimals.value.max(self.position_decimals.value),
        }
    }

    /// The table of a joint from all that is planned for its axis.
    fn table(
        &self,
        task: Task<'_>,
        plan: &Plan,
        joint: u32,
        (planned, axis): (&PlannedTable, Option<&AxisState>),
    ) -> CompTable {
        let columns = Direction::BOTH.map(|way| column(plan, planned.term, axis, way));
        let grid = &planned.grid;
        let row = |(at, deviations): (i64, (Deviation, Deviation))| {
            self.row(task, grid.written(at), [deviations.0, deviations.1])
        };
        let [up, down] = columns;
        let rows = (grid.first..=grid.last).zip(up.into_iter().zip(down));
        CompTable { joint, columns: self.columns.value, rows: rows.map(row).collect() }
    }

    /// A row that cancels a deviation for travel up, and one for travel down; rounded here, once.
    fn row(&self, task: Task<'_>, nominal: f64, deviations: [Deviation; 2]) -> Row {
        let decimals = self.value_decimals.value;
        let column = |deviation: Deviation| {
            let um = self.trim_sign.value.table_um(deviation);
            let trim = rounded(um / task.um_per_unit(), decimals);
            match self.columns.value {
                Columns::Trims => trim + 0.0, // −0 is 0
                Columns::Reached => rounded(nominal - trim, self.column_decimals()) + 0.0,
            }
        };
        let [forward, reverse] = deviations.map(column);
        Row { nominal, forward, reverse }
    }

    /// What templates see of a table.
    fn seen(&self, table: &CompTable) -> Value {
        let position = |number: f64| fixed(number, self.position_decimals.value);
        let column = |number: f64| fixed(number, self.column_decimals());
        let row = |row: &Row| {
            json!({
                "nominal": position(row.nominal),
                "forward": column(row.forward),
                "reverse": column(row.reverse),
            })
        };
        let ends = [table.rows.first(), table.rows.last()];
        let [first, last] = ends.map(|row| row.map_or(String::new(), |row| position(row.nominal)));
        json!({
            "number": table.joint.to_string(),
            "type": table.columns.number().to_string(),
            "first": first,
            "last": last,
            "count": table.rows.len().to_string(),
            "rows": table.rows.iter().map(row).collect::<Vec<Value>>(),
        })
    }

    /// `joint.0.backlash-corr: -0.018 mm at 900 mm moving up; …`, where the table holds most.
    fn shown(&self, table: &CompTable, state: &ControlState) -> String {
        let trim = |row: &Row| match table.columns {
            Columns::Trims => row.forward,
            Columns::Reached => row.nominal - row.forward,
        };
        let by_size = |a: &&Row, b: &&Row| trim(a).abs().total_cmp(&trim(b).abs());
        let largest = table.rows.iter().max_by(by_size);
        let [value, place] = [largest.map_or(0.0, trim), largest.map_or(0.0, |row| row.nominal)]
            .map(|number| trimmed(number, self.column_decimals()));
        let (joint, unit) = (table.joint, state.unit.word());
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

fn preconditions(task: Task<'_>, joints: &[CompTable], cross: &[CrossTable]) -> Vec<Precondition> {
    let unit = task.job.compensation.control_unit.word();
    let mut list = vec![Precondition::new(
        "[TRAJ]LINEAR_UNITS",
        unit,
        "positions and values of the tables are in the machine unit; in another one every movement is 25.4 times as large or as small",
        "LinuxCNC documentation, INI Configuration",
    ).dangerous()];
    list.extend(joints.iter().map(|table| {
        Precondition::new(
            format!("BACKLASH of [{}]", table.name()),
            "removed",
            "a joint with a COMP_FILE ignores it: the table holds the whole reversal that is corrected",
            SEEN,
        )
    }));
    let has_step =
        |table: &&CompTable| table.rows.iter().any(|row| (row.forward - row.reverse).abs() > 0.0);
    list.extend(joints.iter().filter(has_step).map(|table| {
        Precondition::new(
            format!("STEPGEN_MAXACCEL of [{}], where there is one", table.name()),
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
