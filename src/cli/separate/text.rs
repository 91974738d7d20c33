//! What `separate` prints for people: what was determined and what not, then the figures.

use super::agreement;
use super::closure::{closure, outliers};
use super::diagonals::{StandardFigures, diagonal_table};
use super::document::open_advice;
use super::reversal::{repeatability, reversal};
use super::words::{
    SQUARENESS_SIGN, doubtful, expanded, freedom, list, shown, signed, three, undetermined,
};
use crate::cli::show::{Column, paragraphs, table};
use crate::inputs::job::SetUp;
use crate::machine::separation::line::{ReferenceLine, range};
use crate::machine::separation::metric::Plane;
use crate::machine::separation::monte_carlo::{Figure, Simulated, measured_coverage};
use crate::machine::separation::{Evidence, Separation};
use crate::quantity::axis::{Axis, Direction, ErrorTerm, PerTerm};
use crate::quantity::diagonal::PathKind;
use crate::text::problem::Problems;

pub(super) fn summary(
    separation: &Separation,
    simulated: Option<&Simulated>,
) -> Result<String, Problems> {
    Ok(paragraphs(&[
        doubtful(&separation.doubts),
        outcome(separation),
        assumed_set_up(separation),
        undetermined(&separation.undetermined, &open_advice(separation)),
        outliers(&separation.closure.outliers),
        terms(separation),
        directions(separation),
        squareness(separation),
        agreement::table_of(separation.agreement.as_ref()),
        setup(separation),
        closure(separation),
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

/// What was determined, in one line, and what no U holds.
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
    let mut lines = vec![format!(
        "Determined: {count} of 9 errors; squareness {}; {set_up}",
        planes.join(", ")
    )];
    lines.extend(separation.not_counted.sentences());
    lines.join("\n")
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
        Column::Right("max - min/µm"),
        Column::Right("straightness/µm"),
        Column::Right("largest U(95 %)/µm"),
        Column::Right("freedom"),
    ];
    let rows = ErrorTerm::ALL.into_iter().map(|term| {
        let mut row = vec![term.to_string()];
        match &separation.errors.mean[term] {
            None => row.extend(["not determined", "-", "-"].map(String::from)),
            Some(found) => row.extend([
                three(
                    ReferenceLine::EndPoints
                        .slope_um_per_m(&positions_mm(separation, term.along), &found.deviation_um),
                ),
                three(last(&found.deviation_um)),
                three(range(found.deviation_um.iter().copied())),
            ]),
        }
        row.push(three(range(separation.shapes[term].iter().copied())));
        let largest = separation.errors.mean[term].as_ref();
        let largest = largest.map(|found| largest_u(found, separation));
        row.extend(match largest {
            None => ["-".to_string(), "-".to_string()],
            Some(largest) => [
                expanded(largest.map(|(um, _)| um)),
                freedom(largest.map(|(_, freedom)| freedom)),
            ],
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

/// U where it is largest on the curve, often in the middle, and its effective degrees of freedom.
fn largest_u(found: &Evidence, separation: &Separation) -> Option<(f64, Option<f64>)> {
    let at = |index| {
        let um = found.expanded_um(index, separation.noise)?;
        Some((um, found.freedom(index, separation.noise)))
    };
    let all: Option<Vec<_>> = (0..found.deviation_um.len()).map(at).collect();
    all?.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))
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
        Column::Right("largest U(95 %) of either/µm"),
    ];
    let pairs = |term: ErrorTerm| {
        let of = |errors: &PerTerm<Option<Evidence>>| errors[term].clone();
        of(plus).zip(of(minus))
    };
    let rows = ErrorTerm::ALL.into_iter().filter_map(|term| {
        let (plus, minus) = pairs(term)?;
        let size = |found: &Evidence| three(range(found.deviation_um.iter().copied()));
        let u = |found: &Evidence| largest_u(found, separation).map(|(um, _)| um);
        let either = u(&plus).zip(u(&minus)).map(|(a, b)| a.max(b));
        Some(vec![
            term.to_string(),
            three(last(&plus.deviation_um)),
            three(last(&minus.deviation_um)),
            size(&plus),
            size(&minus),
            expanded(either),
        ])
    });
    let apart = "+ is zero at the low end, - stands beside it by the reversal there";
    let open = "each is zero at its own low end: the reversal between them is not determined";
    let known = Axis::ALL
        .into_iter()
        .filter(|axis| separation.is_directed(*axis));
    let known: Vec<String> = known.map(|axis| format!("E{axis}{axis}")).collect();
    let zero = if separation.turn.is_some() {
        apart.to_string()
    } else if known.is_empty() {
        open.to_string()
    } else {
        format!("{}: {apart}; others: {open}", known.join(", "))
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
        Column::Right("U(95 %)/(µm/m)"),
        Column::Right("freedom"),
        Column::Right("by least squares/(µm/m)"),
    ];
    if naive {
        columns.push(Column::Right("sum of separated slopes/(µm/m)"));
    }
    let known = |plane: Plane| {
        let u = separation.u_squareness_um_per_m.of(plane);
        u.map(|_| separation.squareness_freedom.of(plane))
    };
    let rows = Plane::ALL.into_iter().map(|plane| {
        let mut row = vec![
            plane.key().to_uppercase(),
            separation
                .squareness_um_per_m
                .of(plane)
                .map_or_else(|| "not determined".into(), three),
            expanded(separation.expanded_squareness_um_per_m(plane)),
            freedom(known(plane)),
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

fn diagonals(separation: &Separation) -> Result<String, Problems> {
    let figures = StandardFigures::of(&separation.volume, PathKind::Step, &separation.zeroed_runs)?;
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
