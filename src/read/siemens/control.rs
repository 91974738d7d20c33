//! What a SINUMERIK adds to an axis: ENC_COMP and CEC tables, backlash.
//!
//! ```text
//!   LEC_A = F(x_A)                          own table of the axis, active measuring system
//!   c_t   = f_t(x_in) [ · f_m(x_in(m)) ]    factor table m of table t, if it names one
//!   CEC_A = clamp( Σ c_t of the tables with output A that act ,  ±CEC_MAX_SUM )
//!   BL_A  = backlash, away from the reference direction
//!   correction(A) = σ(LEC_A) + σ(CEC_A) − BL_A
//! ```
//! The base of a CEC table is the uncompensated setpoint, so tables never feed each other. F is
//! linear between points, holds its end values and repeats if modulo (Function Manual Extended
//! Functions 03/2013, K3 p. 236-249; 802D sl Function Manual 11/2012, p. 214-215).
//! σ is [`crate::control::controller::TableSign`] of the profile, the only place where a table value gets its
//! sense. Everything that is switched by machine data is taken as switched on, weights as 1. A response is
//! that of one base axis, so products of tables and sums that would be clamped are refused; so is what
//! the documents leave open (a missing point, a grid that does not fit, a chain of factor tables).

use crate::control::control_state::ControlState;
use crate::control::controller::{ControlUnit, MultiplyMode, SiemensFacts};
use crate::control::table::siemens::{Place, SiemensTable, SiemensTables, largest_sum};
use crate::quantity::{Correction, Direction, Millimetres, UM_PER_MM};
use crate::read::emulate::{Between, CannotEmulate, Emulated, NodeTable, Response, cannot};
use crate::read::listed::{Pair, PairControl};
use std::collections::BTreeSet;

/// (MAX−MIN)/STEP may differ this much from the index of the last point, in steps; STEP is
/// rounded in real files.
const RATIO_TOLERANCE: f64 = 1e-3;
/// The same for repeating tables, where the difference adds up with every turn.
const MODULO_RATIO_TOLERANCE: f64 = 1e-6;

/// A control that holds these tables.
///
/// **unit** positions and values of the tables in `state.unit` · **limits** fails if a point
/// is missing (the control would keep an old value), if the number of points does not fit the
/// grid or the control, if a repeating table does not close, and where the documents do not
/// say what the control does: chains of factor tables, products on an inch control, repeating
/// (rotary) tables on an inch control.
pub(super) fn control(
    tables: &SiemensTables,
    facts: &SiemensFacts,
    state: &ControlState,
) -> Emulated<PairControl> {
    let load = |table| Ok(TableInControl { table, corrections: nodes(table, facts, state.unit)? });
    let memory = Memory {
        tables: tables.tables.iter().map(load).collect::<Result<_, _>>()?,
        facts,
        um_per_unit: state.unit.in_mm() * UM_PER_MM,
    };
    refuse_factors(tables, state.unit)?;
    Ok(PairControl { pairs: memory.pairs(), replaces_backlash: false, state: state.clone() })
}

/// Checked tables.
struct Memory<'a> {
    tables: Vec<TableInControl<'a>>,
    facts: &'a SiemensFacts,
    um_per_unit: f64,
}

/// A checked table.
struct TableInControl<'a> {
    table: &'a SiemensTable,
    corrections: NodeTable,
}

impl TableInControl<'_> {
    fn is_from(&self, base: &str) -> bool {
        same(&self.table.input_axis, base)
    }

    fn is_cec_of(&self, output: &str) -> bool {
        self.table.place.cec().is_some() && same(&self.table.output_axis, output)
    }

    /// Largest number without its sign, µm.
    fn peak_um(&self) -> f64 {
        self.corrections.nodes().map(|(_, own)| own.um().abs()).fold(0.0, f64::max)
    }
}

fn same(a: &str, b: &str) -> bool {
    a.eq_ignore_ascii_case(b)
}

