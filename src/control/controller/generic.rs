//! No particular control: facts of the generic table (docs/interface.md §4.1), whose files are not declared line by line
//! but fixed, and of what is typed in from it.

use super::fact::{Fact, Facts, Outside};
use super::family::Family;
use super::form::Size;
use crate::control::table::{ListedTables, Tables};
use crate::text::{section, words};

pub(super) static FAMILY: Family = Family {
    word: "generic",
    backlash_parameter: "backlash parameter",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Listed(ListedTables::NONE),
    off: "removed",
    restarts: true,
    proofs: &[],
};

section! {
    /// What a person types into the control. The generic table carries deviation, correction and increment, so no
    /// sign has to be assumed.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Typed(facts: &Facts<'_>) {
        /// What it is.
        pub value as typed_value: Fact<TypedValue> = stated(), must;
        /// In which unit its screen takes it.
        pub unit as typed_unit: Fact<Size> = stated(), must;
        /// Its decimals, where the control fixes them; `None` = multiples of the detection unit.
        pub decimals as value_decimals: Option<Fact<u32>> = if_stated();
        /// A point has one value for both directions.
        pub one_for_both: Option<Fact<bool>> = if_stated();
    }
}

impl Typed {
    /// The column of a typed list that holds the values.
    pub(crate) fn column(&self) -> String {
        format!("{}_{}", self.value.value.word(), self.unit_word())
    }

    /// The unit of the values, in the name of that column.
    pub(crate) fn unit_word(&self) -> &'static str {
        self.unit.value.word().unwrap_or("count")
    }

    /// Each direction can have a table. Increments do not hold what a second one has at the reference.
    pub fn takes_directions(&self) -> bool {
        let is_one = self.one_for_both.as_ref().is_some_and(|own| own.value);
        !is_one && !self.value.value.is_increment()
    }

    /// Tables hold the numbers that are typed: counts, or with the decimals of the control. Else they hold µm.
    pub(crate) fn is_held(&self) -> bool {
        self.decimals.is_some() || self.unit.value.word().is_none()
    }

    /// Size of 1 in a table.
    pub(super) fn size(&self) -> Size {
        if self.is_held() { self.unit.value } else { Size::fixed(1.0) }
    }
}

words! {
    /// What a person types into a control that reads no file.
    pub enum TypedValue {
        /// The machine's error.
        Deviation = "deviation",
        /// What the control adds.
        Correction = "correction",
        /// Its change from the point before.
        Increment = "increment",
        /// The same, each change at the end of its section that is away from the reference.
        Outward = "outward_increment",
    }
}

impl TypedValue {
    /// Whether it is a change, zero where nothing is said of it.
    pub(crate) const fn is_increment(self) -> bool {
        matches!(self, TypedValue::Increment | TypedValue::Outward)
    }

    /// What it is, for the person who types it.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            TypedValue::Deviation => "deviation of the machine (actual − commanded)",
            TypedValue::Correction => "correction, which the control adds",
            TypedValue::Increment => "change of the correction from the point before, from − to +",
            TypedValue::Outward => {
                "change of the correction, from − to +, over the section that ends at the point, seen from the reference"
            }
        }
    }
}
