//! What a control adds to an axis, as its profile declares it.
//!
//! ```text
//!   value → error or correction at each point (amount, position − point, sum of increments, zero at the
//!   reference) → straight lines between, outside held or nothing
//! ```

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{BesideTable, DeclaredFacts, Outside, ValueForm};
use crate::control::table::declared::{DeclaredTable, DeclaredTables, Point};
use crate::quantity::axis::Direction;
use crate::quantity::units::{Correction, Millimetres, UM_PER_MM};
use crate::read::emulate::{Between, CannotEmulate, Emulator, NodeTable, Response};

/// A control with its tables in memory.
#[derive(Clone, Debug)]
pub struct DeclaredControl {
    tables: Vec<Loaded>,
    replaces: bool,
    state: ControlState,
}

#[derive(Clone, Debug)]
struct Loaded {
    base: String,
    output: String,
    /// While the base axis moves in +, and in −.
    ways: [Response; 2],
}

impl DeclaredControl {
    /// A control that holds these tables.
    ///
    /// **limits** fails if an axis is not one of the control
    pub fn new(
        tables: &DeclaredTables,
        facts: &DeclaredFacts,
        state: &ControlState,
    ) -> Result<DeclaredControl, CannotEmulate> {
        let load = |table: &DeclaredTable| load(table, facts, state);
        Ok(DeclaredControl {
            tables: tables.tables.iter().map(load).collect::<Result<_, _>>()?,
            replaces: facts.backlash.value == BesideTable::Replaced,
            state: state.clone(),
        })
    }
}

impl Emulator for DeclaredControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        let pair = |own: &Loaded| (own.base.clone(), own.output.clone());
        self.tables.iter().map(pair).collect()
    }

    fn response(
        &self,
        base: &str,
        output: &str,
        direction: Direction,
    ) -> Result<Response, CannotEmulate> {
        let is_it = |own: &&Loaded| {
            own.base.eq_ignore_ascii_case(base) && own.output.eq_ignore_ascii_case(output)
        };
        let own = self.tables.iter().find(is_it);
        let mut response = own.map_or_else(Response::default, |own| match direction {
            Direction::Plus => own.ways[0].clone(),
            Direction::Minus => own.ways[1].clone(),
        });
        let is_own = base.eq_ignore_ascii_case(output);
        if is_own && !(self.replaces && own.is_some()) {
            response.shift(known_axis(&self.state, base)?.backlash(direction));
        }
        Ok(response)
    }
}

fn known_axis<'a>(state: &'a ControlState, name: &str) -> Result<&'a AxisState, CannotEmulate> {
    let axis = state.axis(name);
    axis.ok_or_else(|| CannotEmulate(format!("foreign axis: the job has no axis `{name}`")))
}

fn load(
    table: &DeclaredTable,
    facts: &DeclaredFacts,
    state: &ControlState,
) -> Result<Loaded, CannotEmulate> {
    known_axis(state, &table.output)?;
    let reference = known_axis(state, &table.base)?.reference;
    let mut points = table.points.clone();
    points.sort_by(|a, b| a.position.total_cmp(&b.position));
    let way = |value: fn(&Point) -> f64| {
        let column = Column {
            points: &points,
            value,
            facts,
        };
        let response = column.response(table, reference);
        response.ok_or_else(|| CannotEmulate(format!("the {} has no point", table.name())))
    };
    Ok(Loaded {
        base: table.base.clone(),
        output: table.output.clone(),
        ways: [
            way(|point| point.forward)?,
            way(|point| point.reverse.unwrap_or(point.forward))?,
        ],
    })
}

/// The values of a table for one direction.
struct Column<'a> {
    points: &'a [Point],
    value: fn(&Point) -> f64,
    facts: &'a DeclaredFacts,
}

impl Column<'_> {
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
