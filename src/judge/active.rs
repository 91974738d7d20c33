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
//!
//! A backlash parameter that the new tables do not replace acts before and after alike and is
//! left out of both; with `two-tables` and `curve-and-parameter`, which set it, it is part of the
//! old correction and has to be known.
//!
//! What acted is one thing, what a read-out holds another: [`Held`] keeps all of it for the way
//! back, with the tables that were switched off and the parameters that no table needs.

mod beside;
mod fanuc;
mod found;
mod held;
mod interpolation;
mod kit;
mod machine;
mod read_out;
mod siemens;
mod without_tables;

pub use self::beside::{collisions, left_over};
pub use self::found::ReadOutFor;
pub use self::held::Held;
pub use self::interpolation::take_interpolation;
pub use self::kit::{from_kit, named_axis};
pub use self::machine::uncompensated;
pub use self::read_out::from_read_out;
pub use self::without_tables::without_tables;

use crate::control::claims::Assumption;
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{NumberRange, Profile};
use crate::control::table::Tables;
use crate::inputs::job::{AxisSettings, BacklashPolicy, Job};
use crate::quantity::axis::{Axis, PerAxis};
use crate::text::problem::{Problem, Problems};
use crate::write::plan::axis_names;

/// The control as it was while measuring, decoded from files.
///
/// limits only what the files hold and concerns the compensation of the job's axes; a value that
///        no file holds is not invented
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveControl {
    /// Tables, parameters and points that acted on the job's axes.
    pub tables: Tables,
    /// Every file of the control that was read, name and bytes unchanged, in the order of reading.
    pub files: Vec<(String, Vec<u8>)>,
    /// The state of the control outside the tables: unit, reference, backlash parameters (0 where
    /// no file holds one, see `backlash_um`).
    pub state: ControlState,
    /// The path, as the job names it.
    pub path: String,
    /// Where the files come from.
    pub origin: Origin,
    /// Backlash parameter that acted while measuring, µm, where a file or the job states it; not
    /// known of files that are judged as they are now.
    pub backlash_um: PerAxis<Option<f64>>,
    /// What the files of a read-out hold of it, axis by axis as the control names them (of a gantry
    /// each), µm.
    pub held_backlash: Vec<(String, Option<f64>)>,
    /// What of the read-out belongs to others and must not be overwritten.
    pub others: Others,
    /// What the files do not say and is taken for granted.
    pub assumptions: Vec<Assumption>,
    /// What the user should know.
    pub notes: Vec<String>,
    /// How files that are judged contradict the job, one sentence each; what was active while
    /// measuring may not contradict it at all.
    pub disagreements: Vec<String>,
    /// What acts on the job's axes beside their tables and is not emulated, one sentence each.
    pub beside: Vec<String>,
}

/// Where the files of the active tables come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Origin {
    /// A kit of this program: the bytes of its manifest, and the version that made it.
    Kit {
        /// `manifest.json`.
        manifest: Vec<u8>,
        /// Name and version of the program.
        tool: String,
    },
    /// Files that were read out of the control, with everything that they hold.
    ReadOut(Held),
    /// No files: no table was active, and the job states the backlash parameters that were.
    NoTables,
}

/// What a read-out holds for axes that the job does not have, or in a form that is not ours.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Others {
    /// Siemens: numbers of CEC tables.
    pub cec_tables: Vec<u32>,
    /// Fanuc: pitch and straightness points.
    pub points: Vec<NumberRange>,
    /// Fanuc: straightness sets, from 1.
    pub sets: Vec<u32>,
}

/// Where the job speaks of the active tables.
const KEY: &str = "measurement.active_while_measuring";

fn problem(job: &Job, message: impl Into<String>, help: &str) -> Problem {
    job.problem_at(KEY, message).help(help)
}

/// Whether the new tables replace the backlash parameter.
fn replaces_backlash(job: &Job) -> bool {
    let policy = job.compensation.backlash;
    matches!(
        policy,
        Some(BacklashPolicy::TwoTables | BacklashPolicy::CurveAndParameter)
    )
}

/// The control as the job describes it, without tables.
fn stated(
    job: &Job,
    profile: &Profile,
    backlash_um: &PerAxis<Option<f64>>,
) -> Result<ControlState, Problems> {
    let names = axis_names(job, profile)?;
    let mut axes = Vec::new();
    for (axis, names) in names.iter() {
        let Some(machine) = job.machine.axes[axis] else {
            continue;
        };
        let settings = job.compensation.axes[axis].as_ref();
        let bits = settings.and_then(|s| s.parameter_3605).unwrap_or(0);
        axes.extend(names.iter().map(|name| AxisState {
            name: name.clone(),
            reference: machine.reference,
            reference_direction: machine.homing(),
            detection_unit_um: settings.and_then(|s| s.detection_unit_um),
            backlash_um: backlash_um[axis].unwrap_or(0.0),
            bidirectional: bits & 1 != 0,
            interpolated: settings.is_some_and(AxisSettings::is_interpolated),
        }));
    }
    Ok(ControlState {
        unit: job.compensation.control_unit,
        axes,
    })
}

/// Backlash parameters of the files and of the job together; two different values are a problem.
fn backlash_of(
    job: &Job,
    found: &PerAxis<Option<f64>>,
    problems: &mut Problems,
) -> PerAxis<Option<f64>> {
    const SAME_UM: f64 = 1e-6;
    PerAxis::from_fn(|axis| {
        let own = job.measurement.active_settings.backlash_um[axis];
        match (found[axis], own) {
            (Some(found), Some(own)) if (found - own).abs() > SAME_UM => {
                let path = format!("measurement.active_backlash_um.{}", axis.key());
                let message = format!(
                    "the files hold a backlash parameter of {found} µm for {axis}, the job states {own} µm"
                );
                problems.push(
                    job.problem_at(&path, message)
                        .help("remove it from the job, or name the files of that day"),
                );
                Some(found)
            }
            (found, own) => found.or(own),
        }
    })
}

/// The axis of the job that the control calls by this name.
fn axis_of(names: &PerAxis<Vec<String>>, name: &str) -> Option<Axis> {
    let has = |axis: &Axis| {
        names[*axis]
            .iter()
            .any(|own| own.eq_ignore_ascii_case(name))
    };
    Axis::ALL.into_iter().find(has)
}
