//! LinuxCNC: the positioning error of a joint into the table that its `COMP_FILE` names, cross terms into a HAL
//! file.
//!
//! * One row for each point; column 2 for travel up, column 3 for travel down, so one table holds both
//!   directions. Without directions both columns are the same.
//! * A joint with a table ignores BACKLASH. So the reversal that a policy leaves to the backlash parameter
//!   stands in the columns too.
//! * No such table moves another joint. A profile with `cross_terms = "hal"` writes a HAL file for straightness
//!   and squareness; else they get none.

use crate::control::claims::Precondition;
use crate::control::control_state::ControlState;
use crate::control::controller::{
    Columns, ControlUnit, CrossTerms, LinuxcncFacts, MOST_JOINTS, Mechanism, PointLists,
};
use crate::control::table::{ListedTable, ListedTables, Point, Tables};
use crate::inputs::job::Compensation;
use crate::quantity::{Axis, Direction, ErrorTerm, rounded};
use crate::text::{Problem, Problems, joined};
use crate::write::control_text::{Seen, fixed, seen, trimmed};
use crate::write::family::{Compiled, Family, FileSource, ProofOf};
use crate::write::grid::LengthDigit;
use crate::write::listed;
use crate::write::refusals;
use crate::write::selection::TableStock;
use crate::write::task::{Plan, PlannedTable, Target, Task};
use std::collections::BTreeMap;

impl Family for LinuxcncFacts {
    fn expected_name(&self, _axis: Axis, name: &str) -> Option<&'static str> {
        let joint = name.parse::<u32>().ok().filter(|n| n.to_string() == name);
        let is_joint = joint.is_some_and(|joint| joint < MOST_JOINTS);
        (!is_joint).then_some("the number of a joint, \"0\" to \"15\"")
    }

    fn length_digit(&self, unit: ControlUnit) -> LengthDigit {
        LengthDigit { unit, decimals: self.position_decimals.value }
    }

    fn takes_directions(&self, term: ErrorTerm) -> bool {
        term.is_positioning()
    }

    fn replaces_backlash(&self) -> bool {
        true
    }

    fn budget(&self, _compensation: &Compensation) -> Option<TableStock> {
        (self.cross_terms.value != CrossTerms::Hal).then_some(TableStock {
            resource: "tables for cross terms (COMP_FILE corrects its own joint only)",
            key: "terms",
            ..TableStock::default()
        })
    }

    /// Curves of a HAL file are counted when all are there.
    fn point_limit(&self, targets: &[&Target]) -> (u32, &'static str) {
        match targets.iter().any(|target| target.term.is_positioning()) {
            true => (self.rows.value, "a COMP_FILE"),
            false => (self.curves.value * (self.curve_points.value - 1) + 1, "the memory of HAL"),
        }
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        let mut compiled = listed::compile(self, task, plan, |planned| {
            place(plan, planned, &plan.names[planned.term.of])
        })?;
        self.pad(&mut compiled.tables);
        self.check_curves(task, tables_of(&compiled.tables))?;
        Ok(Compiled { preconditions: preconditions(task, tables_of(&compiled.tables)), ..compiled })
    }

    fn context(&self, emitted: &FileSource<'_>) -> Seen {
        let unit = emitted.task.job.compensation.control_unit;
        let tables = tables_of(emitted.tables);
        let own = tables.iter().filter(|table| table.is_own());
        let joints = own.map(|table| self.seen(table, unit)).collect();
        self.seen_of_all(joints, tables, emitted.task.reference_text())
    }

    fn displayed(&self, tables: &Tables, state: &ControlState) -> Vec<String> {
        let (own, cross) = sorted(tables_of(tables));
        let joints = own.into_iter().map(|table| self.shown(table, state));
        joints.chain(self.corrections(&cross, state)).collect()
    }

    fn belongs(&self, mechanism: Mechanism, table: &PlannedTable) -> bool {
        match mechanism {
            Mechanism::Comp => table.term.is_positioning(),
            Mechanism::Hal => table.term.is_cross(),
            _ => true,
        }
    }

    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let mut tables = listed::proof_tables(self, proof);
        self.pad(&mut tables);
        Some(tables)
    }
}

/// The tables of a memory; a memory of another family holds none.
fn tables_of(tables: &Tables) -> &[ListedTable] {
    &tables.own::<ListedTables>().tables
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
    let names = joined(joints.iter().map(|joint| format!("JOINT_{joint}")));
    let column = match planned.direction {
        None => "",
        Some(Direction::Plus) => " moving up",
        Some(Direction::Minus) => " moving down",
    };
    names + column
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
        list.extend(preconditions_of_hal());
    }
    list
}

