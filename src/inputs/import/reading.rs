//! What every format is read into: passes over targets or rows of a table, as the file counts them → machine
//! coordinates, the mean of the runs and its uncertainty → series of the error table.

use crate::control::controller::TableSign;
use crate::inputs::error_table::{Component, Kind, Series};
use crate::inputs::findings::ImportFinding;
use crate::inputs::import::intake::{Contents, Intake};
use crate::inputs::import::stated::{FIRST_TARGET, TARGETS_RUN};
use crate::inputs::refusals;
use crate::inputs::table::Content;
use crate::quantity::{
    Axis, Deviation, Direction, Millimetres, Pass, SAME_PLACE_MM, Squared, rounded,
};
use crate::text::{Line, Place, Problem};
use std::collections::BTreeMap;

/// Nine decimals: far below what can be measured, and free of the dust of binary sums.
pub(super) fn tidy(number: f64) -> f64 {
    rounded(number, 9)
}

/// A value of a file as a deviation.
pub(super) fn deviation(sign: TableSign, value: f64) -> Deviation {
    -sign.correction(value)
}

/// The runs of each way over the targets of the file (`None` = not distinguished), their values in the order of the
/// targets.
pub(super) type Ways = Vec<(Option<Pass>, Vec<Vec<f64>>)>;

/// Passes over the targets of one axis.
pub(super) struct Passes {
    /// As the file counts them, mm.
    pub(super) targets: Vec<f64>,
    pub(super) place: Place,
    /// µm.
    pub(super) ways: Ways,
}

impl Passes {
    /// The contents of a file of one component, which must be known by now with its sign. `of_runs` is said
    /// behind the places.
    pub(super) fn contents(
        &self,
        term: Option<Component>,
        sign: Option<TableSign>,
        of_runs: Vec<ImportFinding>,
        intake: &Intake<'_>,
    ) -> Option<Contents> {
        let first_mm = intake.stated.first_target_at_mm;
        let placing = Placing::of(&self.targets, &self.place, first_mm, intake);
        let (term, sign, placing) = (term?, sign?, placing?);
        intake.say([placing.found()].into_iter().chain(placing.turned(term)).chain(of_runs));
        let series = self.ways.iter().map(|(way, runs)| {
            let mut series =
                Series::new(term.along, placing.direction(*way), placing.positions.clone());
            placing.put(&mut series, term, sign, runs);
            series
        });
        let mut series: Vec<Series> = series.collect();
        series.sort_by_key(|series| series.direction);
        Some((series, Vec::new()))
    }

    /// How many runs went which way, and what they tell of the uncertainty.
    pub(super) fn of_runs(&self, intake: &Intake<'_>) -> Vec<ImportFinding> {
        // Where it is not stated, nothing is said of the file but that.
        let run = intake.stated.targets_run.unwrap_or(Direction::Plus);
        let counts = self.ways.iter().map(|(way, runs)| (runs.len(), travelled(*way, run)));
        let counts: Vec<(usize, Direction)> = counts.collect();
        let fewest = counts.iter().map(|(runs, _)| *runs).min().unwrap_or(0);
        let freedom = freedom(self.targets.len(), fewest);
        std::iter::once(ImportFinding::Runs { counts, fewest }).chain(freedom).collect()
    }
}

/// Where the targets of a file stand on the machine.
pub(super) struct Placing {
    /// Machine coordinates, ascending.
    pub(super) positions: Vec<Millimetres>,
    /// The way of the axis from the first target to the last.
    run: Direction,
    /// The file counts its targets against the axis.
    turned: bool,
}

impl Placing {
    /// From what was stated; what is missing is noted.
    pub(super) fn of(
        targets: &[f64],
        at: &Place,
        first_mm: Option<f64>,
        intake: &Intake<'_>,
    ) -> Option<Placing> {
        let ascending = ascends(targets);
        let run = intake.stated.targets_run;
        if ascending.is_none() {
            intake.notes.refuse(refusals::no_sense_of_targets().at(at.clone()));
        }
        let lacking = [(&FIRST_TARGET, first_mm.is_none()), (&TARGETS_RUN, run.is_none())];
        for (fact, _) in lacking.iter().filter(|(_, is)| *is) {
            intake.notes.refuse(fact.missing().at(at.clone()));
        }
        let (first_mm, run) = (first_mm?, run?);
        let turned = ascending? != (run == Direction::Plus);
        let positions = targets.iter().map(|target| {
            let way = target - targets[0];
            Millimetres::new(tidy(first_mm + if turned { -way } else { way }))
        });
        let mut placing = Placing { positions: Vec::new(), run, turned };
        placing.positions = placing.ascending(positions.collect());
        Some(placing)
    }

