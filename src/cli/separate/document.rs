//! The documents of `separate --format json` (contract §5). Lengths and angles are rounded where a
//! document is printed; here only what has no unit.

use super::words::{Found, advice};
use crate::cli::diagonals::diagonal_json;
use crate::cli::outcome::{joined, known};
use crate::inputs::job::SetUp;
use crate::machine::separation::Separation;
use crate::machine::separation::metric::{Agreement, LineCheck};
use crate::machine::separation::readings::{Noise, coverage_factor};
use crate::machine::separation::reversal::Turn;
use crate::machine::separation::solved::scale_sum_um_mm;
use crate::machine::standards::{Diagonals, repeatability_um};
use crate::quantity::{
    Diagonal, Direction, Listed, Pass, PerAxis, PerDiagonal, PerTerm, Volume, picometres,
};
use crate::text::Finding;
use serde_json::{Map, Value, json};

pub(super) fn separation((separation, figures, simulated): Found<'_>) -> Value {
    known([
        slopes(separation),
        closure(separation),
        json!({
            "rank": {
                "rank": separation.rank().0,
                "unknowns": separation.rank().1,
                "undetermined": separation.undetermined,
                "advice": open_advice(separation),
            },
            "outliers": separation.closure.outliers,
            "diagonals": diagonals(figures, &separation.volume, &separation.end_um, |diagonal| {
                let of = |pass| repeatability_um(&separation.runs, diagonal, pass);
                json!({ "repeatability_um": { "forward": of(Pass::Forward), "reverse": of(Pass::Reverse) } })
            }),
            "noise": separation.noise.map(|found| {
                let test = separation.closure.test(&found);
                joined([noise(found), json!({ "closure_probability": test.map(|test| test.probability) })])
            }),
        }),
        separation.turn.as_ref().map_or(Value::Null, reversal),
        json!({
            "separated_slope_um_per_m": separation.naive_slopes_um_per_m,
            "shape_um": separation.shapes,
            "monte_carlo": simulated,
            "doubts": separation.doubts,
        }),
        json!(separation.silence),
        json!({ "labels": separation.labels }),
    ])
}

/// The nine errors, squareness and tilts of the mirror.
fn slopes(separation: &Separation) -> Value {
    let metric = &separation.metric;
    let u_squareness = metric.u_squareness();
    let tilts = separation.tilts.as_ref();
    json!({
        "schema": 1,
        "errors": errors(separation),
        "squareness_um_per_m": metric.squareness_um_per_m(),
        "u_squareness_um_per_m": u_squareness.map(|u| Some(u?.u)),
        "squareness_freedom": u_squareness.map(|u| u?.freedom),
        "redundancy": separation.agreement.as_ref().map(agreement),
        "squareness_least_squares_um_per_m": separation.errors.least_squares_squareness(&separation.volume),
        "setup_arcsec": tilts.map(|tilts| PerDiagonal::from_fn(|d| tilts[d].arcsec)),
        "setup_direction": tilts.map(|tilts| PerDiagonal::from_fn(|d| Listed(tilts[d].direction))),
    })
}

/// Of both directions together, and of each where they are known apart.
fn errors(separation: &Separation) -> Map<String, Value> {
    let directed = |way: Direction| Some((way.symbol(), separation.errors.directed(way)?));
    let directed = Direction::BOTH.into_iter().filter_map(directed);
    let all = std::iter::once(("", &separation.errors.mean)).chain(directed);
    let entries = all.flat_map(|(suffix, errors)| {
        errors.iter().filter_map(move |(term, found)| {
            let found = found.as_ref()?;
            let entry = json!({
                "position_mm": separation.volume.positions(term.along),
                "deviation_um": found.deviation_um,
                "u_um": found.u_um(),
            });
            Some((format!("{term}{suffix}"), known([entry])))
        })
    });
    entries.collect()
}

/// Linear axes and beams against each other and the diagonals.
pub(super) fn agreement(agreement: &Agreement) -> Value {
    let line = |line: &LineCheck| {
        json!({
            "line": line.name(),
            "stated_um_per_m": line.stated_um_per_m,
            "by_others_um_per_m": line.others.map(|o| o.found_um_per_m),
            "difference_um_per_m": line.difference().map(|(um_per_m, _)| um_per_m),
            "u_difference_um_per_m": line.others.map(|o| o.u_difference_um_per_m),
        })
    };
    json!({
        "chi_squared": agreement.chi_squared,
        "degrees_of_freedom": agreement.freedom,
        "probability": agreement.probability,
        "contradiction": agreement.contradiction().map(Finding::from),
        "lines": agreement.lines.iter().map(line).collect::<Vec<_>>(),
    })
}

/// What is left over, with what the noise lets expect.
fn closure(separation: &Separation) -> Value {
    let closure = &separation.closure;
    let sigma = separation.noise.map(|noise| noise.sigma_um);
    let ramps = closure.ramps.as_ref().map(|ramps| {
        json!({
            "change_um": ramps.change_um,
            "probability": ramps.probability,
            "roll": ramps.is_roll(),
        })
    });
    json!({
        "closure_um": closure.by_interval,
        "mean_closure_um": closure.mean,
        "closure_expected_um": sigma.map(|sigma| closure.scatter.times(sigma)),
        "mean_closure_expected_um": sigma.map(|sigma| PerAxis::from_fn(|axis| closure.u_mean_um(axis, sigma))),
        "closure_ramp": ramps,
    })
}

/// Reversals of a turn: by term, at both ends of each axis, and from each diagonal alone.
fn reversal(turn: &Turn) -> Value {
    let ends = PerAxis::from_fn(|axis| {
        let [low, high] = turn.ends[axis];
        let constancy = turn.constancy[axis].map(picometres);
        json!({"low": low, "high": high, "constancy_probability": constancy})
    });
    json!({
        "reversal_um": PerTerm::from_fn(|term| turn.reversal[term].um),
        "u_reversal_um": PerTerm::from_fn(|term| turn.reversal[term].u_um),
        "reversal_change_um": turn.change_um,
        "reversal_at_ends": ends,
        "reversal_by_diagonal": turn.by_diagonal,
    })
}

/// σ of a single reading and where it comes from.
pub(super) fn noise(noise: Noise) -> Value {
    json!({
        "sigma_um": noise.sigma_um,
        "degrees_of_freedom": noise.freedom,
        "coverage_factor": coverage_factor(noise.freedom_f64()),
        "source": noise.source.word(),
    })
}

/// What would determine the scales that are open; nothing is asked for under an assumed set-up.
pub(super) fn open_advice(separation: &Separation) -> Vec<String> {
    match separation.setup {
        SetUp::Solve => advice(&separation.metric),
        SetUp::AssumePerfect => Vec::new(),
    }
}

/// The figures of all four diagonals together, and of each with what else is known of it.
pub(super) fn diagonals(
    all: &Diagonals,
    volume: &Volume,
    end_um: &PerDiagonal<f64>,
    more: impl Fn(Diagonal) -> Value,
) -> Value {
    let each = end_um.iter().zip(&all.diagonals).map(|((diagonal, end_um), of)| {
        let own = json!({
            "end_reading_um": end_um,
            "range_um": of.range_um,
            "figures_um": diagonal_json(of),
        });
        (of.name.clone(), joined([own, more(diagonal)]))
    });
    let together = json!({
        "range_over_all_um": all.range_over_all_um,
        "scale_sum_um_mm": scale_sum_um_mm(volume, end_um),
        "e_d_um": all.e_d_um,
        "b_d_um": all.b_d_um,
        "label": all.label,
    });
    joined([together, Value::Object(each.collect())])
}
