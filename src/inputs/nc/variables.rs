//! The variables of a program: `#1`, `#<name>`, `R1`. One that was not set has no value: never 0.

use std::collections::BTreeMap;
use std::fmt;

/// Variables from this number on belong to the control (tool data, positions, signals).
const FIRST_OF_CONTROL: u32 = 1000;
/// Variables up to this number belong to one call of an `O… sub`.
const LAST_LOCAL: u32 = 30;

/// A variable as it is written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Name {
    /// `#1`.
    Number(u32),
    /// `#<name>`, in small letters; `_name` is the same one in all subprograms.
    Named(String),
    /// `R1` of Siemens.
    R(u32),
}

impl Name {
    fn is_local(&self) -> bool {
        match self {
            Name::Number(number) => *number <= LAST_LOCAL,
            Name::Named(name) => !name.starts_with('_'),
            Name::R(_) => false,
        }
    }

    /// Whether it is one of the control's own, whose value no program tells.
    pub(super) fn is_of_control(&self) -> bool {
        matches!(self, Name::Number(number) if *number >= FIRST_OF_CONTROL || *number == 0)
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Name::Number(number) => write!(f, "#{number}"),
            Name::Named(name) => write!(f, "#<{name}>"),
            Name::R(number) => write!(f, "R{number}"),
        }
    }
}

/// The values that a program has set.
#[derive(Clone, Debug, Default)]
pub(super) struct Variables {
    values: BTreeMap<Name, f64>,
    /// Local values of those that called, the last one last.
    callers: Vec<BTreeMap<Name, f64>>,
}

impl Variables {
    pub(super) fn get(&self, name: &Name) -> Option<f64> {
        self.values.get(name).copied()
    }

    pub(super) fn set(&mut self, name: Name, value: f64) {
        self.values.insert(name, value);
    }

    /// A subprogram begins: it sees its arguments as `#1`, `#2` …, and no other local variable.
    pub(super) fn enter(&mut self, arguments: &[f64]) {
        let all = std::mem::take(&mut self.values);
        let (local, common) = all.into_iter().partition(|(name, _)| name.is_local());
        self.callers.push(local);
        self.values = common;
        for (number, value) in (1..).zip(arguments) {
            self.set(Name::Number(number), *value);
        }
    }

    /// What a subprogram returns is `#<_value>`; without it, that has no value.
    pub(super) fn answer(&mut self, value: Option<f64>) {
        let name = Name::Named("_value".to_string());
        match value {
            Some(value) => self.set(name, value),
            None => drop(self.values.remove(&name)),
        }
    }

    /// It returns.
    pub(super) fn leave(&mut self) {
        self.values.retain(|name, _| !name.is_local());
        self.values.extend(self.callers.pop().unwrap_or_default());
    }
}
