//! What a read-out holds of the compensation, whether it acted or not.

use crate::control::table::Tables;
use crate::read::siemens::{MachineDatum, MachineValue, SiemensContents};

/// Everything of the compensation that files of a control hold, as they hold it.
///
/// limits of Siemens machine data those that [`crate::read::control_data`] takes from an
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
    pub(crate) fn is_off(&self, name: &str, indices: &[String]) -> bool {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on has to stop")]

    use super::{Held, agreed};
    use crate::control::table::Tables;
    use crate::control::table::siemens::SiemensTables;
    use crate::read::siemens::read;

    #[test]
    fn a_switch_with_two_values_is_not_held() {
        let on = "$MA_CEC_ENABLE[AX1]=1\n$MA_ENC_COMP_ENABLE[0,AX1]=TRUE\nM17\n";
        let off = "$MA_CEC_ENABLE[AX1]=0\n$MA_ENC_COMP_ENABLE[0,AX1]=1\nM17\n";
        let parts = [on, off, on].map(|text| read("part", text).unwrap());
        let (data, contrary) = agreed(&parts);
        assert_eq!(contrary[0].name, "MA_CEC_ENABLE");
        let held = Held {
            data,
            ..Held::plain(Tables::Siemens(SiemensTables::default()))
        };
        let axis = |text: &str| text.split(',').map(str::to_string).collect::<Vec<_>>();
        assert_eq!(held.datum("MA_CEC_ENABLE", &axis("AX1")), None);
        assert!(held.datum("MA_ENC_COMP_ENABLE", &axis("0,AX1")).is_some());
        assert!(!held.is_off("MA_CEC_ENABLE", &axis("AX1")));
    }
}
