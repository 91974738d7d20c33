//! Straight runs along the body diagonals: what four totals hold, and the closure test.
//!
//! ```text
//!   T_d = R·e_d(end)      S = X²p_xx + Y²p_yy + Z²p_zz = ΣT/4
//!   φxy = (T1 − T2 − T3 + T4)/(4XY)   φxz = (T1 − T2 + T3 − T4)/(4XZ)   φyz = (T1 + T2 − T3 − T4)/(4YZ)   (4)
//! ```
//! 1 … 4 = PPP, NPP, PNP, PPN. Four numbers, four quantities: three squareness errors and one
//! combination of the three scales, whatever the set-up.

use super::line::range;
use super::metric::{PerPlane, Plane};
use crate::axis::{Axis, PerAxis};
use crate::diagonal::{Diagonal, Pass, PathKind, PerDiagonal, Volume};
use crate::error_table::ErrorTable;
use crate::problem::{Problem, Problems};
use crate::separation::lookup::at;
use crate::separation::noise::{CorrectedRun, means};

/// What the totals of the four diagonals determine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Totals {
    /// φ, µm/m.
    pub squareness_um_per_m: PerPlane<f64>,
    /// S = X²p_xx + Y²p_yy + Z²p_zz, µm·mm: the one combination of the scales.
    pub scale_sum_um_mm: f64,
}

/// Formula (4) from the readings at the far ends, µm.
pub fn totals(volume: &Volume, ends_um: &PerDiagonal<f64>) -> Totals {
    let total = |d: Diagonal| volume.diagonal_mm() * ends_um[d];
    let squareness = |plane: Plane| {
        let (a, b) = plane.axes();
        let part = |d: Diagonal| d.sign(a) * d.sign(b) * total(d);
        let sum: f64 = Diagonal::ALL.into_iter().map(part).sum();
        1000.0 * sum / (4.0 * volume.size[a].mm() * volume.size[b].mm())
    };
    Totals {
        squareness_um_per_m: PerPlane {
            xy: squareness(Plane::Xy),
            xz: squareness(Plane::Xz),
            yz: squareness(Plane::Yz),
        },
        scale_sum_um_mm: Diagonal::ALL.into_iter().map(total).sum::<f64>() / 4.0,
    }
}

/// u(φ) = R/(2 V_j V_k)·u(e_end), µm/m.
pub fn u_squareness(volume: &Volume, u_end_um: f64) -> PerPlane<f64> {
    let of = |plane: Plane| {
        let (a, b) = plane.axes();
        let area = volume.size[a].mm() * volume.size[b].mm();
        1000.0 * volume.diagonal_mm() / (2.0 * area) * u_end_um
    };
    PerPlane {
        xy: of(Plane::Xy),
        xz: of(Plane::Xz),
        yz: of(Plane::Yz),
    }
}

/// Figures of one diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalFigures {
    /// Reading error at the far end, mean of all passes and runs, µm.
    pub end_um: f64,
    /// Max − min over the nodes that lie on the diagonal, both passes, µm.
    pub range_um: f64,
}

/// Figures of every diagonal, and max − min over all of them, µm. Of a step run only the cell
/// ends count: between them the target is beside the diagonal.
pub fn figures(runs: &[CorrectedRun], kind: PathKind) -> (PerDiagonal<DiagonalFigures>, f64) {
    let every = match kind {
        PathKind::Step => 3,
        PathKind::Straight => 1,
    };
    let mean = |diagonal: Diagonal, pass: Pass| -> Vec<f64> {
        let runs: Vec<&CorrectedRun> = runs
            .iter()
            .filter(|run| run.diagonal == diagonal && run.pass == pass)
            .collect();
        let nodes = runs.first().map_or(0, |run| run.readings_um.len());
        #[allow(clippy::cast_precision_loss, reason = "a handful of runs")]
        let count = runs.len() as f64;
        (0..nodes)
            .step_by(every)
            .map(|node| runs.iter().map(|run| run.readings_um[node]).sum::<f64>() / count)
            .collect()
    };
    let both = PerDiagonal::from_fn(|d| Pass::BOTH.map(|pass| mean(d, pass)));
    let figures = PerDiagonal::from_fn(|d| {
        let ends: Vec<f64> = both[d].iter().filter_map(|pass| total(pass)).collect();
        #[allow(clippy::cast_precision_loss, reason = "two passes at most")]
        let count = ends.len().max(1) as f64;
        DiagonalFigures {
            end_um: ends.iter().sum::<f64>() / count,
            range_um: range(both[d].iter().flatten().copied()),
        }
    });
    let all = both.iter().flat_map(|(_, passes)| passes.iter().flatten());
    let over_all = range(all.copied());
    (figures, over_all)
}

