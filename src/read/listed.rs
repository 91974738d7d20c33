//! What a control adds to an axis whose tables list their points one by one.
//!
//! ```text
//!   value → error or correction at each point (amount, position − point, sum of increments, zero at the
//!   reference) → straight lines between, outside held
//! ```
//! A factor stands for a line. It counts from the reference: what is added there is a shift of all positions, which no
//! error against the reference sees.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{Form, Outside, PointLists, ValueForm};
use crate::control::table::{ListedTable, ListedTables, Point};
use crate::quantity::{Correction, Direction, Figure, Millimetres, UM_PER_MM, power_of_ten};
use crate::read::emulate::{CannotEmulate, Emulated, Emulator, Response};

/// A control that holds these tables.
///
/// **limits** fails if an axis is not one of the control, if a table ends inside the travel of its axis and
/// the profile does not say what is added outside, or says nothing is and the table does not end with nothing, and
/// if it goes beyond the travel and the profile says that the control uses no such point
pub(super) fn control(
    tables: &ListedTables,
    own: &impl PointLists,
    state: &ControlState,
) -> Emulated<PairControl> {
    let load = |table: &ListedTable| {
        let name = own.table_name(table);
        let mut form = own.form(table.is_own(), state.unit);
        if form.is_of_axis {
            let unit_um = known_axis(state, &table.output)?.detection_unit_um;
            let none = || CannotEmulate(format!("{} has no detection unit", table.output));
            form = form.on_axis(unit_um.ok_or_else(none)?);
        }
        load_table(table, (&name, &form), known_axis(state, &table.base)?)
    };
    let pairs: Vec<Pair> = tables.tables.iter().map(load).collect::<Result<_, _>>()?;
    for pair in &pairs {
        known_axis(state, &pair.output)?;
    }
    Ok(PairControl { pairs, replaces_backlash: own.replaces_parameter(), state: state.clone() })
}

fn load_table(table: &ListedTable, own: (&str, &Form), base: &AxisState) -> Emulated<Pair> {
    let (name, form) = own;
    let mut points = if form.is_factor { line(table, base) } else { table.points.clone() };
    points.sort_by(|a, b| a.position.total_cmp(&b.position));
    let way = |value: fn(&Point) -> f64| {
        let added = one_way(form, &points, value, base.reference);
        added.ok_or_else(|| CannotEmulate(format!("the {name} has no point")))
    };
    let copies =
        form.zero_reverse_is_forward && points.iter().all(|point| point.reverse == Some(0.0));
    let reverse = match copies {
        true => |point: &Point| point.forward,
        false => |point: &Point| point.reverse.unwrap_or(point.forward),
    };
    let ways = [way(|point| point.forward)?, way(reverse)?];
    meets_travel(own, &places_mm(form, &points), base, &ways)?;
    Ok(Pair { base: table.base.clone(), output: table.output.clone(), ways: ways.map(Ok) })
}

/// The line of a factor over the travel, in mm.
fn line(table: &ListedTable, base: &AxisState) -> Vec<Point> {
    let point = |place: Millimetres| Point {
        position: place.mm(),
        forward: table.factor() * (place - base.reference).mm(),
        reverse: None,
    };
    base.travel().map(point).to_vec()
}

/// Whether ascending places cover the travel of the axis that is looked up and do not go beyond it, where a control
/// needs that, but for the rounding of a position.
fn meets_travel(
    (name, form): (&str, &Form),
    places: &[f64],
    base: &AxisState,
    ways: &[Response; 2],
) -> Emulated<()> {
    let digit_mm = form.position_um / UM_PER_MM / power_of_ten(form.position_decimals);
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return Ok(());
    };
    let [low, high] = base.travel().map(Millimetres::mm);
    let is_nothing = |at: &f64| {
        let um = |way: &Response| way.correction(Millimetres::new(*at)).um().abs();
        ways.iter().all(|way| um(way) <= NOTHING_UM)
    };
    let may_end = |at: &f64| match form.outside {
        Outside::Hold => true,
        Outside::Zero => is_nothing(at),
        Outside::Unknown => false,
    };
    let covers_low = *first <= low + digit_mm || may_end(first);
    let covers = covers_low && (*last >= high - digit_mm || may_end(last));
    let (lowest, highest) = (base.ends.0.mm(), base.ends.1.mm());
    let is_beyond = *first < lowest - digit_mm || *last > highest + digit_mm;
    let why = match is_beyond && !form.beyond_travel {
        true => "this control does not use points beyond the travel",
        false if covers => return Ok(()),
        false => form.outside.why(),
    };
    let [first, last, low, high] = [*first, *last, low, high].map(Figure);
    let axis = &base.name;
    Err(CannotEmulate(format!(
        "the {name} covers {first:.3} mm to {last:.3} mm, the travel of {axis} with its reference point is {low:.3} mm to {high:.3} mm, and {why}"
    )))
}

