//! Rows of one axis and direction of a mapped text → one series of the error table.

use crate::control::controller::TableSign;
use crate::inputs::error_table::{Component, Kind, Series};
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::intake::Intake;
use crate::inputs::import::reading::{Placing, freedom, means, tidy};
use crate::inputs::refusals;
use crate::inputs::table::Content;
use crate::quantity::{Axis, Direction, SAME_PLACE_MM};
use crate::text::{Line, Problem};
use std::collections::BTreeMap;

/// A row whose mapped cells could be read.
pub(super) struct Row<'a> {
    pub(super) line: Line<'a>,
    pub(super) axis: Axis,
    pub(super) direction: Option<Direction>,
    /// As the file numbers it, also by a time stamp.
    pub(super) run: u64,
    /// mm.
    pub(super) position: f64,
    /// What was measured there, µm or µrad; the same quantities in every row.
    pub(super) values: Vec<(Content, f64)>,
}

/// Whether the targets ascend from the first row of the file, which holds its first target: one end, the same
/// for every group of rows.
pub(super) fn is_ascending(rows: &[Row<'_>], intake: &Intake<'_>) -> bool {
    let Some(first) = rows.first() else {
        return true;
    };
    if let Some(other) = rows.iter().find(|row| row.axis != first.axis) {
        intake.notes.refuse(refusals::two_axes().at(other.line.whole()));
    }
    let ascending = rows.iter().all(|row| row.position >= first.position);
    if !ascending && rows.iter().any(|row| row.position > first.position) {
        intake.notes.refuse(refusals::no_first_target().at(first.line.whole()));
    }
    ascending
}

/// The series of each axis and direction. `targets` = the first target of the file, mm (`None` = positions are
/// machine coordinates), and whether positions ascend from the first one of the file.
pub(super) fn series(
    rows: &[Row<'_>],
    targets: (Option<f64>, bool),
    sign: TableSign,
    intake: &Intake<'_>,
) -> Vec<Series> {
    let mut groups: BTreeMap<(Axis, Option<Direction>), Vec<&Row<'_>>> = BTreeMap::new();
    for row in rows {
        groups.entry((row.axis, row.direction)).or_default().push(row);
    }
    let series = groups.into_iter().filter_map(|((axis, direction), rows)| {
        Group { targets, axis, direction, rows, intake }.series(sign)
    });
    series.collect()
}

/// Rows of one axis and direction.
struct Group<'a, 'b> {
    targets: (Option<f64>, bool),
    axis: Axis,
    direction: Option<Direction>,
    rows: Vec<&'b Row<'a>>,
    intake: &'b Intake<'b>,
}

impl<'a, 'b> Group<'a, 'b> {
    /// The series; what was done is said once for all groups.
    fn series(&self, sign: TableSign) -> Option<Series> {
        let runs = self.runs()?;
        let positions: Vec<f64> = runs.first()?.iter().map(|row| row.position).collect();
        let placing = match self.targets.0 {
            Some(first) => self.placing(first, &positions)?,
            None => Placing::on_machine(&positions),
        };
        self.say(runs.len(), &placing);
        let mut series = Series::new(self.axis, self.direction, placing.positions.clone());
        for (index, (quantity, _)) in self.rows.first()?.values.iter().enumerate() {
            let of_run = |run: &Vec<&Row<'_>>| run.iter().map(|row| row.values[index].1).collect();
            let values: Vec<Vec<f64>> = runs.iter().map(of_run).collect();
            match self.component(*quantity) {
                Some(component) => placing.put(&mut series, component, sign, &values),
                None => {
                    let u: Vec<f64> = means(&values).iter().map(|(mean, _)| *mean).collect();
                    series.put(*quantity, placing.uncertainties(&u));
                }
            }
        }
        Some(series)
    }

    fn placing(&self, first: f64, positions: &[f64]) -> Option<Placing> {
        let row = self.rows.first()?;
        if (positions.first()? - first).abs() > SAME_PLACE_MM {
            return self.intake.notes.refused(refusals::other_first_target().at(row.line.whole()));
        }
        let first_mm = self.intake.stated.first_target_at_mm;
        Placing::of(positions, &row.line.whole(), first_mm, self.intake)
    }

    /// The component of a quantity.
    fn component(&self, quantity: Content) -> Option<Component> {
        match quantity {
            Content::Value(kind) => Some(Component { kind, along: self.axis }),
            _ => None,
        }
    }

    fn say(&self, runs: usize, placing: &Placing) {
        let quantities = self.rows.iter().take(1).flat_map(|row| &row.values);
        let components = quantities.filter_map(|(quantity, _)| self.component(*quantity));
        let components: Vec<Component> = components.collect();
        if self.targets.0.is_some() {
            self.intake.say_once([placing.found()]);
            self.intake.say_once(components.iter().filter_map(|c| placing.turned(*c)));
        }
        let is_deviation = |c: &Component| matches!(c.kind, Kind::Deviation(_));
        let u = match (components.iter().any(is_deviation), components.iter().all(is_deviation)) {
            (true, true) => "u = s/√runs (k = 1)",
            (true, false) => "u = s/√runs (k = 1) of the deviations; none is written for angles",
            _ => "no u is written for angles",
        };
        let direction = self.direction.map_or("both", Direction::symbol);
        let several = ImportFinding::RunsOf { runs, axis: self.axis, direction, u };
        self.intake.say_once((runs > 1).then_some(several));
        self.intake.say_once(freedom(placing.positions.len(), runs));
    }

    /// The rows of each run, in the order of their positions; all runs at the same positions.
    fn runs(&self) -> Option<Vec<Vec<&'b Row<'a>>>> {
        let mut runs: BTreeMap<u64, Vec<&'b Row<'a>>> = BTreeMap::new();
        for row in &self.rows {
            runs.entry(row.run).or_default().push(row);
        }
        let mut runs: Vec<Vec<&'b Row<'a>>> = runs.into_values().collect();
        let mut whole = true;
        for run in &mut runs {
            whole &= self.is_in_order(run);
            run.sort_by(|a, b| a.position.total_cmp(&b.position));
            if !self.targets.1 {
                run.reverse();
            }
            whole &= self.is_single(run);
        }
        let differ =
            |(a, b): (&&Row<'_>, &&Row<'_>)| (a.position - b.position).abs() > SAME_PLACE_MM;
        for run in runs.iter().skip(1) {
            if run.len() != runs[0].len() || run.iter().zip(&runs[0]).any(differ) {
                whole = self.refuse(run[0], refusals::other_run(run[0].run));
            }
        }
        if let ([run], true) = (&runs[..], whole)
            && let [row] = run[..]
        {
            whole = self.refuse(row, refusals::single_position(self.axis));
        }
        whole.then_some(runs)
    }

    fn refuse(&self, row: &Row<'_>, problem: Problem) -> bool {
        self.intake.notes.refuse_with(|| problem.at(row.line.whole()));
        false
    }

    /// A run goes one way: a row that turns back belongs to another run, or its number was misread.
    fn is_in_order(&self, run: &[&Row<'_>]) -> bool {
        let step = |pair: &[&Row<'_>]| pair[1].position - pair[0].position;
        let mut pairs = run.windows(2);
        let first = pairs.clone().map(step).find(|step| step.abs() > 0.0).unwrap_or_default();
        pairs.find(|pair| step(pair) * first < 0.0).is_none_or(|pair| {
            let way = if first > 0.0 { "ascend" } else { "descend" };
            self.refuse(pair[1], refusals::no_order(pair[1].position, pair[0].position, way))
        })
    }

    fn is_single(&self, run: &[&Row<'_>]) -> bool {
        let tidy = |row: &Row<'_>| tidy(row.position);
        let is_twice = |pair: &&[&Row<'_>]| tidy(pair[0]).total_cmp(&tidy(pair[1])).is_eq();
        let twice = run
            .windows(2)
            .filter(is_twice)
            .map(|pair| self.refuse(pair[1], refusals::position_twice(pair[1].position)));
        twice.count() == 0
    }
}
