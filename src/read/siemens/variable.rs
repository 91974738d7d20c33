//! The variables that a compensation file may write: their names, indices and allowed values.
//!
//! Function Manual Extended Functions 03/2013, K3 p. 237-249 and 268.

use crate::control::table::siemens::CecDirection;
use crate::read::lexer::Complaint;
use crate::read::siemens::assignment::{Assignment, Value, is_digits};
use crate::text::problem::nearest;

/// Largest table or point number that is read at all.
const LARGEST_INDEX: u32 = 99_999;

/// What stands between `[` and `]`.
#[derive(Clone, Copy)]
enum Shape {
    EncoderPointAxis,
    EncoderAxis,
    Axis,
    TablePoint,
    Table,
    /// No index: one value for the control.
    Alone,
}

impl Shape {
    const fn example(self) -> &'static str {
        match self {
            Shape::EncoderPointAxis => "[0,5,AX1]",
            Shape::EncoderAxis => "[0,AX1]",
            Shape::Axis => "[AX1]",
            Shape::TablePoint => "[0,5]",
            Shape::Table => "[0]",
            Shape::Alone => "",
        }
    }
}

/// Every variable that a compensation file may write. `$MA_`, `$MN_`, `$SN_` are closed too: a
/// mistyped name stops a control just as an unknown one does.
const VARIABLES: [(&str, Shape); 31] = [
    ("AA_ENC_COMP", Shape::EncoderPointAxis),
    ("AA_ENC_COMP_STEP", Shape::EncoderAxis),
    ("AA_ENC_COMP_MIN", Shape::EncoderAxis),
    ("AA_ENC_COMP_MAX", Shape::EncoderAxis),
    ("AA_ENC_COMP_IS_MODULO", Shape::EncoderAxis),
    ("AN_CEC", Shape::TablePoint),
    ("AN_CEC_INPUT_AXIS", Shape::Table),
    ("AN_CEC_OUTPUT_AXIS", Shape::Table),
    ("AN_CEC_STEP", Shape::Table),
    ("AN_CEC_MIN", Shape::Table),
    ("AN_CEC_MAX", Shape::Table),
    ("AN_CEC_DIRECTION", Shape::Table),
    ("AN_CEC_MULT_BY_TABLE", Shape::Table),
    ("AN_CEC_IS_MODULO", Shape::Table),
    ("AN_CEC_TYPE", Shape::Table),
    ("AN_CEC_INPUT_NCU", Shape::Table),
    ("AN_CEC_OUTPUT_NCU", Shape::Table),
    ("MA_ENC_COMP_ENABLE", Shape::EncoderAxis),
    ("MA_MM_ENC_COMP_MAX_POINTS", Shape::EncoderAxis),
    ("MA_BACKLASH", Shape::EncoderAxis),
    ("MA_CEC_ENABLE", Shape::Axis),
    ("MA_CEC_MAX_SUM", Shape::Axis),
    ("MA_CEC_MAX_VELO", Shape::Axis),
    ("MA_CEC_SCALING_SYSTEM_METRIC", Shape::Axis),
    ("MA_ENC_REFP_MODE", Shape::EncoderAxis),
    ("MA_REFP_SET_POS", Shape::EncoderAxis),
    ("MN_CONVERT_SCALING_SYSTEM", Shape::Alone),
    ("MN_MM_CEC_MAX_POINTS", Shape::Table),
    ("MN_SCALING_SYSTEM_IS_METRIC", Shape::Alone),
    ("SN_CEC_TABLE_ENABLE", Shape::Table),
    ("SN_CEC_TABLE_WEIGHT", Shape::Table),
];

/// Machine data that are 0 or 1 (TRUE, FALSE) and nothing else.
const TRUTHS: [&str; 3] = [
    "MA_CEC_SCALING_SYSTEM_METRIC",
    "MN_CONVERT_SCALING_SYSTEM",
    "MN_SCALING_SYSTEM_IS_METRIC",
];

/// Machine and setting data that are numbers, and neither TRUE nor an axis.
const NUMBERS: [&str; 6] = [
    "MA_BACKLASH",
    "MA_ENC_REFP_MODE",
    "MA_CEC_MAX_SUM",
    "MA_CEC_MAX_VELO",
    "MA_REFP_SET_POS",
    "SN_CEC_TABLE_WEIGHT",
];

/// Whether a variable has no index; only machine data of the whole control have none.
pub(super) fn is_alone(name: &str) -> bool {
    if !name.starts_with("MN_") {
        return false; // of thousands of points, without a look at the list
    }
    let alone = |(known, shape): &(&str, Shape)| *known == name && matches!(shape, Shape::Alone);
    VARIABLES.iter().any(alone)
}

/// Whether a machine datum can only be 0 or 1.
pub(super) fn is_truth(name: &str) -> bool {
    TRUTHS.contains(&name)
}

/// Whether a machine or setting datum can only be a number.
pub(super) fn is_number(name: &str) -> bool {
    NUMBERS.contains(&name)
}

/// The indices, told apart.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Key<'a> {
    /// Measuring system, 0 or 1.
    pub(super) encoder: u32,
    /// CEC table.
    pub(super) table: u32,
    /// Point of the table.
    pub(super) point: u32,
    /// Axis.
    pub(super) axis: &'a str,
}

