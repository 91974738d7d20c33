//! Rows of one axis and direction of a mapped text → one series of the error table.

use crate::control::controller::TableSign;
use crate::inputs::error_table::{Component, Kind, Quantity, Series};
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::reading::{FileContents, Placing, freedom, means, tidy};
use crate::inputs::import::stated::Stated;
use crate::quantity::axis::{Axis, Direction};
use crate::quantity::units::SAME_PLACE_MM;
use crate::text::delimited::Line;
use crate::text::finding::Finding;
use crate::text::problem::{Problem, Problems};
use std::collections::BTreeMap;

const LEAVE_OUT: &str = "a missing value is never filled in: leave the run out";

/// A row whose mapped cells could be read.
pub(super) struct Row<'a> {
    pub(super) line: Line<'a>,
    pub(super) axis: Axis,
    pub(super) direction: Option<Direction>,
    pub(super) run: usize,
    /// mm.
    pub(super) position: f64,
    /// What was measured there, µm or µrad; the same quantities in every row.
    pub(super) values: Vec<(Quantity, f64)>,
}

impl Row<'_> {
    fn problem(&self, message: impl Into<String>, help: &str) -> Problem {
        Problem::new(message).at(self.line.whole()).help(help)
    }
}

/// Whether the targets ascend from the first row of the file, which holds its first target: one end, the same
/// for every group of rows.
pub(super) fn is_ascending(rows: &[Row<'_>], problems: &mut Problems) -> bool {
    let Some(first) = rows.first() else {
        return true;
    };
    if let Some(other) = rows.iter().find(|row| row.axis != first.axis) {
        let message =
            "targets of two axes stand in one file, but one first target can be stated only";
        let help = "import one axis at a time, or map machine coordinates to `position_mm`";
        problems.push(other.problem(message, help));
    }
    let ascending = rows.iter().all(|row| row.position >= first.position);
    if !ascending && rows.iter().any(|row| row.position > first.position) {
        let message =
            "the first row is not at an end of the targets, so the first target is not known";
        problems.push(first.problem(message, "sort the rows, beginning with target 1"));
    }
    ascending
}

/// Rows of one axis and direction.
pub(super) struct Group<'a, 'b> {
    /// The first target of the file, mm; `None` = positions are machine coordinates.
    pub(super) first_target: Option<f64>,
    /// Order of the positions from the first one of the file.
    pub(super) ascending: bool,
    pub(super) axis: Axis,
    pub(super) direction: Option<Direction>,
    pub(super) rows: Vec<&'b Row<'a>>,
}

impl<'a, 'b> Group<'a, 'b> {
    /// The series; what was done is said once for all groups.
    pub(super) fn series(
        &self,
        sign: TableSign,
        stated: &Stated,
        said: &mut FileContents,
        problems: &mut Problems,
    ) -> Option<Series> {
        let runs = problems.take(self.runs())?;
        let positions: Vec<f64> = runs.first()?.iter().map(|row| row.position).collect();
        let placing = match self.first_target {
            Some(first) => self.placing(first, &positions, stated, problems)?,
            None => Placing::on_machine(&positions),
        };
        for fact in self.facts(runs.len(), &placing).map(Finding::from) {
            if !said.findings.contains(&fact) {
                said.findings.push(fact);
            }
        }
        let mut series = Series::new(self.axis, self.direction, placing.positions());
        for (index, (quantity, _)) in self.rows.first()?.values.iter().enumerate() {
            let of_run = |run: &Vec<&Row<'_>>| run.iter().map(|row| row.values[index].1).collect();
            let values: Vec<Vec<f64>> = runs.iter().map(of_run).collect();
            match self.component(*quantity) {
                Some(component) => placing.put(&mut series, component, sign, &values),
                None => {
                    let u: Vec<f64> = means(&values).iter().map(|(mean, _)| *mean).collect();
                    series.put(*quantity, Some(placing.uncertainties(&u)));
                }
            }
        }
        Some(series)
    }

    fn placing(
        &self,
        first: f64,
        positions: &[f64],
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<Placing> {
        let row = self.rows.first()?;
        if (positions.first()? - first).abs() > SAME_PLACE_MM {
            let message = "these rows do not begin with the first target of the file";
            problems.push(row.problem(message, LEAVE_OUT));
            return None;
        }
        Placing::of(positions, &row.line.whole(), stated, problems)
    }

    /// The component of a quantity.
    fn component(&self, quantity: Quantity) -> Option<Component> {
        match quantity {
            Quantity::Value(kind) => Some(Component { kind, along: self.axis }),
            _ => None,
        }
    }

    fn facts(&self, runs: usize, placing: &Placing) -> impl Iterator<Item = ImportFinding> {
        let quantities = self.rows.iter().take(1).flat_map(|row| &row.values);
        let components = quantities.filter_map(|(quantity, _)| self.component(*quantity));
        let components: Vec<Component> = components.collect();
        let mut found = Vec::new();
        if self.first_target.is_some() {
            found.push(placing.found());
            found.extend(components.iter().filter_map(|c| placing.turned(*c)));
        }
        let is_deviation = |c: &Component| matches!(c.kind, Kind::Deviation(_));
        let u = match (components.iter().any(is_deviation), components.iter().all(is_deviation)) {
            (true, true) => "u = s/√runs (k = 1)",
            (true, false) => "u = s/√runs (k = 1) of the deviations; none is written for angles",
            _ => "no u is written for angles",
        };
        let several = ImportFinding::RunsOf {
            runs,
            axis: self.axis,
            direction: self.direction.map_or("both", Direction::symbol),
            u,
        };
        found.extend((runs > 1).then_some(several));
        found.extend(freedom(placing.positions().len(), runs));
        found.into_iter()
    }

    /// The rows of each run, in the order of their positions; all runs at the same positions.
    fn runs(&self) -> Result<Vec<Vec<&'b Row<'a>>>, Problems> {
        let mut runs: BTreeMap<usize, Vec<&'b Row<'a>>> = BTreeMap::new();
        for row in &self.rows {
            runs.entry(row.run).or_default().push(row);
        }
        let mut runs: Vec<Vec<&'b Row<'a>>> = runs.into_values().collect();
        let mut problems = Problems::none();
        for run in &mut runs {
            refuse_broken_order(run, &mut problems);
            run.sort_by(|a, b| a.position.total_cmp(&b.position));
            if !self.ascending {
                run.reverse();
            }
            refuse_twice(run, &mut problems);
        }
        let differ =
            |(a, b): (&&Row<'_>, &&Row<'_>)| (a.position - b.position).abs() > SAME_PLACE_MM;
        for run in runs.iter().skip(1) {
            if run.len() != runs[0].len() || run.iter().zip(&runs[0]).any(differ) {
                let number = run[0].run;
                let message = format!("run {number} does not have the positions of the first run");
                problems.push_with(|| run[0].problem(message, LEAVE_OUT));
            }
        }
        if let ([run], true) = (&runs[..], problems.is_empty())
            && let [row] = run[..]
        {
            let axis = self.axis;
            let message = format!("axis {axis} has a single position, expected at least two");
            problems.push(row.problem(message, "one position makes no curve"));
        }
        problems.or_ok(runs)
    }
}

/// A run goes one way: a row that turns back belongs to another run, or its number was misread.
fn refuse_broken_order(run: &[&Row<'_>], problems: &mut Problems) {
    let step = |pair: &[&Row<'_>]| pair[1].position - pair[0].position;
    let mut pairs = run.windows(2);
    let Some(first) = pairs.clone().map(step).find(|step| step.abs() > 0.0) else {
        return;
    };
    if let Some(pair) = pairs.find(|pair| step(pair) * first < 0.0) {
        let (before, here) = (pair[0].position, pair[1].position);
        let way = if first > 0.0 { "ascend" } else { "descend" };
        let message = format!(
            "position {here} comes after {before}, but the rows above {way}: expected one order in a run"
        );
        let help = "look for a sign between thousands; else map the number of the run (`…=run`), or sort the rows";
        problems.push_with(|| pair[1].problem(message, help));
    }
}

fn refuse_twice(run: &[&Row<'_>], problems: &mut Problems) {
    let tidy = |row: &Row<'_>| tidy(row.position);
    let is_twice = |pair: &&[&Row<'_>]| tidy(pair[0]).total_cmp(&tidy(pair[1])).is_eq();
    for pair in run.windows(2).filter(is_twice) {
        let message = format!("position {} is given twice", pair[1].position);
        let help = "map the number of the run (`…=run`) or the direction of travel (`…=direction`), or leave one row out";
        problems.push_with(|| pair[1].problem(message, help));
    }
}
