//! Cross terms into a HAL file: curves of the positions of joints, added to the commands of others and taken out
//! of their feedback (docs/linuxcnc.md §3).
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
use crate::control::table::{ListedTable, ListedTables, Point, Tables};
use crate::quantity::rounded;
use crate::text::Problem;
use crate::write::control_text::{Seen, fixed, seen, trimmed};
use crate::write::task::Task;
use std::collections::BTreeMap;

impl LinuxcncFacts {
    /// The curves of all cross terms, in their order.
    fn curves_of(&self, tables: &[ListedTable]) -> Vec<Curve> {
        let mut curves: Vec<Curve> = Vec::new();
        for table in tables.iter().filter(|table| !table.is_own()) {
            let pieces = self.pieces(&table.points).into_iter();
            let axes = [&table.base, &table.output].map(Clone::clone);
            curves.extend(pieces.map(|points| Curve { axes: axes.clone(), points }));
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
    pub(super) fn pad(&self, tables: &mut Tables) {
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
    pub(super) fn check_curves(
        &self,
        task: Task<'_>,
        tables: &[ListedTable],
    ) -> Result<(), Problem> {
        let (curves, most) = (self.curves_of(tables).len(), self.curves.value as usize);
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
    pub(super) fn seen_of_all(
        &self,
        joints: Vec<Seen>,
        tables: &[ListedTable],
        reference: String,
    ) -> Seen {
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
struct Curve {
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
    fn add_joint(&mut self, facts: &LinuxcncFacts, curves: &[Curve]) {
        let [Curve { axes: [_, joint], .. }, ..] = curves else {
            return;
        };
        let own = |name: &str| format!("nonius-{joint}-{name}");
        let (last, correction) = (curves.len() - 1, own("correction"));
        let mut before: Option<String> = None;
        for (number, Curve { axes: [base, _], points }) in curves.iter().enumerate() {
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
const SEEN: &str = "LinuxCNC 2.9.0~pre1, seen: docs/linuxcnc.md §1, §3";

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
