//! How tables that were read back differ from what the job asks for, in words.
//!
//! Both sides are emulated; where they differ, the difference is compared with the mistakes that
//! happen: turned sign, shifted reference, other spacing, wrong scale, missing points, foreign
//! axis.

pub mod contents;

use crate::judge::field::Field;
use crate::judge::findings::Difference;
use crate::quantity::{
    AT_PLACE_MM, Axis, Direction, ErrorTerm, Figure, MM_PER_INCH, Millimetres, Rotation, rounded,
};
use crate::read::emulate::{Emulator, NodeTable, Response};
use crate::text::Finding;
use crate::write::plan::Plan;
use std::collections::BTreeMap;

/// Two corrections closer than this are equal, µm (a picometre).
const EQUAL_UM: f64 = 1e-6;

/// All disagreements; none if the tables do what the job asks for.
pub fn compare(plan: &Plan, expected: &dyn Emulator, found: &dyn Emulator) -> Disagreements {
    let mut diagnosis = Disagreements::default();
    // An axis that the job does not have has no response, and tables for it are foreign.
    let asked = Field::of(&plan.names, expected, |_| false).unwrap_or_default();
    for (term, pair) in asked.pairs() {
        let (base, output) = (&pair.base, &pair.output);
        let [plus, minus] = Direction::BOTH.map(|way| match found.response(base, output, way) {
            Ok(got) => Compared::of(pair.way(way), &got).difference(&others(&asked, term)),
            Err(problem) => Some(problem.0),
        });
        let said = match plus == minus {
            true => [(None, plus), (None, None)],
            false => [(Some(Direction::Plus), plus), (Some(Direction::Minus), minus)],
        };
        for (direction, how) in said {
            let Some(how) = how else { continue };
            let (base, output) = (base.clone(), output.clone());
            let effect = Difference::Effect { term, base, output, direction, how };
            diagnosis.tell(effect, &pair.base, &pair.output);
        }
    }
    let known: Vec<_> =
        asked.pairs().map(|(_, own)| (own.base.clone(), own.output.clone())).collect();
    let connected = found.connected_axes().into_iter();
    for (base, output) in connected.filter(|(base, output)| !holds(&known, base, output)) {
        let axes = (base.clone(), output.clone());
        diagnosis.tell(Difference::ForeignAxis { base, output }, &axes.0, &axes.1);
    }
    for (table, how) in angles(plan, expected, found) {
        diagnosis.tell(Difference::OtherValues { table, values: vec![how] }, "", "");
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
            (Some(wanted), Some(got)) => Compared::of(&wanted, &got).difference(&[]),
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

/// What the job asks for of the other terms.
fn others(asked: &Field, term: ErrorTerm) -> Vec<(ErrorTerm, &Response)> {
    let others = asked.pairs().filter(|(other, _)| *other != term);
    others.flat_map(|(other, pair)| Direction::BOTH.map(|way| (other, pair.way(way)))).collect()
}

/// What may have been done to every correction, if it is a rule by itself: its factor and words.
const RULES: [(f64, &str); 3] = [
    (-1.0, "wrong sign: every correction is turned round, the error would double"),
    (2.0, "wrong scale: every correction is double (applied twice, or twice the magnification?)"),
    (0.0, "all corrections are zero"),
];

/// Factors that come from a wrong unit.
const UNITS: [(f64, &str); 4] = [
    (1000.0, "1000 times too large (µm taken for mm?)"),
    (0.001, "1000 times too small (mm taken for µm?)"),
    (MM_PER_INCH, "25.4 times too large (inch taken for mm?)"),
    (1.0 / MM_PER_INCH, "25.4 times too small (mm taken for inch?)"),
];

/// What is asked for and what was found for a pair of axes in one direction, at every node of both,
/// each place once, and at the machine's zero.
struct Compared<'a> {
    wanted: &'a Response,
    got: &'a Response,
    places: Vec<Millimetres>,
    /// Asked for there, µm.
    asked_um: Vec<f64>,
    /// Found there, µm.
    found_um: Vec<f64>,
}

impl<'a> Compared<'a> {
    fn of(wanted: &'a Response, got: &'a Response) -> Compared<'a> {
        let tables = wanted.tables().iter().chain(got.tables());
        let mut places: Vec<Millimetres> =
            tables.flat_map(|table| table.nodes().map(|(at, _)| at)).collect();
        places.push(Millimetres::new(0.0));
        places.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
        places.dedup_by(|a, b| (a.mm() - b.mm()).abs() <= AT_PLACE_MM);
        let [asked_um, found_um] = [wanted, got].map(|of| corrections(of, &places));
        Compared { wanted, got, places, asked_um, found_um }
    }

    /// What is wrong with it, if anything: the first of the usual mistakes that explains every value.
    fn difference(&self, others: &[(ErrorTerm, &Response)]) -> Option<String> {
        let are = |factor: f64, off: f64| self.are(off, |w| factor * w);
        if are(1.0, EQUAL_UM) {
            return None;
        }
        if self.wanted.tables().is_empty() {
            return Some("the tables correct it, the job does not ask for it".to_string());
        }
        if self.got.tables().is_empty() {
            return Some("missing: the tables hold nothing for it".to_string());
        }
        let sizes = self.asked_um.iter().zip(&self.found_um);
        let (w, g) = sizes.max_by(|(a, _), (b, _)| a.abs().total_cmp(&b.abs()))?;
        if let Some((_, words)) = RULES.into_iter().find(|(factor, _)| are(*factor, EQUAL_UM)) {
            return Some(words.to_string());
        }
        for (factor, words) in UNITS {
            // A scaled table was rounded once more, so a hundredth of its size is allowed.
            let off = 0.01 * factor * w.abs();
            for (sign, turned) in [(1.0, ""), (-1.0, ", and the sign is turned")] {
                if are(sign * factor, off) {
                    return Some(format!("wrong scale: the corrections are {words}{turned}"));
                }
            }
        }
        // One value that differs is a value, not a scale.
        let enough = self.asked_um.iter().filter(|w| w.abs() > EQUAL_UM).count() > 1;
        if enough && are(g / w, EQUAL_UM) {
            let factor = Figure(g / w);
            return Some(format!(
                "wrong scale: every correction is {factor:.3} times what the job asks for"
            ));
        }
        self.foreign(others).or_else(|| self.table()).or_else(|| self.largest())
    }

    /// Whether everything found is what this makes of what was asked for, but for so much, µm.
    fn are(&self, off_um: f64, made: impl Fn(f64) -> f64) -> bool {
        let made = self.asked_um.iter().map(|w| made(*w));
        made.zip(&self.found_um).all(|(made, g)| (g - made).abs() <= off_um.max(1e-9 * made.abs()))
    }

    /// Whether the corrections of another term stand here, instead of the own ones or beside them.
    fn foreign(&self, others: &[(ErrorTerm, &Response)]) -> Option<String> {
        others.iter().find_map(|(other, response)| {
            let values = corrections(response, &self.places);
            let mut all = self.asked_um.iter().zip(&self.found_um).zip(&values);
            let words = if all.clone().all(|((_, g), um)| (g - um).abs() <= EQUAL_UM) {
                format!("foreign axis: these are the corrections of {other}")
            } else if all.all(|((w, g), um)| (g - w - um).abs() <= EQUAL_UM) {
                format!("foreign axis: the corrections of {other} are added to its own")
            } else {
                return None;
            };
            has_a_shape(values).then_some(words)
        })
    }

    /// What differs between one table and one table: where it stands, its zero, its points.
    fn table(&self) -> Option<String> {
        let lift = self.found_um.first()? - self.asked_um.first()?;
        let lifted = || {
            self.are(EQUAL_UM, |w| w + lift).then(|| {
                let lift = Figure(lift);
                format!("not zero at the reference: every correction is off by {lift:.3} µm")
            })
        };
        let ([w], [g]) = (self.wanted.tables(), self.got.tables()) else { return lifted() };
        let nodes = |table: &NodeTable| table.nodes().map(|(at, um)| (at.mm(), um.um())).collect();
        let (w, g): (Vec<Node>, Vec<Node>) = (nodes(w), nodes(g));
        moved(&w, &g).or_else(lifted).or_else(|| points(&w, &g)).or_else(|| stepped(&w, &g))
    }

    fn largest(&self) -> Option<String> {
        let off = |index: &usize| (self.found_um[*index] - self.asked_um[*index]).abs();
        let wrong = (0..self.places.len()).filter(|index| off(index) > EQUAL_UM).count();
        let most = (0..self.places.len()).max_by(|a, b| off(a).total_cmp(&off(b)))?;
        let at = Figure(self.places[most].mm());
        let [tables, job] = [&self.found_um, &self.asked_um].map(|um| micrometres(um[most]));
        let amounts =
            format!("at {at:.4} mm, where the tables correct {tables} and the job asks for {job}");
        Some(match wrong {
            1 => format!("another value {amounts}"),
            n => format!("other values: {n} places differ, most {amounts}"),
        })
    }
}

