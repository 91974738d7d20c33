//! What `separate` prints for people: what was determined and what not, then the figures.

use super::diagonals::{diagonal_table, standard_figures};
use super::document::open_advice;
use super::words::{SQUARENESS_SIGN, expanded, list, shown, signed, three, undetermined};
use crate::axis::{Axis, Direction, ErrorTerm, PerTerm};
use crate::cli::show::{Column, paragraphs, table};
use crate::diagonal::PathKind;
use crate::job::SetUp;
use crate::problem::Problems;
use crate::separation::closure::Outlier;
use crate::separation::line::{ReferenceLine, range};
use crate::separation::metric::Plane;
use crate::separation::monte_carlo::{Figure, Simulated, measured_coverage};
use crate::separation::noise::NoiseSource;
use crate::separation::{Evidence, Separation};

const SMALL_PROBABILITY: f64 = 0.01;
/// A disturbance of more standard deviations than these needs no exact number.
const MANY_DEVIATIONS: f64 = 100.0;

pub(super) fn summary(
    separation: &Separation,
    simulated: Option<&Simulated>,
) -> Result<String, Problems> {
    Ok(paragraphs(&[
        outcome(separation),
        assumed_set_up(separation),
        undetermined(&separation.undetermined, &open_advice(separation)),
        outliers(&separation.closure.outliers),
        terms(separation),
        directions(separation),
        squareness(separation),
        setup(separation),
        closure(separation),
        reversal(separation),
        diagonals(separation)?,
        simulated.map_or_else(String::new, monte_carlo),
        list(
            "Assumed, and what the uncertainty holds:",
            &separation.labels,
        ),
    ]))
}

/// What was determined, in one line.
fn outcome(separation: &Separation) -> String {
    let errors = separation.errors.mean.iter();
    let count = errors.filter(|(_, found)| found.is_some()).count();
    let planes: Vec<String> = Plane::ALL
        .into_iter()
        .filter(|plane| separation.squareness_um_per_m.of(*plane).is_some())
        .map(|plane| plane.key().to_uppercase())
        .collect();
    let set_up = match (separation.setup, &separation.tilts) {
        (SetUp::AssumePerfect, _) => "set-up assumed perfect",
        (SetUp::Solve, Some(_)) => "set-up solved for",
        (SetUp::Solve, None) => "tilt of the mirror not determined",
    };
    format!(
        "Determined: {count} of 9 errors; squareness {}; {set_up}",
        planes.join(", ")
    )
}

/// The first thing to read where the set-up is assumed; the label says the rest.
fn assumed_set_up(separation: &Separation) -> String {
    match separation.setup {
        SetUp::Solve => String::new(),
        SetUp::AssumePerfect => "WARNING: `setup = \"assume-perfect\"`: slopes that were separated hold the tilt of the mirror.\nFor figures of the machine use `setup = \"solve\"` with two or three linear axes.".to_string(),
    }
}

fn positions_mm(separation: &Separation, axis: Axis) -> Vec<f64> {
    let positions = separation.volume.positions(axis);
    positions.iter().map(|position| position.mm()).collect()
}

fn terms(separation: &Separation) -> String {
    let columns = [
        Column::Left("error"),
        Column::Right("slope/(µm/m)"),
        Column::Right("far end/µm"),
        Column::Right("U(k=2)/µm"),
        Column::Right("max - min/µm"),
        Column::Right("straightness/µm"),
        Column::Right("largest U(k=2)/µm"),
    ];
    let rows = ErrorTerm::ALL.into_iter().map(|term| {
        let mut row = vec![term.to_string()];
        match &separation.errors.mean[term] {
            None => row.extend(["not determined", "-", "-", "-"].map(String::from)),
            Some(found) => row.extend([
                three(
                    ReferenceLine::EndPoints
                        .slope_um_per_m(&positions_mm(separation, term.along), &found.deviation_um),
                ),
                three(last(&found.deviation_um)),
                expanded(found.u_um.as_ref().map(|u| last(u))),
                three(range(found.deviation_um.iter().copied())),
            ]),
        }
        row.push(three(range(separation.shapes[term].iter().copied())));
        row.push(match &separation.errors.mean[term] {
            None => "-".to_string(),
            Some(found) => largest_u(found),
        });
        row
    });
    format!(
        "Errors (actual - commanded), zero at the low end of each axis\nslope, straightness: line through the end points; straightness of EXX, EYY, EZZ: what is left beside that line\n{}",
        table(&columns, rows)
    )
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(0.0)
}

/// U where it is largest on the curve, often in the middle.
fn largest_u(found: &Evidence) -> String {
    let u = found.u_um.as_ref();
    expanded(u.map(|u| u.iter().copied().fold(0.0, f64::max)))
}

/// Both directions, where they stand apart.
fn directions(separation: &Separation) -> String {
    let plus = separation.errors.directed(Direction::Plus);
    let Some((plus, minus)) = plus.zip(separation.errors.directed(Direction::Minus)) else {
        return String::new();
    };
    let columns = [
        Column::Left("error"),
        Column::Right("far end +/µm"),
        Column::Right("far end -/µm"),
        Column::Right("max - min +/µm"),
        Column::Right("max - min -/µm"),
        Column::Right("largest U(k=2) of either/µm"),
    ];
    let pairs = |term: ErrorTerm| {
        let of = |errors: &PerTerm<Option<Evidence>>| errors[term].clone();
        of(plus).zip(of(minus))
    };
    let rows = ErrorTerm::ALL.into_iter().filter_map(|term| {
        let (plus, minus) = pairs(term)?;
        let size = |found: &Evidence| three(range(found.deviation_um.iter().copied()));
        let u = plus.u_um.iter().chain(&minus.u_um).flatten();
        let known = plus.u_um.is_some() && minus.u_um.is_some();
        Some(vec![
            term.to_string(),
            three(last(&plus.deviation_um)),
            three(last(&minus.deviation_um)),
            size(&plus),
            size(&minus),
            expanded(known.then(|| u.copied().fold(0.0, f64::max))),
        ])
    });
    let zero = if separation.has_directed_table() {
        "+ is zero at the low end, - stands beside it by the reversal there"
    } else {
        "each is zero at its own low end: the reversal between them is not determined"
    };
    format!(
        "The same by direction of motion; {zero}\n{}",
        table(&columns, rows)
    )
}

