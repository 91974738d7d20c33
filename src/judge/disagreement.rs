//! How tables that were read back differ from what the job asks for, in words.
//!
//! Both sides are emulated; where they differ, the difference is compared with the mistakes that
//! happen: turned sign, shifted reference, other spacing, wrong scale, missing points, foreign
//! axis.

mod contents;
mod diagnosis;
pub(super) mod entries;

pub(crate) use self::contents::surroundings;
pub use self::contents::{absent, contents, measuring_systems};
pub use self::diagnosis::Disagreements;

use self::diagnosis::holds;

use crate::judge::findings::Difference;
use crate::quantity::axis::{Axis, Direction, ErrorTerm, Rotation};
use crate::quantity::units::{AT_PLACE_MM, Correction, Figure, Millimetres};
use crate::read::emulate::{Emulator, NodeTable, Response};
use crate::write::plan::{Plan, axis_pairs};

/// Two corrections closer than this are equal, µm (a picometre).
const EQUAL_UM: f64 = 1e-6;

/// All disagreements; none if the tables do what the job asks for.
pub fn compare(plan: &Plan, expected: &dyn Emulator, found: &dyn Emulator) -> Disagreements {
    let mut diagnosis = Disagreements::default();
    let mut known = Vec::new();
    let all = responses(plan, expected);
    for (term, base, output, ways) in &all {
        known.push(((*base).to_string(), (*output).to_string()));
        let mut said: Vec<(Direction, String)> = Vec::new();
        for (direction, wanted) in ways {
            let words = match found.response(base, output, *direction) {
                Ok(got) => Pair::of(wanted, &got).difference(|pair| pair.foreign(&all, *term)),
                Err(problem) => Some(problem.0),
            };
            said.extend(words.map(|words| (*direction, words)));
        }
        let alike = matches!(said.as_slice(), [(_, plus), (_, minus)] if plus == minus);
        let count = if alike { 1 } else { said.len() };
        for (way, how) in said.into_iter().take(count) {
            let effect = Difference::Effect {
                term: *term,
                base: (*base).to_string(),
                output: (*output).to_string(),
                direction: (!alike).then_some(way),
                how,
            };
            diagnosis.tell(effect, base, output);
        }
    }
    let connected = found.connected_axes().into_iter();
    for (base, output) in connected.filter(|(base, output)| !holds(&known, base, output)) {
        let (moving, corrected) = (base.clone(), output.clone());
        let foreign = Difference::ForeignAxis { base, output };
        diagnosis.tell(foreign, &moving, &corrected);
    }
    for (what, how) in angles(plan, expected, found) {
        let values = Difference::OtherValues { table: what, values: vec![how] };
        diagnosis.tell(values, "", "");
    }
    diagnosis
}

/// What differs in the angles of two controls, which the lines of measurement need not show.
fn angles(plan: &Plan, expected: &dyn Emulator, found: &dyn Emulator) -> Vec<(String, String)> {
    let one = |rotation: Rotation| {
        let base = plan.names[rotation.along].first()?;
        let of = |control: &dyn Emulator| control.rotation(base, rotation.about);
        let how = match (of(expected), of(found)) {
            (None, None) => None,
            (Some(_), None) => Some("missing".to_string()),
            (None, Some(_)) => Some("the job does not write it".to_string()),
            (Some(wanted), Some(got)) => Pair::of(&wanted, &got).difference(|_| None),
        };
        Some((rotation.to_string(), how?))
    };
    let mut all: Vec<(String, String)> = Rotation::all().filter_map(one).collect();
    let orders =
        [expected, found].map(|control| control.levers().map(|order| Axis::letters(&order)));
    if let [Some(wanted), Some(got)] = &orders
        && wanted != got
    {
        let how = format!("{got}, the job has {wanted}: the angles act at other levers");
        all.push(("chain".to_string(), how));
    }
    all
}

/// What the job asks for of a term and a pair of moving and corrected axis, in each direction.
type Asked<'a> = (ErrorTerm, &'a str, &'a str, Vec<(Direction, Response)>);

/// What the job asks for; an axis that it does not have has no response, and tables for it are foreign.
fn responses<'a>(plan: &'a Plan, expected: &dyn Emulator) -> Vec<Asked<'a>> {
    let mut all = Vec::new();
    for term in ErrorTerm::ALL {
        for (base, output) in axis_pairs(&plan.names, term) {
            let of = |way| Some((way, expected.response(base, output, way).ok()?));
            let ways: Vec<_> = Direction::BOTH.into_iter().filter_map(of).collect();
            if !ways.is_empty() {
                all.push((term, base, output, ways));
            }
        }
    }
    all
}

/// What is asked for and what was found for a pair of axes in one direction, at every node of both,
/// each place once, and at the machine's zero.
struct Pair<'a> {
    wanted: &'a Response,
    got: &'a Response,
    places: Vec<Millimetres>,
    /// Asked for and found there, µm.
    um: Vec<(f64, f64)>,
}

