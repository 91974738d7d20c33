//! What judge and kit ask of a family of controls of which files were read out, and what the control held of all that a
//! kit changes. Each family implements the trait for the facts of its profiles; nothing else of judge, kit and command
//! line asks which family it is.

use crate::control::controller::{Dialect, Profile};
use crate::control::table::Tables;
use crate::inputs::job::Job;
use crate::judge::active::{ActiveControl, Origin, Others, ReadOutReader};
use crate::judge::disagreement::Disagreements;
use crate::judge::disagreement::Entries;
use crate::judge::findings::{Difference, InControl, InSum};
use crate::quantity::Axis;
use crate::read::ReadBack;
use crate::text::{Finding, Problems, grouped};
use crate::write::compensation::Compiled;
use crate::write::plan::{Plan, Task};

/// A family of controls, on the side of what was read out.
pub(crate) trait Family {
    /// Takes what files of the control hold, and what of it acts on the job's axes.
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<(), Problems>;

    /// New tables at places of others, and what to do.
    fn taken(&self, _others: &Others, _new: &Tables) -> Vec<(String, &'static str)> {
        Vec::new()
    }

    /// What makes old tables act that the new files do not overwrite. Here: a new file takes the place of the
    /// old one, whole.
    fn left_over(&self, _old: &Tables, _new: &Tables) -> Vec<String> {
        Vec::new()
    }

    /// Lets the job say what the files do between the points, where it does not state it; gives what is to be
    /// told.
    fn take_interpolation(
        &self,
        _job: &mut Job,
        _profile: &Profile,
        _active: &ActiveControl,
    ) -> Vec<InSum> {
        Vec::new()
    }

    /// What tables hold, entry by entry, beside those that they are compared with.
    fn entries(&self, side: &Side<'_>) -> Entries;

    /// What the files of a kit set beside the tables that the job does not write, what they do not set though they
    /// should, and what no file of it sets and somebody has to see to.
    fn beside(&self, _wanted: &Compiled, _read: &ReadBack) -> Vec<Finding> {
        Vec::new()
    }

    /// Tables that are emulated alike, but are for another measuring system than the job states.
    fn measuring_systems(&self, _wanted: &Tables, _found: &Tables) -> Vec<Difference> {
        Vec::new()
    }

    /// What a read-out holds around the tables that contradicts the job; and what no file of it holds.
    fn surroundings(&self, _before: &Before<'_>) -> (Vec<InControl>, Vec<String>) {
        (Vec::new(), Vec::new())
    }

    /// What the control held of all that a kit changes; `Err` = what of the tables, points and parameters
    /// that the files overwrite was not read out.
    fn old(&self, before: &Before<'_>) -> Result<Old, Vec<String>>;
}

/// Tables beside those that they are compared with.
#[derive(Clone, Copy)]
pub(crate) struct Side<'a> {
    pub(crate) tables: &'a Tables,
    pub(crate) others: &'a Tables,
    pub(crate) diagnosis: Option<&'a Disagreements>,
}

impl Side<'_> {
    /// Whether a difference of the table of a pair of axes is told: no diagnosis explains it.
    pub(crate) fn tells(&self, base: &str, output: &str) -> bool {
        !self.diagnosis.is_some_and(|d| d.explains(base, output))
    }
}

/// The family of a profile.
pub(crate) fn family(dialect: &Dialect) -> &dyn Family {
    match dialect {
        Dialect::Siemens(facts) => facts,
        Dialect::Fanuc(facts) => facts,
        Dialect::Declared(facts) => facts,
        Dialect::Linuxcnc(facts) => facts,
        Dialect::Isg(facts) => facts,
    }
}

/// A kit, and what the control held before it.
pub(crate) struct Before<'a> {
    pub(crate) task: Task<'a>,
    pub(crate) plan: &'a Plan,
    pub(crate) compiled: &'a Compiled,
    pub(crate) active: &'a ActiveControl,
    /// What the control held.
    pub(crate) held: &'a Tables,
}

impl<'a> Before<'a> {
    /// What was read out of the control; `None` where nothing was.
    pub(crate) fn of(
        task: Task<'a>,
        plan: &'a Plan,
        compiled: &'a Compiled,
        active: &'a ActiveControl,
    ) -> Option<Before<'a>> {
        let Origin::ReadOut(held) = &active.origin else {
            return None;
        };
        Some(Before { task, plan, compiled, active, held })
    }

    /// Who changes the backlash parameter of an axis, where it gets tables of its positioning.
    pub(super) fn backlash(&self, axis: Axis) -> Option<ChangedBy> {
        self.plan.of_axis(axis).next()?;
        let is_set = self.plan.sets_backlash(axis);
        Some(if is_set { ChangedBy::Precondition } else { ChangedBy::Nobody })
    }

    /// The tables of the kit, those that the control holds and those that act.
    pub(super) const fn tables(&self) -> [&Tables; 3] {
        [&self.compiled.tables, self.held, &self.active.tables]
    }
}

/// What the control held of all that the kit changes.
pub(crate) struct Old {
    /// Of Siemens with switches, backlash and weights.
    pub(crate) tables: Tables,
    /// What no file that was read out holds and no rollback file restores: names, as the control shows them, and what
    /// changes it.
    pub(crate) unknown: Vec<(String, ChangedBy)>,
    /// Tables that keep the values of the kit, switched off: they were reserved without a grid.
    pub(crate) stays: Vec<String>,
}

/// What changes a datum beside the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ChangedBy {
    /// A file of the kit.
    File,
    /// A person, because a precondition asks for a value.
    Precondition,
    /// Nobody: it acts in addition to the tables and goes along where it was read out.
    Nobody,
}

/// One name for all data of a kind: `MD32700 $MA_ENC_COMP_ENABLE[0,AX1], [0,AX2]`. `lacking`: of each its name, which of
/// those of this name, and by whom it is changed.
pub(crate) fn unknown(lacking: Vec<(String, String, ChangedBy)>) -> Vec<(String, ChangedBy)> {
    let groups = grouped(lacking.into_iter().map(|(name, index, by)| ((name, by), index)));
    groups.into_iter().map(|((name, by), indices)| (name + &indices.join(", "), by)).collect()
}