/// Far end less start of a pass, so that an offset between the passes does not count.
fn total(pass: &[f64]) -> Option<f64> {
    Some(pass.last()? - pass.first()?)
}

/// Readings that nine errors predict for the nodes of a diagonal (nine-error model), µm; an
/// undirected term serves both passes. `None` where a term of the nine is missing.
pub fn predicted_um(
    volume: &Volume,
    kind: PathKind,
    errors: &ErrorTable,
    diagonal: Diagonal,
    pass: Pass,
) -> Option<Vec<f64>> {
    let error_at = |node: usize| -> Option<PerAxis<f64>> {
        let place = volume.place(diagonal, kind, node);
        let mut error = PerAxis::default();
        for along in Axis::ALL {
            let direction = diagonal.travelled(along, pass);
            let all = errors.series(along);
            let directed = all.iter().find(|s| s.direction == Some(direction));
            let series = directed.or_else(|| all.first())?;
            for of in Axis::ALL {
                let values = series.deviations[of].as_ref()?;
                let values: Vec<f64> = values.iter().map(|value| value.um()).collect();
                error[of] += at(&series.positions, &values, place[along].mm());
            }
        }
        Some(error)
    };
    let values = volume.along_beam(diagonal, kind, error_at)?;
    let start = *values.first()?;
    Some(values.iter().map(|value| value - start).collect())
}

/// The closure test: measured less predicted readings of a diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosureTest {
    /// Largest |difference|, µm.
    pub largest_um: f64,
    /// At the far end, µm.
    pub end_um: f64,
}

/// Compares the forward readings of a run with what nine errors predict.
pub fn closure_test(measured: &[f64], predicted: &[f64]) -> ClosureTest {
    let start = measured.first().copied().unwrap_or(0.0);
    let left: Vec<f64> = measured
        .iter()
        .zip(predicted)
        .map(|(measured, predicted)| measured - start - predicted)
        .collect();
    ClosureTest {
        largest_um: left
            .iter()
            .fold(0.0, |largest: f64, v| largest.max(v.abs())),
        end_um: left.last().copied().unwrap_or(0.0),
    }
}

/// Direction cosines squared: the share of each scale in S, for the words of a report.
pub fn scale_shares(volume: &Volume) -> PerAxis<f64> {
    PerAxis::from_fn(|axis| volume.cosine(axis).powi(2))
}

/// What a straight run of the four diagonals says.
#[derive(Clone, Debug, PartialEq)]
pub struct StraightResult {
    /// The corrected runs.
    pub runs: Vec<CorrectedRun>,
    /// Figures of the diagonals.
    pub diagonals: PerDiagonal<DiagonalFigures>,
    /// Max − min over all diagonals, µm.
    pub range_over_all_um: f64,
    /// Squareness and the combination of scales.
    pub totals: Totals,
    /// The closure test against nine errors, forward runs.
    pub closure: Option<PerDiagonal<ClosureTest>>,
    /// What the readings say of themselves, one sentence each.
    pub notes: Vec<String>,
}

/// Evaluates straight runs; `errors` = nine errors to be tested by them.
pub fn straight(
    volume: &Volume,
    runs: Vec<CorrectedRun>,
    errors: Option<&ErrorTable>,
) -> Result<StraightResult, Problems> {
    let (diagonals, range_over_all_um) = figures(&runs, PathKind::Straight);
    let ends = PerDiagonal::from_fn(|d| diagonals[d].end_um);
    let means = means(&runs);
    let closure = match errors {
        None => None,
        Some(table) => Some(tested(volume, table, &means.forward)?),
    };
    Ok(StraightResult {
        diagonals,
        range_over_all_um,
        totals: totals(volume, &ends),
        closure,
        runs,
        notes: Vec::new(),
    })
}

fn tested(
    volume: &Volume,
    table: &ErrorTable,
    forward: &PerDiagonal<Vec<f64>>,
) -> Result<PerDiagonal<ClosureTest>, Problems> {
    let mut missing = Problems::none();
    let tests = PerDiagonal::from_fn(|d| {
        let predicted = predicted_um(volume, PathKind::Straight, table, d, Pass::Forward);
        predicted.map(|predicted| closure_test(&forward[d], &predicted))
    });
    let all = PerDiagonal::from_fn(|d| {
        tests[d].unwrap_or(ClosureTest {
            largest_um: 0.0,
            end_um: 0.0,
        })
    });
    if tests.iter().any(|(_, test)| test.is_none()) {
        missing.push(
            Problem::new(
                "the closure test needs all nine errors; at least one is missing from the table",
            )
            .at(table.header.clone())
            .help("measure it, or leave `closure_errors` out"),
        );
    }
    missing.or_ok(all)
}
