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
//! σ is [`TableSign`] of the profile, the only place where a table value gets its sense.
//! Everything that is switched by machine data is taken as switched on, weights as 1.

mod load;

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{LengthUnit, MultiplyMode, SiemensFacts, TableSign};
use crate::control::table::siemens::{CecDirection, CecTable, LecTable, SiemensTables};
use crate::quantity::axis::Direction;
use crate::quantity::units::{Correction, Millimetres, UM_PER_MM};
use crate::read::emulate::{CannotEmulate, Emulator, Response};
use load::{LoadedCec, LoadedLec, link_factors, load_cec, load_lec};

/// A control of the Siemens family with its tables in memory.
#[derive(Clone, Debug)]
pub struct SiemensControl {
    lec: Vec<LoadedLec>,
    cec: Vec<LoadedCec>,
    axes: Vec<AxisState>,
    rules: Rules,
}

/// The profile's facts that act when a correction is computed.
#[derive(Clone, Copy, Debug)]
struct Rules {
    um_per_unit: f64,
    cec_sign: TableSign,
    max_sum_um: f64,
    multiply_mode: MultiplyMode,
    factor_contributes: bool,
}

impl LoadedCec {
    fn name(&self) -> String {
        format!("$AN_CEC[{}]", self.number)
    }

    fn contributes(&self, rules: Rules) -> bool {
        !self.is_factor || rules.factor_contributes
    }

    fn acts_in(&self, direction: Direction) -> bool {
        match self.direction {
            CecDirection::Both => true,
            CecDirection::Plus => direction == Direction::Plus,
            CecDirection::Minus => direction == Direction::Minus,
        }
    }

    /// Its number at the position of its base axis, in the file's unit; 0 while it does not act.
    fn number_at(&self, state: Moment<'_>, rules: Rules) -> Result<f64, CannotEmulate> {
        if self.direction != CecDirection::Both {
            let why = format!("{} depends on direction", self.name());
            if !self.acts_in(state.direction(&self.input, &why)?) {
                return Ok(0.0);
            }
        }
        let at = state.position(&self.input)?;
        Ok(self.numbers.correction(at).um() / rules.um_per_unit)
    }
}

/// Where the axes stand and how they came there.
#[derive(Clone, Copy)]
struct Moment<'a> {
    positions: &'a [(&'a str, Millimetres)],
    directions: &'a [(&'a str, Direction)],
}

impl Moment<'_> {
    fn position(&self, axis: &str) -> Result<Millimetres, CannotEmulate> {
        find(self.positions, axis)
            .ok_or_else(|| CannotEmulate(format!("the position of axis {axis} is not known")))
    }

    fn direction(&self, axis: &str, why: &str) -> Result<Direction, CannotEmulate> {
        find(self.directions, axis).ok_or_else(|| {
            CannotEmulate(format!(
                "{why}, and the direction of axis {axis} is not known"
            ))
        })
    }
}

