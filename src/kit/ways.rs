//! What to change where a kit does not keep its limit: what other backlash policies would leave; and on a second
//! visit, whether the control is best left as it is.

use crate::inputs::job::{Acceptance, BacklashPolicy, policies_as_stated};
use crate::judge::conformity::Verdict;
use crate::judge::field::Field;
use crate::judge::forecast::{Forecast, Machine, forecast, judged_ranges};
use crate::kit::alternatives::{Alternative, other_policies};
use crate::kit::inputs::judged;
use crate::kit::made::Made;
use crate::quantity::{ErrorTerm, PerAxis, larger};
use crate::text::{Finding, findings, joined};

/// What the last printed digit does not show is no gain, µm.
const SHOWN_UM: f64 = 0.001;

findings! {
    /// What a person may change.
    Way {
        AsItIs { left: Left } => Label,
            "as measured, with what is active now, every limit is kept ({}): the control can be left as it is", left.words();
        Backlash { policies: PerAxis<Option<BacklashPolicy>>, left: Left, tables: usize, verdict: Verdict } => Label,
            "`backlash = {}` would leave {} with {tables} {}: {}", policies_as_stated(policies), left.words(), if *tables == 1 { "table" } else { "tables" }, verdict.word();
        Grid { terms: Vec<ErrorTerm>, largest_um: f64 } => Label,
            "{}: the points of the tables leave up to {largest_um:.3} µm of it; closer points (`spacing_mm`, `points`, `max_residual_um`) leave less", joined(terms);
        NoTable { terms: Vec<ErrorTerm> } => Label,
            "{}: no table holds it, so all of it is left", joined(terms);
    }
}

/// The largest of the figures that a job limits, µm; `None` = not limited, or there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Left {
    terms_um: Option<f64>,
    diagonals_um: Option<f64>,
}

impl Left {
    fn of(forecast: &Forecast, asked: Acceptance) -> Left {
        let terms = asked.max_deviation_um.map(|_| forecast.max_residual_um());
        let diagonals = forecast.diagonals.iter().map(|d| d.change.after_um);
        let diagonals = diagonals.reduce(larger);
        Left {
            terms_um: terms,
            diagonals_um: diagonals.filter(|_| asked.max_diagonal_um.is_some()),
        }
    }

    /// By how much the worst of them exceeds its limit, µm; below 0 where all keep theirs.
    fn excess_um(self, asked: Acceptance) -> f64 {
        let over = |um: Option<f64>, limit: Option<f64>| Some(um? - limit?);
        let all = [
            over(self.terms_um, asked.max_deviation_um),
            over(self.diagonals_um, asked.max_diagonal_um),
        ];
        let worst = all.into_iter().flatten().reduce(f64::max);
        worst.unwrap_or(f64::INFINITY)
    }

    fn words(self) -> String {
        let terms = self.terms_um.map(|um| format!("at most {um:.3} µm"));
        let diagonals = self.diagonals_um;
        let diagonals = diagonals.map(|um| format!("at most {um:.3} µm on the diagonals"));
        let both: Vec<String> = terms.into_iter().chain(diagonals).collect();
        both.join(" and ")
    }
}

/// The ways to another answer; none where the kit keeps its limit and nothing was active.
pub(super) fn ways(made: &Made<'_>) -> Vec<Finding> {
    if made.inputs.job.acceptance.asks_nothing() {
        return Vec::new();
    }
    let mut ways: Vec<Way> = as_found(made).into_iter().collect();
    if made.verdict != Verdict::Pass {
        ways.extend(policies(made));
        ways.extend(of_terms(made));
    }
    ways.into_iter().map(Finding::from).collect()
}

/// What keeps single terms from their limit: points too far apart, no table.
fn of_terms(made: &Made<'_>) -> Vec<Way> {
    let Some(limit_um) = made.inputs.job.acceptance.max_deviation_um else {
        return Vec::new();
    };
    let grid_um = |term: ErrorTerm| {
        let own = made.compiled.placements.iter().filter(|p| p.term == term);
        own.map(|p| p.grid_residual_um).fold(0.0, larger)
    };
    let left = made.forecast.terms.iter().filter(|t| t.change.after_um > limit_um);
    let (held, none): (Vec<_>, Vec<_>) = left.partition(|t| t.compensated);
    let grid = held.into_iter().filter(|t| 2.0 * grid_um(t.term) >= t.change.after_um);
    let grid: Vec<ErrorTerm> = grid.map(|t| t.term).collect();
    let none: Vec<ErrorTerm> = none.into_iter().map(|t| t.term).collect();
    let largest_um = grid.iter().map(|term| grid_um(*term)).fold(0.0, larger);
    let grid = (!grid.is_empty()).then_some(Way::Grid { terms: grid, largest_um });
    let none = (!none.is_empty()).then_some(Way::NoTable { terms: none });
    grid.into_iter().chain(none).collect()
}

/// Where tables were active while measuring and what they left keeps every limit.
fn as_found(made: &Made<'_>) -> Option<Way> {
    let inputs = made.inputs;
    inputs.under_tables.as_ref()?;
    let model = inputs.as_measured();
    let ranges = judged_ranges(&inputs.job, model);
    let found = forecast(Machine::alone(model), &made.plan, &Field::default(), &ranges);
    let left = Left::of(&found, inputs.job.acceptance);
    (judged(&found, inputs, &made.doubts) == Verdict::Pass).then_some(Way::AsItIs { left })
}

/// The policies that come to a better verdict, or leave less where the limit is exceeded, the best first.
/// What the control refuses is no way.
fn policies(made: &Made<'_>) -> Vec<Way> {
    let asked = made.inputs.job.acceptance;
    let excess_um = |forecast: &Forecast| Left::of(forecast, asked).excess_um(asked);
    let own_um = excess_um(&made.forecast);
    let is_better = |(other, um): &(Alternative, f64)| {
        other.verdict < made.verdict || made.verdict == Verdict::Fail && *um < own_um - SHOWN_UM
    };
    let others = other_policies(&made.inputs.job.compensation.backlash).into_iter();
    let others = others.filter_map(|policies| {
        let other = Alternative::of(made.inputs, |asked| asked.backlash = policies).ok()?;
        let um = excess_um(&other.forecast);
        Some((other, um))
    });
    let mut better: Vec<(Alternative, f64)> = others.filter(is_better).collect();
    better.sort_by(|a, b| a.0.verdict.cmp(&b.0.verdict).then(a.1.total_cmp(&b.1)));
    let way = |(other, _): (Alternative, f64)| Way::Backlash {
        policies: other.backlash,
        left: Left::of(&other.forecast, asked),
        tables: other.tables,
        verdict: other.verdict,
    };
    better.into_iter().map(way).collect()
}
