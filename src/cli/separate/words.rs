//! What both pages of `separate` show: numbers, what is open and how to determine it, linear axes and
//! beams against the diagonals; and the page of straight runs.

use crate::cli::screen::{More, Screen, list, paragraphs, table};
use crate::cli::show::{figure, um};
use crate::machine::findings::CHECK;
use crate::machine::separation::Separation;
use crate::machine::separation::metric::{Agreement, Metric};
use crate::machine::separation::monte_carlo::Simulated;
use crate::machine::separation::solved::scale_sum_um_mm;
use crate::machine::separation::straight::{ClosureTests, StraightResult};
use crate::machine::standards::Diagonals;
use crate::quantity::{Axis, Figure, Plane, Squared};
use crate::text::{Finding, Severity, joined};

/// What was separated, its diagonals by standard, and what was simulated where that was asked for.
pub(super) type Results<'a> = (&'a Separation, &'a Diagonals, Option<&'a Simulated>);

/// More degrees of freedom than these need no exact number: k is 2.00.
const MANY: f64 = 1000.0;

/// The sentence of contract §1 that stands wherever φ stands.
const SQUARENESS_SIGN: &str = "positive = the angle between the two positive axis directions is less than 90° (ISO 230-1: EC0Y = -xy, EB0Z = +xz, EA0Z = -yz)";

/// Squareness of each plane with its U; `more` = the headings of further columns, and their cells.
pub(super) fn squareness(metric: &Metric, more: &str, cells: impl Fn(Plane) -> String) -> String {
    let rows = Plane::ALL.into_iter().map(|plane| {
        let found = metric.squareness(plane);
        let slope = figure(found.um_per_m, "not determined");
        let (u, freedom) =
            (expanded(found.expanded_um_per_m()), freedom(found.u.map(|u| u.freedom)));
        format!("{}\t{slope}\t{u}\t{freedom}{}", plane.key().to_uppercase(), cells(plane))
    });
    let heading = format!("plane\t>squareness/(µm/m)\t>U(95 %)/(µm/m)\t>degrees of freedom{more}");
    format!("{}\n{SQUARENESS_SIGN}", table(&heading, rows))
}

/// U with its coverage factor; one that is known never reads 0 unless it is.
pub(super) fn expanded(expanded: Option<f64>) -> String {
    match expanded {
        Some(expanded) if expanded > 0.0 && expanded < 0.0005 => "< 0.001".to_string(),
        known => figure(known, "not known"),
    }
}

/// Effective degrees of freedom of a known U; `None` inside = unlimited.
pub(super) fn freedom(known: Option<Option<f64>>) -> String {
    match known {
        None => "-".to_string(),
        Some(None) => "unlimited".to_string(),
        Some(Some(freedom)) if freedom > MANY => format!("> {MANY:.0}"),
        Some(Some(freedom)) => format!("{freedom:.0}"),
    }
}

/// The screen of a result: what speaks against it and what is not determined, with how to determine it,
/// stand first.
pub(super) fn screen(
    doubts: &[Finding],
    determined: String,
    (undetermined, advice): (&[Finding], &[String]),
    figures: String,
    mut more: Vec<More>,
    labels: &[Finding],
) -> Screen {
    let mut open = list("NOT DETERMINED by these readings, and left out:", undetermined);
    for advice in advice.iter().filter(|_| !undetermined.is_empty()) {
        open += &format!("\n      {advice}");
    }
    // What the readings say of themselves never leaves the screen.
    let (said, labels): (Vec<&Finding>, Vec<&Finding>) =
        labels.iter().partition(|label| label.severity() == Severity::Note);
    let heading = "Assumed, and what the uncertainty holds:";
    more.push(More::new(labels.len(), ["label", "labels"], list(heading, &labels)));
    Screen {
        figures,
        always: said.iter().map(|note| format!("note: {note}")).collect(),
        more,
        ..Screen::of(paragraphs(&[
            list("INCONSISTENT, so the answer is no:", doubts),
            determined,
            open,
        ]))
    }
}

const LINEAR: &str =
    "[[measurement.step_diagonal.linear]] with axis, slope_um_per_m (or errors) and u_um_per_m";
const BEAM: &str =
    "[[measurement.step_diagonal.beam]] with from_mm, to_mm, slope_um_per_m and u_um_per_m";

/// Ways to determine the scales that are open (docs/method.md §5); empty where none is.
pub(super) fn advice(metric: &Metric) -> Vec<String> {
    let open = |axis: &Axis| metric.scale(*axis).um_per_m.is_none();
    let (open, known): (Vec<Axis>, Vec<Axis>) = Axis::ALL.into_iter().partition(open);
    match (open.as_slice(), known.as_slice()) {
        ([], _) => Vec::new(),
        ([a, b], [known]) => vec![
            format!("{a} or {b} measured along its length: add {LINEAR}"),
            format!("or a face diagonal of a plane with {known}: add {BEAM}"),
        ],
        _ => vec![
            format!("two axes measured along their length: add two {LINEAR}"),
            format!(
                "or face diagonals of two planes, or one axis and a face diagonal of a plane with it: add {BEAM}"
            ),
        ],
    }
}

