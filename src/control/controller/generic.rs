//! No particular control: facts of the generic table (docs/interface.md §4.1).

use super::fact::facts;
use super::family::Family;
use crate::control::table::Tables;
use crate::control::table::generic::GenericTable;

pub(super) static FAMILY: Family = Family {
    word: "generic",
    backlash_parameter: "backlash parameter",
    between: "linear",
    no_tables: Tables::Generic(GenericTable { rows: Vec::new() }),
    off: "removed",
    restarts: true,
    off_by_hand: ", see to it by hand",
    page: None,
    proofs: &[],
};

facts! {
    /// Facts of the generic dialect (contract §4.1). Its table carries deviation, correction and
    /// increment, so no sign has to be assumed.
    GenericFacts {
        /// Most points of one table, if the control has a limit.
        points: u32,
    }
}
