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

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{ControlUnit, MultiplyMode, SiemensFacts};
use crate::control::table::siemens::{SiemensTable, SiemensTables};
use crate::quantity::{Correction, Direction, Millimetres, UM_PER_MM};
use crate::read::emulate::{
    Between, CannotEmulate, Emulated, Emulator, NodeTable, Response, cannot,
};
use std::collections::BTreeMap;

/// (MAX−MIN)/STEP may differ this much from the index of the last point, in steps; STEP is
/// rounded in real files.
const RATIO_TOLERANCE: f64 = 1e-3;
/// The same for repeating tables, where the difference adds up with every turn.
const MODULO_RATIO_TOLERANCE: f64 = 1e-6;

/// A control of the Siemens family with its tables in memory.
#[derive(Clone, Debug)]
pub struct SiemensControl {
    tables: Vec<Loaded>,
    axes: Vec<AxisState>,
    facts: SiemensFacts,
    um_per_unit: f64,
}

/// A checked table.
#[derive(Clone, Debug)]
struct Loaded {
    table: SiemensTable,
    corrections: NodeTable,
    /// Largest number without its sign, µm.
    peak_um: f64,
    /// Index of the table it is multiplied by.
    factor: Option<usize>,
    /// Another table is multiplied by this one.
    is_factor: bool,
}

impl Loaded {
    fn acts_in(&self, direction: Direction) -> bool {
        self.table.direction.is_none_or(|own| own == direction)
    }

    fn is_from(&self, base: &str) -> bool {
        same(&self.table.input_axis, base)
    }

    fn is_cec_of(&self, output: &str) -> bool {
        self.table.place.cec().is_some() && same(&self.table.output_axis, output)
    }
}

fn same(a: &str, b: &str) -> bool {
    a.eq_ignore_ascii_case(b)
}

impl SiemensControl {
    /// A control that holds these tables.
    ///
    /// **unit** positions and values of the tables in `state.unit` · **limits** fails if a point
    /// is missing (the control would keep an old value), if the number of points does not fit the
    /// grid or the control, if a repeating table does not close, and where the documents do not
    /// say what the control does: chains of factor tables, products on an inch control, repeating
    /// (rotary) tables on an inch control.
    pub fn new(
        tables: &SiemensTables,
        facts: &SiemensFacts,
        state: &ControlState,
    ) -> Emulated<SiemensControl> {
        let all = tables.tables.iter().map(|table| load(table, facts, state.unit));
        let mut all: Vec<Loaded> = all.collect::<Result<_, _>>()?;
        link_factors(&tables.tables, &mut all, state.unit)?;
        Ok(SiemensControl {
            tables: all,
            axes: state.axes.clone(),
            facts: facts.clone(),
            um_per_unit: state.unit.in_mm() * UM_PER_MM,
        })
    }

    fn axis(&self, name: &str) -> Emulated<&AxisState> {
        let found = self.axes.iter().find(|axis| same(&axis.name, name));
        found.ok_or_else(|| CannotEmulate(format!("the control has no axis `{name}`")))
    }

