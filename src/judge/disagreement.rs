//! How tables that were read back differ from what the job asks for, in words.
//!
//! Both sides are emulated; where they differ, the difference is compared with the mistakes that
//! happen: turned sign, shifted reference, other spacing, wrong scale, missing points, foreign
//! axis.

mod contents;
mod surroundings;

pub use contents::{absent, contents};
pub use surroundings::surroundings;

use crate::control::table::Tables;
use crate::control::table::siemens::LecTable;
use crate::quantity::axis::{Direction, ErrorTerm};
use crate::quantity::units::{Correction, Figure, Millimetres};
use crate::read::emulate::{Emulator, NodeTable, Response};
use crate::write::plan::{Plan, axis_pairs};

/// Two corrections closer than this are equal, µm (a picometre).
const EQUAL_UM: f64 = 1e-6;

/// Two places closer than this are one, mm.
const EQUAL_MM: f64 = 1e-6;

/// What emulation tells of two sets of tables.
#[derive(Clone, Debug, Default)]
pub struct Diagnosis {
    /// One sentence for each disagreement.
    pub words: Vec<String>,
    /// The pairs of moving and corrected axis that the sentences are about.
    pub pairs: Vec<(String, String)>,
}

impl Diagnosis {
    /// Whether a sentence is about these axes.
    pub(crate) fn explains(&self, base: &str, output: &str) -> bool {
        self.pairs
            .iter()
            .any(|(b, o)| b.eq_ignore_ascii_case(base) && o.eq_ignore_ascii_case(output))
    }
}

/// All disagreements, one sentence each; none if the tables do what the job asks for.
pub fn compare(plan: &Plan, expected: &dyn Emulator, found: &dyn Emulator) -> Diagnosis {
    let mut sentences = Vec::new();
    let mut known = Vec::new();
    let all = responses(plan, expected);
    for term in ErrorTerm::ALL {
        for (base, output) in axis_pairs(&plan.names, term) {
            for direction in Direction::BOTH {
                let label = label(term, base, output, direction);
                // An axis that the job does not have; tables for it are foreign.
                let Ok(wanted) = expected.response(base, output, direction) else {
                    continue;
                };
                known.push((base.to_string(), output.to_string()));
                match found.response(base, output, direction) {
                    Ok(got) => {
                        let words =
                            difference(&wanted, &got, || foreign(&all, term, &wanted, &got));
                        sentences.extend(words.map(|words| (label, words)));
                    }
                    Err(problem) => sentences.push((label, problem.0)),
                }
            }
        }
    }
    let mut pairs: Vec<(String, String)> = sentences
        .iter()
        .map(|(label, _)| (label.base.clone(), label.output.clone()))
        .collect();
    let mut words = join_directions(sentences);
    for (base, output) in found.connected_axes() {
        let is_known = known
            .iter()
            .any(|(b, o)| b.eq_ignore_ascii_case(&base) && o.eq_ignore_ascii_case(&output));
        if !is_known {
            words.push(format!("foreign axis: the tables correct {output} while {base} moves, which the job does not ask for"));
            pairs.push((base, output));
        }
    }
    Diagnosis { words, pairs }
}

/// ENC_COMP tables of another measuring system than the job states: emulated alike, but without
/// effect on the control.
pub(crate) fn measuring_systems(wanted: &Tables, found: &Tables) -> Vec<String> {
    let (Tables::Siemens(wanted), Tables::Siemens(found)) = (wanted, found) else {
        return Vec::new();
    };
    let of_axis = |axis: &str| {
        wanted
            .lec
            .iter()
            .find(|t| t.axis.eq_ignore_ascii_case(axis))
    };
    let sentence = |table: &LecTable| {
        let stated = of_axis(&table.axis)?.encoder;
        (table.encoder != stated).then(|| {
            format!(
                "foreign measuring system: the ENC_COMP table of {} is for system {}, the job is for {}",
                table.axis,
                table.encoder + 1,
                stated + 1
            )
        })
    };
    found.lec.iter().filter_map(sentence).collect()
}

/// What the job asks for, term by term.
fn responses(plan: &Plan, expected: &dyn Emulator) -> Vec<(ErrorTerm, Response)> {
    let mut all = Vec::new();
    for term in ErrorTerm::ALL {
        for (base, output) in axis_pairs(&plan.names, term) {
            for direction in Direction::BOTH {
                let response = expected.response(base, output, direction);
                all.extend(response.ok().map(|response| (term, response)));
            }
        }
    }
    all
}

