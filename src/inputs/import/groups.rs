//! Rows of one axis and direction → one series of the error table.

use crate::inputs::error_table::DraftSeries;
use crate::inputs::import::choices::Sign;
use crate::inputs::import::mapped_rows::Row;
use crate::inputs::import::mapping::{Content, Mapping};
use crate::inputs::import::placing::{Placing, freedom_remark, mean, pooled, tidy};
use crate::inputs::import::stated::Stated;
use crate::inputs::import::{Component, Kind};
use crate::quantity::axis::{Axis, Direction};
use crate::text::problem::{Problem, Problems};
use std::collections::BTreeMap;

/// Two positions that are nearer than this are one, mm.
const SAME_MM: f64 = 1e-9;

/// Order of the targets from the first one of the file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Ascending,
    Descending,
}

/// The first row of the file holds its first target: one end, the same for every group of rows.
pub(super) fn target_order(rows: &[Row<'_>], mapping: &Mapping, problems: &mut Problems) -> Order {
    let Some(first) = rows.first().filter(|_| mapping.has_targets()) else {
        return Order::Ascending;
    };
    if let Some(other) = rows.iter().find(|row| row.axis != first.axis) {
        problems.push(
            Problem::new(
                "targets of two axes stand in one file, but one first target can be stated only",
            )
            .at(other.line.whole())
            .help("import one axis at a time, or map machine coordinates to `position_mm`"),
        );
    }
    let ends = |row: &Row<'_>| (row.position - first.position).total_cmp(&0.0);
    if rows.iter().all(|row| ends(row).is_ge()) {
        return Order::Ascending;
    }
    if !rows.iter().all(|row| ends(row).is_le()) {
        problems.push(
            Problem::new(
                "the first row is not at an end of the targets, so the first target is not known",
            )
            .at(first.line.whole())
            .help("sort the rows, beginning with target 1"),
        );
    }
    Order::Descending
}

/// Rows of one axis and direction.
pub(super) struct Group<'a, 'b> {
    pub(super) mapping: &'b Mapping,
    pub(super) order: Order,
    /// The first target of the file, mm.
    pub(super) first_target: f64,
    pub(super) axis: Axis,
    pub(super) direction: Option<Direction>,
    pub(super) rows: Vec<&'b Row<'a>>,
}

impl<'a, 'b> Group<'a, 'b> {
    /// The series; what was done is said once for all groups.
    pub(super) fn series(
        &self,
        sign: Sign,
        stated: &Stated,
        facts: &mut Vec<String>,
        problems: &mut Problems,
    ) -> Option<DraftSeries> {
        let runs = self.runs(problems)?;
        let positions: Vec<f64> = runs.first()?.iter().map(|row| row.position).collect();
        let placing = if self.mapping.has_targets() {
            Some(self.placing(&positions, stated, problems)?)
        } else {
            None
        };
        let known = freedom_remark(positions.len(), runs.len());
        for fact in self
            .facts(runs.len(), placing.as_ref())
            .into_iter()
            .chain(known)
        {
            if !facts.contains(&fact) {
                facts.push(fact);
            }
        }
        let mm = placing.as_ref().map_or_else(
            || positions.iter().map(|mm| tidy(*mm)).collect(),
            Placing::positions_mm,
        );
        let mut series = DraftSeries::new(self.axis, self.direction, mm);
        for (index, (_, content)) in self.mapping.columns.iter().enumerate() {
            let with = (sign, placing.as_ref());
            self.put(&mut series, index, *content, &runs, with);
        }
        Some(series)
    }

    fn placing(
        &self,
        positions: &[f64],
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<Placing> {
        let at = self.rows.first()?.line.whole();
        if (positions.first()? - self.first_target).abs() > SAME_MM {
            problems.push(
                Problem::new("these rows do not begin with the first target of the file")
                    .at(at)
                    .help("a missing value is never filled in: leave the run out"),
            );
            return None;
        }
        Placing::of(positions, &at, stated, problems)
    }

    /// The components that the mapped columns give.
    fn components(&self) -> Vec<Component> {
        let columns = self.mapping.columns.iter();
        columns
            .filter_map(|(_, content)| match content {
                Content::Value(kind, _) => Some(Component {
                    kind: *kind,
                    along: self.axis,
                }),
                _ => None,
            })
            .collect()
    }

    fn facts(&self, runs: usize, placing: Option<&Placing>) -> Vec<String> {
        let components = self.components();
        let mut facts = Vec::new();
        if let Some(placing) = placing {
            facts.extend(placing.words());
            facts.extend(components.iter().filter_map(|c| placing.sense_words(*c)));
        }
        if runs > 1 {
            let is_deviation = |c: &Component| matches!(c.kind, Kind::Deviation(_));
            let u = match (
                components.iter().any(is_deviation),
                components.iter().all(is_deviation),
            ) {
                (true, true) => "u = s/√runs (k = 1)",
                (true, false) => {
                    "u = s/√runs (k = 1) of the deviations; none is written for angles"
                }
                _ => "no u is written for angles",
            };
            let travel = self.direction.map_or("both", Direction::symbol);
            facts.push(format!(
                "runs: {runs} of {}, direction {travel}; their mean, {u}",
                self.axis
            ));
        }
        facts
    }

    /// The rows of each run, in the order of their positions; all runs at the same positions.
    fn runs(&self, problems: &mut Problems) -> Option<Vec<Vec<&'b Row<'a>>>> {
        let mut runs: BTreeMap<usize, Vec<&'b Row<'a>>> = BTreeMap::new();
        for row in &self.rows {
            runs.entry(row.run).or_default().push(row);
        }
        let mut runs: Vec<Vec<&'b Row<'a>>> = runs.into_values().collect();
        let mut found = Problems::none();
        for run in &mut runs {
            refuse_broken_order(run, &mut found);
            run.sort_by(|a, b| a.position.total_cmp(&b.position));
            if self.order == Order::Descending {
                run.reverse();
            }
        }
        let first = runs.first()?;
        for run in &runs {
            refuse_twice(run, &mut found);
            refuse_other_positions(run, first, &mut found);
        }
        if let ([run], true) = (&runs[..], found.is_empty()) {
            refuse_single(self.axis, run, &mut found);
        }
        let is_good = found.is_empty();
        problems.extend(found);
        is_good.then_some(runs)
    }

    fn put(
        &self,
        series: &mut DraftSeries,
        index: usize,
        content: Content,
        runs: &[Vec<&Row<'_>>],
        (sign, placing): (Sign, Option<&Placing>),
    ) {
        let points = runs.first().map_or(0, Vec::len);
        let figures: Vec<(f64, Option<f64>)> = (0..points)
            .map(|point| {
                let values = runs.iter().filter_map(|run| run.get(point)?.numbers[index]);
                mean(&values.collect::<Vec<f64>>())
            })
            .collect();
        let means: Vec<f64> = figures.iter().map(|(mean, _)| *mean).collect();
        let uncertainties = |u: &[f64]| match placing {
            Some(placing) => placing.uncertainties(u),
            None => u.iter().map(|u| tidy(*u)).collect(),
        };
        match content {
            Content::Value(kind, _) => {
                let along = self.axis;
                let component = Component { kind, along };
                let values = match placing {
                    Some(placing) => placing.deviations(&means, component, sign),
                    None => means.iter().map(|v| tidy(sign.deviation(*v))).collect(),
                };
                component.put(series, values);
                let spread: Option<Vec<f64>> = figures.iter().map(|(_, u)| *u).collect();
                if let (Kind::Deviation(of), Some(u)) = (kind, spread) {
                    series.uncertainties_um[of] = Some(uncertainties(&pooled(&u)));
                }
            }
            Content::Uncertainty(of, _) => {
                series.uncertainties_um[of] = Some(uncertainties(&means));
            }
            _ => {}
        }
    }
}

/// A run goes one way: a row that turns back belongs to another run, or its number was misread.
fn refuse_broken_order(run: &[&Row<'_>], problems: &mut Problems) {
    let steps = || {
        run.windows(2)
            .map(|pair| (pair[1].position - pair[0].position, pair))
    };
    let Some((first, _)) = steps().find(|(step, _)| step.abs() > 0.0) else {
        return;
    };
    let turned = steps().find(|(step, _)| step * first < 0.0);
    if let Some((_, pair)) = turned {
        problems.push_with(|| {
            Problem::new(format!(
                "position {} comes after {}, but the rows above {}: expected one order in a run",
                pair[1].position,
                pair[0].position,
                if first > 0.0 { "ascend" } else { "descend" }
            ))
            .at(pair[1].line.whole())
            .help("look for a sign between thousands; else map the number of the run (`…=run`), or sort the rows")
        });
    }
}

fn refuse_twice(run: &[&Row<'_>], problems: &mut Problems) {
    for pair in run.windows(2) {
        if tidy(pair[0].position)
            .total_cmp(&tidy(pair[1].position))
            .is_eq()
        {
            problems.push_with(|| {
                Problem::new(format!("position {} stands twice", pair[1].position))
                    .at(pair[1].line.whole())
                    .help("map the number of the run (`…=run`) or the direction of travel (`…=direction`), or leave one row out")
            });
        }
    }
}

fn refuse_other_positions(run: &[&Row<'_>], first: &[&Row<'_>], problems: &mut Problems) {
    let mut pairs = run.iter().zip(first);
    let differ = |(a, b): (&&Row<'_>, &&Row<'_>)| (a.position - b.position).abs() > SAME_MM;
    let (true, Some(row)) = (run.len() != first.len() || pairs.any(differ), run.first()) else {
        return;
    };
    problems.push_with(|| {
        Problem::new(format!(
            "run {} does not have the positions of the first run",
            row.run
        ))
        .at(row.line.whole())
        .help("a missing value is never filled in: leave the run out")
    });
}

fn refuse_single(axis: Axis, run: &[&Row<'_>], problems: &mut Problems) {
    if let [row] = run {
        problems.push(
            Problem::new(format!(
                "axis {axis} has a single position, expected at least two"
            ))
            .at(row.line.whole())
            .help("one position makes no curve"),
        );
    }
}
