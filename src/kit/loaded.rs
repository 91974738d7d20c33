//! Files in the emulated control of a job: those that are made for it, those of a kit, or those that were
//! read out of a control; and how they differ from what the job asks for.
//!
//! A backlash parameter stands in no file for the control: a kit names it in its manifest. The job
//! that the kit is judged by may ask for another one.

use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::KitFile;
use crate::control::table::Tables;
use crate::inputs::job::ActiveTables;
use crate::judge::active::{ActiveControl, State};
use crate::judge::conformity::Verdict;
use crate::judge::disagreement::{compare, contents};
use crate::judge::family::Before;
use crate::judge::field::Field;
use crate::judge::findings::{InControl, not_emulated};
use crate::judge::forecast::{Forecast, forecast, judged_ranges};
use crate::kit::findings::KitFinding;
use crate::kit::inputs::{Inputs, JobTables, judged};
use crate::kit::refusals;
use crate::quantity::{Axis, rounded};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::{ReadBack, emulator, read, unread};
use crate::text::{Finding, Problem, Problems, Severity, of_severity};
use crate::write::compensation::Compiled;
use crate::write::emit;
use crate::write::plan::{Plan, Task};
use crate::write::target::wants;

/// A control with tables in it, beside what the job asks of it.
pub struct Loaded<'a> {
    /// What the job asks for.
    pub(crate) asked: JobTables<'a>,
    /// What the files hold.
    pub(crate) tables: Tables,
    /// The control outside the tables, as it goes with the files.
    pub(crate) state: ControlState,
    /// The control with the tables, or why nothing can be said of it.
    pub(crate) control: Result<Box<dyn Emulator>, Problems>,
    /// How the files differ from what the job asks for; what no file does, what was ignored, and
    /// what is taken for granted; what acts on the axes of the job and is not emulated (a doubt).
    pub(crate) findings: Vec<Finding>,
    /// Files that the control may load and no reader takes.
    pub(crate) unread: Option<Finding>,
    /// The directory that the files lie in; `None` = they were made from the job, and lie nowhere yet.
    pub(crate) directory: Option<String>,
}

impl<'a> Loaded<'a> {
    /// Tables in a control of this state, of which nothing else is known.
    fn with(
        asked: JobTables<'a>,
        tables: Tables,
        (state, findings): Outside,
        control: Emulated<Box<dyn Emulator>>,
    ) -> Loaded<'a> {
        let control = control.map_err(Problems::from);
        Loaded { asked, tables, state, control, findings, unread: None, directory: None }
    }

    /// The files of a kit; `named` = `state` of their manifest. Everything that they hold counts.
    pub(super) fn kit(
        asked: JobTables<'a>,
        files: &[KitFile],
        named: Option<&State>,
    ) -> Result<Loaded<'a>, Problems> {
        let outside = loaded_state(&asked, named);
        Loaded::files(asked, files, outside)
    }

    /// The files that were made for the job, in the control that it describes.
    pub(super) fn own(asked: JobTables<'a>, files: &[KitFile]) -> Result<Loaded<'a>, Problems> {
        let outside = (asked.compiled.state.clone(), Vec::new());
        Loaded::files(asked, files, outside)
    }

    /// The files of a kit, with the control outside them.
    fn files(
        asked: JobTables<'a>,
        files: &[KitFile],
        (state, of_state): Outside,
    ) -> Result<Loaded<'a>, Problems> {
        let profile = &asked.inputs.profile;
        let read = read(profile, files)?;
        let (mut findings, found) = differences(&asked, &read);
        findings.extend(of_state);
        let control = found.and_then(|found| match state == asked.compiled.state {
            true => Ok(found),
            false => emulator(profile, &read.tables, &state),
        });
        let unread = unread(profile, files);
        Ok(Loaded { unread, ..Loaded::with(asked, read.tables, (state, findings), control) })
    }

    /// The control of a job with its tables as they were compiled; `files`: those that no reader takes.
    pub(super) fn compiled(asked: JobTables<'a>, files: &[KitFile]) -> Loaded<'a> {
        let profile = &asked.inputs.profile;
        let Compiled { tables, state, .. } = asked.compiled.clone();
        let (unread, control) = (unread(profile, files), emulator(profile, &tables, &state));
        Loaded { unread, ..Loaded::with(asked, tables, (state, Vec::new()), control) }
    }

    /// What was read out of a control, judged by what it does to the job's axes.
    pub(super) fn read_out(
        asked: JobTables<'a>,
        active: &ActiveControl,
    ) -> Result<Loaded<'a>, Problems> {
        let JobTables { inputs, plan, compiled } = &asked;
        let (state, of_state) = read_out_state(&asked, active);
        let with = |tables, state| emulator(&inputs.profile, tables, state);
        let wanted = with(&compiled.tables, &compiled.state)?;
        let mut findings = active.findings.clone();
        let facts: Vec<String> = active.assumptions.iter().map(|a| a.fact.clone()).collect();
        if !facts.is_empty() {
            findings.push(InControl::TakenAsOn { facts }.into());
        }
        let before = Before::of(inputs.task(), plan, compiled, active);
        findings.extend(before.iter().flat_map(contents::surroundings));
        match with(&active.tables, &compiled.state) {
            Ok(found) => {
                findings.extend(compare(plan, wanted.as_ref(), found.as_ref()).findings);
            }
            Err(reason) => findings.push(not_emulated(reason)),
        }
        findings.extend(of_state);
        let control = with(&active.tables, &state);
        Ok(Loaded::with(asked, active.tables.clone(), (state, findings), control))
    }

    /// What the files make of the control; refused where nothing can be said of it.
    pub(crate) fn control(&self) -> Result<&dyn Emulator, Problems> {
        self.control.as_deref().map_err(Clone::clone)
    }

    /// What the tables add to every term; refused where nothing can be said of it.
    pub(crate) fn effect(&self) -> Result<Field, Problems> {
        Ok(self.field(self.control()?)?)
    }

    /// The same of a control.
    pub(super) fn field(&self, control: &dyn Emulator) -> Emulated<Field> {
        let JobTables { inputs, plan, .. } = &self.asked;
        Field::of(&plan.names, control, |term| inputs.model.terms[term].is_some())
    }

    /// What the tables will leave in the control.
    pub(super) fn forecast(&self, effect: &Field) -> Forecast {
        let JobTables { inputs, plan, .. } = &self.asked;
        forecast(inputs.machine(), plan, effect, &judged_ranges(&inputs.job, inputs.as_measured()))
    }

    /// Where the tables come from, in words.
    pub(crate) fn from(&self) -> String {
        match &self.directory {
            Some(directory) => format!("the files of {directory}"),
            None => format!("the tables of the job for {}", self.asked.inputs.profile.name),
        }
    }
}

