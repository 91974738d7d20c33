//! No particular control: facts of the generic table (docs/interface.md §4.1).

use super::fact::{Fact, Facts, Outside};
use super::family::Family;
use crate::control::table::Tables;
use crate::control::table::generic::GenericTable;
use crate::text::delimited::LengthUnit;
use crate::text::document::section;
use crate::text::words::{Word, words};

pub(super) static FAMILY: Family = Family {
    word: "generic",
    backlash_parameter: "backlash parameter",
    between: "linear",
    outside: &[Outside::Hold],
    no_tables: Tables::Generic(GenericTable { rows: Vec::new() }),
    off: "removed",
    restarts: true,
    proofs: &[],
};

section! {
    /// Facts of the generic dialect (contract §4.1). Its table carries deviation, correction and
    /// increment, so no sign has to be assumed.
    #[derive(Clone, Debug, PartialEq)]
    pub struct GenericFacts(facts: &Facts<'_>) {
        /// Most points of one table, if the control has a limit.
        pub points: Fact<u32> = stated(), must;
        /// How many other axes an axis can follow.
        pub cross_terms: Fact<u32> = stated(), must;
        /// What a person types into the control.
        pub typed_value: Fact<TypedValue> = stated(), must;
        /// In which unit its screen takes it.
        pub typed_unit: Fact<LengthUnit> = stated(), must;
    }
}

impl GenericFacts {
    /// The column of a typed list that holds the values.
    pub(crate) fn typed_column(&self) -> String {
        let (value, unit) = (self.typed_value.value, self.typed_unit.value);
        format!("{}_{}", value.word(), unit.word())
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