/// A correction that is none, µm (a picometre).
const NOTHING_UM: f64 = 1e-6;

/// Where points lie.
fn places_mm(form: &Form, points: &[Point]) -> Vec<f64> {
    points.iter().map(|point| point.position * form.position_um / UM_PER_MM).collect()
}

/// What a column of a table adds; `None` without a point.
fn one_way(
    form: &Form,
    points: &[Point],
    value: fn(&Point) -> f64,
    reference: Millimetres,
) -> Option<Response> {
    let mut sum = 0.0;
    let correction = |point: &Point| {
        let value = value(point);
        sum += value;
        // Error or correction, in the size of a value.
        let amount = match form.value {
            ValueForm::Amount => value,
            ValueForm::Position => value - point.position,
            ValueForm::Increment => sum,
        };
        let amount = if form.is_float { as_float(amount) } else { amount };
        form.sign.correction(amount * form.value_um)
    };
    let values: Vec<Correction> = points.iter().map(correction).collect();
    let mut response = Response::straight(&places_mm(form, points), &values)?;
    if form.value == ValueForm::Increment {
        response.shift(Correction::from_um(0.0 - response.correction(reference).um()));
    }
    Some(response)
}

/// A number as the control holds it in a C float.
#[allow(clippy::cast_possible_truncation, reason = "the control rounds so")]
fn as_float(number: f64) -> f64 {
    f64::from(number as f32)
}

// A control that holds one correction for each pair of axes and each direction: what most families make of their
// tables.
//
// ```text
//   correction(A while B moves) = that of the pair (B, A) in the direction
//                                 − backlash of A where A = B, unless the table of A stands in place of it
// ```

/// What one axis gets because another one, or itself, stands somewhere.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub(super) base: String,
    pub(super) output: String,
    /// While the base axis moves in +, and in −, as far as that is known.
    pub(super) ways: [Emulated<Response>; 2],
}

impl Pair {
    pub(super) fn is_for(&self, base: &str, output: &str) -> bool {
        self.base.eq_ignore_ascii_case(base) && self.output.eq_ignore_ascii_case(output)
    }
}

/// A control with its tables in memory.
#[derive(Clone, Debug)]
pub(super) struct PairControl {
    pub(super) pairs: Vec<Pair>,
    /// Whether the table of an axis for itself stands in place of its backlash parameter.
    pub(super) replaces_backlash: bool,
    pub(super) state: ControlState,
}

impl Emulator for PairControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        let names = |pair: &Pair| (pair.base.clone(), pair.output.clone());
        self.pairs.iter().map(names).collect()
    }

    fn response(&self, base: &str, output: &str, direction: Direction) -> Emulated<Response> {
        let own = self.pairs.iter().find(|pair| pair.is_for(base, output));
        let way = usize::from(direction == Direction::Minus);
        let mut response =
            own.map_or_else(|| Ok(Response::default()), |own| own.ways[way].clone())?;
        let is_replaced = self.replaces_backlash && own.is_some();
        if base.eq_ignore_ascii_case(output) && !is_replaced {
            response.shift(known_axis(&self.state, base)?.backlash(direction));
        }
        Ok(response)
    }
}

/// The axis of a name.
pub(super) fn known_axis<'a>(state: &'a ControlState, name: &str) -> Emulated<&'a AxisState> {
    let axis = state.axis(name);
    axis.ok_or_else(|| CannotEmulate(format!("foreign axis: the job has no axis `{name}`")))
}

#[cfg(test)]
mod tests;