/// Linear axes and beams against each other and the diagonals.
pub(super) fn agreement(agreement: &Agreement) -> String {
    let rows = agreement.lines.iter().map(|line| {
        let others = figure(line.by_others_um_per_m, "nothing");
        let by = line.difference_um_per_m.map_or("-".into(), |by| format!("{:+.3}", Figure(by)));
        let (stated, u) = (Figure(line.stated_um_per_m), um(line.u_difference_um_per_m));
        format!("{}\t{stated:.3}\t{others}\t{by}\t{u}", line.name)
    });
    let heading = "line\t>stated/(µm/m)\t>by all others/(µm/m)\t>difference/(µm/m)\t>u(k=1)/(µm/m)";
    let verdict = match agreement.probability {
        Some(p) if agreement.contradiction.is_some() => {
            format!("probability {p:.3}: they DISAGREE; {CHECK}")
        }
        Some(p) => format!("probability {p:.3}: they agree"),
        None => "not judged: the noise of the readings is not known".into(),
    };
    format!(
        "Linear axes and beams against the diagonals\n{}\nchi-squared {:.2}, degrees of freedom {}, {verdict}",
        table(heading, rows),
        agreement.chi_squared,
        agreement.freedom
    )
}

/// What `separate` says of straight runs.
pub(super) fn straight_screen(
    result: &StraightResult,
    figures: &Diagonals,
    open: (&[Finding], &[String]),
) -> Screen {
    let diagonals = figures.as_read(|diagonal| result.end_um[diagonal]);
    screen(
        &result.doubts,
        outcome(result),
        open,
        paragraphs(&[
            straight_squareness(result),
            scales(result),
            result.closure.as_ref().map_or_else(String::new, closure_table),
        ]),
        vec![
            More::part("linear axes and beams", result.agreement.as_ref().map(agreement)),
            More::part("diagonals", diagonals),
        ],
        &result.labels,
    )
}

fn outcome(result: &StraightResult) -> String {
    let known = |axis: &Axis| result.metric.scale(*axis).um_per_m.is_some();
    let scales = match joined(Axis::ALL.into_iter().filter(known)) {
        none if none.is_empty() => "no single scale".to_string(),
        known => format!("scale of {known}"),
    };
    let mut lines = vec![format!(
        "Straight runs along the four body diagonals: squareness XY, XZ, YZ; {scales}; no straightness (that needs single-axis steps)"
    )];
    lines.extend(result.silence.sentences());
    lines.join("\n")
}

fn straight_squareness(result: &StraightResult) -> String {
    let table = squareness(&result.metric, "", |_| String::new());
    format!("{table}; from the totals of the diagonals, so of the lines through the end points")
}

fn scales(result: &StraightResult) -> String {
    let share = |axis| result.volume.cosine(axis).squared();
    let shares = Axis::ALL.map(|axis| format!("{:.3} x slope of E{axis}{axis}", share(axis)));
    let square_m = result.volume.diagonal_mm().squared() / 1000.0;
    let mut lines = vec![format!(
        "One combination of the scales from the diagonals alone: {} = {:.3} µm/m",
        shares.join(" + "),
        Figure(scale_sum_um_mm(&result.volume, &result.end_um) / square_m)
    )];
    for axis in Axis::ALL {
        let found = result.metric.scale(axis);
        if let Some(scale) = found.um_per_m {
            let u = expanded(found.expanded_um_per_m());
            lines.push(format!("slope of E{axis}{axis}: {:.3} µm/m, U(95 %) {u}", Figure(scale)));
        }
    }
    lines.join("\n")
}

fn closure_table(closure: &ClosureTests) -> String {
    let rows = closure.tests.iter().map(|test| {
        let (largest, end) = (Figure(test.largest_um), Figure(test.end_um));
        let (pass, u) = (test.pass.word(), expanded(test.u_end_um.map(|u| 2.0 * u)));
        let ratio = test.worst_ratio.map_or_else(|| "-".to_string(), |ratio| format!("{ratio:.1}"));
        format!("{}\t{pass}\t{largest:.3}\t{end:+.3}\t{u}\t{ratio}", test.diagonal)
    });
    let heading = "diagonal\truns\t>largest/µm\t>far end/µm\t>U(k=2) there/µm\t>largest by its u";
    format!(
        "Closure test: measured less what the nine errors of `closure_errors` predict, each run from its own start\n{}\n{}",
        table(heading, rows),
        verdict(closure)
    )
}

fn verdict(closure: &ClosureTests) -> String {
    let of_table = if closure.table_states_u {
        "noise of the readings and the table's u"
    } else {
        "noise of the readings only: the table states no u"
    };
    match closure.agrees {
        None => "no verdict: the noise of the readings is not known (repeat the runs, or state `noise_um`)".to_string(),
        Some(true) => format!("in keeping: no difference is beyond {:.1} u ({of_table})", closure.k),
        Some(false) => format!("NOT in keeping: a difference is beyond {:.1} u ({of_table})", closure.k),
    }
}
