//! What `separate` prints of the reversal at a turn and of repeated runs.

use super::words::three;
use crate::cli::show::{Column, paragraphs, table};
use crate::machine::separation::Separation;
use crate::machine::separation::noise::{coverage_factor, repeatability_um};
use crate::machine::separation::reversal::{Estimate, Turn};
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::diagonal::{Diagonal, Pass};

pub(super) fn reversal(separation: &Separation) -> String {
    let Some(turn) = &separation.turn else {
        return String::new();
    };
    let k = coverage_factor(separation.noise.and_then(|noise| noise.freedom_f64()));
    let shown = |b: Estimate| {
        let u = b.u_um.map_or_else(|| "not known".into(), |u| three(k * u));
        format!("{} ± {u}", three(b.um))
    };
    paragraphs(&[
        reversal_of_axes(turn, shown),
        reversal_by_diagonal(turn, shown),
        reversal_of_cross_terms(turn, shown),
    ])
}

fn reversal_of_axes(turn: &Turn, shown: impl Fn(Estimate) -> String) -> String {
    let columns = [
        Column::Left("axis"),
        Column::Right("B/µm"),
        Column::Right("at low end/µm"),
        Column::Right("at high end/µm"),
        Column::Right("constant?"),
    ];
    let rows = Axis::ALL.into_iter().map(|axis| {
        let own = ErrorTerm {
            of: axis,
            along: axis,
        };
        let [low, high] = turn.ends[axis];
        let constancy = turn.constancy[axis];
        let constancy = constancy.map_or_else(|| "-".into(), |p| format!("probability {p:.3}"));
        vec![
            axis.to_string(),
            shown(turn.reversal[own]),
            shown(low),
            shown(high),
            constancy,
        ]
    });
    format!(
        "Reversal from the turn (B = moving + minus moving -; ± U(95 %)): one for the whole axis, and at each end as the curves hold it\n{}\na small probability in the last column: the reversal differs along the axis, and the first figure is no figure of the machine",
        table(&columns, rows)
    )
}

fn reversal_by_diagonal(turn: &Turn, shown: impl Fn(Estimate) -> String) -> String {
    let mut columns = vec![Column::Left("B/µm")];
    columns.extend(Diagonal::ALL.map(|d| Column::Right(d.name())));
    let rows = Axis::ALL.into_iter().map(|axis| {
        let mut row = vec![axis.to_string()];
        row.extend(turn.by_diagonal.iter().map(|(_, b)| shown(b[axis])));
        row
    });
    format!(
        "From each diagonal alone, where the axis turned (X of NPP, Y of PNP, Z of PPN at the low end, all others at the high end)\n{}",
        table(&columns, rows)
    )
}

fn reversal_of_cross_terms(turn: &Turn, shown: impl Fn(Estimate) -> String) -> String {
    let cross = ErrorTerm::ALL.into_iter().filter(|t| !t.is_positioning());
    let said: Vec<String> = cross
        .map(|term| {
            let held = if turn.in_curves[term] {
                " (in the - curve)"
            } else {
                ""
            };
            format!("{term} {}{held}", shown(turn.reversal[term]))
        })
        .collect();
    format!("Reversal of cross terms, µm: {}", said.join(", "))
}

/// R of both passes along every diagonal.
pub(super) fn repeatability(separation: &Separation) -> String {
    let of = |diagonal: Diagonal| {
        let pass = |pass: Pass| {
            let found = repeatability_um(&separation.runs, diagonal, pass)?;
            Some(format!("{diagonal} {} {}", pass.word(), three(found)))
        };
        Pass::BOTH.into_iter().filter_map(pass).collect::<Vec<_>>()
    };
    let all: Vec<String> = Diagonal::ALL.into_iter().flat_map(of).collect();
    if all.is_empty() {
        return String::new();
    }
    format!(
        "Repeatability R = 4 s, the largest over all nodes (ISO 230-2), µm: {}",
        all.join(", ")
    )
}