/// Where the factor table of a table stands.
fn factor(table: &SiemensTable) -> Option<Place> {
    table.multiply_by.checked_sub(1).map(Place::Cec)
}

impl Memory<'_> {
    /// Of every pair of axes that a table connects, by itself or as a factor, what the control adds.
    fn pairs(&self) -> Vec<Pair> {
        let mut axes = BTreeSet::new();
        for own in &self.tables {
            let bases = [Some(own), self.factor_of(own)].into_iter().flatten();
            axes.extend(bases.map(|base| (&base.table.input_axis, &own.table.output_axis)));
        }
        let pair = |(base, output): (&String, &String)| Pair {
            base: base.clone(),
            output: output.clone(),
            ways: Direction::BOTH.map(|way| self.response(base, output, way)),
        };
        axes.into_iter().map(pair).collect()
    }

    fn response(&self, base: &str, output: &str, direction: Direction) -> Emulated<Response> {
        self.refuse_products(base, output)?;
        let cec = self.cec_of(output);
        let cec: Vec<_> =
            cec.filter(|own| own.is_from(base) && own.table.acts_in(direction)).collect();
        if !cec.is_empty() {
            self.refuse_clamp(output)?;
        }
        let own = if same(base, output) { self.lec_of(base)? } else { None };
        let tables = own.into_iter().chain(cec).map(|loaded| loaded.corrections.clone());
        Ok(Response::new(tables.collect(), Correction::ZERO))
    }

    fn lec_of(&self, axis: &str) -> Emulated<Option<&TableInControl<'_>>> {
        let mut of_axis = self.tables.iter().filter_map(|loaded| {
            let (own, encoder) = loaded.table.place.lec()?;
            same(own, axis).then_some((loaded, encoder))
        });
        match (of_axis.next(), of_axis.next()) {
            (Some((_, first)), Some((_, second))) => cannot(format!(
                "axis {axis} has tables for the measuring systems {first} and {second}; which one acts is \
                 not in the files",
            )),
            (first, _) => Ok(first.map(|(loaded, _)| loaded)),
        }
    }

    /// CEC tables that add to an axis by themselves.
    fn cec_of(&self, output: &str) -> impl Iterator<Item = &TableInControl<'_>> {
        let contributes = |table: &TableInControl<'_>| {
            !self.is_factor(table) || self.facts.factor_contributes.value
        };
        self.tables.iter().filter(move |table| table.is_cec_of(output) && contributes(table))
    }

    fn factor_of(&self, own: &TableInControl<'_>) -> Option<&TableInControl<'_>> {
        let place = factor(own.table)?;
        self.tables.iter().find(|other| other.table.place == place)
    }

    /// Whether another table is multiplied by it.
    fn is_factor(&self, own: &TableInControl<'_>) -> bool {
        let place = &own.table.place;
        let mut others = self.tables.iter().filter(|other| other.table.place != *place);
        others.any(|other| factor(other.table).as_ref() == Some(place))
    }

    /// A product of tables has no response of one base axis alone.
    fn refuse_products(&self, base: &str, output: &str) -> Emulated<()> {
        let takes_part = |loaded: &&TableInControl<'_>| {
            let factor = self.factor_of(loaded);
            let is_product = factor.is_some() || self.is_factor(loaded);
            let from_base =
                loaded.is_from(base) || factor.is_some_and(|factor| factor.is_from(base));
            is_product && from_base && loaded.is_cec_of(output)
        };
        match self.tables.iter().find(takes_part) {
            None => Ok(()),
            Some(loaded) => cannot(format!(
                "${} takes part in a product of tables, which depends on more than one axis",
                loaded.table.place
            )),
        }
    }

    /// The clamp acts on the sum over all base axes, so no single response can show it.
    fn refuse_clamp(&self, output: &str) -> Emulated<()> {
        let largest = largest_sum(self.cec_of(output).map(|own| (own.table, self.peak_um(own))));
        let limit = self.facts.cec_max_sum_um.value;
        if largest <= limit {
            return Ok(());
        }
        cannot(format!(
            "the CEC tables of axis {output} can add up to {largest:.1} µm, more than \
             CEC_MAX_SUM of {limit:.1} µm; the control would cut their sum: check their scale \
             (µm taken for mm?)"
        ))
    }

    fn peak_um(&self, table: &TableInControl<'_>) -> f64 {
        let Some(factor) = self.factor_of(table) else {
            return table.peak_um();
        };
        let product = table.peak_um() * factor.peak_um() / self.um_per_unit;
        match self.facts.multiply_mode.value {
            MultiplyMode::Product => product,
            MultiplyMode::Additive => table.peak_um() + product,
        }
    }
}

