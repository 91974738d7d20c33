//! Machine and setting data of the compensation: number and name of each, and which of them switch a table.

use crate::control::table::siemens::{Place, SiemensTable};
use crate::read::siemens::{MachineDatum, datum};

/// A machine or setting datum: its number, and its name without `$`.
pub(super) type Datum = (&'static str, &'static str);

pub(super) const BACKLASH: Datum = ("MD32450", "MA_BACKLASH");
pub(super) const LEC_ON: Datum = ("MD32700", "MA_ENC_COMP_ENABLE");
pub(super) const LEC_POINTS: Datum = ("MD38000", "MA_MM_ENC_COMP_MAX_POINTS");
pub(super) const CEC_ON: Datum = ("MD32710", "MA_CEC_ENABLE");
pub(super) const CEC_UNIT: Datum = ("MD32711", "MA_CEC_SCALING_SYSTEM_METRIC");
pub(super) const CEC_LIMIT: Datum = ("MD32720", "MA_CEC_MAX_SUM");
pub(super) const CEC_POINTS: Datum = ("MD18342", "MN_MM_CEC_MAX_POINTS");
pub(super) const TABLE_ON: Datum = ("SD41300", "SN_CEC_TABLE_ENABLE");
pub(super) const WEIGHT: Datum = ("SD41310", "SN_CEC_TABLE_WEIGHT");
pub(super) const REFERENCE: Datum = ("MD34100", "MA_REFP_SET_POS");
pub(super) const REFERENCE_MODE: Datum = ("MD34200", "MA_ENC_REFP_MODE");
pub(super) const UNIT: Datum = ("MD10240", "MN_SCALING_SYSTEM_IS_METRIC");
pub(super) const UNIT_CHANGES: Datum = ("MD10260", "MN_CONVERT_SCALING_SYSTEM");

/// A datum as files write it: `$MA_BACKLASH[0,AX1]`.
pub(super) fn variable((_, name): Datum, index: &str) -> String {
    match index {
        "" => format!("${name}"),
        index => format!("${name}[{index}]"),
    }
}

/// The same behind its number.
pub(super) fn numbered(datum: Datum, index: &str) -> String {
    format!("{} {}", datum.0, variable(datum, index))
}

/// The number that data hold of it.
pub(super) fn number(data: &[MachineDatum], of: Datum, index: &str) -> Option<f64> {
    datum(data, &variable(of, index))?.value.number()
}

/// The switch of a table, and what reserves its memory.
pub(super) fn of_place(place: &Place) -> [Datum; 2] {
    match place {
        Place::Lec { .. } => [LEC_ON, LEC_POINTS],
        Place::Cec(_) => [TABLE_ON, CEC_POINTS],
    }
}

/// What switches a table on: its own switch first, then that of all CEC tables of an axis.
pub(super) fn switches(table: &SiemensTable) -> Vec<(Datum, String)> {
    let own = (of_place(&table.place)[0], table.place.index());
    let of_axis = table.place.cec().map(|_| (CEC_ON, table.output_axis.clone()));
    std::iter::once(own).chain(of_axis).collect()
}
