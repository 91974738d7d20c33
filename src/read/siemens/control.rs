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
use crate::control::table::siemens::{CecDirection, CecTable, SiemensGrid, SiemensTables};
use crate::quantity::axis::Direction;
use crate::quantity::units::{Correction, Millimetres, UM_PER_MM};
use crate::read::emulate::{Between, CannotEmulate, Emulated, Emulator, NodeTable, Response};

/// (MAX−MIN)/STEP may differ this much from the index of the last point, in steps; STEP is
/// rounded in real files.
const RATIO_TOLERANCE: f64 = 1e-3;
/// The same for repeating tables, where the difference adds up with every turn.
const MODULO_RATIO_TOLERANCE: f64 = 1e-6;

/// A control of the Siemens family with its tables in memory.
#[derive(Clone, Debug)]
pub struct SiemensControl {
    lec: Vec<LoadedLec>,
    cec: Vec<LoadedCec>,
    axes: Vec<AxisState>,
    facts: SiemensFacts,
    um_per_unit: f64,
}

/// A checked ENC_COMP table.
#[derive(Clone, Debug)]
struct LoadedLec {
    encoder: u32,
    axis: String,
    corrections: NodeTable,
}

/// A checked CEC table.
#[derive(Clone, Debug)]
struct LoadedCec {
    name: String,
    input: String,
    output: String,
    direction: CecDirection,
    corrections: NodeTable,
    /// Largest number without its sign, µm.
    peak_um: f64,
    /// Index of the table it is multiplied by.
    factor: Option<usize>,
    /// Another table is multiplied by this one.
    is_factor: bool,
}

impl LoadedCec {
    fn acts_in(&self, direction: Direction) -> bool {
        match self.direction {
            CecDirection::Both => true,
            CecDirection::Plus => direction == Direction::Plus,
            CecDirection::Minus => direction == Direction::Minus,
        }
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
        let mut lec = Vec::new();
        for table in &tables.lec {
            let raw = Raw {
                name: format!("$AA_ENC_COMP[{},{}]", table.encoder, table.axis),
                grid: table.grid,
                values: &table.values,
                modulo: table.modulo,
                most_points: facts.lec_points.value,
                unit: state.unit,
            };
            let sign = facts.lec_sign.value;
            lec.push(LoadedLec {
                encoder: table.encoder,
                axis: table.axis.clone(),
                corrections: raw.nodes(&raw.numbers_um()?, |um| sign.correction(um))?,
            });
        }
        let load = |table: &CecTable| load_cec(table, facts, state.unit);
        let mut cec: Vec<LoadedCec> = tables.cec.iter().map(load).collect::<Result<_, _>>()?;
        link_factors(&tables.cec, &mut cec, state.unit)?;
        Ok(SiemensControl {
            lec,
            cec,
            axes: state.axes.clone(),
            facts: facts.clone(),
            um_per_unit: state.unit.in_mm() * UM_PER_MM,
        })
    }

    fn axis(&self, name: &str) -> Emulated<&AxisState> {
        let found = self.axes.iter().find(|axis| same(&axis.name, name));
        found.ok_or_else(|| CannotEmulate(format!("the control has no axis `{name}`")))
    }

    fn lec_of(&self, axis: &str) -> Emulated<Option<&LoadedLec>> {
        let mut of_axis = self.lec.iter().filter(|table| same(&table.axis, axis));
        match (of_axis.next(), of_axis.next()) {
            (Some(first), Some(second)) => Err(CannotEmulate(format!(
                "axis {axis} has tables for the measuring systems {} and {}; which one acts is \
                 not in the files",
                first.encoder, second.encoder
            ))),
            (first, _) => Ok(first),
        }
    }

    /// Tables that add to an axis by themselves.
    fn cec_of(&self, output: &str) -> impl Iterator<Item = &LoadedCec> {
        let contributes =
            |table: &LoadedCec| !table.is_factor || self.facts.factor_contributes.value;
        let tables = self.cec.iter();
        tables.filter(move |table| same(&table.output, output) && contributes(table))
    }

    /// A product of tables has no response of one base axis alone.
    fn refuse_products(&self, base: &str, output: &str) -> Emulated<()> {
        let takes_part = |table: &&LoadedCec| {
            let factor = table.factor.map(|index| &self.cec[index]);
            let is_product = table.is_factor || factor.is_some();
            let from_base =
                same(&table.input, base) || factor.is_some_and(|factor| same(&factor.input, base));
            is_product && from_base && same(&table.output, output)
        };
        match self.cec.iter().find(takes_part) {
            None => Ok(()),
            Some(table) => Err(CannotEmulate(format!(
                "{} takes part in a product of tables, which depends on more than one axis",
                table.name
            ))),
        }
    }

    /// The clamp acts on the sum over all base axes, so no single response can show it.
    fn refuse_clamp(&self, output: &str) -> Emulated<()> {
        let largest = self.largest_cec_um(output);
        let limit = self.facts.cec_max_sum_um.value;
        if largest <= limit {
            return Ok(());
        }
        Err(CannotEmulate(format!(
            "the CEC tables of axis {output} can add up to {largest:.1} µm, more than \
             CEC_MAX_SUM of {limit:.1} µm; the control would cut their sum: check their scale \
             (µm taken for mm?)"
        )))
    }

