//! No particular control: facts of the generic table (docs/interface.md §4.1), whose files are not declared line by line
//! but fixed, and of what is typed in from it.

use super::fact::{Fact, Facts, Outside};
use super::family::Family;
use crate::control::table::{ListedTables, Tables};
use crate::text::{LengthUnit, Word, section, words};

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
        pub unit as typed_unit: Fact<LengthUnit> = stated(), must;
    }
}

impl Typed {
    /// The column of a typed list that holds the values.
    pub(crate) fn column(&self) -> String {
        format!("{}_{}", self.value.value.word(), self.unit.value.word())
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
    }
}

impl TypedValue {
    /// What it is, for the person who types it.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            TypedValue::Deviation => "deviation of the machine (actual − commanded)",
            TypedValue::Correction => "correction, which the control adds",
            TypedValue::Increment => "change of the correction from the point before, from − to +",
        }
    }
}

impl Word for LengthUnit {
    const WORDS: &'static [(&'static str, LengthUnit)] =
        &[("um", LengthUnit::Um), ("mm", LengthUnit::Mm)];
}