    fn lec_of(&self, axis: &str) -> Emulated<Option<&Loaded>> {
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
    fn cec_of(&self, output: &str) -> impl Iterator<Item = &Loaded> {
        let contributes = |table: &Loaded| !table.is_factor || self.facts.factor_contributes.value;
        self.tables.iter().filter(move |table| table.is_cec_of(output) && contributes(table))
    }

    /// A product of tables has no response of one base axis alone.
    fn refuse_products(&self, base: &str, output: &str) -> Emulated<()> {
        let takes_part = |loaded: &&Loaded| {
            let factor = loaded.factor.map(|index| &self.tables[index]);
            let is_product = loaded.is_factor || factor.is_some();
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
        let largest = self.largest_cec_um(output);
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

    /// A bound of the CEC sum of an axis, µm: peaks added over all base axes, the worse direction
    /// of each.
    fn largest_cec_um(&self, output: &str) -> f64 {
        let mut of_base: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
        for own in self.cec_of(output) {
            let ways = of_base.entry(&own.table.input_axis).or_default().iter_mut();
            let acting = ways.zip(Direction::BOTH).filter(|(_, way)| own.acts_in(*way));
            acting.for_each(|(sum, _)| *sum += self.peak_um(own));
        }
        of_base.values().map(|[plus, minus]| plus.max(*minus)).sum()
    }

    fn peak_um(&self, table: &Loaded) -> f64 {
        let Some(index) = table.factor else {
            return table.peak_um;
        };
        let product = table.peak_um * self.tables[index].peak_um / self.um_per_unit;
        match self.facts.multiply_mode.value {
            MultiplyMode::Product => product,
            MultiplyMode::Additive => table.peak_um + product,
        }
    }
}

impl Emulator for SiemensControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        let pair =
            |of: &Loaded, to: &Loaded| (of.table.input_axis.clone(), to.table.output_axis.clone());
        let own = self.tables.iter().map(|loaded| pair(loaded, loaded));
        let through_factor = self.tables.iter();
        let through_factor =
            through_factor.filter_map(|loaded| Some(pair(&self.tables[loaded.factor?], loaded)));
        let mut pairs: Vec<_> = own.chain(through_factor).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    fn response(&self, base: &str, output: &str, direction: Direction) -> Emulated<Response> {
        self.refuse_products(base, output)?;
        let cec = self.cec_of(output);
        let cec: Vec<_> = cec.filter(|own| own.is_from(base) && own.acts_in(direction)).collect();
        if !cec.is_empty() {
            self.refuse_clamp(output)?;
        }
        let (own, constant) = match same(base, output) {
            true => (self.lec_of(base)?, self.axis(base)?.backlash(direction)),
            false => (None, Correction::ZERO),
        };
        let tables = own.into_iter().chain(cec).map(|loaded| loaded.corrections.clone());
        Ok(Response::new(tables.collect(), constant))
    }
}

fn load(table: &SiemensTable, facts: &SiemensFacts, unit: ControlUnit) -> Emulated<Loaded> {
    let (sign, most_points) = facts.of_place(&table.place);
    let raw = Raw { table, most_points, unit };
    let most_tables = facts.cec_tables.value;
    if table.place.cec().is_some_and(|number| number >= most_tables) {
        let place = &table.place;
        return cannot(format!("${place} does not exist, the control has {most_tables} tables"));
    }
    let numbers_um = raw.numbers_um()?;
    let corrections: Vec<Correction> = numbers_um.iter().map(|um| sign.correction(*um)).collect();
    Ok(Loaded {
        table: table.clone(),
        corrections: raw.nodes(&corrections)?,
        peak_um: numbers_um.iter().fold(0.0, |peak, um| um.abs().max(peak)),
        factor: None,
        is_factor: false,
    })
}

/// Connects tables with their factor tables. A table may be multiplied by itself; any other
/// chain is refused, the manuals do not say how deep the control follows it.
fn link_factors(tables: &[SiemensTable], loaded: &mut [Loaded], unit: ControlUnit) -> Emulated<()> {
    for (index, table) in tables.iter().enumerate() {
        let Some(number) = table.multiply_by.checked_sub(1) else {
            continue;
        };
        let cannot = |what: String| cannot(format!("${}{what}", table.place));
        let is_factor = |other: &SiemensTable| other.place.cec() == Some(number);
        let Some(factor) = tables.iter().position(is_factor) else {
            let what = format!(" is multiplied by $AN_CEC[{number}], which no file holds");
            return cannot(what);
        };
        if factor != index && tables[factor].multiply_by != 0 {
            return cannot(format!(" and its factor $AN_CEC[{number}] form a chain"));
        }
        if unit == ControlUnit::Inch {
            let what = ": products of tables on an inch control have no settled unit";
            return cannot(what.to_string());
        }
        loaded[index].factor = Some(factor);
        loaded[factor].is_factor |= factor != index;
    }
    Ok(())
}

/// A table as the file holds it.
struct Raw<'a> {
    table: &'a SiemensTable,
    most_points: u32,
    unit: ControlUnit,
}

impl Raw<'_> {
    /// The numbers in µm, in table sense; fails if one is missing or the grid does not fit.
    fn numbers_um(&self) -> Emulated<Vec<f64>> {
        self.check_grid()?;
        let um_per_unit = self.unit.in_mm() * UM_PER_MM;
        let number = |(point, value): (usize, &Option<f64>)| match value {
            Some(value) => Ok(value * um_per_unit),
            None => Err(self.fault(&format!(
                "point {point} is missing; the control would keep an older value"
            ))),
        };
        let numbers = self.table.values.iter().enumerate().map(number);
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
        self.check_closed(&numbers)?;
        Ok(numbers)
    }

    fn check_grid(&self) -> Emulated<()> {
        let points = self.table.values.len();
        let tolerance = if self.table.modulo { MODULO_RATIO_TOLERANCE } else { RATIO_TOLERANCE };
        let ratio = self.table.grid.steps();
        let off = (ratio + 1.0 - points as f64).abs();
        if points < 2 || off.is_nan() || off >= tolerance {
            return Err(self.fault(&format!("has {points} points, but (MAX-MIN)/STEP is {ratio}")));
        }
        if u32::try_from(points).map_or(true, |points| points > self.most_points) {
            let most = self.most_points;
            return Err(self.fault(&format!("has {points} points, the control holds {most}")));
        }
        Ok(())
    }

    fn check_closed(&self, numbers: &[f64]) -> Emulated<()> {
        if !self.table.modulo {
            return Ok(());
        }
        if self.unit == ControlUnit::Inch {
            let why = "repeats; the scale of its positions on an inch control is not documented";
            return Err(self.fault(why));
        }
        match (numbers.first(), numbers.last()) {
            (Some(first), Some(last)) if (first - last).abs() > 0.0 => Err(self.fault(&format!(
                "repeats, but its values at both ends differ ({first} µm and {last} µm)"
            ))),
            _ => Ok(()),
        }
    }

    fn nodes(&self, corrections: &[Correction]) -> Emulated<NodeTable> {
        let in_mm = |length: f64| Millimetres::new(length * self.unit.in_mm());
        let (start, step) = (in_mm(self.table.grid.min), in_mm(self.table.grid.step));
        let nodes = NodeTable::new(start, step, corrections, Between::Linear)
            .ok_or_else(|| self.fault("has no usable grid"))?;
        Ok(if self.table.modulo { nodes.repeating() } else { nodes })
    }

    fn fault(&self, what: &str) -> CannotEmulate {
        CannotEmulate(format!("${}: {what}", self.table.place))
    }
}

#[cfg(test)]
mod tests;
