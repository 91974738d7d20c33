//! The variables of a program by their names as written: `#1`, `#<name>`, `R1`. One that was not set has no value: never 0.

use std::collections::BTreeMap;

/// Variables from this number on belong to the control (tool data, positions, signals).
const FIRST_OF_CONTROL: u32 = 1000;

/// The values that a program has set.
pub(crate) type Variables = BTreeMap<String, f64>;

/// Whether a variable is one of the control's own, whose value no program tells.
pub(crate) fn is_of_control(name: &str) -> bool {
    let number = name.strip_prefix('#').and_then(|number| number.parse().ok());
    number.is_some_and(|number: u32| number >= FIRST_OF_CONTROL || number == 0)
}
