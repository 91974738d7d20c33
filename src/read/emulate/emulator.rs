//! The emulator of a control.

use crate::control::control_state::ControlState;
use crate::control::controller::{Dialect, Profile};
use crate::control::table::Tables;
use crate::read::emulate::fanuc::FanucControl;
use crate::read::emulate::generic::GenericControl;
use crate::read::emulate::siemens::SiemensControl;
use crate::read::emulate::{CannotEmulate, Emulator};

/// The emulator of a profile's dialect, loaded with tables.
pub fn emulator(
    profile: &Profile,
    tables: &Tables,
    state: &ControlState,
) -> Result<Box<dyn Emulator>, CannotEmulate> {
    Ok(match (&profile.dialect, tables) {
        (Dialect::Siemens(facts), Tables::Siemens(tables)) => {
            Box::new(SiemensControl::new(tables, facts, state)?)
        }
        (Dialect::Fanuc(facts), Tables::Fanuc(memory)) => {
            Box::new(FanucControl::new(memory, facts, state)?)
        }
        (Dialect::Generic(_), Tables::Generic(table)) => {
            Box::new(GenericControl::new(table, state)?)
        }
        _ => {
            return Err(CannotEmulate(
                "the tables are not of the profile's dialect".to_string(),
            ));
        }
    })
}
