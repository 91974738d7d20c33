//! Figures of the body diagonals, for people and for documents.

use super::words::{shown, three};
use crate::cli::show::{Column, table};
use crate::diagonal::{Diagonal, PathKind, Volume};
use crate::problem::Problems;
use crate::separation::diagonal_runs::diagonal_runs;
use crate::separation::noise::CorrectedRun;
use crate::standards::{self, DiagonalMotion, Diagonals};
use crate::target_runs::Runs;

/// Figures by standard, with the label of the motion. `runs`: only those that count from the
/// start of the forward run, or the two directions cannot be compared.
pub(super) fn standard_figures(
    volume: &Volume,
    kind: PathKind,
    runs: &[CorrectedRun],
) -> Result<Diagonals, Problems> {
    let motion = match kind {
        PathKind::Step => DiagonalMotion::StepDiagonalCellEnds,
        PathKind::Straight => DiagonalMotion::StraightRuns,
    };
    let mut all: Vec<(&str, Runs)> = Vec::new();
    for diagonal in Diagonal::ALL {
        all.push((
            diagonal.name(),
            diagonal_runs(volume, kind, diagonal, runs)?,
        ));
    }
    let named: Vec<(&str, &Runs)> = all.iter().map(|(name, runs)| (*name, runs)).collect();
    Ok(standards::diagonal(&named, motion))
}

/// The table of the diagonals. E and B appear only where both directions were measured.
pub(super) fn diagonal_table(figures: &Diagonals, end_um: impl Fn(Diagonal) -> f64) -> String {
    let both = figures.e_d_um.is_some();
    let mut columns = vec![
        Column::Left("diagonal"),
        Column::Right("far end/µm"),
        Column::Right("max - min/µm"),
    ];
    if both {
        columns.extend([Column::Right("E/µm"), Column::Right("B/µm")]);
    }
    let rows = Diagonal::ALL
        .into_iter()
        .zip(&figures.diagonals)
        .map(|(diagonal, of)| {
            let mut row = vec![
                diagonal.to_string(),
                three(end_um(diagonal)),
                shown(of.range_um),
            ];
            if both {
                row.extend([shown(of.figures.e.both_um), shown(of.figures.b_um)]);
            }
            row
        });
    let machine = match (figures.e_d_um, figures.b_d_um) {
        (Some(e_d), Some(b_d)) => format!(
            "machine: E_d {} µm, B_d {} µm (largest of the four)",
            three(e_d),
            three(b_d)
        ),
        _ => "no E and B: they need runs in both directions that count from one zero".to_string(),
    };
    format!(
        "Body diagonals as read (corrected readings, no compensation forecast), {}\n{}\nlargest range {} µm; over all four {} µm\n{machine}",
        figures.label,
        table(&columns, rows),
        shown(figures.largest_range_um),
        shown(figures.range_over_all_um),
    )
}
