//! The variables that a compensation file may write: their names, indices and allowed values.
//!
//! Function Manual Extended Functions 03/2013, K3 p. 237-249 and 268.

use super::contents::MachineValue;
use super::statement::{Assignment, Value};
use crate::control::table::siemens::Place;
use crate::read::lexer::Complaint;
use crate::text::nearest;

/// Largest table or point number that is read at all.
const LARGEST_INDEX: u32 = 99_999;

/// What one index names.
#[derive(Clone, Copy)]
enum Index {
    Encoder,
    Table,
    Point,
    Axis,
}
use Index::{Axis, Encoder, Point, Table};

/// What a variable may be set to.
#[derive(Clone, Copy)]
enum Allowed {
    /// A number, TRUE, FALSE or a name.
    Any,
    Number,
    /// A whole number in a range, in words.
    Whole(i32, i32, &'static str),
    /// 0 or FALSE, 1 or TRUE.
    Truth,
    AxisName,
}
use Allowed::{Any, AxisName, Number, Truth, Whole};

/// Index + 1 of a table, or 0; the limit is far above the 62 tables of an 840D sl.
const TABLE_NUMBER: Allowed = Whole(0, 1000, "0 or the number of a table (its index + 1)");
/// A number of an NCU, no truth: 1, as a real control writes beside the axes of a table, or 0 where nobody
/// filled it. Others link axes of several NCUs.
const OWN_NCU: Allowed = Whole(0, 1, "0 or 1");
const TYPE: Allowed = Whole(0, 0, "0, or remove the line: its meaning is not documented");

/// Every variable that a compensation file may write. `$MA_`, `$MN_`, `$SN_` are closed too: a
/// mistyped name stops a control just as an unknown one does. Without an index: one value for the control.
const VARIABLES: [(&str, &[Index], Allowed); 31] = [
    ("AA_ENC_COMP", &[Encoder, Point, Axis], Number),
    ("AA_ENC_COMP_STEP", &[Encoder, Axis], Number),
    ("AA_ENC_COMP_MIN", &[Encoder, Axis], Number),
    ("AA_ENC_COMP_MAX", &[Encoder, Axis], Number),
    ("AA_ENC_COMP_IS_MODULO", &[Encoder, Axis], Truth),
    ("AN_CEC", &[Table, Point], Number),
    ("AN_CEC_INPUT_AXIS", &[Table], AxisName),
    ("AN_CEC_OUTPUT_AXIS", &[Table], AxisName),
    ("AN_CEC_STEP", &[Table], Number),
    ("AN_CEC_MIN", &[Table], Number),
    ("AN_CEC_MAX", &[Table], Number),
    ("AN_CEC_DIRECTION", &[Table], Whole(-1, 1, "-1, 0 or 1")),
    ("AN_CEC_MULT_BY_TABLE", &[Table], TABLE_NUMBER),
    ("AN_CEC_IS_MODULO", &[Table], Truth),
    ("AN_CEC_TYPE", &[Table], TYPE),
    ("AN_CEC_INPUT_NCU", &[Table], OWN_NCU),
    ("AN_CEC_OUTPUT_NCU", &[Table], OWN_NCU),
    ("MA_ENC_COMP_ENABLE", &[Encoder, Axis], Any),
    ("MA_MM_ENC_COMP_MAX_POINTS", &[Encoder, Axis], Any),
    ("MA_BACKLASH", &[Encoder, Axis], Number),
    ("MA_CEC_ENABLE", &[Axis], Any),
    ("MA_CEC_MAX_SUM", &[Axis], Number),
    ("MA_CEC_MAX_VELO", &[Axis], Number),
    ("MA_CEC_SCALING_SYSTEM_METRIC", &[Axis], Truth),
    ("MA_ENC_REFP_MODE", &[Encoder, Axis], Number),
    ("MA_REFP_SET_POS", &[Encoder, Axis], Number),
    ("MN_CONVERT_SCALING_SYSTEM", &[], Truth),
    ("MN_MM_CEC_MAX_POINTS", &[Table], Any),
    ("MN_SCALING_SYSTEM_IS_METRIC", &[], Truth),
    ("SN_CEC_TABLE_ENABLE", &[Table], Any),
    ("SN_CEC_TABLE_WEIGHT", &[Table], Number),
];

/// Whether a name is that of a point or parameter of a table; known or not.
pub(super) fn is_of_table(name: &str) -> bool {
    name.starts_with("AA_ENC_COMP") || name.starts_with("AN_CEC")
}

/// The machine and setting data that are read beside tables, where a control wrote all it has.
pub(super) fn data() -> impl Iterator<Item = &'static str> {
    let names = VARIABLES.iter().map(|(name, _, _)| *name);
    names.filter(|name| !is_of_table(name) && *name != "MA_CEC_MAX_VELO")
}