/// Factors that come from a wrong unit.
const UNIT_SLIPS: [(f64, &str); 4] = [
    (1000.0, "1000 times too large (µm taken for mm?)"),
    (0.001, "1000 times too small (mm taken for µm?)"),
    (25.4, "25.4 times too large (inch taken for mm?)"),
    (1.0 / 25.4, "25.4 times too small (mm taken for inch?)"),
];

/// What was done to every correction, if it is a rule by itself.
const RULES: [(f64, &str); 3] = [
    (-1.0, "wrong sign: every correction is turned round, the error would double"),
    (2.0, "wrong scale: every correction is double (applied twice, or twice the magnification?)"),
    (0.0, "all corrections are zero"),
];

impl<'a> Pair<'a> {
    fn of(wanted: &'a Response, got: &'a Response) -> Pair<'a> {
        let tables = wanted.tables().iter().chain(got.tables());
        let mut places: Vec<Millimetres> =
            tables.flat_map(|table| table.nodes().map(|(at, _)| at)).collect();
        places.push(Millimetres::new(0.0));
        places.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
        places.dedup_by(|a, b| (a.mm() - b.mm()).abs() <= AT_PLACE_MM);
        let at = |at: &Millimetres| (wanted.correction(*at).um(), got.correction(*at).um());
        Pair { um: places.iter().map(at).collect(), wanted, got, places }
    }

    /// What is wrong with it, if anything.
    fn difference(&self, foreign: impl Fn(&Pair<'_>) -> Option<String>) -> Option<String> {
        let close = |a: f64, b: f64| (a - b).abs() <= EQUAL_UM.max(1e-9 * b.abs());
        let all = |factor: f64| self.um.iter().all(|(w, g)| close(*g, factor * w));
        let (none_wanted, none_got) =
            (self.wanted.tables().is_empty(), self.got.tables().is_empty());
        if all(1.0) {
            return None;
        }
        if none_got && !none_wanted {
            return Some("missing: the tables hold nothing for it".to_string());
        }
        if none_wanted {
            return Some("the tables correct it, the job does not ask for it".to_string());
        }
        let rule = RULES.into_iter().find(|(factor, _)| all(*factor));
        rule.map(|(_, words)| words.to_string())
            .or_else(|| self.scale())
            .or_else(|| foreign(self))
            .or_else(|| self.table())
            .or_else(|| self.largest())
    }

    fn scale(&self) -> Option<String> {
        let by_size = |a: &&(f64, f64), b: &&(f64, f64)| a.0.abs().total_cmp(&b.0.abs());
        let (w, g) = self.um.iter().max_by(by_size)?;
        for (factor, words) in UNIT_SLIPS {
            for (sign, turned) in [(1.0, ""), (-1.0, ", and the sign is turned")] {
                // A scaled table was rounded once more, so a hundredth of its size is allowed.
                let off = |(a, b): &(f64, f64)| (b - sign * factor * a).abs();
                if self.um.iter().all(|pair| off(pair) <= 0.01 * factor * w.abs()) {
                    return Some(format!("wrong scale: the corrections are {words}{turned}"));
                }
            }
        }
        let factor = g / w;
        let fits = |(w, g): &(f64, f64)| (g - factor * w).abs() <= EQUAL_UM;
        // One value that differs is a value, not a scale.
        let enough = self.um.iter().filter(|(w, _)| w.abs() > EQUAL_UM).count() > 1;
        (enough && self.um.iter().all(fits)).then(|| {
            format!(
                "wrong scale: every correction is {:.3} times what the job asks for",
                Figure(factor)
            )
        })
    }

    /// Whether the corrections of another term stand here, instead of the own ones or beside them.
    fn foreign(&self, all: &[Asked<'_>], term: ErrorTerm) -> Option<String> {
        let others = all.iter().filter(|(other, ..)| *other != term);
        let others =
            others.flat_map(|(other, .., ways)| ways.iter().map(move |way| (other, &way.1)));
        others.into_iter().find_map(|(other, response)| {
            let values = self.places.iter().map(|at| response.correction(*at).um());
            let values: Vec<f64> = values.collect();
            let is = |found: fn(&(f64, f64)) -> f64| {
                let mut pairs = self.um.iter().zip(&values);
                pairs.all(|(pair, value)| (found(pair) - value).abs() <= EQUAL_UM)
            };
            let words = if is(|(_, got)| *got) {
                format!("foreign axis: these are the corrections of {other}")
            } else if is(|(wanted, got)| got - wanted) {
                format!("foreign axis: the corrections of {other} are added to its own")
            } else {
                return None;
            };
            has_a_shape(values).then_some(words)
        })
    }

    /// What differs between one table and one table: where it stands, its zero, its points.
    fn table(&self) -> Option<String> {
        let lifted = || {
            let (w, g) = self.um.first()?;
            let lift = g - w;
            let is_lifted = |(w, g): &(f64, f64)| (g - w - lift).abs() <= EQUAL_UM;
            self.um.iter().all(is_lifted).then(|| {
                let lift = Figure(lift);
                format!("not zero at the reference: every correction is off by {lift:.3} µm")
            })
        };
        let ([w], [g]) = (self.wanted.tables(), self.got.tables()) else {
            return lifted();
        };
        moved(w, g).or_else(lifted).or_else(|| points(w, g)).or_else(|| stepped(w, g))
    }

    fn largest(&self) -> Option<String> {
        let off = |(w, g): &(f64, f64)| (g - w).abs();
        let wrong = self.um.iter().filter(|pair| off(pair) > EQUAL_UM).count();
        let places = self.places.iter().zip(&self.um);
        let (at, (w, g)) = places.max_by(|a, b| off(a.1).total_cmp(&off(b.1)))?;
        let (at, tables, job) = (Figure(at.mm()), micrometres(*g), micrometres(*w));
        let amounts =
            format!("at {at:.4} mm, where the tables correct {tables} and the job asks for {job}");
        Some(match wrong {
            1 => format!("another value {amounts}"),
            n => format!("other values: {n} places differ, most {amounts}"),
        })
    }
}

/// Whether a correction takes enough different values to be told from a single changed point.
fn has_a_shape(mut values: Vec<f64>) -> bool {
    const ENOUGH_VALUES: usize = 4; // one changed increment makes two values, two make three
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() <= EQUAL_UM);
    values.len() >= ENOUGH_VALUES
}

