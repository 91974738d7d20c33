//! Siemens tables: `$AA_ENC_COMP` (one axis corrects itself) and `$AN_CEC` (one axis corrects
//! another, or itself depending on direction). docs/siemens.md §2.1, §2.2.
//!
//! Positions and values are in the control's basic unit (mm or inch), as in the file.

use crate::quantity::Direction;
use std::collections::BTreeMap;
use std::fmt;

/// The grid of a table: `min`, `min + step`, … `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiemensGrid {
    /// Position of point 0.
    pub min: f64,
    /// Distance of two points.
    pub step: f64,
    /// Position of the last point.
    pub max: f64,
}

/// (MAX−MIN)/STEP may differ this much from a whole number, in steps. Real files round STEP:
/// 770 / 19.7436 = 38.99998.
const WHOLE: f64 = 1e-3;

impl SiemensGrid {
    /// (MAX−MIN)/STEP.
    pub fn steps(&self) -> f64 {
        (self.max - self.min) / self.step
    }

    /// Whether the last point lies on MAX.
    pub(crate) fn is_whole(&self) -> bool {
        (self.steps() - self.steps().round()).abs() < WHOLE
    }

    /// Index of the last point that does not lie behind MAX; 0 where there is none.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a cast from a float holds the nearest number that fits"
    )]
    pub(crate) fn last_whole_point(&self) -> u32 {
        (self.steps() + WHOLE).floor() as u32
    }

    /// Position of a point.
    pub fn position(&self, index: usize) -> f64 {
        self.min + index as f64 * self.step
    }

    /// Value of the point nearest to a position; beyond the table that of its end, which is held.
    pub fn nearest(&self, values: &[Option<f64>], position: f64) -> Option<f64> {
        let distance = |index: &usize| (self.position(*index) - position).abs();
        let nearest = (0..values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        values[nearest]
    }
}

/// A grid whose MAX lies between two points, as real controls hold it, and what is not known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenEnd {
    /// The last point that does not lie behind MAX.
    pub point: u32,
    /// Its position.
    pub from: f64,
    /// What the table would differ by at MAX if the control went on towards the next point, in the unit
    /// of the file without sign; `None` where no file holds that point.
    pub differs_by: Option<f64>,
}

/// Where a table stands in the control: tables of ENC_COMP first, in the order of their axes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// `$AA_ENC_COMP[e,N,axis]`, measuring-system error compensation.
    Lec {
        /// Name of the axis, upper case.
        axis: String,
        /// Index of the measuring system in the file: 0 = first, 1 = second.
        encoder: u32,
    },
    /// `$AN_CEC[t,N]`, cross-error compensation: table index t, from 0.
    Cec(u32),
}

impl Place {
    /// What stands in brackets: `0,AX1` or `3`.
    pub fn index(&self) -> String {
        match self {
            Place::Lec { axis, encoder } => format!("{encoder},{axis}"),
            Place::Cec(number) => number.to_string(),
        }
    }

    /// Axis and measuring system of an ENC_COMP table.
    pub fn lec(&self) -> Option<(&String, u32)> {
        match self {
            Place::Lec { axis, encoder } => Some((axis, *encoder)),
            Place::Cec(_) => None,
        }
    }

    /// The number of a CEC table.
    pub fn cec(&self) -> Option<u32> {
        match self {
            Place::Lec { .. } => None,
            Place::Cec(number) => Some(*number),
        }
    }

    /// What people call its table: `ENC_COMP[0,AX1]`, `CEC table 3`.
    pub(crate) fn name(&self) -> String {
        match self {
            Place::Lec { .. } => format!("ENC_COMP[{}]", self.index()),
            Place::Cec(number) => format!("CEC table {number}"),
        }
    }
}

/// As files write it behind `$`: `AA_ENC_COMP[0,AX1]`, `AN_CEC[3]`.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let array = if self.cec().is_some() { "AN_CEC" } else { "AA_ENC_COMP" };
        write!(f, "{array}[{}]", self.index())
    }
}