// Cross terms into a HAL file: curves of the positions of joints, added to the commands of others and taken out
// of their feedback (docs/linuxcnc.md §3).
//
// ```text
//   joint.0.pos-cmd ─→ lincurve ─┐
//   joint.2.pos-cmd ─→ lincurve ─┴ sum2 ─→ correction ─┬ + joint.1.motor-pos-cmd ─→ drive
//                                                      └ encoder − correction ───→ joint.1.motor-pos-fb
// ```
// A curve has few points, so a table is written as pieces that add up: each is 0 up to its first point and holds
// after its last.

impl LinuxcncFacts {
    /// The curves of all cross terms, in their order.
    fn curves_of(&self, tables: &[ListedTable]) -> Vec<HalCurve> {
        let mut curves: Vec<HalCurve> = Vec::new();
        for table in tables.iter().filter(|table| !table.is_own()) {
            let pieces = self.pieces(&table.points).into_iter();
            let axes = [&table.base, &table.output].map(Clone::clone);
            curves.extend(pieces.map(|points| HalCurve { axes: axes.clone(), points }));
        }
        curves
    }

    /// Curves of few points whose sum is the curve of all.
    fn pieces(&self, points: &[Point]) -> Vec<Vec<Point>> {
        let sections = self.curve_points.value as usize - 1;
        let starts = (0..points.len().saturating_sub(1)).step_by(sections);
        let piece = |start: usize| {
            let end = points.len().min(start + sections + 1);
            let base = if start == 0 { 0.0 } else { points[start].forward };
            let above = |point: &Point| Point {
                forward: rounded(point.forward - base, self.value_decimals.value) + 0.0,
                ..*point
            };
            points[start..end].iter().map(above).collect()
        };
        starts.map(piece).collect()
    }

    /// The numbers of points repeat when there are more curves than numbers: then all curves have as many, and a
    /// table goes on behind its last point, which it holds.
    fn pad(&self, tables: &mut Tables) {
        let Tables::Listed(ListedTables { tables, .. }) = tables else {
            return;
        };
        if self.curves_of(tables).len() <= self.personalities.value as usize {
            return;
        }
        let sections = self.curve_points.value as usize - 1;
        for ListedTable { points, .. } in tables.iter_mut().filter(|table| !table.is_own()) {
            while let [.., before, last] = points[..]
                && !(points.len() - 1).is_multiple_of(sections)
            {
                let beyond = last.position + (last.position - before.position);
                let position = rounded(beyond, self.position_decimals.value);
                points.push(Point { position, ..last });
            }
        }
    }

    /// Told where the memory of HAL does not hold so many curves.
    fn check_curves(&self, task: Task<'_>, tables: &[ListedTable]) -> Result<(), Problem> {
        let (curves, most) = (self.curves_of(tables).len(), self.curves.value as usize);
        if curves <= most {
            return Ok(());
        }
        let wrong = refusals::many_curves(curves, self.curve_points.value, most);
        Err(task.job.source.at("compensation.axes", wrong))
    }

    /// `nonius-1-correction: -0.018 mm with joint 0 at 900 mm …`, where each table holds most.
    fn corrections(
        &self,
        tables: &[&ListedTable],
        state: &ControlState,
    ) -> impl Iterator<Item = String> {
        let unit = state.unit.word();
        tables.iter().filter_map(move |table| {
            let by_size = |a: &&Point, b: &&Point| a.forward.abs().total_cmp(&b.forward.abs());
            let most = table.points.iter().max_by(by_size)?;
            let [value, place] = [most.forward, most.position].map(|n| trimmed(n, self.value_decimals.value));
            let ListedTable { base, output, .. } = table;
            Some(format!("nonius-{output}-correction: {value} {unit} with joint {base} at {place} {unit} and the other joints at their reference points; 0 with all joints there"))
        })
    }

    /// What templates see: beside the tables of joints `curves`, `sums`, `nets`, `personality`; the lists are empty
    /// without cross terms.
    fn seen_of_all(&self, joints: Vec<Seen>, tables: &[ListedTable], reference: String) -> Seen {
        let curves = self.curves_of(tables);
        let mut netlist = Netlist::default();
        for of_output in curves.chunk_by(|a, b| a.axes[1] == b.axes[1]) {
            netlist.add_joint(self, of_output);
        }
        let lengths = curves.iter().map(|curve| curve.points.len().to_string());
        let lengths: Vec<String> = lengths.take(self.personalities.value as usize).collect();
        let net = |(signal, pins): (String, Vec<String>)| seen! { "signal": signal, "pins": pins };
        seen! {
            "personality": lengths.join(","),
            "curve_count": netlist.curves.len().to_string(),
            "sum_count": netlist.sums.len().to_string(),
            "curves": netlist.curves,
            "sums": netlist.sums,
            "nets": netlist.nets.into_iter().map(net).collect::<Vec<Seen>>(),
            "joints": joints,
            "controller_reference": reference,
        }
    }
}

