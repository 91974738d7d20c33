//! What a control held while measuring, and what is found while its files are read.

use crate::control::claims::Assumption;
use crate::control::control_state::ControlState;
use crate::control::controller::{ControlUnit, NumberRange, Profile};
use crate::control::table::Tables;
use crate::inputs::job::{ActiveTables, Job};
use crate::judge::findings::InControl;
use crate::judge::refusals;
use crate::quantity::{Axis, PerAxis};
use crate::text::{Finding, Problem, Problems};
use crate::write::compensation::stated_control;
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
    pub held_backlash: NamedBacklash,
    /// What of the read-out belongs to others and must not be overwritten.
    pub others: Others,
    /// What the files do not say and is taken for granted.
    pub assumptions: Vec<Assumption>,
    /// What the user should know. Files that are judged may contradict the job, or hold what acts on
    /// its axes and is not emulated (a doubt); what was active while measuring may not.
    pub findings: Vec<Finding>,
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
    /// Files that were read out of the control, with everything of the compensation that they hold, whether it acted
    /// or not.
    ///
    /// limits of Siemens machine data those that [`crate::read::siemens::read_out`] takes from an archive, and
    ///        switches only where all files agree
    ReadOut(Tables),
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

impl ActiveControl {
    /// The control of a job without tables, of which nothing else is known.
    pub(super) fn bare(
        job: &Job,
        profile: &Profile,
        path: &str,
        backlash_um: PerAxis<Option<f64>>,
    ) -> Result<ActiveControl, Problems> {
        Ok(ActiveControl {
            tables: profile.family.no_tables.clone(),
            files: Vec::new(),
            state: stated(job, profile, &backlash_um)?,
            path: path.to_string(),
            origin: Origin::NoTables,
            backlash_um,
            held_backlash: Vec::new(),
            others: Others::default(),
            assumptions: Vec::new(),
            findings: Vec::new(),
        })
    }
}

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
    ActiveControl::bare(job, profile, "", backlash_um).map(Some)
}

/// What files that were read out are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadOutFor {
    /// They were active while measuring, and the new tables build on them: what contradicts the
    /// job is refused.
    OldTables,
    /// They are judged as they are now: what contradicts the job is what is looked for, and
    /// nothing that was active while measuring stands in for what they do not hold.
    Judging,
}

/// The backlash parameters that axes of the control hold, µm, by the control's names.
pub(crate) type NamedBacklash = Vec<(String, Option<f64>)>;

/// A read-out against a job, while it is read.
pub(crate) struct ReadOutReader<'a> {
    pub(crate) job: &'a Job,
    /// The files: names and texts.
    pub(crate) texts: &'a [(&'a str, &'a str)],
    pub(crate) names: PerAxis<Vec<String>>,
    pub(crate) purpose: ReadOutFor,
    /// What was found so far.
    pub(crate) active: ActiveControl,
}

impl ReadOutReader<'_> {
    /// Whether the files are judged as they are now.
    pub(crate) fn judges(&self) -> bool {
        self.purpose == ReadOutFor::Judging
    }

    pub(crate) fn tell(&mut self, finding: InControl) {
        self.active.findings.push(finding.into());
    }

    /// What acted on the job's axes, of all that the files hold.
    pub(crate) fn found(&mut self, acted: Tables, held: Tables) {
        self.active.tables = acted;
        self.active.origin = Origin::ReadOut(held);
    }

    /// Takes the backlash parameter of each axis of the control, µm, where a file holds it.
    pub(crate) fn backlash(&self, of: impl Fn(Axis, &str) -> Option<f64>) -> NamedBacklash {
        self.named().map(|(axis, name)| (name.clone(), of(axis, name))).collect()
    }

    /// The axes of the job, and of the control.
    pub(crate) fn named(&self) -> impl Iterator<Item = (Axis, &String)> {
        self.names.iter().flat_map(|(axis, names)| names.iter().map(move |name| (axis, name)))
    }

    /// Tells of a control that counts in another unit than the job, where a file holds its unit.
    pub(crate) fn check_unit(&mut self, unit: Option<ControlUnit>) {
        let own = self.job.compensation.control_unit;
        if let Some(unit) = unit.filter(|unit| *unit != own) {
            let (unit, own) = (unit.word(), own.word());
            self.tell(InControl::ControlUnit { unit, own });
        }
    }

    /// What is assumed of old tables, and told of files that are judged.
    pub(crate) fn take(&mut self, assumption: Assumption, told: InControl) {
        match self.purpose {
            ReadOutFor::OldTables => self.active.assumptions.push(assumption),
            ReadOutFor::Judging => self.tell(told),
        }
    }

    /// The axis of the job that the control calls by this name.
    pub(crate) fn axis(&self, name: &str) -> Option<Axis> {
        axis_of(&self.names, name)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.axis(name).is_some()
    }
}

/// The axis of the job that the control calls by this name.
pub(super) fn axis_of(names: &PerAxis<Vec<String>>, name: &str) -> Option<Axis> {
    let is = |own: &String| own.eq_ignore_ascii_case(name);
    let has = |axis: &Axis| names[*axis].iter().any(is);
    Axis::ALL.into_iter().find(has)
}

/// Where the job speaks of the active tables.
pub(super) const KEY: &str = "measurement.active_while_measuring";

pub(super) fn at_key(job: &Job, problem: Problem) -> Problem {
    job.source.at(KEY, problem)
}

/// The control as the job describes it, without tables.
pub(super) fn stated(
    job: &Job,
    profile: &Profile,
    backlash_um: &PerAxis<Option<f64>>,
) -> Result<ControlState, Problems> {
    let names = axis_names(job, profile)?;
    let backlash_um = |axis| backlash_um[axis].unwrap_or(0.0);
    Ok(stated_control(job, &names, backlash_um, |_| false))
}

/// Backlash parameters of the files and of the job together; two different values are a problem.
pub(super) fn backlash_of(
    job: &Job,
    found: &PerAxis<Option<f64>>,
    problems: &mut Problems,
) -> PerAxis<Option<f64>> {
    const SAME_UM: f64 = 1e-6;
    let stated = &job.measurement.active_settings.backlash_um;
    for axis in Axis::ALL {
        if let (Some(found), Some(own)) = (found[axis], stated[axis])
            && (found - own).abs() > SAME_UM
        {
            let path = format!("measurement.active_backlash_um.{}", axis.key());
            problems.push(job.source.at(&path, refusals::other_backlash(found, axis, own)));
        }
    }
    PerAxis::from_fn(|axis| found[axis].or(stated[axis]))
}
