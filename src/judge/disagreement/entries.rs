//! What tables hold, entry by entry: each family lists its own, and the lists are compared alike.

use crate::judge::findings::Difference;
use crate::quantity::rounded;
use crate::text::Finding;
use std::collections::BTreeMap;

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

impl Entry {
    pub(crate) const fn of(value: Value, alone: bool, differing: bool) -> Entry {
        Entry { value, alone, differing }
    }
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
