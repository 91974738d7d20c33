//! Files in the emulated control of a job: those of a kit, or those that were read out of a
//! control; and how they differ from what the job asks for.
//!
//! A backlash parameter stands in no file for the control: a kit names it in its manifest. The job
//! that the kit is judged by may ask for another one.

use super::made::differences;
use super::{Inputs, generate, named_backlash};
use crate::control::control_state::{AxisState, ControlState};
use crate::control::table::Tables;
use crate::judge::active::{ActiveControl, named_axis};
use crate::judge::before::Before;
use crate::judge::disagreement::{self, surroundings};
use crate::judge::findings::{InControl, not_emulated};
use crate::kit::inputs::{Asked, cannot_emulate};
use crate::quantity::units::rounded;
use crate::read::emulate::{Emulated, Emulator};
use crate::read::{KitFile, emulator, read, unread};
use crate::text::finding::Finding;
use crate::text::problem::Problems;
use crate::write::plan::Plan;
use serde_json::Value;

/// Files against what the job asks for.
pub(super) struct Loaded {
    /// What the files hold.
    pub(super) tables: Tables,
    /// The control outside the tables, as it goes with the files.
    pub(super) state: ControlState,
    /// The control with the tables, or why nothing can be said of it.
    pub(super) control: Emulated<Box<dyn Emulator>>,
    /// How the files differ from what the job asks for; what no file does, what was ignored, and
    /// what is taken for granted; what acts on the axes of the job and is not emulated (a doubt).
    pub(super) findings: Vec<Finding>,
    /// Files that the control may load and no reader takes.
    pub(super) unread: Option<Finding>,
}

impl Loaded {
    /// The files of a kit; `named` = `state` of their manifest. Everything that they hold counts.
    pub(super) fn kit(
        asked: &Asked<'_>,
        files: &[KitFile<'_>],
        named: Option<&Value>,
    ) -> Result<Loaded, Problems> {
        let profile = &asked.inputs.profile;
        let (state, of_state) = loaded_state(asked, named);
        let read = read(profile, files)?;
        let (mut findings, found) = differences(asked, &read);
        let absent = disagreement::absent(profile, &asked.compiled.tables, &read);
        findings.extend(absent.into_iter().chain(of_state));
        Ok(Loaded {
            unread: unread(profile, files),
            control: found.and_then(|_| emulator(profile, &read.tables, &state)),
            tables: read.tables,
            state,
            findings,
        })
    }

    /// What was read out of a control, judged by what it does to the job's axes.
    pub(super) fn read_out(asked: &Asked<'_>, active: &ActiveControl) -> Result<Loaded, Problems> {
        let Asked { inputs, plan, compiled } = asked;
        let (state, of_state) = read_out_state(asked, active);
        let with = |tables, state| emulator(&inputs.profile, tables, state);
        let wanted =
            with(&compiled.tables, &compiled.state).map_err(|reason| cannot_emulate(&reason))?;
        let mut findings = active.findings.clone();
        let facts: Vec<String> = active.assumptions.iter().map(|a| a.fact.clone()).collect();
        if !facts.is_empty() {
            findings.push(InControl::TakenAsOn { facts }.into());
        }
        let before = Before::of(inputs.task(), plan, compiled, active);
        findings.extend(before.iter().flat_map(surroundings));
        match with(&active.tables, &compiled.state) {
            Ok(found) => {
                let differs = disagreement::compare(plan, wanted.as_ref(), found.as_ref());
                findings.extend(differs.findings);
            }
            Err(reason) => findings.push(not_emulated(reason)),
        }
        findings.extend(of_state);
        Ok(Loaded {
            unread: None,
            control: with(&active.tables, &state),
            tables: active.tables.clone(),
            state,
            findings,
        })
    }

    fn with(self, plan: Plan) -> Result<LoadedControl, Problems> {
        Ok(LoadedControl {
            plan,
            control: self.control.map_err(|reason| cannot_emulate(&reason))?,
            findings: self.findings.into_iter().chain(self.unread).collect(),
        })
    }
}

/// A control with tables in it, and the plan that names its axes.
pub struct LoadedControl {
    /// The plan of the job.
    pub plan: Plan,
    /// What the files make of the control.
    pub control: Box<dyn Emulator>,
    /// How the files differ from what the job asks for, what no file does, what was ignored, and
    /// what is taken for granted.
    pub findings: Vec<Finding>,
}

/// Loads the bytes of a kit into the emulated control of a job; `named` = `state` of their manifest.
pub fn load(
    inputs: &Inputs,
    files: &[KitFile<'_>],
    named: Option<&Value>,
) -> Result<LoadedControl, Problems> {
    let asked = Asked::of(inputs)?;
    Loaded::kit(&asked, files, named)?.with(asked.plan)
}

/// Loads what was read out of a control into the emulated control of a job.
pub(crate) fn load_read_out(
    inputs: &Inputs,
    active: &ActiveControl,
) -> Result<LoadedControl, Problems> {
    let asked = Asked::of(inputs)?;
    Loaded::read_out(&asked, active)?.with(asked.plan)
}

/// Makes the files of a job in memory and loads their bytes.
pub(crate) fn load_own(inputs: &Inputs) -> Result<LoadedControl, Problems> {
    let kit = generate(inputs)?;
    load(inputs, &kit.kit_files(), Some(&kit.manifest.state))
}

/// The state of a control, and what is to be said of it.
type Outside = (ControlState, Vec<Finding>);

/// The control of a job with the backlash parameters of a kit; `named` = `state` of its manifest,
/// `None` where there is none, so that only the job says what they are.
pub(super) fn loaded_state(asked: &Asked<'_>, named: Option<&Value>) -> Outside {
    outside(asked, |axis, wanted| {
        let entry = named.and_then(|state| named_axis(state, &axis.name));
        match entry.and_then(|entry| entry.get("backlash_um")) {
            Some(parameter) => take(axis, "the kit was made for", parameter.as_f64(), wanted),
            // No kit, or one from before manifests held it.
            None => wanted
                .map(|um| InControl::NoManifest { axis: axis.name.clone(), um: micrometres(um) }),
        }
    })
}

/// The same with the backlash parameters that were read out of the control. One that the job does
/// not ask for acts as it did while measuring.
fn read_out_state(asked: &Asked<'_>, control: &ActiveControl) -> Outside {
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
    asked: &Asked<'_>,
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
