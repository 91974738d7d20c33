//! What both pages of `separate` show: numbers, what is open and how to determine it, linear axes and
//! beams against the diagonals.

use crate::cli::screen::{More, Screen, list, paragraphs, table};
use crate::cli::show::figure;
use crate::machine::findings::CHECK;
use crate::machine::separation::Separation;
use crate::machine::separation::metric::Agreement;
use crate::machine::separation::metric::Metric;
use crate::machine::separation::monte_carlo::Simulated;
use crate::machine::standards::Diagonals;
use crate::quantity::{Axis, Figure, Plane};
use crate::text::{Finding, Severity};

/// What was separated, its diagonals by standard, and what was simulated where that was asked for.
pub(super) type Found<'a> = (&'a Separation, &'a Diagonals, Option<&'a Simulated>);

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
        verdict: paragraphs(&[
            list("INCONSISTENT, so the answer is no:", doubts),
            determined,
            open,
        ]),
        figures,
        always: said.iter().map(|note| format!("note: {note}")).collect(),
        more,
        ..Screen::default()
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
pub(super) fn agreement(agreement: Option<&Agreement>) -> String {
    let Some(agreement) = agreement else {
        return String::new();
    };
    let rows = agreement.lines.iter().map(|line| {
        let found = line.others.zip(line.difference());
        let others = found.map_or("nothing\t-\t-".to_string(), |(others, (by, _))| {
            let [found, by, u] =
                [others.found_um_per_m, by, others.u_difference_um_per_m].map(Figure);
            format!("{found:.3}\t{by:+.3}\t{u:.3}")
        });
        format!("{}\t{:.3}\t{others}", line.name(), Figure(line.stated_um_per_m))
    });
    let heading = "line\t>stated/(µm/m)\t>by all others/(µm/m)\t>difference/(µm/m)\t>u(k=1)/(µm/m)";
    let verdict = match agreement.probability {
        Some(p) if agreement.is_refuted() => {
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
