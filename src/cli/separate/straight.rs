//! What `separate` says of straight runs: the page for people and the document.

use super::document::{agreement, diagonals, noise};
use super::words::{self, advice, expanded};
use crate::cli::outcome::known;
use crate::cli::screen::{More, Screen, paragraphs, table};
use crate::machine::separation::Uncertainty;
use crate::machine::separation::solved::scale_sum_um_mm;
use crate::machine::separation::straight::{ClosureTest, ClosureTests, StraightResult};
use crate::machine::standards::Diagonals;
use crate::quantity::{Axis, Diagonal, Figure, PerAxis, Squared};
use crate::text::joined;
use serde_json::{Value, json};

pub(super) fn screen(result: &StraightResult, figures: &Diagonals) -> Screen {
    let diagonals = figures.as_read(|diagonal| result.end_um[diagonal]);
    let closure = result.closure.as_ref();
    let (open, advice) = (result.metric.undetermined(), advice(&result.metric));
    words::screen(
        &result.doubts,
        outcome(result),
        (&open, &advice),
        paragraphs(&[
            squareness(result),
            scales(result),
            closure.map_or_else(String::new, closure_table),
        ]),
        vec![
            More::part("linear axes and beams", words::agreement(result.agreement.as_ref())),
            More::part("diagonals", diagonals),
        ],
        &result.labels,
    )
}

fn outcome(result: &StraightResult) -> String {
    let known = |axis: &Axis| result.metric.scale(*axis).um_per_m.is_some();
    let scales = match joined(Axis::ALL.into_iter().filter(known)) {
        none if none.is_empty() => "no single scale".to_string(),
        known => format!("scale of {known}"),
    };
    let mut lines = vec![format!(
        "Straight runs along the four body diagonals: squareness XY, XZ, YZ; {scales}; no straightness (that needs single-axis steps)"
    )];
    lines.extend(result.silence.sentences());
    lines.join("\n")
}

fn squareness(result: &StraightResult) -> String {
    let table = words::squareness(&result.metric, "", |_| String::new());
    format!("{table}; from the totals of the diagonals, so of the lines through the end points")
}

fn scales(result: &StraightResult) -> String {
    let share = |axis| result.volume.cosine(axis).squared();
    let shares = Axis::ALL.map(|axis| format!("{:.3} x slope of E{axis}{axis}", share(axis)));
    let square_m = result.volume.diagonal_mm().squared() / 1000.0;
    let mut lines = vec![format!(
        "One combination of the scales from the diagonals alone: {} = {:.3} µm/m",
        shares.join(" + "),
        Figure(scale_sum_um_mm(&result.volume, &result.end_um) / square_m)
    )];
    for axis in Axis::ALL {
        let found = result.metric.scale(axis);
        if let Some(scale) = found.um_per_m {
            let u = expanded(found.expanded_um_per_m());
            lines.push(format!("slope of E{axis}{axis}: {:.3} µm/m, U(95 %) {u}", Figure(scale)));
        }
    }
    lines.join("\n")
}

fn closure_table(closure: &ClosureTests) -> String {
    let rows = closure.tests.iter().map(|test| {
        let (largest, end) = (Figure(test.largest_um), Figure(test.end_um));
        let (pass, u) = (test.pass.word(), expanded(test.u_end_um));
        let ratio = test.worst_ratio.map_or_else(|| "-".to_string(), |ratio| format!("{ratio:.1}"));
        format!("{}\t{pass}\t{largest:.3}\t{end:+.3}\t{u}\t{ratio}", test.diagonal)
    });
    let heading = "diagonal\truns\t>largest/µm\t>far end/µm\t>U(k=2) there/µm\t>largest by its u";
    format!(
        "Closure test: measured less what the nine errors of `closure_errors` predict, each run from its own start\n{}\n{}",
        table(heading, rows),
        verdict(closure)
    )
}

fn verdict(closure: &ClosureTests) -> String {
    let of_table = if closure.table_states_u {
        "noise of the readings and the table's u"
    } else {
        "noise of the readings only: the table states no u"
    };
    match closure.agrees() {
        None => "no verdict: the noise of the readings is not known (repeat the runs, or state `noise_um`)".to_string(),
        Some(true) => format!("in keeping: no difference is beyond {:.1} u ({of_table})", closure.k),
        Some(false) => format!("NOT in keeping: a difference is beyond {:.1} u ({of_table}); the nine errors do not describe this machine as it is now", closure.k),
    }
}

pub(super) fn document(result: &StraightResult, figures: &Diagonals) -> Value {
    let metric = &result.metric;
    let u = |known: Option<Uncertainty>| known.map(|known| known.u);
    let scales = |of: &dyn Fn(Axis) -> Option<f64>| known([json!(PerAxis::from_fn(of))]);
    known([
        json!({
            "schema": 1,
            "squareness_um_per_m": metric.squareness_um_per_m(),
            "u_squareness_um_per_m": metric.u_squareness().map(u),
            "redundancy": result.agreement.as_ref().map(agreement),
            "scale_um_per_m": scales(&|axis| metric.scale(axis).um_per_m),
            "u_scale_um_per_m": scales(&|axis| metric.scale(axis).um_per_m.and(u(metric.scale(axis).u))),
            "rank": {
                "rank": metric.rank,
                "unknowns": 6,
                "undetermined": metric.undetermined(),
                "advice": advice(metric),
            },
            "diagonals": diagonals(figures, &result.volume, &result.end_um, |diagonal| {
                largest(result, diagonal).map_or(Value::Null, |test| json!({ "closure_largest_um": test.largest_um, "closure_end_um": test.end_um }))
            }),
            "noise": result.noise.map(noise),
            "closure_test": result.closure.as_ref().map(|closure| json!({
                "agrees": closure.agrees(),
                "k": closure.k,
                "table_states_u": closure.table_states_u,
                "tests": closure.tests,
            })),
            "doubts": result.doubts,
        }),
        json!(result.silence),
        json!({ "labels": result.labels }),
    ])
}

/// The closure test of a diagonal with the larger difference of its two directions.
fn largest(result: &StraightResult, diagonal: Diagonal) -> Option<&ClosureTest> {
    let tests = result.closure.as_ref()?.tests.iter();
    let of = tests.filter(|test| test.diagonal == diagonal);
    of.max_by(|a, b| a.largest_um.total_cmp(&b.largest_um))
}
