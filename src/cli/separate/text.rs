//! What `separate` prints for people.

use super::closure::{closure, outliers};
use crate::axis::{Axis, ErrorTerm};
use crate::cli::show::{Column, paragraphs, table};
use crate::diagonal::{Diagonal, Pass, PathKind, Volume};
use crate::job::DiagonalMeasurement;
use crate::problem::Problems;
use crate::separation::diagonal_runs::diagonal_runs;
use crate::separation::line::{ReferenceLine, range};
use crate::separation::metric::{PerPlane, Plane};
use crate::separation::monte_carlo::Simulated;
use crate::separation::noise::{CorrectedRun, coverage_factor, repeatability_um};
use crate::separation::reversal::{Estimate, Turn};
use crate::separation::straight::{StraightResult, scale_shares};
use crate::separation::{Evidence, Separation};
use crate::standards::{self, DiagonalMotion, Diagonals};
use crate::target_runs::Runs;

pub(super) const STRAIGHT_UNDETERMINED: &str = "scale of X, Y and Z can be traded against each other (only their sum weighted with the squares of the edges is known); measure two axes along their length";

/// The sentence of contract §1 that stands wherever φ stands.
const SQUARENESS_SIGN: &str = "squareness in um/m: positive = the angle between the two positive axis directions is less than 90 degrees (ISO 230-1: EC0Y = -xy, EB0Z = +xz, EA0Z = -yz)";

/// Figures of the diagonals by standard, with the label of the motion.
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

pub(super) fn summary(
    separation: &Separation,
    simulated: Option<&Simulated>,
) -> Result<String, Problems> {
    Ok(paragraphs(&[
        list("DOUBTFUL, so the answer is no:", &separation.doubts),
        terms(separation),
        squareness(
            &separation.squareness_um_per_m,
            separation.u_squareness_um_per_m.as_ref(),
            separation.noise.and_then(|noise| noise.freedom_f64()),
        ),
        undetermined(&separation.undetermined),
        setup(separation),
        closure(separation),
        outliers(&separation.closure.outliers),
        reversal(separation),
        diagonals(separation)?,
        repeatability(separation),
        simulated.map_or_else(String::new, monte_carlo),
        list(
            "Assumed, and what the uncertainty holds:",
            &separation.labels,
        ),
    ]))
}

/// Three decimals, never −0.
fn three(value: f64) -> String {
    format!("{:.3}", (value * 1000.0).round() / 1000.0 + 0.0)
}

/// The same with its sign.
fn signed(value: f64) -> String {
    format!("{:+.3}", (value * 1000.0).round() / 1000.0 + 0.0)
}

pub(super) fn list(heading: &str, lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let lines: Vec<String> = lines.iter().map(|line| format!("- {line}")).collect();
    format!("{heading}\n{}", lines.join("\n"))
}

fn terms(separation: &Separation) -> String {
    let columns = [
        Column::Left("term"),
        Column::Right("slope um/m"),
        Column::Right("range um"),
        Column::Right("beside end points um"),
        Column::Right("at far end um"),
        Column::Right("U(95 %) there um"),
        Column::Right("freedom"),
    ];
    let rows = ErrorTerm::ALL.into_iter().map(|term| {
        let positions: Vec<f64> = separation
            .volume
            .positions(term.along)
            .iter()
            .map(|position| position.mm())
            .collect();
        let shape = &separation.shapes[term];
        let beside = three(range(shape.iter().copied()));
        match &separation.errors.mean[term] {
            None => vec![
                term.to_string(),
                "not determined".into(),
                "-".into(),
                beside,
                "-".into(),
                "-".into(),
                "-".into(),
            ],
            Some(found) => {
                let [expanded, freedom] = expanded(found, separation);
                vec![
                    term.to_string(),
                    format!(
                        "{:.3}",
                        ReferenceLine::EndPoints.slope_um_per_m(&positions, &found.deviation_um)
                    ),
                    three(range(found.deviation_um.iter().copied())),
                    beside,
                    three(found.deviation_um.last().copied().unwrap_or(0.0)),
                    expanded,
                    freedom,
                ]
            }
        }
    });
    format!(
        "{}, zero at the low end of each axis (slope of the line through the end points)\n{}",
        heading(separation.missing().len()),
        table(&columns, rows)
    )
}

