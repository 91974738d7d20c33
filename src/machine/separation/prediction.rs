//! The closure test: readings of straight runs against what nine errors predict for them.
//!
//! ```text
//!   predicted(q) = Σ_j u_j (Dj(x) + Dj(y) + Dj(z)) less its value at the start of the run
//!   u²(q)        = 2σ²/r + Σ u_j² (u²(D at q) + u²(D at the start))        what is known of it
//! ```
//! Every run counts from its own start, so a reversal is not part of the test. Correlation
//! between the points of a table is not known to a table and not included.

use super::lookup::at;
use super::noise::{CorrectedRun, Noise, means, run_counts};
use crate::inputs::error_table::{ErrorTable, Series};
use crate::quantity::axis::Axis;
use crate::quantity::diagonal::{Diagonal, Pass, PathKind, Volume};
use crate::quantity::units::Squared;
use crate::text::problem::{Problem, Problems};
use statrs::distribution::{ContinuousCDF, Normal};

/// How often machines that agree are to fail the test.
const FALSE_ALARM: f64 = 0.05;

/// Measured less predicted readings of the runs of one diagonal in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosureTest {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Forward or reverse runs.
    pub pass: Pass,
    /// Largest |difference|, µm.
    pub largest_um: f64,
    /// Difference at the far end of the run, µm.
    pub end_um: f64,
    /// Its standard uncertainty, µm; `None` = not known.
    pub u_end_um: Option<f64>,
    /// Largest |difference|/u over the nodes; `None` = u is not known.
    pub worst_ratio: Option<f64>,
}

/// All closure tests of a measurement and their verdict.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosureTests {
    /// By diagonal and direction.
    pub tests: Vec<ClosureTest>,
    /// k of the limit k·u, so that one in twenty machines that agree has a difference beyond it
    /// anywhere.
    pub k: f64,
    /// Whether the table states its uncertainty; else that of the readings alone counts.
    pub table_states_u: bool,
}

impl ClosureTests {
    /// Whether no difference is beyond k·u; `None` where u is not known.
    pub fn agrees(&self) -> Option<bool> {
        let ratios: Option<Vec<f64>> = self.tests.iter().map(|test| test.worst_ratio).collect();
        ratios.map(|ratios| ratios.iter().all(|ratio| *ratio <= self.k))
    }
}

/// A predicted reading, µm, and the square of what the table states of its uncertainty.
#[derive(Clone, Copy)]
struct Predicted {
    um: f64,
    square_um2: Option<f64>,
}

/// Compares straight runs with what nine errors predict. `noise`: of a single reading.
pub(crate) fn closure_tests(
    volume: &Volume,
    table: &ErrorTable,
    runs: &[CorrectedRun],
    noise: Option<Noise>,
) -> Result<ClosureTests, Problems> {
    let (means, counts) = (means(runs), run_counts(runs));
    let mut tests = Vec::new();
    let mut table_states_u = true;
    for diagonal in Diagonal::ALL {
        for pass in Pass::BOTH {
            let count = counts[diagonal][usize::from(pass == Pass::Reverse)];
            if count == 0.0 {
                continue;
            }
            let predicted = predicted(volume, table, diagonal, pass)?;
            table_states_u &= predicted.iter().all(|p| p.square_um2.is_some());
            let readings = noise.map(|noise| 2.0 * noise.sigma_um.squared() / count);
            let measured = &means.of(pass)[diagonal];
            tests.push(compared(diagonal, pass, measured, &predicted, readings));
        }
    }
    Ok(ClosureTests {
        k: limit(tests.len() * volume.steps),
        tests,
        table_states_u,
    })
}

/// k of a test of so many differences together.
fn limit(differences: usize) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^52 nodes")]
    let count = differences.max(1) as f64;
    Normal::standard().inverse_cdf(1.0 - FALSE_ALARM / (2.0 * count))
}

fn compared(
    diagonal: Diagonal,
    pass: Pass,
    measured: &[f64],
    predicted: &[Predicted],
    square_um2: Option<f64>,
) -> ClosureTest {
    let start = match pass {
        Pass::Forward => 0,
        Pass::Reverse => measured.len() - 1,
    };
    let end = measured.len() - 1 - start;
    let left =
        |node: usize| measured[node] - measured[start] - (predicted[node].um - predicted[start].um);
    let u = |node: usize| {
        let stated = |node: usize| predicted[node].square_um2.unwrap_or(0.0);
        Some((square_um2? + stated(node) + stated(start)).sqrt())
    };
    let others = || (0..measured.len()).filter(|node| *node != start);
    let ratio = |node: usize| {
        let u = u(node).filter(|u| *u > 0.0)?;
        Some(left(node).abs() / u)
    };
    let ratios: Option<Vec<f64>> = others().map(ratio).collect();
    ClosureTest {
        diagonal,
        pass,
        largest_um: others().map(|node| left(node).abs()).fold(0.0, f64::max),
        end_um: left(end),
        u_end_um: u(end),
        worst_ratio: ratios.map(|ratios| ratios.into_iter().fold(0.0, f64::max)),
    }
}

/// What nine errors predict for the nodes of a diagonal; an undirected curve serves both ways.
fn predicted(
    volume: &Volume,
    table: &ErrorTable,
    diagonal: Diagonal,
    pass: Pass,
) -> Result<Vec<Predicted>, Problems> {
    let u = volume.laser(diagonal);
    let at_node = |node: usize| -> Option<Predicted> {
        let place = volume.place(diagonal, PathKind::Straight, node);
        let (mut um, mut square_um2) = (0.0, Some(0.0));
        for along in Axis::ALL {
            let direction = diagonal.travelled(along, pass);
            let all = table.series(along);
            let directed = all.iter().find(|s| s.direction == Some(direction));
            let series = directed.or_else(|| all.first())?;
            for of in Axis::ALL {
                let (value, stated) = point(series, of, place[along].mm())?;
                um += u[of] * value;
                square_um2 = square_um2
                    .zip(stated)
                    .map(|(sum, s)| sum + (u[of] * s).squared());
            }
        }
        Some(Predicted { um, square_um2 })
    };
    let all: Option<Vec<Predicted>> = (0..=volume.steps).map(at_node).collect();
    all.ok_or_else(|| {
        Problem::new(
            "the closure test needs all nine errors; at least one is missing from the table",
        )
        .at(table.header.clone())
        .help("measure it, or leave `closure_errors` out")
        .into()
    })
}

/// Deviation and stated uncertainty of a curve at a machine position, µm.
fn point(series: &Series, of: Axis, position_mm: f64) -> Option<(f64, Option<f64>)> {
    let values = series.deviations[of].as_ref()?;
    let values: Vec<f64> = values.iter().map(|value| value.um()).collect();
    let stated = series.uncertainties_um[of].as_ref();
    Some((
        at(&series.positions, &values, position_mm),
        stated.map(|stated| at(&series.positions, stated, position_mm)),
    ))
}