/// What a sentence is about.
#[derive(Clone, PartialEq)]
struct Label {
    term: ErrorTerm,
    base: String,
    output: String,
    direction: Direction,
}

fn label(term: ErrorTerm, base: &str, output: &str, direction: Direction) -> Label {
    Label {
        term,
        base: base.to_string(),
        output: output.to_string(),
        direction,
    }
}

/// One sentence where both directions say the same.
fn join_directions(sentences: Vec<(Label, String)>) -> Vec<String> {
    let mut joined: Vec<(Label, bool, String)> = Vec::new();
    for (label, words) in sentences {
        let twin = joined.iter_mut().find(|(other, _, same)| {
            other.term == label.term && other.output == label.output && *same == words
        });
        match twin {
            Some((_, both, _)) => *both = true,
            None => joined.push((label, false, words)),
        }
    }
    joined
        .into_iter()
        .map(|(label, both, words)| {
            let travel = if both {
                String::new()
            } else {
                format!(" in {}", label.direction)
            };
            format!(
                "{} ({} while {} moves{travel}): {words}",
                label.term, label.output, label.base
            )
        })
        .collect()
}

/// What is wrong with one response, if anything.
fn difference(
    wanted: &Response,
    got: &Response,
    foreign: impl Fn() -> Option<String>,
) -> Option<String> {
    let places = places(wanted, got);
    let pairs: Vec<(f64, f64)> = places
        .iter()
        .map(|at| (wanted.correction(*at).um(), got.correction(*at).um()))
        .collect();
    let tolerance = EQUAL_UM;
    let close = |a: f64, b: f64| (a - b).abs() <= tolerance.max(1e-9 * b.abs());
    if pairs.iter().all(|(w, g)| close(*g, *w)) {
        return None;
    }
    let all = |rule: &dyn Fn(f64) -> f64| pairs.iter().all(|(w, g)| close(*g, rule(*w)));
    if got.tables().is_empty() && !wanted.tables().is_empty() {
        return Some("missing: the tables hold nothing for it".to_string());
    }
    if wanted.tables().is_empty() {
        return Some("the tables correct it, the job does not ask for it".to_string());
    }
    if all(&|w| -w) {
        return Some(
            "wrong sign: every correction is turned round, the error would double".to_string(),
        );
    }
    if all(&|w| 2.0 * w) {
        return Some(
            "wrong scale: every correction is double (applied twice, or twice the magnification?)"
                .to_string(),
        );
    }
    if all(&|_| 0.0) {
        return Some("all corrections are zero".to_string());
    }
    scale(&pairs)
        .or_else(foreign)
        .or_else(|| spaced(wanted, got))
        .or_else(|| shifted(wanted, got))
        .or_else(|| lifted(&pairs))
        .or_else(|| points(wanted, got))
        .or_else(|| stepped(wanted, got))
        .or_else(|| largest(&places, &pairs))
}

/// Every node of both, each place once, and the machine's zero.
fn places(wanted: &Response, got: &Response) -> Vec<Millimetres> {
    let nodes = |r: &Response| -> Vec<Millimetres> {
        r.tables()
            .iter()
            .flat_map(|table| table.nodes().map(|(at, _)| at).collect::<Vec<_>>())
            .collect()
    };
    let mut places = nodes(wanted);
    places.extend(nodes(got));
    places.push(Millimetres::new(0.0));
    places.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
    places.dedup_by(|a, b| (a.mm() - b.mm()).abs() <= EQUAL_MM);
    places
}

/// Factors that come from a wrong unit.
const UNIT_SLIPS: [(f64, &str); 4] = [
    (1000.0, "1000 times too large (µm taken for mm?)"),
    (0.001, "1000 times too small (mm taken for µm?)"),
    (25.4, "25.4 times too large (inch taken for mm?)"),
    (1.0 / 25.4, "25.4 times too small (mm taken for inch?)"),
];

