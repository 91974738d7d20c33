//! What every format is read into: passes over targets, as the file counts them → machine coordinates, the
//! mean of the runs and its uncertainty → series of the error table.

use crate::control::controller::TableSign;
use crate::inputs::error_table::{Component, Kind, Series};
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::intake::{Contents, Intake};
use crate::inputs::import::stated::{FIRST_TARGET, TARGETS_RUN};
use crate::inputs::refusals;
use crate::inputs::table::Content;
use crate::quantity::{Axis, Deviation, Direction, Millimetres, Pass, Squared, rounded};
use crate::text::Place;

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
        let Some(run) = intake.stated.targets_run else {
            return Vec::new();
        };
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

    /// Uncertainties in the order of the machine; they have no sign.
    pub(super) fn uncertainties(&self, um: &[f64]) -> Vec<f64> {
        self.ascending(um.iter().map(|um| tidy(*um)).collect())
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
        let deviations = self.deviations(&of_targets, component, sign);
        series.put(Content::Value(component.kind), deviations);
        let scatter: Option<Vec<f64>> = figures.iter().map(|(_, u)| *u).collect();
        if let (Kind::Deviation(of), Some(u)) = (component.kind, scatter) {
            let mean_square = u.iter().map(|u| u.squared()).sum::<f64>() / float(u.len());
            series.uncertainties_um[of] = Some(vec![tidy(mean_square.sqrt()); u.len()]);
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

fn float(count: usize) -> f64 {
    count as f64
}

/// For each target the mean of the runs, and with two runs or more its standard uncertainty s/√n.
pub(super) fn means(runs: &[Vec<f64>]) -> Vec<(f64, Option<f64>)> {
    let targets = runs.first().map_or(0, Vec::len);
    let of_target = |target: usize| {
        let values: Vec<f64> = runs.iter().map(|run| run[target]).collect();
        let count = float(values.len());
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
        let values = series.deviations[axis].as_ref()?;
        Some(values.iter().map(|value| value.um()).sum::<f64>() / float(values.len()))
    };
    let of = |axis: Axis| {
        let um = mean_um(axis, Direction::Plus)? - mean_um(axis, Direction::Minus)?;
        (um > NOTABLE_UM).then_some(ImportFinding::UnlikelyReversal { axis, um })
    };
    Axis::ALL.into_iter().filter_map(of).collect()
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