fn squareness(separation: &Separation) -> String {
    let naive = separation.setup == SetUp::AssumePerfect;
    let mut columns = vec![
        Column::Left("plane"),
        Column::Right("squareness/(µm/m)"),
        Column::Right("U(k=2)/(µm/m)"),
        Column::Right("by least squares/(µm/m)"),
    ];
    if naive {
        columns.push(Column::Right("sum of separated slopes/(µm/m)"));
    }
    let u = separation.u_squareness_um_per_m;
    let rows = Plane::ALL.into_iter().map(|plane| {
        let mut row = vec![
            plane.key().to_uppercase(),
            separation
                .squareness_um_per_m
                .of(plane)
                .map_or_else(|| "not determined".into(), three),
            expanded(u.map(|u| u.of(plane))),
            shown(separation.squareness_least_squares_um_per_m.of(plane)),
        ];
        if naive {
            row.push(three(separation.naive_squareness_um_per_m(plane)));
        }
        row
    });
    let mut lines = vec![
        table(&columns, rows),
        SQUARENESS_SIGN.to_string(),
        "squareness and U: lines through the end points, from the totals of the diagonals; by least squares: lines through the curves above, with their straightness".to_string(),
    ];
    if naive {
        lines.push("sum of separated slopes: holds the tilt of the mirror, no figure of the machine; with `frame = \"as-measured\"` it is what the curves and the tables made from them carry".to_string());
    }
    lines.join("\n")
}

fn setup(separation: &Separation) -> String {
    let Some(tilts) = &separation.tilts else {
        return String::new();
    };
    let columns = [
        Column::Left("set-up"),
        Column::Right("tilt/arcsec"),
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
        "Tilt of the mirror: its normal against the nominal diagonal (solved for and taken out; no error of the machine)\n{}",
        table(&columns, rows)
    )
}

fn closure(separation: &Separation) -> String {
    let closure = &separation.closure;
    let means = Axis::ALL.map(|axis| format!("{axis} {:+.3}", closure.mean[axis]));
    let mut lines = vec![format!(
        "Closure w: mean over each axis (µm) {} - what is constant is set-up error",
        means.join(", ")
    )];
    if let Some(sigma) = closure.sigma_um() {
        lines.push(format!(
            "its scatter: standard deviation {sigma:.3} µm of a single reading ({} degrees of freedom)",
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
            "chi-squared test against {:.3} µm {}: probability {probability:.3}, {verdict}",
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
                "{}: {} µm, {}",
                places.join(" or "),
                signed(outlier.size_um),
                deviations(outlier.ratio)
            )
        })
        .collect();
    list(
        "Disturbed readings (they stay in the result: repeat the run):",
        &lines,
    )
}

fn deviations(ratio: f64) -> String {
    if ratio > MANY_DEVIATIONS {
        return format!("more than {MANY_DEVIATIONS:.0} standard deviations");
    }
    format!("{ratio:.1} standard deviations")
}

fn reversal(separation: &Separation) -> String {
    let Some(turn) = &separation.turn else {
        return String::new();
    };
    let columns = [
        Column::Left("axis"),
        Column::Right("reversal B/µm"),
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
        "Reversal at the reversal point (B = moving + minus moving -), together and from each diagonal alone\n{}",
        table(&columns, rows)
    )
}

fn diagonals(separation: &Separation) -> Result<String, Problems> {
    let figures = standard_figures(&separation.volume, PathKind::Step, &separation.zeroed_runs)?;
    let table = diagonal_table(&figures, |diagonal| separation.diagonals[diagonal].end_um);
    Ok(format!(
        "{table}\n`generate` computes its diagonals from the nine errors instead: without the tilt of the mirror, without noise between the nodes"
    ))
}

fn monte_carlo(simulated: &Simulated) -> String {
    let columns = [
        Column::Left("figure"),
        Column::Right("estimate"),
        Column::Right("bias by noise"),
        Column::Right("from"),
        Column::Right("to"),
        Column::Left("unit"),
        Column::Right("held the truth"),
    ];
    let rows = simulated.figures.iter().map(|f: &Figure| {
        vec![
            f.name.clone(),
            three(f.estimate),
            signed(f.bias),
            three(f.interval[0]),
            three(f.interval[1]),
            f.unit.to_string(),
            format!("{:.1} %", 100.0 * measured_coverage(f)),
        ]
    });
    let size = |f: &Figure| f.unit == "µm" && f.interval[0] < 0.0;
    let hidden = if simulated.figures.iter().any(size) {
        "\na range or straightness whose interval reaches below 0 cannot be told from noise"
    } else {
        ""
    };
    format!(
        "Monte Carlo, {} trials, seed {}; range = max - min, straightness by least squares lines\nonly noise of the readings and the stated u of linear axes and beams are varied: no tilt, no angular errors\nintervals are made for 95 %; how often such intervals held the truth on simulated machines stands beside them\n{}{hidden}",
        simulated.plan.trials,
        simulated.plan.seed,
        table(&columns, rows)
    )
}
