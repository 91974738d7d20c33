//! What `separate` prints for people: what was determined and what not, then the figures.

use super::closure::{closure, disturbed, repeatability, reversal};
use super::document::open_advice;
use super::words::{self, SQUARENESS_SIGN, expanded, freedom};
use crate::cli::diagonals::StandardFigures;
use crate::cli::screen::{More, Screen, paragraphs, table};
use crate::cli::show::um;
use crate::inputs::job::SetUp;
use crate::machine::separation::curves::{ReferenceLine, range};
use crate::machine::separation::metric::Plane;
use crate::machine::separation::monte_carlo::{Figure as Simulation, Simulated};
use crate::machine::separation::solved::naive_squareness;
use crate::machine::separation::{SeparatedError, Separation};
use crate::quantity::axis::{Axis, Direction, ErrorTerm};
use crate::quantity::diagonal::PathKind;
use crate::quantity::units::Figure;
use crate::text::problem::Problems;

pub(super) fn screen(
    separation: &Separation,
    simulated: Option<&Simulated>,
) -> Result<Screen, Problems> {
    let figures =
        StandardFigures::of(&separation.volume, PathKind::Step, &separation.zeroed_runs, true)?;
    let outliers = &separation.closure.outliers;
    let more = vec![
        More::part("directions", directions(separation)),
        More::part("linear axes and beams", words::agreement(separation.agreement.as_ref())),
        More::part("set-up", setup(separation)),
        More::part("closure", closure(separation)),
        More::part("reversal", reversal(separation)),
        More::part("diagonals", diagonals(separation, &figures)),
        More::part("repeatability", repeatability(separation)),
        More::part("Monte Carlo", simulated.map_or_else(String::new, monte_carlo)),
    ];
    let mut screen = words::screen(
        &separation.doubts,
        outcome(separation),
        (&separation.undetermined, &open_advice(separation)),
        paragraphs(&[terms(separation), squareness(separation)]),
        more,
        &separation.labels,
    );
    screen.findings = outliers.iter().map(disturbed).collect();
    Ok(screen)
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
    lines.extend(separation.silence.sentences());
    if separation.setup == SetUp::AssumePerfect {
        // The first thing to read there; the label says the rest.
        lines.push("WARNING: `setup = \"assume-perfect\"`: slopes that were separated hold the tilt of the mirror; for figures of the machine use `setup = \"solve\"` with two or three linear axes".to_string());
    }
    lines.join("\n")
}

fn positions_mm(separation: &Separation, axis: Axis) -> Vec<f64> {
    let positions = separation.volume.positions(axis);
    positions.iter().map(|position| position.mm()).collect()
}

fn terms(separation: &Separation) -> String {
    let rows = ErrorTerm::ALL.into_iter().map(|term| {
        let shape = um(Some(range(separation.shapes[term].iter().copied())));
        let Some(found) = &separation.errors.mean[term] else {
            return format!("{term}\tnot determined\t-\t-\t{shape}\t-\t-");
        };
        let curve = &found.deviation_um;
        let positions = positions_mm(separation, term.along);
        let slope = ReferenceLine::EndPoints.slope_um_per_m(&positions, curve);
        let [slope, end, range] = [slope, last(curve), range(curve.iter().copied())].map(Figure);
        let largest = largest_u(found, separation);
        let (u, freedom) = (expanded(largest.map(|(um, _)| um)), freedom(largest.map(|(_, f)| f)));
        format!("{term}\t{slope:.3}\t{end:.3}\t{range:.3}\t{shape}\t{u}\t{freedom}")
    });
    let heading = "error\t>slope/(µm/m)\t>far end/µm\t>max - min/µm\t>straightness/µm\t>largest U(95 %)/µm\t>degrees of freedom";
    format!(
        "Errors (actual - commanded), zero at the low end of each axis\nslope, straightness: line through the end points; straightness of EXX, EYY, EZZ: residual from that line\n{}",
        table(heading, rows)
    )
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(0.0)
}

