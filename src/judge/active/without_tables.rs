//! Measured without tables: what acted all the same is the backlash parameter.

use super::{ActiveControl, Origin, Others, stated};
use crate::control::controller::{Dialect, Profile};
use crate::control::table::Tables;
use crate::control::table::fanuc::FanucMemory;
use crate::control::table::generic::GenericTable;
use crate::control::table::siemens::SiemensTables;
use crate::inputs::job::{ActiveTables, Job};
use crate::text::problem::Problems;

/// The control of a job with `active_while_measuring = "none"` and `active_backlash_um`; `None`
/// where the job states no parameter.
///
/// limits an axis that the job does not state is counted as 0, which the kit says of itself
pub fn without_tables(job: &Job, profile: &Profile) -> Result<Option<ActiveControl>, Problems> {
    let backlash_um = job.measurement.active_settings.backlash_um;
    let states_one = backlash_um.iter().any(|(_, um)| um.is_some());
    if job.measurement.active != ActiveTables::None || !states_one {
        return Ok(None);
    }
    let state = stated(job, profile, &backlash_um)?;
    Ok(Some(ActiveControl {
        tables: match &profile.dialect {
            Dialect::Siemens(_) => Tables::Siemens(SiemensTables::default()),
            Dialect::Fanuc(_) => Tables::Fanuc(FanucMemory::default()),
            Dialect::Generic(_) => Tables::Generic(GenericTable { rows: Vec::new() }),
        },
        files: Vec::new(),
        state,
        path: String::new(),
        origin: Origin::NoTables,
        backlash_um,
        others: Others::default(),
        assumptions: Vec::new(),
        notes: Vec::new(),
        held_backlash: Vec::new(),
        disagreements: Vec::new(),
        beside: Vec::new(),
    }))
}
