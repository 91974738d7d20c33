//! How tables that were read back differ from what the job asks for, in words.
//!
//! Both sides are emulated; where they differ, the difference is compared with the mistakes that
//! happen: turned sign, shifted reference, wrong unit, missing points, wrong axis.

use crate::axis::{Direction, ErrorTerm};
use crate::emulate::{Emulator, NodeTable, Response};
use crate::forecast::axis_pairs;
use crate::plan::Plan;
use crate::units::{Correction, Millimetres};

/// Two corrections closer than this are equal, µm (a picometre).
const EQUAL_UM: f64 = 1e-6;

/// All disagreements, one sentence each; empty if the tables do what the job asks for.
pub fn compare(plan: &Plan, expected: &dyn Emulator, found: &dyn Emulator) -> Vec<String> {
    let mut sentences = Vec::new();
    let mut known = Vec::new();
    for term in ErrorTerm::ALL {
        for (base, output) in axis_pairs(plan, term) {
            for direction in Direction::BOTH {
                let label = label(term, base, output, direction);
                // An axis that the job does not have; tables for it are foreign.
                let Ok(wanted) = expected.response(base, output, direction) else {
                    continue;
                };
                known.push((base.to_string(), output.to_string()));
                match found.response(base, output, direction) {
                    Ok(got) => {
                        sentences.extend(difference(&wanted, &got).map(|words| (label, words)));
                    }
                    Err(problem) => sentences.push((label, problem.0)),
                }
            }
        }
    }
    let mut words = join_directions(sentences);
    for (base, output) in found.connected_axes() {
        let is_known = known
            .iter()
            .any(|(b, o)| b.eq_ignore_ascii_case(&base) && o.eq_ignore_ascii_case(&output));
        if !is_known {
            words.push(format!("foreign axis: the tables correct {output} while {base} moves, which the job does not ask for"));
        }
    }
    words
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
fn difference(wanted: &Response, got: &Response) -> Option<String> {
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
        return Some("applied twice: every correction is double".to_string());
    }
    if all(&|_| 0.0) {
        return Some("all corrections are zero".to_string());
    }
    scale(&pairs)
        .or_else(|| shifted(wanted, got))
        .or_else(|| lifted(&pairs))
        .or_else(|| points(wanted, got))
        .or_else(|| largest(&places, &pairs))
}

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
    None
}

fn shifted(wanted: &Response, got: &Response) -> Option<String> {
    let ([w], [g]) = (wanted.tables(), got.tables()) else {
        return None;
    };
    let shift = g.first().mm() - w.first().mm();
    let same_values = same_values(w, g);
    (same_values && shift.abs() > EQUAL_UM).then(|| {
        format!("shifted reference: the table stands {shift:.4} mm from where the job puts it ({:.4} instead of {:.4} mm)", g.first().mm(), w.first().mm())
    })
}

fn same_values(a: &NodeTable, b: &NodeTable) -> bool {
    let values = |t: &NodeTable| -> Vec<Correction> { t.nodes().map(|(_, c)| c).collect() };
    let (a, b) = (values(a), values(b));
    a.len() == b.len()
        && a.iter()
            .zip(&b)
            .all(|(a, b)| (a.um() - b.um()).abs() <= EQUAL_UM)
}

fn lifted(pairs: &[(f64, f64)]) -> Option<String> {
    let (w, g) = pairs.first()?;
    let lift = g - w;
    pairs
        .iter()
        .all(|(w, g)| (g - w - lift).abs() <= EQUAL_UM)
        .then(|| format!("not zero at the reference: every correction is off by {lift:.3} µm"))
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
            g.first().mm(),
            g.last().mm(),
            w.first().mm(),
            w.last().mm()
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
    Some(format!(
        "other values: {wrong} places differ, most at {:.4} mm, where the tables correct {g:.3} µm and the job asks for {w:.3} µm",
        at.mm()
    ))
}
