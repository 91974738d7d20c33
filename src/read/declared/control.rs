//! What a control adds to an axis, as its profile declares it.
//!
//! ```text
//!   value → error or correction at each point (amount, position − point, sum of increments, zero at the
//!   reference) → straight lines between, outside held or nothing
//! ```

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{BesideTable, DeclaredFacts, Outside, ValueForm};
use crate::control::table::declared::{DeclaredTable, DeclaredTables, Point};
use crate::quantity::units::{Correction, Figure, Millimetres, UM_PER_MM, power_of_ten};
use crate::read::emulate::{Between, CannotEmulate, Emulated, NodeTable, Response};
use crate::read::pairs::{Pair, PairControl, known_axis};

/// A control that holds these tables.
///
/// **limits** fails if an axis is not one of the control, if a table ends inside the travel of its axis and
/// the profile does not say what is added outside, or says nothing is and the table does not end with nothing, and
/// if it goes beyond the travel and the profile says that the control uses no such point
pub(super) fn control(
    tables: &DeclaredTables,
    facts: &DeclaredFacts,
    state: &ControlState,
) -> Emulated<PairControl> {
    let load = |table: &DeclaredTable| load(table, facts, known_axis(state, &table.base)?);
    let pairs = tables.tables.iter().map(load).collect::<Result<_, _>>()?;
    let replaces_backlash = facts.backlash.value == BesideTable::Replaced;
    PairControl::new(pairs, replaces_backlash, state)
}

fn load(table: &DeclaredTable, facts: &DeclaredFacts, base: &AxisState) -> Emulated<Pair> {
    let mut points = table.points.clone();
    points.sort_by(|a, b| a.position.total_cmp(&b.position));
    let way = |value: fn(&Point) -> f64| {
        let column = OneWay { points: &points, value, facts };
        let response = column.response(table, base.reference);
        response.ok_or_else(|| CannotEmulate(format!("the {} has no point", table.name())))
    };
    let copies = facts.zero_reverse_is_forward.value
        && points.iter().all(|point| point.reverse == Some(0.0));
    let reverse = match copies {
        true => |point: &Point| point.forward,
        false => |point: &Point| point.reverse.unwrap_or(point.forward),
    };
    let mut ways = [way(|point| point.forward)?, way(reverse)?];
    let places = facts.places_mm(&points);
    meets_travel(table, &places, facts, base, &ways)?;
    if facts.outside.value == Outside::Zero {
        for way in &mut ways {
            nothing_outside(&places, way);
        }
    }
    Ok(Pair { base: table.base.clone(), output: table.output.clone(), ways })
}

/// Whether ascending places cover the travel of the axis that is looked up and do not go beyond it, where a control
/// needs that, but for the rounding of a position.
fn meets_travel(
    table: &DeclaredTable,
    places: &[f64],
    facts: &DeclaredFacts,
    base: &AxisState,
    ways: &[Response; 2],
) -> Emulated<()> {
    let digit_mm = facts.position_size.value.um / UM_PER_MM;
    let digit_mm = digit_mm / power_of_ten(facts.position_decimals.value);
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return Ok(());
    };
    let (low, high) = (base.travel.0.mm(), base.travel.1.mm());
    let is_nothing = |at: &f64| {
        let um = |way: &Response| way.correction(Millimetres::new(*at)).um().abs();
        ways.iter().all(|way| um(way) <= NOTHING_UM)
    };
    let may_end = |at: &f64| match facts.outside.value {
        Outside::Hold => true,
        Outside::Zero => is_nothing(at),
        Outside::Unknown => false,
    };
    let covers_low = *first <= low + digit_mm || may_end(first);
    let covers = covers_low && (*last >= high - digit_mm || may_end(last));
    let (lowest, highest) = (base.ends.0.mm(), base.ends.1.mm());
    let is_beyond = *first < lowest - digit_mm || *last > highest + digit_mm;
    let why = match facts.outside.value {
        _ if is_beyond && !facts.points_beyond_travel.value => {
            "this control does not use points beyond the travel"
        }
        _ if covers => return Ok(()),
        Outside::Zero => {
            "this control adds nothing outside a table: the correction would jump at its end"
        }
        _ => "what this control adds outside a table is not known",
    };
    let [first, last, low, high] = [*first, *last, low, high].map(Figure);
    let (name, axis) = (table.name(), &base.name);
    Err(CannotEmulate(format!(
        "the {name} covers {first:.3} mm to {last:.3} mm, the travel of {axis} with its reference point is {low:.3} mm to {high:.3} mm, and {why}"
    )))
}

/// A correction that is none, µm (a picometre).
const NOTHING_UM: f64 = 1e-6;

impl DeclaredFacts {
    /// Where points lie.
    fn places_mm(&self, points: &[Point]) -> Vec<f64> {
        let unit_mm = |point: &Point| point.position * self.position_size.value.um / UM_PER_MM;
        points.iter().map(unit_mm).collect()
    }
}

/// The values of a table for one direction.
struct OneWay<'a> {
    points: &'a [Point],
    value: fn(&Point) -> f64,
    facts: &'a DeclaredFacts,
}

impl OneWay<'_> {
    fn response(&self, table: &DeclaredTable, reference: Millimetres) -> Option<Response> {
        let sign = self.facts.sign(table.is_own()).value;
        let value_um = self.facts.value_size.value.um;
        let mm = self.facts.places_mm(self.points);
        let correction = |amount: &f64| sign.correction(amount * value_um);
        let values: Vec<Correction> = self.amounts().iter().map(correction).collect();
        let mut response = Response::straight(&mm, &values)?;
        if self.facts.value_form.value == ValueForm::Increment {
            let there = response.correction(reference);
            response.shift(Correction::from_um(0.0 - there.um()));
        }
        Some(response)
    }

    /// Error or correction at each point, in the size of a value.
    fn amounts(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let amount = |point: &Point| {
            let value = (self.value)(point);
            sum += value;
            match self.facts.value_form.value {
                ValueForm::Amount => value,
                ValueForm::Position => value - point.position,
                ValueForm::Increment => sum,
            }
        };
        self.points.iter().map(amount).collect()
    }
}

/// A step to nothing before the first place and behind the last one.
fn nothing_outside(mm: &[f64], response: &mut Response) {
    const ANY_MM: f64 = 1.0;
    let (Some(first), Some(last)) = (mm.first(), mm.last()) else {
        return;
    };
    let taken = |at: f64| Correction::from_um(0.0 - response.correction(Millimetres::new(at)).um());
    let steps = [
        (first - ANY_MM, [taken(*first), Correction::ZERO], 1.0),
        (*last, [Correction::ZERO, taken(*last)], 0.0),
    ];
    for (start, values, fraction) in steps {
        let [start, step] = [start, ANY_MM].map(Millimetres::new);
        let table = NodeTable::new(start, step, &values, Between::Step { fraction });
        table.into_iter().for_each(|table| response.push(table));
    }
}

#[cfg(test)]
mod tests;
