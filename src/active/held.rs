//! What a read-out holds of the compensation, whether it acted or not.

use crate::readback::siemens::{MachineDatum, MachineValue, SiemensContents};
use crate::table::Tables;

/// Everything of the compensation that files of a control hold, as they hold it.
///
/// limits of Siemens machine data those that [`crate::readback::control_data`] takes from an
///        archive, and only where all files agree
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Tables, parameters and points, none left out.
    pub tables: Tables,
    /// Machine and setting data (Siemens).
    pub data: Vec<MachineDatum>,
    /// Tables that the control reserves without a grid, such as `AN_CEC[3]` (Siemens).
    pub without_grid: Vec<String>,
}

impl Held {
    /// Tables of a control whose switches are in them, or that has none.
    pub(super) fn plain(tables: Tables) -> Held {
        Held {
            tables,
            data: Vec::new(),
            without_grid: Vec::new(),
        }
    }

    /// A machine or setting datum.
    pub fn datum(&self, name: &str, indices: &[String]) -> Option<&MachineDatum> {
        let same = |datum: &&MachineDatum| datum.name == name && datum.indices == indices;
        self.data.iter().find(same)
    }

    /// Whether a switch was read out and stands at 0.
    pub fn is_off(&self, name: &str, indices: &[String]) -> bool {
        let value = self.datum(name, indices).map(|datum| &datum.value);
        matches!(value, Some(MachineValue::Number(number)) if *number <= 0.0)
    }
}

/// Machine data that every part of a read-out holds with the same value, and those that it holds
/// with several.
pub(super) fn agreed(parts: &[SiemensContents]) -> (Vec<MachineDatum>, Vec<MachineDatum>) {
    let (mut agreed, mut contrary): (Vec<MachineDatum>, Vec<MachineDatum>) = Default::default();
    let same = |a: &MachineDatum, b: &MachineDatum| a.name == b.name && a.indices == b.indices;
    for datum in parts.iter().flat_map(|part| &part.machine_data) {
        match agreed.iter().find(|known| same(known, datum)) {
            None => agreed.push(datum.clone()),
            Some(known) if known.value == datum.value => {}
            Some(_) => contrary.push(datum.clone()),
        }
    }
    agreed.retain(|datum| !contrary.iter().any(|other| same(other, datum)));
    (agreed, contrary)
}
