//! Cross terms into a HAL file: curves of the positions of joints, added to the commands of others and taken out
//! of their feedback (docs/linuxcnc.md §6).
//!
//! ```text
//!   joint.0.pos-cmd ─→ lincurve ─┐
//!   joint.2.pos-cmd ─→ lincurve ─┴ sum2 ─→ correction ─┬ + joint.1.motor-pos-cmd ─→ drive
//!                                                      └ encoder − correction ───→ joint.1.motor-pos-fb
//! ```
//! A curve has few points, so a table is written as pieces that add up: each is 0 up to its first point and holds
//! after its last.

use crate::control::claims::Precondition;
use crate::control::control_state::ControlState;
use crate::control::controller::LinuxcncFacts;
use crate::control::table::linuxcnc::{CrossTable, Point};
use crate::quantity::units::{Deviation, rounded};
use crate::text::problem::Problem;
use crate::write::control_text::{fixed, trimmed};
use crate::write::task::{Plan, PlannedTable, Task};
use serde_json::{Value, json};
use std::collections::BTreeMap;

impl LinuxcncFacts {
    /// The tables of all planned cross terms, with the deviations that each cancels.
    pub(super) fn cross_tables<'p>(
        &self,
        task: Task<'_>,
        plan: &'p Plan,
        deviations: impl Fn(&PlannedTable) -> Vec<Deviation>,
    ) -> Vec<CrossTable> {
        let cross = plan.tables.iter().filter(|table| table.term.is_cross());
        let of_outputs = |table: &'p PlannedTable| {
            let outputs = plan.names[table.term.of].iter();
            outputs.map(move |output| (table, output))
        };
        let mut tables: Vec<CrossTable> = cross
            .flat_map(of_outputs)
            .filter_map(|(table, output)| {
                Some(CrossTable {
                    base: plan.base_of(table.term, output).parse().ok()?,
                    output: output.parse().ok()?,
                    pieces: self.pieces(&self.points(task, table, deviations(table))),
                })
            })
            .collect();
        tables.sort_by_key(|table| (table.output, table.base));
        self.pad(&mut tables);
        tables
    }

    /// The points of a table; rounded here, once.
    fn points(&self, task: Task<'_>, table: &PlannedTable, values: Vec<Deviation>) -> Vec<Point> {
        let grid = &table.grid;
        let point = |(at, deviation): (i64, Deviation)| {
            let units = self.sum_sign.value.table_um(deviation) / task.um_per_unit();
            Point {
                position: grid.written(at),
                value: rounded(units, self.value_decimals.value) + 0.0, // −0 is 0
            }
        };
        (grid.first..=grid.last).zip(values).map(point).collect()
    }

    /// Curves of few points whose sum is the curve of all.
    fn pieces(&self, points: &[Point]) -> Vec<Vec<Point>> {
        let sections = self.curve_points.value as usize - 1;
        let starts = (0..points.len().saturating_sub(1)).step_by(sections);
        let piece = |start: usize| {
            let end = points.len().min(start + sections + 1);
            let base = if start == 0 { 0.0 } else { points[start].value };
            let above = |point: &Point| Point {
                value: rounded(point.value - base, self.value_decimals.value) + 0.0,
                ..*point
            };
            points[start..end].iter().map(above).collect()
        };
        starts.map(piece).collect()
    }

    /// The numbers of points repeat when there are more curves than numbers: then all curves have as many.
    fn pad(&self, tables: &mut [CrossTable]) {
        if count(tables) <= self.personalities.value as usize {
            return;
        }
        for piece in tables.iter_mut().flat_map(|table| &mut table.pieces) {
            while let [.., before, last] = piece[..]
                && piece.len() < self.curve_points.value as usize
            {
                let beyond = last.position + (last.position - before.position);
                piece.push(Point {
                    position: rounded(beyond, self.position_decimals.value),
                    ..last
                });
            }
        }
    }

    /// Told where the memory of HAL does not hold so many curves.
    pub(super) fn check_curves(
        &self,
        task: Task<'_>,
        tables: &[CrossTable],
    ) -> Result<(), Problem> {
        let (curves, most) = (count(tables), self.curves.value as usize);
        if curves <= most {
            return Ok(());
        }
        let message = format!(
            "the HAL file would have {curves} curves of {} points, more than the {most} that the memory of HAL holds",
            self.curve_points.value
        );
        Err(task
            .job
            .problem_at("compensation.axes", message)
            .help("use a larger spacing, or `points`, or `max_residual_um`, or list fewer `terms`"))
    }

    /// `nonius-1-correction: -0.018 mm with joint 0 at 900 mm …`, where each table holds most.
    pub(super) fn corrections(
        &self,
        tables: &[CrossTable],
        state: &ControlState,
    ) -> impl Iterator<Item = String> {
        let unit = state.unit.word();
        tables.iter().filter_map(move |table| {
            let totals = totals(&table.pieces);
            let most = totals.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()))?;
            let [value, place] = [most.value, most.position].map(|n| trimmed(n, self.value_decimals.value));
            let CrossTable { base, output, .. } = table;
            Some(format!("nonius-{output}-correction: {value} {unit} with joint {base} at {place} {unit} and the other joints at their reference points; 0 with all joints there"))
        })
    }

    /// What templates see: `curves`, `sums`, `nets`, `personality`; the lists are empty without cross terms.
    pub(super) fn hal_context(&self, tables: &[CrossTable]) -> Value {
        let mut netlist = Netlist::default();
        let by_output = tables.chunk_by(|a, b| a.output == b.output);
        for of_output in by_output {
            netlist.add_joint(self, of_output);
        }
        let points = tables.iter().flat_map(|table| &table.pieces);
        let lengths: Vec<String> = points
            .map(|piece| piece.len().to_string())
            .take(self.personalities.value as usize)
            .collect();
        json!({
            "personality": lengths.join(","),
            "curve_count": netlist.curves.len().to_string(),
            "sum_count": netlist.sums.len().to_string(),
            "curves": netlist.curves,
            "sums": netlist.sums,
            "nets": netlist.nets.iter().map(|(signal, pins)| json!({ "signal": signal, "pins": pins })).collect::<Vec<Value>>(),
        })
    }
}

