//! What a job states of the compensation that was active while measuring.

use crate::quantity::axis::PerAxis;

/// Whether a compensation was active while measuring.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ActiveTables {
    /// `"none"`: the machine was measured without compensation.
    None,
    /// The job does not say; warned about in every output.
    NotStated,
    /// Path of a kit, or of files read out of the control, relative to the job.
    Path(String),
}

/// What becomes of a term that the active tables correct and that was not measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotMeasured {
    /// Its correction is carried over into the new tables.
    Keep,
    /// The new tables do without it; the old table has to be switched off.
    Drop,
}

/// What the job says to the active tables beyond their path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ActiveSettings {
    /// `active_terms_not_measured`; no default.
    pub not_measured: Option<NotMeasured>,
    /// `active_reference = "rezero"`: the value of an active table at the reference is taken off.
    pub rezero: bool,
    /// `active_backlash_um`: backlash parameter of each axis while measuring, µm, where no file
    /// holds it or no table was active; positive = ordinary lost motion.
    pub backlash_um: PerAxis<Option<f64>>,
}