fn find<T: Copy>(list: &[(&str, T)], axis: &str) -> Option<T> {
    list.iter()
        .find(|(name, _)| name.eq_ignore_ascii_case(axis))
        .map(|(_, value)| *value)
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
    ) -> Result<SiemensControl, CannotEmulate> {
        let rules = rules(facts, state.unit)?;
        let load = |table: &LecTable| load_lec(table, facts, state.unit);
        let lec = tables.lec.iter().map(load).collect::<Result<_, _>>()?;
        let load = |table: &CecTable| load_cec(table, facts, state.unit);
        let mut cec: Vec<LoadedCec> = tables.cec.iter().map(load).collect::<Result<_, _>>()?;
        link_factors(&tables.cec, &mut cec, state.unit)?;
        Ok(SiemensControl {
            lec,
            cec,
            axes: state.axes.clone(),
            rules,
        })
    }

    /// What the control adds to axis `output` while the axes stand at `positions`, having come
    /// there in `directions`.
    ///
    /// **formula** see the module; the clamp acts on the sum of the CEC tables · **unit**
    /// positions in mm of machine coordinates, result in µm · **sign** positive moves the axis
    /// further in + · **source** Function Manual Extended Functions 03/2013, K3 p. 238-252 ·
    /// **limits** fails if a needed position is missing, and if the direction of an axis on which
    /// a directional table or a backlash depends is not known.
    pub fn correction(
        &self,
        output: &str,
        positions: &[(&str, Millimetres)],
        directions: &[(&str, Direction)],
    ) -> Result<Correction, CannotEmulate> {
        let moment = Moment {
            positions,
            directions,
        };
        let mut sum = Correction::ZERO;
        if let Some(lec) = self.lec_of(output)? {
            sum = sum + lec.corrections.correction(moment.position(output)?);
        }
        let limit = self.rules.max_sum_um;
        let cec_um = self.cec_sum_um(output, moment)?.clamp(-limit, limit);
        sum = sum + self.rules.cec_sign.correction(cec_um);
        let axis = self.axis(output)?;
        if axis.backlash_um.abs() > 0.0 {
            let why = format!("axis {output} has a backlash of {} µm", axis.backlash_um);
            sum = sum + axis.backlash(moment.direction(output, &why)?);
        }
        Ok(sum)
    }

    /// Sum of the numbers of all CEC tables that act on `output`, in µm, in table sense.
    fn cec_sum_um(&self, output: &str, moment: Moment<'_>) -> Result<f64, CannotEmulate> {
        let mut sum = 0.0;
        for table in self.cec_of(output) {
            let own = table.number_at(moment, self.rules)?;
            let factor = match table.factor {
                None => None,
                Some(index) => Some(self.cec[index].number_at(moment, self.rules)?),
            };
            sum += match (factor, self.rules.multiply_mode) {
                (None, _) => own,
                (Some(factor), MultiplyMode::Product) => own * factor,
                (Some(factor), MultiplyMode::Additive) => own + own * factor,
            };
        }
        Ok(sum * self.rules.um_per_unit)
    }

    fn axis(&self, name: &str) -> Result<&AxisState, CannotEmulate> {
        self.axes
            .iter()
            .find(|axis| axis.name.eq_ignore_ascii_case(name))
            .ok_or_else(|| CannotEmulate(format!("the control has no axis `{name}`")))
    }

    fn lec_of(&self, axis: &str) -> Result<Option<&LoadedLec>, CannotEmulate> {
        let mut of_axis = self
            .lec
            .iter()
            .filter(|table| table.axis.eq_ignore_ascii_case(axis));
        let first = of_axis.next();
        match (first, of_axis.next()) {
            (Some(first), Some(second)) => Err(CannotEmulate(format!(
                "axis {axis} has tables for the measuring systems {} and {}; which one acts is \
                 not in the files",
                first.encoder, second.encoder
            ))),
            _ => Ok(first),
        }
    }

    /// Tables that add to an axis by themselves.
    fn cec_of(&self, output: &str) -> impl Iterator<Item = &LoadedCec> {
        self.cec.iter().filter(move |table| {
            table.output.eq_ignore_ascii_case(output) && table.contributes(self.rules)
        })
    }

    /// A product of tables has no response of one base axis alone.
    fn refuse_products(&self, base: &str, output: &str) -> Result<(), CannotEmulate> {
        for table in &self.cec {
            let from_base = table.input.eq_ignore_ascii_case(base);
            let to_output = table.output.eq_ignore_ascii_case(output);
            if from_base && to_output && table.is_factor {
                return Err(product(table));
            }
            let Some(factor) = table.factor.map(|index| &self.cec[index]) else {
                continue;
            };
            if to_output && (from_base || factor.input.eq_ignore_ascii_case(base)) {
                return Err(product(table));
            }
        }
        Ok(())
    }

    /// The clamp acts on the sum over all base axes, so no single response can show it.
    fn refuse_clamp(&self, output: &str) -> Result<(), CannotEmulate> {
        let largest = self.largest_cec_um(output);
        let limit = self.rules.max_sum_um;
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
        let product = table.peak_um * self.cec[index].peak_um / self.rules.um_per_unit;
        match self.rules.multiply_mode {
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

    fn response(
        &self,
        base: &str,
        output: &str,
        direction: Direction,
    ) -> Result<Response, CannotEmulate> {
        self.refuse_products(base, output)?;
        let mut tables = Vec::new();
        let mut constant = Correction::ZERO;
        if base.eq_ignore_ascii_case(output) {
            tables.extend(self.lec_of(base)?.map(|lec| lec.corrections.clone()));
            constant = self.axis(base)?.backlash(direction);
        }
        let acting = self
            .cec_of(output)
            .filter(|table| table.input.eq_ignore_ascii_case(base) && table.acts_in(direction));
        let own_tables = tables.len();
        tables.extend(acting.map(|table| table.corrections.clone()));
        if tables.len() > own_tables {
            self.refuse_clamp(output)?;
        }
        Ok(Response::new(tables, constant))
    }
}

fn product(table: &LoadedCec) -> CannotEmulate {
    CannotEmulate(format!(
        "{} takes part in a product of tables, which depends on more than one axis",
        table.name()
    ))
}

fn rules(facts: &SiemensFacts, unit: LengthUnit) -> Result<Rules, CannotEmulate> {
    let max_sum_um = facts.cec_max_sum_um.value;
    if max_sum_um.is_nan() || max_sum_um < 0.0 {
        return Err(CannotEmulate(format!(
            "CEC_MAX_SUM of {max_sum_um} µm is not a limit"
        )));
    }
    Ok(Rules {
        um_per_unit: unit.in_mm() * UM_PER_MM,
        cec_sign: facts.cec_sign.value,
        max_sum_um,
        multiply_mode: facts.multiply_mode.value,
        factor_contributes: facts.factor_contributes.value,
    })
}

#[cfg(test)]
mod tests;