/// How files differ from what was compiled: what the tables do to the axes first, then what else
/// the files hold; and the control that they would make, or why there is none.
fn differences(
    asked: &JobTables<'_>,
    read: &ReadBack,
) -> (Vec<Finding>, Emulated<Box<dyn Emulator>>) {
    let JobTables { inputs, plan, compiled } = asked;
    let profile = &inputs.profile;
    let found = emulator(profile, &read.tables, &compiled.state);
    let contents = |diagnosis| contents::contents(profile, compiled, read, diagnosis);
    if let (true, Ok(_)) = (compiled.tables == read.tables, &found) {
        // The same tables do the same: only what the files hold beside them is left to judge.
        return (contents(None), found);
    }
    let mut findings = contents::measuring_systems(profile, &compiled.tables, &read.tables);
    let wanted = emulator(profile, &compiled.tables, &compiled.state);
    let diagnosis = match (&wanted, &found) {
        (Ok(wanted), Ok(found)) => {
            let diagnosis = compare(plan, wanted.as_ref(), found.as_ref());
            findings.extend(diagnosis.findings.iter().cloned());
            Some(diagnosis)
        }
        (Err(reason), _) | (_, Err(reason)) => {
            findings.push(not_emulated(reason.clone()));
            None
        }
    };
    findings.extend(contents(diagnosis.as_ref()));
    (findings, found)
}

/// The state of a control, and what is to be said of it.
type Outside = (ControlState, Vec<Finding>);

/// The control of a job with the backlash parameters of a kit; `named` = `state` of its manifest,
/// `None` where there is none, so that only the job says what they are.
fn loaded_state(asked: &JobTables<'_>, named: Option<&State>) -> Outside {
    outside(asked, |axis, wanted| {
        match named.and_then(|state| state.axis(&axis.name)) {
            Some(entry) => take(axis, "the kit was made for", entry.backlash_um, wanted),
            // No kit, or no such axis.
            None => wanted
                .map(|um| InControl::NoManifest { axis: axis.name.clone(), um: micrometres(um) }),
        }
    })
}

/// The same with the backlash parameters that were read out of the control. One that the job does
/// not ask for acts as it did while measuring.
fn read_out_state(asked: &JobTables<'_>, control: &ActiveControl) -> Outside {
    let parameter = asked.inputs.profile.family.backlash_parameter;
    outside(asked, |state, wanted| {
        let axis = state.name.clone();
        let mut held = control.held_backlash.iter();
        let found = held.find(|(name, _)| *name == axis).and_then(|(_, um)| *um);
        match (found, wanted.map(micrometres)) {
            (None, None) => None,
            (None, Some(um)) => Some(InControl::NoParameter { parameter, axis, um }),
            (Some(um), None) => (um.abs() > 0.0).then(|| InControl::Unchanged {
                parameter,
                axis,
                um: micrometres(um),
            }),
            (Some(_), Some(_)) => take(state, "the control holds", found, wanted),
        }
    })
}

fn outside(
    asked: &JobTables<'_>,
    judged: impl Fn(&mut AxisState, Option<f64>) -> Option<InControl>,
) -> Outside {
    let mut state = asked.compiled.state.clone();
    let findings = state.axes.iter_mut().filter_map(|axis| {
        let wanted = named_backlash(asked.inputs, &asked.plan, &asked.compiled, &axis.name);
        judged(axis, wanted).map(Finding::from)
    });
    let findings = findings.collect();
    (state, findings)
}