fn scale(pairs: &[(f64, f64)]) -> Option<String> {
    let largest = pairs.iter().map(|(w, _)| w.abs()).fold(0.0, f64::max);
    for (factor, words) in UNIT_SLIPS {
        for sign in [1.0, -1.0] {
            // A scaled table was rounded once more, so a hundredth of its size is allowed.
            let fits =
                |(w, g): &(f64, f64)| (g - sign * factor * w).abs() <= 0.01 * factor * largest;
            if pairs.iter().all(fits) {
                let turned = if sign < 0.0 {
                    ", and the sign is turned"
                } else {
                    ""
                };
                return Some(format!("wrong scale: the corrections are {words}{turned}"));
            }
        }
    }
    let (w, g) = pairs
        .iter()
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    let factor = g / w;
    let fits = |(w, g): &(f64, f64)| (g - factor * w).abs() <= EQUAL_UM;
    // One value that differs is a value, not a scale.
    let enough = pairs.iter().filter(|(w, _)| w.abs() > EQUAL_UM).count() > 1;
    (enough && pairs.iter().all(fits)).then(|| {
        format!(
            "wrong scale: every correction is {:.3} times what the job asks for",
            Figure(factor)
        )
    })
}

/// Whether the corrections of another term stand here, instead of the own ones or beside them.
fn foreign(
    all: &[(ErrorTerm, Response)],
    term: ErrorTerm,
    wanted: &Response,
    got: &Response,
) -> Option<String> {
    let places = places(wanted, got);
    let equals = |other: &Response, rest: &dyn Fn(Millimetres) -> f64| {
        let differs = |at: &Millimetres| (rest(*at) - other.correction(*at).um()).abs() > EQUAL_UM;
        !places.iter().any(differs) && has_a_shape(other, &places)
    };
    let whole = |at: Millimetres| got.correction(at).um();
    let surplus = |at: Millimetres| got.correction(at).um() - wanted.correction(at).um();
    all.iter()
        .filter(|(other, _)| *other != term)
        .find_map(|(other, response)| {
            if equals(response, &whole) {
                Some(format!(
                    "foreign axis: these are the corrections of {other}"
                ))
            } else if equals(response, &surplus) {
                Some(format!(
                    "foreign axis: the corrections of {other} are added to its own"
                ))
            } else {
                None
            }
        })
}

/// Whether a correction takes enough different values to be told from a single changed point.
fn has_a_shape(response: &Response, places: &[Millimetres]) -> bool {
    const ENOUGH_VALUES: usize = 4; // one changed increment makes two values, two make three
    let mut values: Vec<f64> = places
        .iter()
        .map(|at| response.correction(*at).um())
        .collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() <= EQUAL_UM);
    values.len() >= ENOUGH_VALUES
}

/// Distance of the nodes of a table, mm.
fn spacing(table: &NodeTable) -> Option<f64> {
    let mut nodes = table.nodes();
    let (first, second) = (nodes.next()?.0, nodes.next()?.0);
    Some(second.mm() - first.mm())
}

fn spaced(wanted: &Response, got: &Response) -> Option<String> {
    let ([w], [g]) = (wanted.tables(), got.tables()) else {
        return None;
    };
    let (expected, found) = (spacing(w)?, spacing(g)?);
    let differs = (found - expected).abs() > EQUAL_MM;
    (differs && is_lifted_copy(w, g)).then(|| {
        format!(
            "other spacing: the points are {found:.4} mm apart, the job asks for {expected:.4} mm"
        )
    })
}

fn shifted(wanted: &Response, got: &Response) -> Option<String> {
    let ([w], [g]) = (wanted.tables(), got.tables()) else {
        return None;
    };
    let shift = g.first().mm() - w.first().mm();
    (is_lifted_copy(w, g) && shift.abs() > EQUAL_MM).then(|| {
        format!("shifted reference: the table stands {:.4} mm from where the job puts it ({:.4} instead of {:.4} mm)", Figure(shift), Figure(g.first().mm()), Figure(w.first().mm()))
    })
}

/// Whether two tables hold the same values but for a constant: increments that are counted from
/// another point give another zero.
fn is_lifted_copy(a: &NodeTable, b: &NodeTable) -> bool {
    let values = |t: &NodeTable| -> Vec<Correction> { t.nodes().map(|(_, c)| c).collect() };
    let (a, b) = (values(a), values(b));
    let lift = |(a, b): (&Correction, &Correction)| b.um() - a.um();
    let mut lifts = a.iter().zip(&b).map(lift);
    let first = lifts.next().unwrap_or(0.0);
    a.len() == b.len() && lifts.all(|lift| (lift - first).abs() <= EQUAL_UM)
}