/// The sum of pieces at each of their points: a piece begins where the one before holds its last value.
fn totals(pieces: &[Vec<Point>]) -> impl Iterator<Item = Point> {
    let mut before = 0.0;
    pieces.iter().flat_map(move |piece| {
        let base = before;
        before += piece.last().map_or(0.0, |last| last.value);
        let total = move |point: &Point| Point { value: base + point.value, ..*point };
        piece.iter().map(total)
    })
}

/// Curves of all tables.
fn count(tables: &[CrossTable]) -> usize {
    tables.iter().map(|table| table.pieces.len()).sum()
}

/// Components in the order in which they run, and the pins of each signal.
#[derive(Default)]
struct Netlist {
    curves: Vec<Value>,
    sums: Vec<Value>,
    nets: BTreeMap<String, Vec<String>>,
}

impl Netlist {
    /// Everything that corrects one joint.
    fn add_joint(&mut self, facts: &LinuxcncFacts, tables: &[CrossTable]) {
        let [CrossTable { output: joint, .. }, ..] = tables else {
            return;
        };
        let own = |name: &str| format!("nonius-{joint}-{name}");
        let (last, correction) = (count(tables) - 1, own("correction"));
        let pieces =
            tables.iter().flat_map(|table| table.pieces.iter().map(|piece| (table.base, piece)));
        let mut before: Option<String> = None;
        for (number, (base, piece)) in pieces.enumerate() {
            let sum = match number == last {
                true => correction.clone(),
                false => own(&format!("sum-{number}")),
            };
            match before.replace(sum.clone()) {
                None => self.add_curve(facts, (base, sum), piece),
                Some(before) => {
                    let curve = own(&format!("curve-{number}"));
                    self.add_curve(facts, (base, curve.clone()), piece);
                    self.add_sum([&before, &curve, &sum], "1");
                }
            }
        }
        self.link(&own("command"), format!("joint.{joint}.motor-pos-cmd"));
        self.add_sum([&own("command"), &correction, &own("drive")], "1");
        self.add_sum([&own("encoder"), &correction, &own("feedback")], "-1");
        self.link(&own("feedback"), format!("joint.{joint}.motor-pos-fb"));
    }

    fn add_curve(&mut self, facts: &LinuxcncFacts, (base, output): (u32, String), piece: &[Point]) {
        let number = self.curves.len();
        let input = format!("nonius-{base}-position");
        if !self.nets.contains_key(&input) {
            self.link(&input, format!("joint.{base}.pos-cmd"));
        }
        self.link(&input, format!("lincurve.{number}.in"));
        self.link(&output, format!("lincurve.{number}.out"));
        let point = |(index, point): (usize, &Point)| {
            json!({
                "index": format!("{index:02}"),
                "position": fixed(point.position, facts.position_decimals.value),
                "value": fixed(point.value, facts.value_decimals.value),
            })
        };
        let points: Vec<Value> = piece.iter().enumerate().map(point).collect();
        self.curves.push(json!({ "number": number.to_string(), "points": points }));
    }

    /// `to` = `a` + gain · `b`.
    fn add_sum(&mut self, [a, b, to]: [&str; 3], gain: &str) {
        let number = self.sums.len();
        self.link(a, format!("sum2.{number}.in0"));
        self.link(b, format!("sum2.{number}.in1"));
        self.link(to, format!("sum2.{number}.out"));
        self.sums.push(json!({ "number": number.to_string(), "gain": gain }));
    }

    fn link(&mut self, signal: &str, pin: String) {
        self.nets.entry(signal.to_string()).or_default().push(pin);
    }
}

/// Where these facts were seen.
const SEEN: &str = "LinuxCNC 2.9.0~pre1, seen: docs/linuxcnc.md §6";

/// What has to be so around the HAL file.
pub(super) fn preconditions() -> [Precondition; 4] {
    [
        Precondition::new(
            "`loadrt lincurve` and `loadrt sum2` of the machine's HAL files",
            "absent",
            "a component is loaded once: LinuxCNC does not start with a second one",
            SEEN,
        ),
        Precondition::new(
            "HOME of each joint in the ini file",
            "the same as HOME_OFFSET",
            "the corrections act while homing too: where the other joints do not stand at their reference points, homing shifts the machine zero by the correction there",
            SEEN,
        ).dangerous(),
        Precondition::new(
            "MIN_LIMIT and MAX_LIMIT of each corrected joint",
            "inside the real ends by at least the largest movement",
            "the correction is added behind the limits of position, velocity and acceleration, which do not see it",
            SEEN,
        ).dangerous(),
        Precondition::new(
            "MIN_FERROR and FERROR of each corrected joint",
            "larger by the way of one servo period",
            "the feedback reaches the motion controller one servo period later than without the file",
            SEEN,
        ),
    ]
}
