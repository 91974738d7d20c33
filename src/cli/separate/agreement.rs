//! What `separate` prints of linear axes and beams against the diagonals.

use super::words::{signed, three};
use crate::cli::show::{Column, table};
use crate::kit::manifest::picometres;
use crate::machine::separation::agreement::{Agreement, CHECK, LineCheck};
use serde_json::{Value, json};

/// Linear axes and beams against each other and the diagonals.
pub(super) fn table_of(agreement: Option<&Agreement>) -> String {
    let Some(agreement) = agreement else {
        return String::new();
    };
    let columns = [
        Column::Left("line"),
        Column::Right("stated/(µm/m)"),
        Column::Right("by all others/(µm/m)"),
        Column::Right("difference/(µm/m)"),
        Column::Right("u(k=1)/(µm/m)"),
    ];
    let rows = agreement.lines.iter().map(|line| {
        let found = line.others.zip(line.difference());
        let others = found.map_or(["nothing".into(), "-".into(), "-".into()], |(o, (d, _))| {
            [
                three(o.found_um_per_m),
                signed(d),
                three(o.u_difference_um_per_m),
            ]
        });
        let mut row = vec![line.name(), three(line.stated_um_per_m)];
        row.extend(others);
        row
    });
    let verdict = match agreement.probability {
        Some(p) if agreement.is_refuted() => {
            format!("probability {p:.3}: they DISAGREE; {CHECK}")
        }
        Some(p) => format!("probability {p:.3}: they agree"),
        None => "not judged: the noise of the readings is not known".into(),
    };
    format!(
        "Linear axes and beams against the diagonals\n{}\nchi-squared {:.2}, degrees of freedom {}, {verdict}",
        table(&columns, rows),
        agreement.chi_squared,
        agreement.freedom
    )
}

/// Linear axes and beams against each other and the diagonals.
pub(super) fn document(agreement: &Agreement) -> Value {
    let line = |line: &LineCheck| {
        json!({
            "line": line.name(),
            "stated_um_per_m": picometres(line.stated_um_per_m),
            "by_others_um_per_m": line.others.map(|o| picometres(o.found_um_per_m)),
            "difference_um_per_m": line.difference().map(|(um_per_m, _)| picometres(um_per_m)),
            "u_difference_um_per_m": line.others.map(|o| picometres(o.u_difference_um_per_m)),
        })
    };
    json!({
        "chi_squared": picometres(agreement.chi_squared),
        "degrees_of_freedom": agreement.freedom,
        "probability": agreement.probability,
        "contradiction": agreement.contradiction(),
        "lines": agreement.lines.iter().map(line).collect::<Vec<_>>(),
    })
}
