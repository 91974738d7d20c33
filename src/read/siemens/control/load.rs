//! Tables as the files hold them, checked and brought to millimetres and micrometres.
//!
//! What the documents leave open (a missing point, a grid that does not fit, a chain of factor
//! tables) ends here, so that the control itself only computes.

use crate::control::controller::{LengthUnit, SiemensFacts};
use crate::control::table::siemens::{CecDirection, CecTable, LecTable, SiemensGrid};
use crate::quantity::units::{Correction, Millimetres, UM_PER_MM};
use crate::read::emulate::{Between, CannotEmulate, NodeTable};

/// (MAX−MIN)/STEP may differ this much from the index of the last point, in steps; STEP is
/// rounded in real files.
const RATIO_TOLERANCE: f64 = 1e-3;
/// The same for repeating tables, where the difference adds up with every turn.
const MODULO_RATIO_TOLERANCE: f64 = 1e-6;

/// A checked ENC_COMP table.
#[derive(Clone, Debug)]
pub(super) struct LoadedLec {
    pub(super) encoder: u32,
    pub(super) axis: String,
    pub(super) corrections: NodeTable,
}

/// A checked CEC table.
#[derive(Clone, Debug)]
pub(super) struct LoadedCec {
    pub(super) number: u32,
    pub(super) input: String,
    pub(super) output: String,
    pub(super) direction: CecDirection,
    /// The numbers of the file, in µm of table sense, for sums and products.
    pub(super) numbers: NodeTable,
    /// The same with their effect on the axis.
    pub(super) corrections: NodeTable,
    /// Largest number without its sign, µm.
    pub(super) peak_um: f64,
    /// Index in `SiemensControl::cec` of the table it is multiplied by.
    pub(super) factor: Option<usize>,
    /// Another table is multiplied by this one.
    pub(super) is_factor: bool,
}

/// A table as the file holds it, whichever kind it is.
struct Raw<'a> {
    name: String,
    grid: SiemensGrid,
    values: &'a [Option<f64>],
    modulo: bool,
    most_points: u32,
    unit: LengthUnit,
}

/// Checks an ENC_COMP table and turns its numbers into corrections.
pub(super) fn load_lec(
    table: &LecTable,
    facts: &SiemensFacts,
    unit: LengthUnit,
) -> Result<LoadedLec, CannotEmulate> {
    let raw = Raw {
        name: format!("$AA_ENC_COMP[{},{}]", table.encoder, table.axis),
        grid: table.grid,
        values: &table.values,
        modulo: table.modulo,
        most_points: facts.lec_points.value,
        unit,
    };
    let sign = facts.lec_sign.value;
    Ok(LoadedLec {
        encoder: table.encoder,
        axis: table.axis.clone(),
        corrections: raw.nodes(&raw.numbers_um()?, |um| sign.correction(um))?,
    })
}

/// Checks a CEC table and turns its numbers into corrections.
pub(super) fn load_cec(
    table: &CecTable,
    facts: &SiemensFacts,
    unit: LengthUnit,
) -> Result<LoadedCec, CannotEmulate> {
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
        number: table.number,
        input: table.input_axis.clone(),
        output: table.output_axis.clone(),
        direction: table.direction,
        numbers: raw.nodes(&numbers_um, Correction::from_um)?,
        corrections: raw.nodes(&numbers_um, |um| sign.correction(um))?,
        peak_um: numbers_um.iter().fold(0.0, |peak, um| um.abs().max(peak)),
        factor: None,
        is_factor: false,
    })
}

impl Raw<'_> {
    /// The numbers in µm, in table sense; fails if one is missing or the grid does not fit.
    fn numbers_um(&self) -> Result<Vec<f64>, CannotEmulate> {
        self.check_grid()?;
        let um_per_unit = self.unit.in_mm() * UM_PER_MM;
        let number = |(point, value): (usize, &Option<f64>)| match value {
            Some(value) if value.is_finite() => Ok(value * um_per_unit),
            Some(_) => Err(self.fault(&format!("point {point} is not a number"))),
            None => Err(self.fault(&format!(
                "point {point} is missing; the control would keep an older value"
            ))),
        };
        let numbers = self.values.iter().enumerate().map(number);
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
        self.check_closed(&numbers)?;
        Ok(numbers)
    }

    #[allow(
        clippy::cast_precision_loss,
        reason = "a table has far fewer than 2^52 points"
    )]
    fn check_grid(&self) -> Result<(), CannotEmulate> {
        let SiemensGrid { min, step, max } = self.grid;
        let points = self.values.len();
        if !(step > 0.0 && max > min && (max - min).is_finite() && points >= 2) {
            return Err(self.fault("needs STEP above 0, MAX above MIN and two points"));
        }
        let tolerance = if self.modulo {
            MODULO_RATIO_TOLERANCE
        } else {
            RATIO_TOLERANCE
        };
        let ratio = (max - min) / step;
        if (ratio - (points - 1) as f64).abs() >= tolerance {
            return Err(self.fault(&format!(
                "has {points} points, but (MAX-MIN)/STEP is {ratio}"
            )));
        }
        if u32::try_from(points).map_or(true, |points| points > self.most_points) {
            let most = self.most_points;
            return Err(self.fault(&format!("has {points} points, the control holds {most}")));
        }
        Ok(())
    }

    fn check_closed(&self, numbers: &[f64]) -> Result<(), CannotEmulate> {
        if !self.modulo {
            return Ok(());
        }
        if self.unit == LengthUnit::Inch {
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
    ) -> Result<NodeTable, CannotEmulate> {
        let corrections: Vec<Correction> = numbers_um.iter().map(|um| correction(*um)).collect();
        let in_mm = |length: f64| Millimetres::new(length * self.unit.in_mm());
        let (start, step) = (in_mm(self.grid.min), in_mm(self.grid.step));
        let table = NodeTable::new(start, step, &corrections, Between::Linear)
            .ok_or_else(|| self.fault("has no usable grid"))?;
        Ok(if self.modulo {
            table.repeating()
        } else {
            table
        })
    }

    fn fault(&self, what: &str) -> CannotEmulate {
        CannotEmulate(format!("{}: {what}", self.name))
    }
}

/// Connects tables with their factor tables. A table may be multiplied by itself; any other
/// chain is refused, the manuals do not say how deep the control follows it.
pub(super) fn link_factors(
    tables: &[CecTable],
    loaded: &mut [LoadedCec],
    unit: LengthUnit,
) -> Result<(), CannotEmulate> {
    for (index, table) in tables.iter().enumerate() {
        let Some(number) = table.multiply_by.checked_sub(1) else {
            continue;
        };
        let name = format!("$AN_CEC[{}]", table.number);
        let Some(factor) = tables.iter().position(|other| other.number == number) else {
            let message = format!("{name} is multiplied by $AN_CEC[{number}], which no file holds");
            return Err(CannotEmulate(message));
        };
        if factor != index && tables[factor].multiply_by != 0 {
            let message = format!("{name} and its factor $AN_CEC[{number}] form a chain");
            return Err(CannotEmulate(message));
        }
        if unit == LengthUnit::Inch {
            let message =
                format!("{name}: products of tables on an inch control have no settled unit");
            return Err(CannotEmulate(message));
        }
        loaded[index].factor = Some(factor);
        loaded[factor].is_factor |= factor != index;
    }
    Ok(())
}
