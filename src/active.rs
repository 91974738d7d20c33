//! The tables that were active while measuring: what the control held, and what it did.
//!
//! ```text
//!   kit directory, or files read out of the control ─→ readers ─→ ActiveControl
//!                                                                      ▼ emulate
//!   measured errors (residual under these tables) ──────────→ − old correction
//!                                                                      ▼
//!                                        model of the machine without compensation
//! ```
//! The new tables are planned for the machine without compensation, so new = old + residual. What
//! is forecast as *before* stays what was measured.

use crate::control_state::ControlState;
use crate::table::Tables;

/// The control as it was while measuring, decoded from files.
///
/// limits only what the files hold and concerns the compensation of the job's axes; a value that
///        no file holds is not invented
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveControl {
    /// Tables, parameters and points, as the readers gave them.
    pub tables: Tables,
    /// Every file that was read, name and bytes unchanged, in the order of reading.
    pub files: Vec<(String, Vec<u8>)>,
    /// The state of the control outside the tables: unit, reference, backlash parameters.
    pub state: ControlState,
}