fn heading(missing: usize) -> String {
    match missing {
        0 => "Nine errors".to_string(),
        missing => {
            let words = [
                "None", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight",
            ];
            let found = words.get(ErrorTerm::ALL.len() - missing);
            format!("{} of the nine errors", found.unwrap_or(&"None"))
        }
    }
}

/// U at the far end with the coverage factor of its effective degrees of freedom, and these.
fn expanded(found: &Evidence, separation: &Separation) -> [String; 2] {
    let last = found.deviation_um.len().saturating_sub(1);
    match found.expanded_um(last, separation.noise) {
        None => ["not known".into(), "-".into()],
        Some(um) => [three(um), freedom(found.freedom(last, separation.noise))],
    }
}

fn freedom(effective: Option<f64>) -> String {
    effective.map_or_else(|| "unlimited".into(), |freedom| format!("{freedom:.0}"))
}

fn squareness(
    found: &PerPlane<Option<f64>>,
    u: Option<&PerPlane<f64>>,
    of_noise: Option<f64>,
) -> String {
    let columns = [
        Column::Left("plane"),
        Column::Right("squareness um/m"),
        Column::Right("U(95 %) um/m"),
        Column::Right("freedom"),
    ];
    let rows = Plane::ALL.into_iter().map(|plane| {
        vec![
            plane.key().to_uppercase(),
            found
                .of(plane)
                .map_or_else(|| "not determined".into(), |value| format!("{value:.3}")),
            u.map_or_else(
                || "not known".into(),
                |u| three(coverage_factor(of_noise) * u.of(plane)),
            ),
            u.map_or_else(|| "-".into(), |_| freedom(of_noise)),
        ]
    });
    format!(
        "{}\n{SQUARENESS_SIGN}; from the totals of the diagonals",
        table(&columns, rows)
    )
}

fn undetermined(words: &[String]) -> String {
    list("NOT DETERMINED by these readings, and left out:", words)
}

fn setup(separation: &Separation) -> String {
    let Some(tilts) = &separation.tilts else {
        return String::new();
    };
    let columns = [
        Column::Left("set-up"),
        Column::Right("tilt arcsec"),
        Column::Right("towards X"),
        Column::Right("Y"),
        Column::Right("Z"),
    ];
    let rows = tilts.iter().map(|(diagonal, tilt)| {
        vec![
            diagonal.to_string(),
            format!("{:.1}", tilt.arcsec),
            signed(tilt.direction.x),
            signed(tilt.direction.y),
            signed(tilt.direction.z),
        ]
    });
    format!(
        "Mirror: its normal leans from the nominal diagonal (solved for; no error of the machine)\n{}",
        table(&columns, rows)
    )
}

fn reversal(separation: &Separation) -> String {
    let Some(turn) = &separation.turn else {
        return String::new();
    };
    let k = coverage_factor(separation.noise.and_then(|noise| noise.freedom_f64()));
    let shown = |b: Estimate| {
        let u = b.u_um.map_or_else(|| "not known".into(), |u| three(k * u));
        format!("{} +- {u}", three(b.um))
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
        Column::Right("B um"),
        Column::Right("at low end um"),
        Column::Right("at high end um"),
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
        "Reversal from the turn (B = moving + minus moving -; +- U(95 %)): one for the whole axis, and at each end as the curves hold it\n{}\na small probability in the last column: the reversal differs along the axis, and the first figure is no figure of the machine",
        table(&columns, rows)
    )
}

fn reversal_by_diagonal(turn: &Turn, shown: impl Fn(Estimate) -> String) -> String {
    let mut columns = vec![Column::Left("B um")];
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
    format!("Reversal of cross terms, um: {}", said.join(", "))
}