/// What an assignment sets.
#[derive(Clone, Copy)]
pub(super) struct Variable {
    /// Name without `$`, upper case.
    name: &'static str,
    allowed: Allowed,
}

/// A parameter of a table, or a point of it, which has a number and no name.
pub(super) type Cell = (&'static str, u32);

/// The variable of an assignment; a complaint if it is unknown or the indices do not fit it.
pub(super) fn variable(set: &Assignment<'_>) -> Result<Variable, Complaint> {
    let known = VARIABLES.iter().find(|(name, _, _)| *name == set.name);
    let Some((name, indices, allowed)) = known else {
        return Err(unknown(set));
    };
    let mut pairs = indices.iter().zip(&set.indices);
    if indices.len() == set.indices.len() && pairs.all(|(index, text)| index.takes(text)) {
        return Ok(Variable { name, allowed: *allowed });
    }
    let example = |index: &Index| match index {
        Encoder | Table => "0",
        Point => "5",
        Axis => "AX1",
    };
    let example: Vec<&str> = indices.iter().map(example).collect();
    Err(Complaint::new(
        set.head.clone(),
        format!("`[{}]` is not an index of `${name}`", set.indices.join(",")),
        format!("write it like `[{}]`; measuring systems are 0 and 1", example.join(",")),
    ))
}

impl Index {
    fn takes(self, text: &str) -> bool {
        let is_up_to = |largest: u32| text.parse().is_ok_and(|number: u32| number <= largest);
        match self {
            Encoder => is_up_to(1),
            Table | Point => is_up_to(LARGEST_INDEX),
            Axis => text.starts_with(|c: char| c.is_ascii_alphabetic()),
        }
    }
}

impl Variable {
    /// The table that it belongs to, and what of it; `None` of machine data.
    pub(super) fn cell(self, set: &Assignment<'_>) -> Option<(Place, Cell)> {
        let number = |at: usize| set.indices.get(at)?.parse().ok();
        let (first, point) = (number(0).unwrap_or(0), number(1).unwrap_or(0));
        if let Some(parameter) = self.name.strip_prefix("AA_ENC_COMP") {
            let axis = set.indices.last()?.to_string();
            return Some((Place::Lec { axis, encoder: first }, (parameter, point)));
        }
        Some((Place::Cec(first), (self.name.strip_prefix("AN_CEC")?, point)))
    }

    /// The value that is assigned, if the variable may have it; truths as numbers.
    pub(super) fn value(self, set: &Assignment<'_>) -> Result<MachineValue, Complaint> {
        let value = set.value.clone()?;
        let number = match value {
            Value::Number(number) => Some(number),
            Value::Truth(_) | Value::Name(_) => None,
        };
        let is_whole = |least: i32, most: i32| {
            let is = |whole: i32| number.is_some_and(|own| (own - f64::from(whole)).abs() <= 0.0);
            (least..=most).any(is)
        };
        let (takes_it, words) = match self.allowed {
            Any => (true, ""),
            Number => (number.is_some(), "a number"),
            Whole(least, most, words) => (is_whole(least, most), words),
            Truth => (matches!(value, Value::Truth(_)) || is_whole(0, 1), "0 or 1"),
            AxisName => (matches!(value, Value::Name(_)), "an axis name such as `(AX1)`"),
        };
        if !takes_it {
            let message = format!("`${}` cannot have this value", self.name);
            return Err(Complaint::new(set.value_span.clone(), message, format!("write {words}")));
        }
        Ok(match value {
            Value::Number(number) => MachineValue::Number(number),
            Value::Truth(truth) => MachineValue::Number(f64::from(u8::from(truth))),
            Value::Name(name) => MachineValue::Text(name),
        })
    }
}

fn unknown(set: &Assignment<'_>) -> Complaint {
    let known = VARIABLES.iter().map(|(name, _, _)| *name);
    let help = match nearest(&set.name, known) {
        Some(known) => format!("did you mean `${known}`?"),
        None => "only variables of ENC_COMP and CEC and their machine data are read".to_string(),
    };
    let message = format!("unknown variable `${}`", set.name);
    Complaint::new(set.head.clone(), message, help)
}
