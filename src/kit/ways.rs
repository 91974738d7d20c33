//! What to change where a kit does not keep its limit: what every other backlash policy would leave;
//! and on a second visit, whether the control is best left as it is.

use crate::inputs::job::{BacklashPolicy, MeasuredData};
use crate::judge::after::Bare;
use crate::judge::conformity::Verdict;
use crate::judge::forecast::{Forecast, Machine, forecast, judged_ranges};
use crate::kit::inputs::{Inputs, judged};
use crate::quantity::axis::{ErrorTerm, PerAxis};
use crate::quantity::units::larger;
use crate::read::emulate::Emulator;
use crate::read::emulator;
use crate::text::finding::{Finding, findings};
use crate::write::compensation::Placement;
use crate::write::plan::{Plan, plan};

/// What the last printed digit does not show is no gain, µm.
const SHOWN_UM: f64 = 0.001;

findings! {
    /// What a person may change.
    Way {
        AsItIs { largest_um: f64 } => Label,
            "as measured, with what is active now, every limit is kept (at most {largest_um:.3} µm): the control can be left as it is";
        Backlash { policy: BacklashPolicy, largest_um: f64, tables: usize, verdict: Verdict } => Label,
            "`backlash = \"{}\"` would leave at most {largest_um:.3} µm with {tables} tables: {}", policy.word(), verdict.word();
        Grid { terms: Vec<ErrorTerm>, largest_um: f64 } => Label,
            "{}: the points of the tables leave up to {largest_um:.3} µm of it; closer points (`spacing_mm`, `points`, `max_residual_um`) leave less", names(terms);
        NoTable { terms: Vec<ErrorTerm> } => Label,
            "{}: no table holds it, so all of it is left", names(terms);
        Uncertain { terms: Vec<ErrorTerm> } => Label,
            "{}: within the limit, but not with its U; measure with more runs or less noise", names(terms);
    }
}

/// Names of terms, as in `EXX, EYX`.
fn names(terms: &[ErrorTerm]) -> String {
    let names: Vec<String> = terms.iter().map(ToString::to_string).collect();
    names.join(", ")
}

/// The ways to another answer; none where the kit keeps its limit and nothing was active.
pub(super) fn ways(
    inputs: &Inputs,
    made: &Plan,
    placements: &[Placement],
    forecast: &Forecast,
    doubts: &[Finding],
) -> Vec<Finding> {
    if inputs.job.acceptance.asks_nothing() {
        return Vec::new();
    }
    let mut ways: Vec<Way> = as_found(inputs, made, doubts).into_iter().collect();
    let judged = judged(forecast, inputs, doubts);
    if judged != Verdict::Pass {
        ways.extend(other_policies(
            inputs,
            judged,
            forecast.max_residual_um(),
            doubts,
        ));
        ways.extend(of_terms(inputs, placements, forecast));
    }
    ways.into_iter().map(Finding::from).collect()
}

/// What keeps single terms from their limit: points too far apart, no table, a large U.
fn of_terms(inputs: &Inputs, placements: &[Placement], forecast: &Forecast) -> Vec<Way> {
    let Some(limit_um) = inputs.job.acceptance.max_deviation_um else {
        return Vec::new();
    };
    let grid_um = |term: ErrorTerm| {
        let own = placements.iter().filter(|p| p.term == term);
        own.map(|p| p.grid_residual_um).fold(0.0, larger)
    };
    let (mut grid, mut none, mut uncertain) = (Vec::new(), Vec::new(), Vec::new());
    for t in &forecast.terms {
        if t.change.after_um + t.change.expanded_um.unwrap_or(0.0) <= limit_um {
            continue;
        }
        if t.change.after_um <= limit_um {
            uncertain.push(t.term);
        } else if !t.compensated {
            none.push(t.term);
        } else if 2.0 * grid_um(t.term) >= t.change.after_um {
            grid.push(t.term);
        }
    }
    let largest_um = grid.iter().map(|term| grid_um(*term)).fold(0.0, larger);
    let ways = [
        (
            grid.is_empty(),
            Way::Grid {
                terms: grid,
                largest_um,
            },
        ),
        (none.is_empty(), Way::NoTable { terms: none }),
        (uncertain.is_empty(), Way::Uncertain { terms: uncertain }),
    ];
    let ways = ways.into_iter().filter(|(empty, _)| !empty);
    ways.map(|(_, way)| way).collect()
}

/// Where tables were active while measuring and what they left keeps every limit.
fn as_found(inputs: &Inputs, made: &Plan, doubts: &[Finding]) -> Option<Way> {
    inputs.under_tables.as_ref()?;
    let model = inputs.as_measured();
    let ranges = judged_ranges(&inputs.job, model);
    let found = forecast(Machine::alone(model), made, &Bare, &ranges).ok()?;
    let largest_um = found.max_residual_um();
    (judged(&found, inputs, doubts) == Verdict::Pass).then_some(Way::AsItIs { largest_um })
}

/// The policies that come to a better verdict, or leave less where the limit is exceeded, the best first.
/// What the control refuses is no way.
fn other_policies(inputs: &Inputs, verdict: Verdict, left_um: f64, doubts: &[Finding]) -> Vec<Way> {
    // What acted while measuring, and readings, are taken into the errors by the policy of the job itself.
    let is_table = matches!(inputs.job.measurement.data, MeasuredData::Errors(_));
    if inputs.active.is_some() || !is_table {
        return Vec::new();
    }
    let own = &inputs.job.compensation.backlash;
    if own.iter().all(|(_, policy)| policy.is_none()) {
        return Vec::new();
    }
    let is_other = |policy: &BacklashPolicy| own.iter().any(|(_, own)| *own != Some(*policy));
    let others = BacklashPolicy::ALL.into_iter().filter(is_other);
    let mut ways: Vec<(Verdict, f64, Way)> = others
        .filter_map(|policy| with_policy(inputs, policy, doubts))
        .filter(|(other, um, _)| {
            *other < verdict || verdict == Verdict::Fail && *um < left_um - SHOWN_UM
        })
        .collect();
    ways.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    ways.into_iter().map(|(_, _, way)| way).collect()
}

fn with_policy(
    inputs: &Inputs,
    policy: BacklashPolicy,
    doubts: &[Finding],
) -> Option<(Verdict, f64, Way)> {
    let mut inputs = inputs.clone();
    inputs.job.compensation.backlash = PerAxis::from_fn(|_| Some(policy));
    let made = plan(inputs.task()).ok()?;
    let compiled = inputs.compile(&made).ok()?;
    let control: Box<dyn Emulator> =
        emulator(&inputs.profile, &compiled.tables, &compiled.state).ok()?;
    let ranges = judged_ranges(&inputs.job, inputs.as_measured());
    let left = forecast(inputs.machine(), &made, control.as_ref(), &ranges).ok()?;
    let (verdict, largest_um) = (judged(&left, &inputs, doubts), left.max_residual_um());
    let tables = compiled.placements.len();
    Some((
        verdict,
        largest_um,
        Way::Backlash {
            policy,
            largest_um,
            tables,
            verdict,
        },
    ))
}