/// Straight from node to node: a node of one table may lie on the same tread of another that steps elsewhere.
fn corrections(response: &Response, places: &[Millimetres]) -> Vec<f64> {
    let lines = response.straightened();
    places.iter().map(|at| lines.correction(*at).um()).collect()
}

/// Whether a correction takes enough different values to be told from a single changed point.
fn has_a_shape(mut values: Vec<f64>) -> bool {
    const ENOUGH_VALUES: usize = 4; // one changed increment makes two values, two make three
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() <= EQUAL_UM);
    values.len() >= ENOUGH_VALUES
}

/// Place and correction of a point of a table, mm and µm.
type Node = (f64, f64);

/// The same values but for a constant (increments that are counted from another point give another
/// zero), at points of another spacing or at another place.
fn moved(w: &[Node], g: &[Node]) -> Option<String> {
    let ([first, second, ..], [at, next, ..]) = (w, g) else { return None };
    let is_lifted = |(w, g): (&Node, &Node)| (g.1 - w.1 - (at.1 - first.1)).abs() <= EQUAL_UM;
    if w.len() != g.len() || !w.iter().zip(g).all(is_lifted) {
        return None;
    }
    let (asked, found, shift) = (second.0 - first.0, next.0 - at.0, at.0 - first.0);
    if (found - asked).abs() > AT_PLACE_MM {
        return Some(format!(
            "other spacing: the points are {found:.4} mm apart, the job asks for {asked:.4} mm"
        ));
    }
    (shift.abs() > AT_PLACE_MM).then(|| {
        let [shift, found, asked] = [shift, at.0, first.0].map(Figure);
        format!("shifted reference: the table stands {shift:.4} mm from where the job puts it ({found:.4} instead of {asked:.4} mm)")
    })
}