/// The indices of an assignment; a complaint if the variable is unknown or they do not fit it.
pub(super) fn key<'a>(set: &'a Assignment<'_>) -> Result<Key<'a>, Complaint> {
    let Some((_, shape)) = VARIABLES.iter().find(|(name, _)| *name == set.name) else {
        return Err(unknown_variable(set));
    };
    let mut key = Key::default();
    let fits = match (shape, set.indices.as_slice()) {
        (Shape::EncoderPointAxis, [encoder, point, axis]) => {
            put(&mut key.encoder, encoder, 1)
                && put(&mut key.point, point, LARGEST_INDEX)
                && put_axis(&mut key.axis, axis)
        }
        (Shape::EncoderAxis, [encoder, axis]) => {
            put(&mut key.encoder, encoder, 1) && put_axis(&mut key.axis, axis)
        }
        (Shape::Axis, [axis]) => put_axis(&mut key.axis, axis),
        (Shape::TablePoint, [table, point]) => {
            put(&mut key.table, table, LARGEST_INDEX) && put(&mut key.point, point, LARGEST_INDEX)
        }
        (Shape::Table, [table]) => put(&mut key.table, table, LARGEST_INDEX),
        (Shape::Alone, []) => true,
        _ => false,
    };
    if fits {
        return Ok(key);
    }
    Err(Complaint::new(
        set.head.clone(),
        format!(
            "`[{}]` is not an index of `${}`",
            set.indices.join(","),
            set.name
        ),
        format!(
            "write it like `{}`; measuring systems are 0 and 1",
            shape.example()
        ),
    ))
}

fn put(place: &mut u32, index: &str, largest: u32) -> bool {
    let number = index.parse().ok().filter(|number| *number <= largest);
    *place = number.unwrap_or_default();
    number.is_some() && is_digits(index)
}

fn put_axis<'a>(place: &mut &'a str, index: &'a str) -> bool {
    *place = index;
    index.starts_with(|c: char| c.is_ascii_alphabetic())
}

fn unknown_variable(set: &Assignment<'_>) -> Complaint {
    let known = VARIABLES.iter().map(|(name, _)| *name);
    let help = match nearest(&set.name, known) {
        Some(known) => format!("did you mean `${known}`?"),
        None => "only variables of ENC_COMP and CEC and their machine data are read".to_string(),
    };
    let message = format!("unknown variable `${}`", set.name);
    Complaint::new(set.head.clone(), message, help)
}

/// The number assigned.
pub(super) fn number_of(set: &Assignment<'_>) -> Result<f64, Complaint> {
    match &set.value {
        Ok(Value::Number(number)) => Ok(*number),
        Ok(_) => Err(not_allowed(set, "a number")),
        Err(complaint) => Err(complaint.clone()),
    }
}

/// The axis assigned, upper case.
pub(super) fn axis(set: &Assignment<'_>) -> Result<String, Complaint> {
    match set.value.clone()? {
        Value::Name(name) => Ok(name),
        _ => Err(not_allowed(set, "an axis name such as `(AX1)`")),
    }
}

/// The whole number `set` assigns, if it is one of `0..=largest` or −1.
fn whole(set: &Assignment<'_>, allowed: &str, largest: i32) -> Result<i32, Complaint> {
    let number = number_of(set)?;
    (-1..=largest)
        .find(|whole| (number - f64::from(*whole)).abs() <= 0.0)
        .ok_or_else(|| not_allowed(set, allowed))
}

/// 0 or 1, FALSE or TRUE.
pub(super) fn truth(set: &Assignment<'_>) -> Result<bool, Complaint> {
    const ALLOWED: &str = "0 or 1";
    if let Value::Truth(truth) = set.value.clone()? {
        return Ok(truth);
    }
    match whole(set, ALLOWED, 1)? {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(not_allowed(set, ALLOWED)),
    }
}

/// `DIRECTION`: −1, 0 or 1.
pub(super) fn direction(set: &Assignment<'_>) -> Result<CecDirection, Complaint> {
    match whole(set, "-1, 0 or 1", 1)? {
        0 => Ok(CecDirection::Both),
        1 => Ok(CecDirection::Plus),
        _ => Ok(CecDirection::Minus),
    }
}

/// `MULT_BY_TABLE`: index + 1 of a table, or 0.
pub(super) fn table_number(set: &Assignment<'_>) -> Result<u32, Complaint> {
    const ALLOWED: &str = "0 or the number of a table (its index + 1)";
    const LARGEST_NUMBER: i32 = 1000; // far above the 62 tables of an 840D sl
    let number = whole(set, ALLOWED, LARGEST_NUMBER)?;
    u32::try_from(number).map_err(|_| not_allowed(set, ALLOWED))
}

/// Refuses every value but 0, where the effect of others is not documented.
pub(super) fn only_zero(set: &Assignment<'_>, why: &str) -> Result<(), Complaint> {
    if number_of(set)?.abs() > 0.0 {
        let mut complaint = not_allowed(set, "0");
        complaint.help = format!("remove the line or write 0: {why}");
        return Err(complaint);
    }
    Ok(())
}

/// `INPUT_NCU`, `OUTPUT_NCU`: 1, as a real control writes beside the axes of a table, or 0 where
/// nobody filled it. Others link axes of several NCUs.
pub(super) fn own_ncu(set: &Assignment<'_>) -> Result<(), Complaint> {
    const ALLOWED: &str = "0 or 1";
    match whole(set, ALLOWED, 1)? {
        0 | 1 => Ok(()),
        _ => Err(not_allowed(set, ALLOWED)),
    }
}

fn not_allowed(set: &Assignment<'_>, expected: &str) -> Complaint {
    Complaint::new(
        set.value_span.clone(),
        format!("`${}` cannot have this value", set.name),
        format!("write {expected}"),
    )
}
