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
/// **limits** fails if an axis is not one of the control, and if a table ends inside the travel of its axis and
/// the profile does not say what is added outside
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
        let column = OneWay {
            points: &points,
            value,
            facts,
        };
        let response = column.response(table, base.reference);
        response.ok_or_else(|| CannotEmulate(format!("the {} has no point", table.name())))
    };
    let ways = [
        way(|point| point.forward)?,
        way(|point| point.reverse.unwrap_or(point.forward))?,
    ];
    if facts.outside.value == Outside::Unknown {
        covers_travel(table, &points, facts, base)?;
    }
    Ok(Pair {
        base: table.base.clone(),
        output: table.output.clone(),
        ways,
    })
}

/// Whether ascending points cover the travel of the axis that is looked up, but for the rounding of a position.
fn covers_travel(
    table: &DeclaredTable,
    points: &[Point],
    facts: &DeclaredFacts,
    base: &AxisState,
) -> Emulated<()> {
    let unit_mm = facts.position_size.value.um / UM_PER_MM;
    let digit_mm = unit_mm / power_of_ten(facts.position_decimals.value);
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Ok(());
    };
    let [first, last] = [first, last].map(|point| point.position * unit_mm);
    let (low, high) = (base.travel.0.mm(), base.travel.1.mm());
    if first <= low + digit_mm && last >= high - digit_mm {
        return Ok(());
    }
    let [first, last, low, high] = [first, last, low, high].map(Figure);
    let (name, axis) = (table.name(), &base.name);
    Err(CannotEmulate(format!(
        "the {name} covers {first:.3} mm to {last:.3} mm, the travel of {axis} with its reference point is {low:.3} mm to {high:.3} mm, and what this control adds outside a table is not known"
    )))
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
        let (value_um, place_um) = (
            self.facts.value_size.value.um,
            self.facts.position_size.value.um,
        );
        let mm: Vec<f64> = self
            .points
            .iter()
            .map(|point| point.position * place_um / UM_PER_MM)
            .collect();
        let correction = |amount: &f64| sign.correction(amount * value_um);
        let values: Vec<Correction> = self.amounts().iter().map(correction).collect();
        let mut response = Response::straight(&mm, &values)?;
        if self.facts.value_form.value == ValueForm::Increment {
            let there = response.correction(reference);
            response.shift(Correction::from_um(0.0 - there.um()));
        }
        if self.facts.outside.value == Outside::Zero {
            nothing_outside(&mm, &mut response);
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