    /// A bound of the CEC sum of an axis, µm: peaks added over all base axes, the worse direction
    /// of each.
    fn largest_cec_um(&self, output: &str) -> f64 {
        let mut bases: Vec<&str> = self.cec_of(output).map(|t| t.input.as_str()).collect();
        bases.sort_unstable();
        bases.dedup();
        let of_base = |base: &str, direction| -> f64 {
            self.cec_of(output)
                .filter(|table| table.input == base && table.acts_in(direction))
                .map(|table| self.peak_um(table))
                .sum()
        };
        bases
            .iter()
            .map(|base| of_base(base, Direction::Plus).max(of_base(base, Direction::Minus)))
            .sum()
    }

    fn peak_um(&self, table: &LoadedCec) -> f64 {
        let Some(index) = table.factor else {
            return table.peak_um;
        };
        let product = table.peak_um * self.cec[index].peak_um / self.um_per_unit;
        match self.facts.multiply_mode.value {
            MultiplyMode::Product => product,
            MultiplyMode::Additive => table.peak_um + product,
        }
    }
}

impl Emulator for SiemensControl {
    fn connected_axes(&self) -> Vec<(String, String)> {
        let own = self.lec.iter().map(|t| (t.axis.clone(), t.axis.clone()));
        let cross = self.cec.iter().map(|t| (t.input.clone(), t.output.clone()));
        let through_factor = self.cec.iter().filter_map(|table| {
            let factor = &self.cec[table.factor?];
            Some((factor.input.clone(), table.output.clone()))
        });
        let mut pairs: Vec<_> = own.chain(cross).chain(through_factor).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    fn response(&self, base: &str, output: &str, direction: Direction) -> Emulated<Response> {
        self.refuse_products(base, output)?;
        let acting = self.cec_of(output);
        let acting = acting.filter(|table| same(&table.input, base) && table.acts_in(direction));
        let mut tables: Vec<NodeTable> = acting.map(|table| table.corrections.clone()).collect();
        if !tables.is_empty() {
            self.refuse_clamp(output)?;
        }
        let mut constant = Correction::ZERO;
        if same(base, output) {
            let own = self.lec_of(base)?.map(|lec| lec.corrections.clone());
            tables.splice(0..0, own);
            constant = self.axis(base)?.backlash(direction);
        }
        Ok(Response::new(tables, constant))
    }
}

fn load_cec(table: &CecTable, facts: &SiemensFacts, unit: ControlUnit) -> Emulated<LoadedCec> {
    let raw = Raw {
        name: format!("$AN_CEC[{}]", table.number),
        grid: table.grid,
        values: &table.values,
        modulo: table.modulo,
        most_points: facts.cec_points.value,
        unit,
    };
    let most_tables = facts.cec_tables.value;
    if table.number >= most_tables {
        let name = raw.name;
        let message = format!("{name} does not exist, the control has {most_tables} tables");
        return Err(CannotEmulate(message));
    }
    let numbers_um = raw.numbers_um()?;
    let sign = facts.cec_sign.value;
    Ok(LoadedCec {
        input: table.input_axis.clone(),
        output: table.output_axis.clone(),
        direction: table.direction,
        corrections: raw.nodes(&numbers_um, |um| sign.correction(um))?,
        peak_um: numbers_um.iter().fold(0.0, |peak, um| um.abs().max(peak)),
        factor: None,
        is_factor: false,
        name: raw.name,
    })
}

/// Connects tables with their factor tables. A table may be multiplied by itself; any other
/// chain is refused, the manuals do not say how deep the control follows it.
fn link_factors(tables: &[CecTable], loaded: &mut [LoadedCec], unit: ControlUnit) -> Emulated<()> {
    for (index, table) in tables.iter().enumerate() {
        let Some(number) = table.multiply_by.checked_sub(1) else {
            continue;
        };
        let cannot = |what: String| Err(CannotEmulate(format!("$AN_CEC[{}]{what}", table.number)));
        let Some(factor) = tables.iter().position(|other| other.number == number) else {
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

/// A table as the file holds it, whichever kind it is.
struct Raw<'a> {
    name: String,
    grid: SiemensGrid,
    values: &'a [Option<f64>],
    modulo: bool,
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
        let numbers = self.values.iter().enumerate().map(number);
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
        self.check_closed(&numbers)?;
        Ok(numbers)
    }

    fn check_grid(&self) -> Emulated<()> {
        let points = self.values.len();
        let tolerance = if self.modulo { MODULO_RATIO_TOLERANCE } else { RATIO_TOLERANCE };
        let ratio = self.grid.steps();
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
        if !self.modulo {
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

    fn nodes(
        &self,
        numbers_um: &[f64],
        correction: impl Fn(f64) -> Correction,
    ) -> Emulated<NodeTable> {
        let corrections: Vec<Correction> = numbers_um.iter().map(|um| correction(*um)).collect();
        let in_mm = |length: f64| Millimetres::new(length * self.unit.in_mm());
        let (start, step) = (in_mm(self.grid.min), in_mm(self.grid.step));
        let table = NodeTable::new(start, step, &corrections, Between::Linear)
            .ok_or_else(|| self.fault("has no usable grid"))?;
        Ok(if self.modulo { table.repeating() } else { table })
    }

    fn fault(&self, what: &str) -> CannotEmulate {
        CannotEmulate(format!("{}: {what}", self.name))
    }
}

#[cfg(test)]
mod tests;
