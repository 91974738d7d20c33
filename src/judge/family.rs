//! What judge and kit ask of a family of controls of which files were read out. Each family is a folder of
//! this room that implements the trait for the facts of its profiles; nothing else of judge, kit and command
//! line asks which family it is.

use crate::control::controller::{Dialect, Profile};
use crate::control::table::Tables;
use crate::inputs::job::Job;
use crate::judge::active::{ActiveControl, Found, Others, ReadOutReader};
use crate::judge::before::{Before, Old};
use crate::judge::disagreement::Disagreements;
use crate::judge::disagreement::entries::Entries;
use crate::judge::findings::{Difference, InControl, InSum};
use crate::read::ReadBack;
use crate::text::{Finding, Problems};
use crate::write::compensation::Compiled;

/// A family of controls, on the side of what was read out.
pub(crate) trait Family {
    /// What files of the control hold, and what of it acts on the job's axes.
    fn read_out(&self, reading: &mut ReadOutReader<'_>) -> Result<Found, Problems>;

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

    /// What the files of a kit set beside the tables that the job does not write, and what they do not set
    /// though they should.
    fn other_settings(&self, _wanted: &Compiled, _read: &ReadBack) -> Vec<Difference> {
        Vec::new()
    }

    /// What no file of a kit sets and somebody has to see to.
    fn absent_settings(&self, _wanted: &Tables, _read: &ReadBack) -> Vec<Finding> {
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