/// A table of ENC_COMP or CEC.
#[derive(Clone, Debug, PartialEq)]
pub struct SiemensTable {
    /// Where it stands.
    pub place: Place,
    /// Name of the base axis, upper case; of ENC_COMP the axis itself.
    pub input_axis: String,
    /// Name of the corrected axis, upper case; of ENC_COMP the axis itself.
    pub output_axis: String,
    /// The grid on the base axis.
    pub grid: SiemensGrid,
    /// Value of each point from index 0; `None` where the file does not write it (the control
    /// would keep what it holds).
    pub values: Vec<Option<f64>>,
    /// While the base axis moves so alone (`$AN_CEC_DIRECTION`: 1, -1); `None` = 0, whichever way it moves.
    pub direction: Option<Direction>,
    /// `$AN_CEC_MULT_BY_TABLE`: index + 1 of the factor table; 0 = none.
    pub multiply_by: u32,
    /// `$AA_ENC_COMP_IS_MODULO`, `$AN_CEC_IS_MODULO`.
    pub modulo: bool,
}

impl SiemensTable {
    /// Leaves grid and values as they are taken to act; gives the open end: where MAX lies between two points,
    /// the value of the last one before it is held.
    ///
    /// limits no available manual says what a control does there
    pub fn close(&mut self) -> Option<OpenEnd> {
        if self.grid.is_whole() {
            return None;
        }
        let point = self.grid.last_whole_point();
        let last = usize::try_from(point).unwrap_or(usize::MAX - 1);
        let at = |index: usize| self.values.get(index).copied().flatten();
        let from = self.grid.position(last);
        let part = (self.grid.max - from) / self.grid.step;
        let next = at(last + 1).zip(at(last));
        let differs_by = next.map(|(next, last)| (next - last).abs() * part);
        self.grid.max = from;
        self.values.truncate(last + 1);
        Some(OpenEnd { point, from, differs_by })
    }

    /// Whether it acts while the base axis moves so.
    pub(crate) fn acts_in(&self, direction: Direction) -> bool {
        self.direction.is_none_or(|own| own == direction)
    }

    /// `$AN_CEC_DIRECTION` as files write it.
    pub fn direction_text(&self) -> &'static str {
        match self.direction {
            None => "0",
            Some(Direction::Plus) => "1",
            Some(Direction::Minus) => "-1",
        }
    }
}

/// One `$MA_`, `$MN_` or `$SN_` assignment.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineDatum {
    /// As files write it: `$MA_BACKLASH[0,AX1]`; whole numbers without leading zeros, names in upper case.
    pub variable: String,
    /// The value.
    pub value: MachineValue,
}

/// Value of a machine or setting datum, in the control's own unit.
#[derive(Clone, Debug, PartialEq)]
pub enum MachineValue {
    /// A number; `TRUE` is 1 and `FALSE` is 0.
    Number(f64),
    /// A name in parentheses or quotes, upper case.
    Text(String),
}

impl MachineValue {
    /// The number.
    pub(crate) fn number(&self) -> Option<f64> {
        match self {
            MachineValue::Number(number) => Some(*number),
            MachineValue::Text(_) => None,
        }
    }
}

impl fmt::Display for MachineValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MachineValue::Number(number) => write!(f, "{number}"),
            MachineValue::Text(text) => f.write_str(text),
        }
    }
}

/// The compensation in a control: its tables, and what stands beside them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiemensTables {
    /// Ascending by place.
    pub tables: Vec<SiemensTable>,
    /// Machine and setting data in the order of their first assignment, with their last value; none of a kit, which
    /// switches on and off.
    pub data: Vec<MachineDatum>,
    /// Tables that the control reserves without a usable grid, such as `AN_CEC[3]`.
    pub reserved: Vec<String>,
}