fn lifted(pairs: &[(f64, f64)]) -> Option<String> {
    let (w, g) = pairs.first()?;
    let lift = g - w;
    pairs
        .iter()
        .all(|(w, g)| (g - w - lift).abs() <= EQUAL_UM)
        .then(|| {
            format!(
                "not zero at the reference: every correction is off by {:.3} µm",
                Figure(lift)
            )
        })
}

fn points(wanted: &Response, got: &Response) -> Option<String> {
    let ([w], [g]) = (wanted.tables(), got.tables()) else {
        return None;
    };
    let (expected, found) = (w.nodes().count(), g.nodes().count());
    (expected != found).then(|| {
        let word = if found < expected { "missing points" } else { "more points" };
        format!(
            "{word}: {found} points from {:.4} to {:.4} mm, expected {expected} from {:.4} to {:.4} mm",
            Figure(g.first().mm()),
            Figure(g.last().mm()),
            Figure(w.first().mm()),
            Figure(w.last().mm())
        )
    })
}

/// One changed step: on one side of it all is as asked, beyond it all is off by the same amount.
/// So it is with one changed increment.
fn stepped(wanted: &Response, got: &Response) -> Option<String> {
    let ([w], [g]) = (wanted.tables(), got.tables()) else {
        return None;
    };
    let asked: Vec<(Millimetres, Correction)> = w.nodes().collect();
    let there: Vec<(Millimetres, Correction)> = g.nodes().collect();
    let same_place = |((a, _), (b, _)): (&(Millimetres, _), &(Millimetres, _))| {
        (a.mm() - b.mm()).abs() <= EQUAL_MM
    };
    if asked.len() != there.len() || !asked.iter().zip(&there).all(same_place) {
        return None;
    }
    let off: Vec<f64> = asked
        .iter()
        .zip(&there)
        .map(|((_, w), (_, g))| g.um() - w.um())
        .collect();
    let differs = |pair: &[f64]| (pair[1] - pair[0]).abs() > EQUAL_UM;
    let mut changed = (0..off.len().saturating_sub(1)).filter(|k| differs(&off[*k..*k + 2]));
    let (step, None) = (changed.next()?, changed.next()) else {
        return None;
    };
    let (lower, upper) = (Figure(asked[step].0.mm()), Figure(asked[step + 1].0.mm()));
    let below = off[step].abs() <= EQUAL_UM;
    let above = off[step + 1].abs() <= EQUAL_UM;
    let (side, by, places) = match (below, above) {
        (true, false) => (
            format!("from {upper:.4} mm on"),
            off[step + 1],
            off.len() - step - 1,
        ),
        (false, true) => (format!("up to {lower:.4} mm"), off[step], step + 1),
        _ => return None,
    };
    let change = |nodes: &[(Millimetres, Correction)]| {
        micrometres(nodes[step + 1].1.um() - nodes[step].1.um())
    };
    (places > 1).then(|| {
        format!(
            "one step is changed: from {lower:.4} to {upper:.4} mm the correction changes by {}, the job asks for {}; so every correction {side} is off by {}",
            change(&there),
            change(&asked),
            micrometres(by)
        )
    })
}

fn largest(places: &[Millimetres], pairs: &[(f64, f64)]) -> Option<String> {
    let wrong = pairs
        .iter()
        .filter(|(w, g)| (g - w).abs() > EQUAL_UM)
        .count();
    let (at, (w, g)) = places
        .iter()
        .zip(pairs)
        .max_by(|a, b| (a.1.1 - a.1.0).abs().total_cmp(&(b.1.1 - b.1.0).abs()))?;
    let (at, tables, job) = (Figure(at.mm()), micrometres(*g), micrometres(*w));
    let amounts =
        format!("at {at:.4} mm, where the tables correct {tables} and the job asks for {job}");
    Some(match wrong {
        1 => format!("another value {amounts}"),
        n => format!("other values: {n} places differ, most {amounts}"),
    })
}

fn micrometres(um: f64) -> String {
    format!("{:.3} µm", Figure(um))
}