/// The same values but for a constant (increments that are counted from another point give another
/// zero), at points of another spacing or at another place.
fn moved(w: &NodeTable, g: &NodeTable) -> Option<String> {
    let values = |t: &NodeTable| -> Vec<f64> { t.nodes().map(|(_, c)| c.um()).collect() };
    let (asked, found) = (values(w), values(g));
    let mut lifts = asked.iter().zip(&found).map(|(a, b)| b - a);
    let first = lifts.next().unwrap_or(0.0);
    if asked.len() != found.len() || !lifts.all(|lift| (lift - first).abs() <= EQUAL_UM) {
        return None;
    }
    let (asked, found) = (spacing(w)?, spacing(g)?);
    let shift = g.first().mm() - w.first().mm();
    if (found - asked).abs() > AT_PLACE_MM {
        return Some(format!(
            "other spacing: the points are {found:.4} mm apart, the job asks for {asked:.4} mm"
        ));
    }
    (shift.abs() > AT_PLACE_MM).then(|| {
        let [shift, found, asked] = [shift, g.first().mm(), w.first().mm()].map(Figure);
        format!("shifted reference: the table stands {shift:.4} mm from where the job puts it ({found:.4} instead of {asked:.4} mm)")
    })
}

/// Distance of the nodes of a table, mm; 0 where it has but one.
fn spacing(table: &NodeTable) -> Option<f64> {
    let mut nodes = table.nodes();
    let first = nodes.next()?.0;
    Some(nodes.next().map_or(0.0, |second| (second.0 - first).mm()))
}

fn points(w: &NodeTable, g: &NodeTable) -> Option<String> {
    let (expected, found) = (w.nodes().count(), g.nodes().count());
    (expected != found).then(|| {
        let word = if found < expected { "missing points" } else { "more points" };
        let [from, to, first, last] = [g.first(), g.last(), w.first(), w.last()].map(|at| Figure(at.mm()));
        format!("{word}: {found} points from {from:.4} to {to:.4} mm, expected {expected} from {first:.4} to {last:.4} mm")
    })
}

/// One changed step: on one side of it all is as asked, beyond it all is off by the same amount.
/// So it is with one changed increment.
fn stepped(w: &NodeTable, g: &NodeTable) -> Option<String> {
    let asked: Vec<(Millimetres, Correction)> = w.nodes().collect();
    let there: Vec<(Millimetres, Correction)> = g.nodes().collect();
    let pairs = || asked.iter().zip(&there);
    if asked.len() != there.len() || !pairs().all(|(a, b)| (a.0 - b.0).mm().abs() <= AT_PLACE_MM) {
        return None;
    }
    let off: Vec<f64> = pairs().map(|((_, w), (_, g))| g.um() - w.um()).collect();
    let differs = |pair: &[f64]| (pair[1] - pair[0]).abs() > EQUAL_UM;
    let mut changed = (0..off.len().saturating_sub(1)).filter(|k| differs(&off[*k..*k + 2]));
    let (step, None) = (changed.next()?, changed.next()) else {
        return None;
    };
    let (lower, upper) = (Figure(asked[step].0.mm()), Figure(asked[step + 1].0.mm()));
    let below = off[step].abs() <= EQUAL_UM;
    let above = off[step + 1].abs() <= EQUAL_UM;
    let (side, by, places) = match (below, above) {
        (true, false) => (format!("from {upper:.4} mm on"), off[step + 1], off.len() - step - 1),
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

fn micrometres(um: f64) -> String {
    format!("{:.3} µm", Figure(um))
}