/// Some of the points of a table: base and output joint, and what is added at each point.
struct HalCurve {
    axes: [String; 2],
    points: Vec<Point>,
}

/// Components in the order in which they run, and the pins of each signal.
#[derive(Default)]
struct Netlist {
    curves: Vec<Seen>,
    sums: Vec<Seen>,
    nets: BTreeMap<String, Vec<String>>,
}

impl Netlist {
    /// Everything that corrects one joint.
    fn add_joint(&mut self, facts: &LinuxcncFacts, curves: &[HalCurve]) {
        let [HalCurve { axes: [_, joint], .. }, ..] = curves else {
            return;
        };
        let own = |name: &str| format!("nonius-{joint}-{name}");
        let (last, correction) = (curves.len() - 1, own("correction"));
        let mut before: Option<String> = None;
        for (number, HalCurve { axes: [base, _], points }) in curves.iter().enumerate() {
            let sum = match number == last {
                true => correction.clone(),
                false => own(&format!("sum-{number}")),
            };
            match before.replace(sum.clone()) {
                None => self.add_curve(facts, (base, sum), points),
                Some(before) => {
                    let curve = own(&format!("curve-{number}"));
                    self.add_curve(facts, (base, curve.clone()), points);
                    self.add_sum([&before, &curve, &sum], "1");
                }
            }
        }
        self.link(&own("command"), format!("joint.{joint}.motor-pos-cmd"));
        self.add_sum([&own("command"), &correction, &own("drive")], "1");
        self.add_sum([&own("encoder"), &correction, &own("feedback")], "-1");
        self.link(&own("feedback"), format!("joint.{joint}.motor-pos-fb"));
    }

    fn add_curve(
        &mut self,
        facts: &LinuxcncFacts,
        (base, output): (&str, String),
        piece: &[Point],
    ) {
        let number = self.curves.len();
        let input = format!("nonius-{base}-position");
        if !self.nets.contains_key(&input) {
            self.link(&input, format!("joint.{base}.pos-cmd"));
        }
        self.link(&input, format!("lincurve.{number}.in"));
        self.link(&output, format!("lincurve.{number}.out"));
        let point = |(index, point): (usize, &Point)| {
            seen! {
                "index": format!("{index:02}"),
                "position": fixed(point.position, facts.position_decimals.value),
                "value": fixed(point.forward, facts.value_decimals.value),
            }
        };
        let points: Vec<Seen> = piece.iter().enumerate().map(point).collect();
        self.curves.push(seen! { "number": number.to_string(), "points": points });
    }

    /// `to` = `a` + gain · `b`.
    fn add_sum(&mut self, [a, b, to]: [&str; 3], gain: &str) {
        let number = self.sums.len();
        self.link(a, format!("sum2.{number}.in0"));
        self.link(b, format!("sum2.{number}.in1"));
        self.link(to, format!("sum2.{number}.out"));
        self.sums.push(seen! { "number": number.to_string(), "gain": gain });
    }

    fn link(&mut self, signal: &str, pin: String) {
        self.nets.entry(signal.to_string()).or_default().push(pin);
    }
}

/// Where these facts were seen.
const SEEN_OF_HAL: &str = "LinuxCNC 2.9.0~pre1, seen: docs/linuxcnc.md §1, §3";

/// What has to be so around the HAL file.
fn preconditions_of_hal() -> [Precondition; 4] {
    [
        Precondition::new(
            "`loadrt lincurve` and `loadrt sum2` of the machine's HAL files",
            "absent",
            "a component is loaded once: LinuxCNC does not start with a second one",
            SEEN_OF_HAL,
        ),
        Precondition::new(
            "HOME of each joint in the ini file",
            "the same as HOME_OFFSET",
            "the corrections act while homing too: where the other joints do not stand at their reference points, homing shifts the machine zero by the correction there",
            SEEN_OF_HAL,
        ).dangerous(),
        Precondition::new(
            "MIN_LIMIT and MAX_LIMIT of each corrected joint",
            "inside the real ends by at least the largest movement",
            "the correction is added behind the limits of position, velocity and acceleration, which do not see it",
            SEEN_OF_HAL,
        ).dangerous(),
        Precondition::new(
            "MIN_FERROR and FERROR of each corrected joint",
            "larger by the way of one servo period",
            "the feedback reaches the motion controller one servo period later than without the file",
            SEEN_OF_HAL,
        ),
    ]
}
