//! What `separate` prints for people.

use crate::axis::{Axis, ErrorTerm};
use crate::cli::show::{Column, paragraphs, table};
use crate::diagonal::{Diagonal, PathKind, Volume};
use crate::job::DiagonalMeasurement;
use crate::problem::Problems;
use crate::separation::agreement::CHECK;
use crate::separation::closure::Outlier;
use crate::separation::diagonal_runs::diagonal_runs;
use crate::separation::line::{ReferenceLine, range};
use crate::separation::metric::{PerPlane, Plane};
use crate::separation::monte_carlo::Simulated;
use crate::separation::noise::{CorrectedRun, NoiseSource};
use crate::separation::straight::{StraightResult, scale_shares};
use crate::separation::{Evidence, Separation};
use crate::standards::{self, DiagonalMotion, Diagonals};
use crate::target_runs::Runs;

pub(super) const STRAIGHT_UNDETERMINED: &str = "scale of X, Y and Z can be traded against each other (only their sum weighted with the squares of the edges is known); measure two axes along their length";

/// The sentence of contract §1 that stands wherever φ stands.
const SQUARENESS_SIGN: &str = "squareness in um/m: positive = the angle between the two positive axis directions is less than 90 degrees (ISO 230-1: EC0Y = -xy, EB0Z = +xz, EA0Z = -yz)";
const SMALL_PROBABILITY: f64 = 0.01;

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
        terms(separation),
        squareness(
            &separation.squareness_um_per_m,
            &separation.u_squareness_um_per_m,
        ),
        agreement(separation),
        undetermined(&separation.undetermined),
        setup(separation),
        closure(separation),
        outliers(&separation.closure.outliers),
        reversal(separation),
        diagonals(separation)?,
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

fn list(heading: &str, lines: &[String]) -> String {
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
        Column::Right("U(k=2) there um"),
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
            ],
            Some(found) => vec![
                term.to_string(),
                format!(
                    "{:.3}",
                    ReferenceLine::EndPoints.slope_um_per_m(&positions, &found.deviation_um)
                ),
                three(range(found.deviation_um.iter().copied())),
                beside,
                three(found.deviation_um.last().copied().unwrap_or(0.0)),
                expanded(found),
            ],
        }
    });
    format!(
        "Nine errors, zero at the low end of each axis (slope of the line through the end points)\n{}",
        table(&columns, rows)
    )
}

fn expanded(found: &Evidence) -> String {
    let last = found.u_um.as_ref().and_then(|u| u.last());
    last.map_or_else(|| "not known".into(), |u| three(2.0 * u))
}

fn squareness(found: &PerPlane<Option<f64>>, u: &PerPlane<Option<f64>>) -> String {
    let columns = [
        Column::Left("plane"),
        Column::Right("squareness um/m"),
        Column::Right("U(k=2) um/m"),
    ];
    let rows = Plane::ALL.into_iter().map(|plane| {
        vec![
            plane.key().to_uppercase(),
            found
                .of(plane)
                .map_or_else(|| "not determined".into(), |value| format!("{value:.3}")),
            u.of(plane)
                .map_or_else(|| "not known".into(), |u| three(2.0 * u)),
        ]
    });
    format!(
        "{}\n{SQUARENESS_SIGN}; from the totals of the diagonals",
        table(&columns, rows)
    )
}

/// Linear axes and beams against each other and the diagonals.
fn agreement(separation: &Separation) -> String {
    let Some(agreement) = &separation.agreement else {
        return String::new();
    };
    let columns = [
        Column::Left("line"),
        Column::Right("stated um/m"),
        Column::Right("by all others um/m"),
        Column::Right("difference um/m"),
        Column::Right("u (k=1) um/m"),
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

fn closure(separation: &Separation) -> String {
    let closure = &separation.closure;
    let means = Axis::ALL.map(|axis| format!("{axis} {:+.3}", closure.mean[axis]));
    let mut lines = vec![format!(
        "Closure: mean over each axis (um) {} - what is constant is set-up error",
        means.join(", ")
    )];
    if let Some(sigma) = closure.sigma_um() {
        lines.push(format!(
            "its scatter speaks for a noise of {sigma:.3} um of a single reading ({} degrees of freedom)",
            closure.freedom
        ));
    }
    let test = separation
        .noise
        .filter(|noise| noise.source != NoiseSource::Closure);
    if let Some(noise) = test
        && let Some(probability) = closure.probability(noise.sigma_um)
    {
        let verdict = if probability < SMALL_PROBABILITY {
            "the scatter is NOT explained by that noise: roll of an axis that carries others, drift, or disturbed readings"
        } else {
            "in keeping with that noise"
        };
        lines.push(format!(
            "chi-squared test against {:.3} um {}: probability {probability:.3}, {verdict}",
            noise.sigma_um,
            noise.source.words()
        ));
    }
    lines.push("a clean closure proves nothing about pitch, yaw and five of eight patterns of set-up error".into());
    lines.join("\n")
}

fn outliers(outliers: &[Outlier]) -> String {
    let lines: Vec<String> = outliers
        .iter()
        .map(|outlier| {
            let places: Vec<String> = outlier
                .readings
                .iter()
                .map(|r| format!("{} {} node {}", r.diagonal, r.pass.word(), r.node))
                .collect();
            format!(
                "{}: {:+.3} um, {:.1} standard deviations",
                places.join(" or "),
                outlier.size_um,
                outlier.ratio
            )
        })
        .collect();
    list(
        "Disturbed readings (they stay in the result: repeat the run):",
        &lines,
    )
}

fn reversal(separation: &Separation) -> String {
    let Some(turn) = &separation.turn else {
        return String::new();
    };
    let columns = [
        Column::Left("axis"),
        Column::Right("reversal B um"),
        Column::Right("PPP"),
        Column::Right("NPP"),
        Column::Right("PNP"),
        Column::Right("PPN"),
    ];
    let rows = Axis::ALL.into_iter().map(|axis| {
        let term = ErrorTerm {
            of: axis,
            along: axis,
        };
        let mut row = vec![axis.to_string(), three(turn.reversal_um[term])];
        row.extend(turn.by_diagonal_um.iter().map(|(_, b)| three(b[axis])));
        row
    });
    format!(
        "Reversal from the turn (B = moving + minus moving -), together and from each diagonal alone\n{}",
        table(&columns, rows)
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
        diagonal_table(&figures, |diagonal| result.diagonals[diagonal].end_um),
        squareness(&phi, &PerPlane::default()),
        scales,
        undetermined(&[STRAIGHT_UNDETERMINED.to_string()]),
        closure,
    ]))
}