/// R of both passes along every diagonal.
fn repeatability(separation: &Separation) -> String {
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
        "Repeatability R = 4 s, the largest over all nodes (ISO 230-2), um: {}",
        all.join(", ")
    )
}

fn diagonals(separation: &Separation) -> Result<String, Problems> {
    let figures = standard_figures(&separation.volume, PathKind::Step, &separation.zeroed_runs)?;
    Ok(diagonal_table(&figures, |diagonal| {
        separation.diagonals[diagonal].end_um
    }))
}

fn diagonal_table(figures: &Diagonals, end_um: impl Fn(Diagonal) -> f64) -> String {
    let columns = [
        Column::Left("diagonal"),
        Column::Right("end um"),
        Column::Right("E um"),
        Column::Right("B um"),
        Column::Right("max - min um"),
    ];
    let shown = |value: Option<f64>| value.map_or_else(|| "-".into(), |um| format!("{um:.3}"));
    let rows = Diagonal::ALL
        .into_iter()
        .zip(&figures.diagonals)
        .map(|(diagonal, of)| {
            vec![
                diagonal.to_string(),
                three(end_um(diagonal)),
                shown(of.figures.e.both_um),
                shown(of.figures.b_um),
                shown(of.range_um),
            ]
        });
    let machine = format!(
        "E_d {} um, B_d {} um; largest range {} um, over all four {} um",
        shown(figures.e_d_um),
        shown(figures.b_d_um),
        shown(figures.largest_range_um),
        shown(figures.range_over_all_um)
    );
    format!(
        "Body diagonals ({})\n{}\n{machine}",
        figures.label,
        table(&columns, rows)
    )
}

fn monte_carlo(simulated: &Simulated) -> String {
    let columns = [
        Column::Left("figure"),
        Column::Right("estimate"),
        Column::Right("bias by noise"),
        Column::Right("95 % from"),
        Column::Right("to"),
        Column::Left("unit"),
    ];
    let rows = simulated.figures.iter().map(|f| {
        vec![
            f.name.clone(),
            three(f.estimate),
            signed(f.bias),
            three(f.interval[0]),
            three(f.interval[1]),
            f.unit.to_string(),
        ]
    });
    format!(
        "Simulated {} times with seed {} (how often such intervals hold: docs/accuracy.md)\n{}",
        simulated.plan.trials,
        simulated.plan.seed,
        table(&columns, rows)
    )
}

pub(super) fn straight(
    measurement: &DiagonalMeasurement,
    result: &StraightResult,
) -> Result<String, Problems> {
    let figures = standard_figures(&measurement.volume, PathKind::Straight, &result.runs)?;
    let phi = &result.totals.squareness_um_per_m;
    let phi = PerPlane {
        xy: Some(phi.xy),
        xz: Some(phi.xz),
        yz: Some(phi.yz),
    };
    let shares = scale_shares(&measurement.volume);
    let shares = Axis::ALL.map(|axis| format!("{:.3} x slope of E{axis}{axis}", shares[axis]));
    let square_m = measurement.volume.diagonal_mm().powi(2) / 1000.0;
    let scales = format!(
        "One combination of the scales: {} = {:.3} um/m",
        shares.join(" + "),
        result.totals.scale_sum_um_mm / square_m
    );
    let closure = result.closure.as_ref().map_or_else(String::new, |tests| {
        let lines: Vec<String> = tests
            .iter()
            .map(|(diagonal, test)| {
                format!(
                    "{diagonal}: largest {:.3} um, at the far end {:+.3} um",
                    test.largest_um, test.end_um
                )
            })
            .collect();
        list(
            "Closure test: measured less what the nine errors predict",
            &lines,
        )
    });
    Ok(paragraphs(&[
        list("What the readings say of themselves:", &result.notes),
        diagonal_table(&figures, |diagonal| result.diagonals[diagonal].end_um),
        squareness(&phi, None, None),
        scales,
        undetermined(&[STRAIGHT_UNDETERMINED.to_string()]),
        closure,
    ]))
}