    /// Of machine coordinates, ascending.
    pub(super) fn on_machine(positions_mm: &[f64]) -> Placing {
        Placing {
            positions: positions_mm.iter().map(|mm| Millimetres::new(tidy(*mm))).collect(),
            run: Direction::Plus,
            turned: false,
        }
    }

    /// Values of the targets in the order of the machine.
    fn ascending<T>(&self, mut of_targets: Vec<T>) -> Vec<T> {
        if self.run == Direction::Minus {
            of_targets.reverse();
        }
        of_targets
    }

    /// The way of the axis in passes of one way.
    pub(super) fn direction(&self, way: Option<Pass>) -> Option<Direction> {
        way.map(|_| travelled(way, self.run))
    }

    /// Values of a file in the order of its targets → deviations in the order of the machine.
    pub(super) fn deviations(&self, um: &[f64], component: Component, sign: TableSign) -> Vec<f64> {
        let against = self.turned && component.is_positioning();
        let of_target = |um: &f64| {
            let deviation = deviation(sign, *um);
            let zero = Deviation::ZERO;
            tidy(if against { zero - deviation } else { deviation }.um())
        };
        self.ascending(um.iter().map(of_target).collect())
    }

    /// Puts the mean of the runs into a series, and of a deviation its uncertainty: one u for all targets,
    /// from their scatter together. That of a single one is known too badly, and two equal readings at a
    /// target do not make it exact.
    pub(super) fn put(
        &self,
        series: &mut Series,
        component: Component,
        sign: TableSign,
        runs: &[Vec<f64>],
    ) {
        let figures = means(runs);
        let of_targets: Vec<f64> = figures.iter().map(|(mean, _)| *mean).collect();
        series.put(Content::Value(component.kind), self.deviations(&of_targets, component, sign));
        let scatter: Option<Vec<f64>> = figures.iter().map(|(_, u)| *u).collect();
        if let (Kind::Deviation(_), Some(u)) = (component.kind, scatter) {
            let mean_square = u.iter().map(|u| u.squared()).sum::<f64>() / u.len() as f64;
            let u = vec![tidy(mean_square.sqrt()); u.len()];
            series.put(Content::Uncertainty(component.kind), u);
        }
    }

    /// Where the targets stand.
    pub(super) fn found(&self) -> ImportFinding {
        let end = |at: Option<&Millimetres>| at.map_or_else(String::new, |at| at.mm().to_string());
        let [first, last] = [self.positions.first(), self.positions.last()].map(end);
        ImportFinding::Positions { count: self.positions.len(), first, last }
    }

    /// What was done with the sense of the deviations, where something was done.
    pub(super) fn turned(&self, component: Component) -> Option<ImportFinding> {
        let is_turned = self.turned && component.is_positioning();
        is_turned.then_some(ImportFinding::Turned { component })
    }
}

/// The way of an axis that moves as `run` says from the first target to the last.
fn travelled(way: Option<Pass>, run: Direction) -> Direction {
    if way == Some(Pass::Reverse) { run.opposite() } else { run }
}

/// Whether targets ascend; `None` = they neither ascend nor descend.
fn ascends(targets: &[f64]) -> Option<bool> {
    let ascending = targets.is_sorted_by(|a, b| a < b);
    let in_order = targets.len() >= 2 && (ascending || targets.is_sorted_by(|a, b| a > b));
    in_order.then_some(ascending)
}

/// The remark of an error table on how well u is known: targets · (runs − 1).
pub(super) fn freedom(targets: usize, runs: usize) -> Option<ImportFinding> {
    let degrees = targets * runs.saturating_sub(1);
    (degrees > 0).then_some(ImportFinding::Freedom { degrees })
}

/// For each target the mean of the runs, and with two runs or more its standard uncertainty s/√n.
pub(super) fn means(runs: &[Vec<f64>]) -> Vec<(f64, Option<f64>)> {
    let targets = runs.first().map_or(0, Vec::len);
    let of_target = |target: usize| {
        let values: Vec<f64> = runs.iter().map(|run| run[target]).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares = values.iter().map(|value| (value - mean).squared());
        let variance = squares.sum::<f64>() / (count - 1.0) / count;
        (mean, (values.len() > 1).then(|| variance.sqrt()))
    };
    (0..targets).map(of_target).collect()
}

/// A reversal above this is no scatter (the limit of `generate`), µm.
const NOTABLE_UM: f64 = 0.5;

