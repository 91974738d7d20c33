//! Straight runs along the body diagonals: what four totals hold.
//!
//! ```text
//!   T_d = R·e_d(end)      S = X²p_xx + Y²p_yy + Z²p_zz = ΣT/4
//!   φxy = (T1 − T2 − T3 + T4)/(4XY)   φxz = (T1 − T2 + T3 − T4)/(4XZ)   φyz = (T1 + T2 − T3 − T4)/(4YZ)   (4)
//! ```
//! 1 … 4 = PPP, NPP, PNP, PPN. Four numbers, four quantities: three squareness errors and one
//! combination of the three scales, whatever the set-up. Linear axes and other beams add to them.
//!
//! The closure test compares the readings with what nine errors predict for them:
//!
//! ```text
//!   predicted(q) = Σ_j u_j (Dj(x) + Dj(y) + Dj(z)) less its value at the start of the run
//!   u²(q)        = 2σ²/r + Σ u_j² (u²(D at q) + u²(D at the start))        what is known of it
//! ```
//! Every run counts from its own start, so a reversal is not part of the test. Correlation
//! between the points of a table is not known to a table and not included.

use super::campaign::Campaign;
use super::closure::large_noise;
use super::curves::at;
use super::labels;
use super::metric::{Agreement, Equation, Equations, Metric};
use super::readings::{self, Noise, Outlier, Walk, float, walks};
use super::start::Start;
use crate::inputs::error_table::{ErrorTable, Kind, Silence};
use crate::machine::findings::SeparationFinding;
use crate::quantity::{Diagonal, ErrorTerm, Pass, PathKind, PerDiagonal, Run, Squared, Volume};
use crate::text::{Finding, Problem, Problems};
use nonius_numerics::rows::{Row, student};
use serde::Serialize;

/// How often machines that agree are to fail the closure test.
const FALSE_ALARM: f64 = 0.05;

/// What straight runs of the four diagonals say.
#[derive(Clone, Debug, PartialEq)]
pub struct StraightResult {
    /// The measured box.
    pub volume: Volume,
    /// The corrected runs.
    pub runs: Vec<Run>,
    /// The runs whose zero is that of the forward run: all, or the forward ones only. Figures
    /// that compare the two directions are made of these.
    pub zeroed_runs: Vec<Run>,
    /// Reading error of each diagonal at the far end less that at the start, mean of all runs, µm.
    pub end_um: PerDiagonal<f64>,
    /// Scales and squareness with linear axes and other beams.
    pub metric: Metric,
    /// Whether linear axes, beams and diagonals agree; `None` where nothing is redundant.
    pub agreement: Option<Agreement>,
    /// What the job does not state and no uncertainty holds.
    pub silence: Silence,
    /// Noise of a single reading: from repeated runs, or stated.
    pub noise: Option<Noise>,
    /// The closure test against nine errors.
    pub closure: Option<ClosureTests>,
    /// Why the result is doubtful; empty = nothing speaks against it.
    pub doubts: Vec<Finding>,
    /// What was assumed and what the uncertainty holds.
    pub labels: Vec<Finding>,
}

/// Evaluates straight runs; `errors` = nine errors to be tested by them.
pub fn straight(
    campaign: &Campaign<'_>,
    runs: &[Run],
    errors: Option<&ErrorTable>,
) -> Result<StraightResult, Problems> {
    let volume = &campaign.measurement.volume;
    let mut start = Start::new(campaign, runs);
    start.set_noise(start.known);
    let (layout, noise) = (start.model.layout, start.known);
    // (7) of first order: u_dᵀ h u_d = e_d(end)/R; the mean of the passes.
    let share = 1000.0 / volume.diagonal_mm() / float(layout.passes);
    let of_diagonal = |d: Diagonal| {
        let at = |pass, node| layout.reading(pass, d, node);
        let ends = |pass| [(at(pass, layout.nodes - 1), share), (at(pass, 0), -share)];
        let row = Row(Pass::BOTH.into_iter().take(layout.passes).flat_map(ends).collect());
        let (direction, known) = (volume.laser(d), noise.is_some());
        Equation { direction, nominal: direction, value: row.dot(&start.z), row, known, own: 0.0 }
    };
    let lines = campaign.lines.iter().enumerate();
    let lines =
        lines.map(|(index, line)| Equation::of_line(line, Row::of(layout.line(index)), &start.z));
    let all = Diagonal::ALL.map(of_diagonal).into_iter().chain(lines).collect();
    let equations = Equations::new(all, &mut start.model);
    let metric = equations.metric(&start.model);
    let agreement = equations.agreement(&metric);
    let (figures, _) = readings::figures(&start.runs, PathKind::Straight);
    let closure = errors.map(|table| closure_tests(&start, table)).transpose()?;
    let stated =
        |tests: &&ClosureTests| tests.table_states_u && campaign.silence().not_stated.is_empty();
    let fails = closure.as_ref().filter(stated).is_some_and(|tests| tests.agrees == Some(false));
    let disturbed = start.outliers.iter().map(Outlier::words);
    let doubts = disturbed
        .map(|which| SeparationFinding::DisturbedTotal { which }.into())
        .chain(agreement.as_ref().and_then(|of| of.contradiction.clone()))
        .chain(large_noise(noise, campaign.stated.noise_um))
        .chain(fails.then(|| SeparationFinding::OtherErrors.into()));
    Ok(StraightResult {
        volume: volume.clone(),
        end_um: PerDiagonal::from_fn(|d| figures[d].end_um),
        silence: campaign.silence(),
        doubts: doubts.collect(),
        agreement,
        noise,
        closure,
        labels: labels::of_straight(&start),
        metric,
        zeroed_runs: start.zeroed_runs(),
        runs: start.runs,
    })
}