/// U where it is largest on the curve, often in the middle, and its effective degrees of freedom.
fn largest_u(found: &SeparatedError, separation: &Separation) -> Option<(f64, Option<f64>)> {
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
    let rows = ErrorTerm::ALL.into_iter().filter_map(|term| {
        let (plus, minus) = (plus[term].as_ref()?, minus[term].as_ref()?);
        let both = [plus, minus].map(|found| &found.deviation_um);
        let [end, other_end] = both.map(|curve| Figure(last(curve)));
        let [size, other_size] = both.map(|curve| Figure(range(curve.iter().copied())));
        let u = |found: &SeparatedError| largest_u(found, separation).map(|(um, _)| um);
        let either = expanded(u(plus).zip(u(minus)).map(|(a, b)| a.max(b)));
        Some(format!("{term}\t{end:.3}\t{other_end:.3}\t{size:.3}\t{other_size:.3}\t{either}"))
    });
    let apart = "+ is zero at the low end, - stands beside it by the reversal there";
    let open = "each is zero at its own low end: the reversal between them is not determined";
    let known = Axis::ALL.into_iter().filter(|axis| separation.is_directed(*axis));
    let known: Vec<String> = known.map(|axis| format!("E{axis}{axis}")).collect();
    let zero = if separation.turn.is_some() {
        apart.to_string()
    } else if known.is_empty() {
        open.to_string()
    } else {
        format!("{}: {apart}; others: {open}", known.join(", "))
    };
    let heading = "error\t>far end +/µm\t>far end -/µm\t>max - min +/µm\t>max - min -/µm\t>largest U(95 %) of either/µm";
    let table = table(heading, rows);
    format!("The same by direction of motion; {zero}\n{table}")
}

fn squareness(separation: &Separation) -> String {
    let naive = separation.setup == SetUp::AssumePerfect;
    let rows = Plane::ALL.into_iter().map(|plane| {
        let found = separation.squareness_um_per_m.of(plane);
        let found = found.map_or_else(|| "not determined".into(), |slope| um(Some(slope)));
        let u = separation.u_squareness.of(plane);
        let freedom = freedom(u.map(|u| u.freedom));
        let row = format!(
            "{}\t{found}\t{}\t{freedom}\t{}",
            plane.key().to_uppercase(),
            expanded(separation.expanded_squareness_um_per_m(plane)),
            um(separation.squareness_least_squares_um_per_m.of(plane)),
        );
        match naive {
            true => format!(
                "{row}\t{:.3}",
                Figure(naive_squareness(&separation.naive_slopes_um_per_m, plane))
            ),
            false => row,
        }
    });
    let (column, legend) = match naive {
        true => (
            "\t>sum of separated slopes/(µm/m)",
            "\nsum of separated slopes: holds the tilt of the mirror, no figure of the machine; with `frame = \"as-measured\"` it is what the curves and the tables made from them carry",
        ),
        false => ("", ""),
    };
    let heading = format!(
        "plane\t>squareness/(µm/m)\t>U(95 %)/(µm/m)\t>degrees of freedom\t>by least squares/(µm/m){column}"
    );
    format!(
        "{}\n{SQUARENESS_SIGN}\nsquareness and U: lines through the end points, from the totals of the diagonals; by least squares: lines through the curves above, with their straightness{legend}",
        table(&heading, rows)
    )
}

fn setup(separation: &Separation) -> String {
    let Some(tilts) = &separation.tilts else {
        return String::new();
    };
    let rows = tilts.iter().map(|(diagonal, tilt)| {
        let towards = tilt.direction;
        let [x, y, z] = [towards.x, towards.y, towards.z].map(Figure);
        format!("{diagonal}\t{:.1}\t{x:+.3}\t{y:+.3}\t{z:+.3}", tilt.arcsec)
    });
    format!(
        "Tilt of the mirror: its normal against the nominal diagonal (solved for and taken out; no error of the machine)\n{}",
        table("set-up\t>tilt/arcsec\t>towards X\t>Y\t>Z", rows)
    )
}

fn diagonals(separation: &Separation, figures: &StandardFigures) -> String {
    let table = figures.as_read(|diagonal| separation.end_um[diagonal]);
    format!(
        "{table}\n`generate` computes its diagonals from the nine errors instead: without the tilt of the mirror, without noise between the nodes"
    )
}

fn monte_carlo(simulated: &Simulated) -> String {
    let rows = simulated.figures.iter().map(|f: &Simulation| {
        let [estimate, bias, from, to] =
            [f.estimate, f.bias, f.interval[0], f.interval[1]].map(Figure);
        let held = 100.0 * f.measured_coverage;
        format!(
            "{}\t{estimate:.3}\t{bias:+.3}\t{from:.3}\t{to:.3}\t{}\t{held:.1} %",
            f.name, f.unit
        )
    });
    let heading = "figure\t>estimate\t>bias by noise\t>from\t>to\tunit\t>held the truth";
    let size = |f: &Simulation| f.unit == "µm" && f.interval[0] < 0.0;
    let hidden = if simulated.figures.iter().any(size) {
        "\na range or straightness whose interval reaches below 0 cannot be told from noise"
    } else {
        ""
    };
    format!(
        "Monte Carlo, {} trials, seed {}; range = max - min, straightness by least squares lines\nonly noise of the readings and the stated u of linear axes and beams are varied: no tilt, no angular errors\nintervals are made for 95 %; how often such intervals held the truth on simulated machines stands beside them\n{}{hidden}",
        simulated.plan.trials,
        simulated.plan.seed,
        table(heading, rows)
    )
}
