//! What the numbers of tables say whose points stand one by one, whichever control holds them.

use super::fact::{ControlUnit, FactValue, Outside, TableSign};
use crate::control::table::ListedTable;
use crate::text::{LengthUnit, Section, words};

words! {
    /// In which form a number of a table says what it says.
    pub enum ValueForm {
        /// Error or correction itself.
        Amount = "amount",
        /// The position that error or correction leads to.
        Position = "position",
        /// Its change from the point before.
        Increment = "increment",
    }
}

words! {
    /// The order of the points in a file.
    pub enum Order {
        /// From − to +.
        Ascending = "ascending",
        /// From + to −.
        Descending = "descending",
    }
}

/// What values are rounded to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rounding {
    /// The last decimal.
    LastDecimal,
    /// Multiples of this many µm.
    Multiple(f64),
    /// Nothing.
    None,
}

/// Size of 1 in a file: a unit of length, or counts of any size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Micrometres; of counts of an axis, its detection units.
    pub um: f64,
    /// It counts in the detection unit of the corrected axis.
    pub is_of_axis: bool,
}

impl Size {
    /// The same on every axis.
    pub const fn fixed(um: f64) -> Size {
        Size { um, is_of_axis: false }
    }

    /// The size of a unit of length by its word, in capitals or not.
    pub(crate) fn of_word(word: &str) -> Option<Size> {
        let mut all = SIZES.iter();
        Some(all.find(|(own, _)| own.eq_ignore_ascii_case(word))?.1)
    }

    /// The word of a unit of length; `None` = counts.
    pub(crate) fn word(self) -> Option<&'static str> {
        SIZES.iter().find(|(_, own)| *own == self && !own.is_of_axis).map(|(word, _)| *word)
    }
}

impl FactValue for Size {
    fn read(fact: &Section<'_>) -> Option<Self> {
        if !fact.as_written("value").is_some_and(|v| v.starts_with(['"', '\''])) {
            return fact.positive("value").map(Size::fixed);
        }
        let in_units = |text: String| {
            let times: f64 = text.strip_suffix(" detection_unit")?.parse().ok()?;
            (1e-6..=1e6).contains(&times).then_some(Size { um: times, is_of_axis: true })
        };
        fact.text("value").and_then(in_units).or_else(|| fact.choice("value", SIZES))
    }
}

const SIZES: &[(&str, Size)] = &[
    ("mm", Size::fixed(LengthUnit::Mm.um())),
    ("um", Size::fixed(LengthUnit::Um.um())),
    ("inch", Size::fixed(LengthUnit::In.um())),
    ("detection_unit", Size { um: 1.0, is_of_axis: true }),
];

/// What the numbers of a table mean. One that writes a table and one that emulates it share nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// Sense of the values.
    pub sign: TableSign,
    /// In which form a number says it.
    pub value: ValueForm,
    /// Size of 1 of a value, µm.
    pub value_um: f64,
    /// That is in detection units of the corrected axis still ([`Form::on_axis`]).
    pub is_of_axis: bool,
    /// Decimals of values.
    pub value_decimals: u32,
    /// What they are rounded to; one count is that.
    pub rounding: Rounding,
    /// Largest number that the control takes, either sign, as in the file.
    pub largest: f64,
    /// Size of 1 of a position, µm.
    pub position_um: f64,
    /// Decimals of positions.
    pub position_decimals: u32,
    /// Order of the points.
    pub order: Order,
    /// A column for each direction of travel.
    pub has_two: bool,
    /// What the control adds outside the table.
    pub outside: Outside,
    /// Whether a point may lie behind the end of the travel.
    pub beyond_travel: bool,
    /// A column for − that is zero everywhere stands for that for +.
    pub zero_reverse_is_forward: bool,
    /// The control holds what it adds as a C float.
    pub is_float: bool,
    /// One number in place of points: what is added in a mm, zero at the reference.
    pub is_factor: bool,
    /// The file says of each table which error it is for.
    pub names_terms: bool,
}

impl Form {
    /// The same on an axis with this detection unit.
    pub(crate) fn on_axis(self, detection_unit_um: f64) -> Form {
        let times = if self.is_of_axis { detection_unit_um } else { 1.0 };
        Form { value_um: self.value_um * times, is_of_axis: false, ..self }
    }

    /// Decimals of the numbers of a table.
    pub(crate) fn decimals(&self) -> u32 {
        match self.value {
            ValueForm::Position => self.value_decimals.max(self.position_decimals),
            ValueForm::Amount | ValueForm::Increment => self.value_decimals,
        }
    }

    /// Positions are in inch.
    pub(crate) fn is_inch(&self) -> bool {
        (self.position_um - LengthUnit::In.um()).abs() < f64::EPSILON
    }

    /// What values are rounded to, µm; 0 = nothing.
    pub(crate) fn count_um(&self) -> f64 {
        match self.rounding {
            Rounding::LastDecimal => {
                self.value_um / crate::quantity::power_of_ten(self.value_decimals)
            }
            Rounding::Multiple(um) => um,
            Rounding::None => 0.0,
        }
    }
}

/// A control whose tables list their points one by one.
pub(crate) trait PointLists {
    /// What the numbers mean of the table of an axis for itself, or of one that follows another, on a control with
    /// this unit.
    fn form(&self, is_own: bool, unit: ControlUnit) -> Form;

    /// Whether the table of an axis for itself stands in place of its backlash parameter.
    fn replaces_parameter(&self) -> bool;

    /// What people call a table.
    fn table_name(&self, table: &ListedTable) -> String;
}