fn points(w: &[Node], g: &[Node]) -> Option<String> {
    let (expected, found) = (w.len(), g.len());
    (expected != found).then(|| {
        let word = if found < expected { "missing points" } else { "more points" };
        let [from, to, first, last] = [&g[0], &g[found - 1], &w[0], &w[expected - 1]].map(|node| Figure(node.0));
        format!("{word}: {found} points from {from:.4} to {to:.4} mm, expected {expected} from {first:.4} to {last:.4} mm")
    })
}

/// One changed step: on one side of it all is as asked, beyond it all is off by the same amount.
/// So it is with one changed increment.
fn stepped(w: &[Node], g: &[Node]) -> Option<String> {
    let is_there = |(w, g): (&Node, &Node)| (w.0 - g.0).abs() <= AT_PLACE_MM;
    if w.len() != g.len() || !w.iter().zip(g).all(is_there) {
        return None;
    }
    let off: Vec<f64> = w.iter().zip(g).map(|(w, g)| g.1 - w.1).collect();
    let is_changed = |upper: &usize| (off[*upper] - off[upper - 1]).abs() > EQUAL_UM;
    let mut changed = (1..off.len()).filter(is_changed);
    let (Some(upper), None) = (changed.next(), changed.next()) else { return None };
    let (from, to) = (Figure(w[upper - 1].0), Figure(w[upper].0));
    let [below, above] = [off[upper - 1], off[upper]];
    let (side, by, places) = match [below, above].map(|um| um.abs() <= EQUAL_UM) {
        [true, false] => (format!("from {to:.4} mm on"), above, off.len() - upper),
        [false, true] => (format!("up to {from:.4} mm"), below, upper),
        _ => return None,
    };
    let [tables, job] = [g, w].map(|of| micrometres(of[upper].1 - of[upper - 1].1));
    let by = micrometres(by);
    (places > 1).then(|| {
        format!("one step is changed: from {from:.4} to {to:.4} mm the correction changes by {tables}, the job asks for {job}; so every correction {side} is off by {by}")
    })
}