/// Each axis whose positioning has a reversal B > 0: the one figure that shows a direction or
/// a sign taken wrongly.
///
/// formula B = mean deviation moving + minus mean deviation moving −, over all positions (ISO 230-2)
/// limits  positions of the two directions are not compared: it is a warning, no figure
pub(super) fn unlikely_reversals(series: &[Series]) -> Vec<ImportFinding> {
    let mean_um = |axis: Axis, direction: Direction| {
        let mut of_axis = series.iter().filter(|s| s.axis == axis);
        let series = of_axis.find(|s| s.direction == Some(direction))?;
        let values = series.values.get(&Kind::Deviation(axis))?;
        Some(values.iter().sum::<f64>() / values.len() as f64)
    };
    let of = |axis: Axis| {
        let um = mean_um(axis, Direction::Plus)? - mean_um(axis, Direction::Minus)?;
        (um > NOTABLE_UM).then_some(ImportFinding::UnlikelyReversal { axis, um })
    };
    Axis::ALL.into_iter().filter_map(of).collect()
}

/// A row whose mapped cells could be read.
pub(super) struct ImportRow<'a> {
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
pub(super) fn is_ascending(rows: &[ImportRow<'_>], intake: &Intake<'_>) -> bool {
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
    rows: &[ImportRow<'_>],
    targets: (Option<f64>, bool),
    sign: TableSign,
    intake: &Intake<'_>,
) -> Vec<Series> {
    let mut groups: BTreeMap<(Axis, Option<Direction>), Vec<&ImportRow<'_>>> = BTreeMap::new();
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
    rows: Vec<&'b ImportRow<'a>>,
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
            let of_run =
                |run: &Vec<&ImportRow<'_>>| run.iter().map(|row| row.values[index].1).collect();
            let values: Vec<Vec<f64>> = runs.iter().map(of_run).collect();
            match *quantity {
                Content::Value(kind) => {
                    placing.put(&mut series, Component { kind, along: self.axis }, sign, &values);
                }
                _ => {
                    let u = means(&values).iter().map(|(mean, _)| tidy(*mean)).collect();
                    series.put(*quantity, placing.ascending(u));
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

    fn say(&self, runs: usize, placing: &Placing) {
        let quantities = self.rows.iter().take(1).flat_map(|row| &row.values);
        let components = quantities.filter_map(|(quantity, _)| match *quantity {
            Content::Value(kind) => Some(Component { kind, along: self.axis }),
            _ => None,
        });
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
    fn runs(&self) -> Option<Vec<Vec<&'b ImportRow<'a>>>> {
        let mut runs: BTreeMap<u64, Vec<&'b ImportRow<'a>>> = BTreeMap::new();
        for row in &self.rows {
            runs.entry(row.run).or_default().push(row);
        }
        let mut runs: Vec<Vec<&'b ImportRow<'a>>> = runs.into_values().collect();
        let mut whole = true;
        for run in &mut runs {
            whole &= self.is_in_order(run);
            run.sort_by(|a, b| a.position.total_cmp(&b.position));
            if !self.targets.1 {
                run.reverse();
            }
            whole &= self.is_single(run);
        }
        let differ = |(a, b): (&&ImportRow<'_>, &&ImportRow<'_>)| {
            (a.position - b.position).abs() > SAME_PLACE_MM
        };
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

    fn refuse(&self, row: &ImportRow<'_>, problem: Problem) -> bool {
        self.intake.notes.refuse_with(|| problem.at(row.line.whole()));
        false
    }

    /// A run goes one way: a row that turns back belongs to another run, or its number was misread.
    fn is_in_order(&self, run: &[&ImportRow<'_>]) -> bool {
        let step = |pair: &[&ImportRow<'_>]| pair[1].position - pair[0].position;
        let mut pairs = run.windows(2);
        let first = pairs.clone().map(step).find(|step| step.abs() > 0.0).unwrap_or_default();
        pairs.find(|pair| step(pair) * first < 0.0).is_none_or(|pair| {
            let way = if first > 0.0 { "ascend" } else { "descend" };
            self.refuse(pair[1], refusals::no_order(pair[1].position, pair[0].position, way))
        })
    }

    fn is_single(&self, run: &[&ImportRow<'_>]) -> bool {
        let tidy = |row: &ImportRow<'_>| tidy(row.position);
        let twice = run
            .windows(2)
            .filter(|pair| tidy(pair[0]).total_cmp(&tidy(pair[1])).is_eq())
            .map(|pair| self.refuse(pair[1], refusals::position_twice(pair[1].position)));
        twice.count() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uncertainty_of_a_mean_is_s_over_the_root_of_n() {
        // Two readings d apart: s = d/√2, s/√2 = d/2.
        let runs = [vec![1.0, 2.0], vec![3.0, 2.0]];
        assert_eq!(means(&runs), [(2.0, Some(1.0)), (2.0, Some(0.0))]);
        assert_eq!(means(&[vec![4.0]]), [(4.0, None)]);
    }
}