/// Measured less predicted readings of the runs of one diagonal in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClosureTest {
    /// The diagonal.
    pub diagonal: Diagonal,
    /// Forward or reverse runs.
    #[serde(rename = "direction")]
    pub pass: Pass,
    /// Largest |difference|, µm.
    pub largest_um: f64,
    /// Difference at the far end of the run, µm.
    pub end_um: f64,
    /// Its standard uncertainty, µm; `None` = not known.
    pub u_end_um: Option<f64>,
    /// Largest |difference|/u over the nodes; `None` = u is not known.
    #[serde(rename = "largest_by_u")]
    pub worst_ratio: Option<f64>,
}

/// All closure tests of a measurement and their verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosureTests {
    /// Whether no difference is beyond k·u; `None` where u is not known.
    pub agrees: Option<bool>,
    /// k of the limit k·u, so that one in twenty machines that agree has a difference beyond it
    /// anywhere.
    pub k: f64,
    /// Whether the table states its uncertainty; else that of the readings alone counts.
    pub table_states_u: bool,
    /// By diagonal and direction.
    pub tests: Vec<ClosureTest>,
}

/// A predicted reading, µm, and the square of what the table states of its uncertainty.
type Predicted = (f64, Option<f64>);

/// Compares straight runs with what nine errors predict.
fn closure_tests(start: &Start<'_>, table: &ErrorTable) -> Result<ClosureTests, Problems> {
    let mut found = ClosureTests { agrees: None, k: 0.0, table_states_u: true, tests: Vec::new() };
    for walk in &walks(&start.runs) {
        let predicted = predicted(start.volume(), table, walk)?;
        found.table_states_u &= predicted.iter().all(|(_, square)| square.is_some());
        found.tests.push(compared(start, walk, &predicted));
    }
    found.tests.sort_by_key(|test| test.diagonal);
    // k of a test of so many differences together.
    let differences = float((found.tests.len() * start.volume().steps).max(1));
    found.k = student(1.0 - FALSE_ALARM / (2.0 * differences), None);
    let ratios: Option<Vec<f64>> = found.tests.iter().map(|test| test.worst_ratio).collect();
    found.agrees = ratios.map(|ratios| ratios.iter().all(|ratio| *ratio <= found.k));
    Ok(found)
}

fn compared(of: &Start<'_>, walk: &Walk, predicted: &[Predicted]) -> ClosureTest {
    let Walk { diagonal, pass, um: measured, .. } = walk;
    let last = measured.len() - 1;
    let [start, end] = if *pass == Pass::Forward { [0, last] } else { [last, 0] };
    let left = |at: usize| measured[at] - measured[start] - (predicted[at].0 - predicted[start].0);
    let stated = |node: usize| predicted[node].1.unwrap_or(0.0);
    let model = &of.model;
    let reading = |node| Row::of(model.layout.reading(*pass, *diagonal, node));
    let u = |node: usize| {
        let difference = Row::sum([(1.0, reading(node)), (-1.0, reading(start))]);
        let square = of.noise.map(|_| model.variance(&difference).all)?;
        Some((square + stated(node) + stated(start)).sqrt())
    };
    let others = || (0..=last).filter(|node| *node != start);
    let ratio = |node: usize| Some(left(node).abs() / u(node).filter(|u| *u > 0.0)?);
    let ratios: Option<Vec<f64>> = others().map(ratio).collect();
    ClosureTest {
        diagonal: *diagonal,
        pass: *pass,
        largest_um: others().map(|node| left(node).abs()).fold(0.0, f64::max),
        end_um: left(end),
        u_end_um: u(end),
        worst_ratio: ratios.map(|ratios| ratios.into_iter().fold(0.0, f64::max)),
    }
}

/// What nine errors predict for the nodes of a diagonal; an undirected curve serves both ways.
fn predicted(volume: &Volume, table: &ErrorTable, walk: &Walk) -> Result<Vec<Predicted>, Problem> {
    let u = volume.laser(walk.diagonal);
    let at_node = |node: usize| {
        let place = volume.place(walk.diagonal, PathKind::Straight, node);
        let mut all = (0.0, Some(0.0));
        for ErrorTerm { of, along } in ErrorTerm::ALL {
            let direction = Some(walk.diagonal.travelled(along, walk.pass));
            let series = table.series(along);
            let series =
                series.iter().find(|s| s.direction == direction).or_else(|| series.first())?;
            let here = |um: &[f64]| u[of] * at(&series.positions, um, place[along].mm());
            let stated = series.uncertainties.get(&Kind::Deviation(of));
            all.0 += here(series.values.get(&Kind::Deviation(of))?);
            all.1 = all.1.zip(stated).map(|(sum, stated)| sum + here(stated).squared());
        }
        Some(all)
    };
    let all: Option<Vec<Predicted>> = (0..=volume.steps).map(at_node).collect();
    let words = "the closure test needs all nine errors; at least one is missing from the table";
    let problem = || Problem::new(words).at(table.header.clone());
    all.ok_or_else(|| problem().help("measure it, or leave `closure_errors` out"))
}