/// A table may be multiplied by itself; any other chain is refused, the manuals do not say how deep
/// the control follows it.
fn refuse_factors(tables: &SiemensTables, unit: ControlUnit) -> Emulated<()> {
    for table in &tables.tables {
        let Some(place) = factor(table) else {
            continue;
        };
        let what = match tables.at(&place) {
            None => format!(" is multiplied by ${place}, which no file holds"),
            Some(factor) if factor != table && factor.multiply_by != 0 => {
                format!(" and its factor ${place} form a chain")
            }
            Some(_) if unit == ControlUnit::Inch => {
                ": products of tables on an inch control have no settled unit".to_string()
            }
            Some(_) => continue,
        };
        return cannot(format!("${}{what}", table.place));
    }
    Ok(())
}

/// What the points of a table add.
fn nodes(table: &SiemensTable, facts: &SiemensFacts, unit: ControlUnit) -> Emulated<NodeTable> {
    let fault = |what: &str| CannotEmulate(format!("${}: {what}", table.place));
    let (sign, most_points) = facts.of_place(&table.place);
    check_size(table, facts.cec_tables.value, most_points)?;
    if let Some(point) = table.values.iter().position(Option::is_none) {
        let what = format!("point {point} is missing; the control would keep an older value");
        return Err(fault(&what));
    }
    let um_per_unit = unit.in_mm() * UM_PER_MM;
    let numbers_um: Vec<f64> = table.values.iter().flatten().map(|own| own * um_per_unit).collect();
    if let (true, [first, .., last]) = (table.modulo, &numbers_um[..]) {
        if unit == ControlUnit::Inch {
            let why = "repeats; the scale of its positions on an inch control is not documented";
            return Err(fault(why));
        }
        if (first - last).abs() > 0.0 {
            let differ =
                format!("repeats, but its values at both ends differ ({first} µm and {last} µm)");
            return Err(fault(&differ));
        }
    }
    let corrections: Vec<Correction> = numbers_um.iter().map(|um| sign.correction(*um)).collect();
    let [start, step] =
        [table.grid.min, table.grid.step].map(|length| Millimetres::new(length * unit.in_mm()));
    let mut nodes = NodeTable::new(start, step, &corrections, Between::Linear)
        .ok_or_else(|| fault("has no usable grid"))?;
    nodes.modulo = table.modulo;
    Ok(nodes)
}

/// The table is one that the control has, with as many points as its grid and the control hold.
fn check_size(table: &SiemensTable, most_tables: u32, most_points: u32) -> Emulated<()> {
    let (place, points) = (&table.place, table.values.len());
    if place.cec().is_some_and(|number| number >= most_tables) {
        return cannot(format!("${place} does not exist, the control has {most_tables} tables"));
    }
    let tolerance = if table.modulo { MODULO_RATIO_TOLERANCE } else { RATIO_TOLERANCE };
    let ratio = table.grid.steps();
    let off = (ratio + 1.0 - points as f64).abs();
    if points < 2 || off.is_nan() || off >= tolerance {
        return cannot(format!("${place}: has {points} points, but (MAX-MIN)/STEP is {ratio}"));
    }
    if points > most_points as usize {
        return cannot(format!("${place}: has {points} points, the control holds {most_points}"));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