/// To a nanometre, without the digits that a conversion from millimetres adds.
fn micrometres(um: f64) -> String {
    format!("{} µm", rounded(um, 3))
}

/// A parameter that the tables do not set counts from the one that acted while measuring.
fn take(
    axis: &mut AxisState,
    who: &'static str,
    named: Option<f64>,
    wanted: Option<f64>,
) -> Option<InControl> {
    /// Two parameters closer than this are one, µm (a manifest holds picometres).
    const SAME_UM: f64 = 1e-6;
    if let Some(um) = named {
        axis.backlash_um += um - wanted.unwrap_or(0.0);
    }
    let said = |um: Option<f64>| um.map_or_else(|| "none".to_string(), micrometres);
    let same = match (named, wanted) {
        (Some(named), Some(wanted)) => (named - wanted).abs() <= SAME_UM,
        (named, wanted) => named.is_none() && wanted.is_none(),
    };
    (!same).then(|| InControl::OtherBacklash {
        axis: axis.name.clone(),
        who,
        named: said(named),
        wanted: said(wanted),
    })
}

/// The backlash parameter of an axis that goes with these tables, µm: the one they name, else the
/// one that acted while measuring; `None` where neither is known.
pub(super) fn named_backlash(
    inputs: &Inputs,
    plan: &Plan,
    compiled: &Compiled,
    name: &str,
) -> Option<f64> {
    let has = |axis: &Axis| plan.names[*axis].iter().any(|own| own == name);
    let axis = Axis::ALL.into_iter().find(has)?;
    if plan.sets_backlash(axis) {
        return Some(compiled.state.axis(name)?.backlash_um);
    }
    inputs.active.as_ref()?.backlash_um[axis]
}

// The files of a kit, read back, with what they will leave.

/// A kit without what is written beside its tables.
pub(crate) struct BareKit<'a> {
    pub(crate) inputs: &'a Inputs,
    pub(crate) plan: Plan,
    pub(crate) compiled: Compiled,
    /// The files of the kit itself.
    pub(crate) files: Vec<KitFile>,
    /// What the tables that were read back from them add to every term; the tables are those of `compiled`.
    pub(crate) effect: Field,
    /// What the files will leave.
    pub(crate) forecast: Forecast,
    /// Forecast against the acceptance of the job.
    pub(crate) verdict: Verdict,
    /// Why the measured errors are doubtful.
    pub(crate) doubts: Vec<Finding>,
}

impl BareKit<'_> {
    /// Refused unless every file reads back to exactly what was meant.
    pub(super) fn of(inputs: &Inputs) -> Result<BareKit<'_>, Problems> {
        let asked = JobTables::of(inputs)?;
        let files = emit::render(inputs.task(), &asked.compiled)?;
        let loaded = Loaded::own(asked, &files).map_err(not_read_back)?;
        ensure_same(&loaded)?;
        let effect = loaded.effect()?;
        let forecast = loaded.forecast(&effect);
        let JobTables { plan, mut compiled, .. } = loaded.asked;
        compiled.notes.extend(loaded.findings);
        if inputs.profile.comments.value.are_allowed() {
            compiled.notes.extend(emit::other_letters(&inputs.job, &inputs.profile.name));
        }
        let doubts = [doubts(inputs), loaded.unread.into_iter().collect()].concat();
        let verdict = judged(&forecast, inputs, &doubts);
        Ok(BareKit { inputs, plan, compiled, files, effect, forecast, verdict, doubts })
    }

    pub(crate) fn task(&self) -> Task<'_> {
        self.inputs.task()
    }

    /// `X (AX1)`, or `X (AX1 and AX4)` for a gantry.
    pub(crate) fn axes(&self, axis: Axis) -> String {
        format!("{axis} ({})", self.plan.names[axis].join(" and "))
    }
}

/// Why the measured errors that the job asks for are doubtful.
pub(super) fn doubts(inputs: &Inputs) -> Vec<Finding> {
    let measured = inputs.as_measured();
    let mut doubts = measured.doubts(|term| wants(&inputs.job, term));
    doubts.extend(measured.unlikely_small(inputs.job.measurement.uncertainty.noise_um));
    if inputs.job.measurement.active == ActiveTables::NotStated {
        doubts.push(KitFinding::ActiveNotStated.into());
    }
    doubts
}

fn not_read_back(problems: Problems) -> Problems {
    let mut all = Problems::from(refusals::not_read_back());
    all.extend(problems);
    all
}

/// A template that drops, doubles, changes or adds something is found here.
fn ensure_same(loaded: &Loaded<'_>) -> Result<(), Problems> {
    let sentences = of_severity(&loaded.findings, Severity::Disagreement);
    let same_tables = loaded.asked.compiled.tables == loaded.tables;
    if same_tables && sentences.is_empty() {
        return Ok(());
    }
    let mut problems = Problems::from(match same_tables {
        true => refusals::something_else_set(),
        false => refusals::other_tables(),
    });
    for words in sentences {
        problems.push(Problem::new(words.to_string()));
    }
    Err(problems)
}