impl SiemensTables {
    /// No table.
    pub(crate) const NONE: SiemensTables =
        SiemensTables { tables: Vec::new(), data: Vec::new(), reserved: Vec::new() };

    /// Tables in any order.
    pub fn of(mut tables: Vec<SiemensTable>) -> SiemensTables {
        tables.sort_by(|a, b| a.place.cmp(&b.place));
        SiemensTables { tables, ..SiemensTables::NONE }
    }

    /// What is held of a variable.
    pub(crate) fn datum(&self, variable: &str) -> Option<&MachineDatum> {
        self.data.iter().find(|datum| datum.variable == variable)
    }

    /// Sets a datum; gives the value that it had.
    pub(crate) fn set(&mut self, datum: MachineDatum) -> Option<MachineValue> {
        match self.data.iter_mut().find(|known| known.variable == datum.variable) {
            Some(known) => Some(std::mem::replace(&mut known.value, datum.value)),
            None => {
                self.data.push(datum);
                None
            }
        }
    }

    /// The table at a place.
    pub fn at(&self, place: &Place) -> Option<&SiemensTable> {
        self.tables.iter().find(|table| table.place == *place)
    }

    /// ENC_COMP tables.
    pub fn lec(&self) -> impl Iterator<Item = &SiemensTable> {
        self.tables.iter().filter(|table| table.place.cec().is_none())
    }

    /// CEC tables.
    pub fn cec(&self) -> impl Iterator<Item = &SiemensTable> {
        self.tables.iter().filter(|table| table.place.cec().is_some())
    }

    /// The axes that CEC tables correct, each once.
    pub(crate) fn cec_outputs(&self) -> Vec<String> {
        let mut outputs: Vec<String> = self.cec().map(|table| table.output_axis.clone()).collect();
        outputs.sort_unstable();
        outputs.dedup();
        outputs
    }

    /// Largest sum of CEC corrections of an output axis ([`largest_sum`]).
    ///
    /// unit   as in the file
    pub(crate) fn largest_cec_sum(&self, output: &str) -> f64 {
        let largest = |table: &SiemensTable| {
            let values = table.values.iter().flatten().map(|value| value.abs());
            values.fold(0.0, f64::max)
        };
        let own = self.cec().filter(|table| table.output_axis == output);
        largest_sum(own.map(|table| (table, largest(table))))
    }
}

/// Largest sum of tables of one output axis with their largest values, in any unit: those that act together, the worse
/// direction of each base axis, added up over the base axes. A bound, not a place.
pub(crate) fn largest_sum<'a>(tables: impl Iterator<Item = (&'a SiemensTable, f64)>) -> f64 {
    let mut of_base: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
    for (table, largest) in tables {
        let ways = of_base.entry(&table.input_axis).or_default().iter_mut();
        let acting = ways.zip(Direction::BOTH).filter(|(_, way)| table.acts_in(*way));
        acting.for_each(|(sum, _)| *sum += largest);
    }
    of_base.values().map(|[plus, minus]| plus.max(*minus)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_that_act_together_add_up() {
        let table = |number, direction, value| SiemensTable {
            place: Place::Cec(number),
            input_axis: "AX1".to_string(),
            output_axis: "AX2".to_string(),
            grid: SiemensGrid { min: 0.0, step: 50.0, max: 50.0 },
            values: vec![Some(0.0), Some(value)],
            direction,
            multiply_by: 0,
            modulo: false,
        };
        let sum = |tables: Vec<SiemensTable>| SiemensTables::of(tables).largest_cec_sum("AX2");
        let (plus, minus) = (Some(Direction::Plus), Some(Direction::Minus));
        let one_each_way = sum(vec![table(0, plus, -0.004), table(1, minus, 0.003)]);
        let twice = sum(vec![table(0, plus, -0.004), table(1, plus, 0.003), table(2, None, 0.001)]);
        assert!((one_each_way - 0.004).abs() < 1e-12 && (twice - 0.008).abs() < 1e-12);
    }
}