fn micrometres(um: f64) -> String {
    format!("{:.3} µm", Figure(um))
}

// What tables hold, entry by entry: each family lists its own, and the lists are compared alike.

/// A number of a table, or a parameter by its name.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Item {
    Name(String),
    Point(u32),
}

/// What stands there.
pub(crate) enum Value {
    Numbers(Vec<Option<f64>>),
    Text(String),
}

impl Value {
    /// Whether both are the same.
    pub(super) fn is(&self, other: &Value) -> bool {
        /// Numbers of files closer than this are equal, in their own unit.
        const EQUAL: f64 = 1e-9;
        let same = |(a, b): (&Option<f64>, &Option<f64>)| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() <= EQUAL,
            (a, b) => a.is_none() == b.is_none(),
        };
        match (self, other) {
            (Value::Numbers(a), Value::Numbers(b)) => a.iter().zip(b).all(same),
            (Value::Text(a), Value::Text(b)) => a == b,
            _ => false,
        }
    }

    /// Rounded, so that numbers that are equal read alike.
    pub(crate) fn words(&self) -> String {
        let number = |value: &Option<f64>| match value {
            Some(value) => rounded(*value, 9).to_string(),
            None => "none".to_string(),
        };
        match self {
            Value::Numbers(values) => values.iter().map(number).collect::<Vec<_>>().join(", "),
            Value::Text(text) => text.clone(),
        }
    }
}

/// An entry of a list of what tables hold.
pub(crate) struct Entry {
    pub(crate) value: Value,
    /// Whether it is told where the other side does not have it, and where the two differ.
    pub(crate) alone: bool,
    pub(crate) differing: bool,
}

/// What tables hold, by table (empty = the whole memory) and item.
pub(crate) type Entries = BTreeMap<(String, Item), Entry>;

// What the emulation of two sets of tables tells of them.

/// What emulation tells of two sets of tables.
#[derive(Clone, Debug, Default)]
pub struct Disagreements {
    /// One for each disagreement.
    pub findings: Vec<Finding>,
    /// The pairs of moving and corrected axis that they are about.
    pub pairs: Vec<(String, String)>,
}

impl Disagreements {
    /// Whether a finding is about these axes.
    pub(crate) fn explains(&self, base: &str, output: &str) -> bool {
        holds(&self.pairs, base, output)
    }

    pub(super) fn tell(&mut self, found: Difference, base: &str, output: &str) {
        self.findings.push(found.into());
        self.pairs.push((base.to_string(), output.to_string()));
    }
}

/// Whether a pair of axes is among these, in capitals or not.
pub(super) fn holds(pairs: &[(String, String)], base: &str, output: &str) -> bool {
    let is =
        |(b, o): &(String, String)| b.eq_ignore_ascii_case(base) && o.eq_ignore_ascii_case(output);
    pairs.iter().any(is)
}
