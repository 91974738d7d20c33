//! What a kit is made from, and what has to be known about its tables.

use crate::control::controller::Profile;
use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::{Compensation, Job, UseOf};
use crate::judge::active::{self, ActiveControl, HashedFile};
use crate::judge::conformity::Verdict;
use crate::judge::family::family;
use crate::judge::field::Field;
use crate::judge::forecast::{Forecast, Machine};
use crate::kit::refusals;
use crate::kit::visit_plan::OpenFigures;
use crate::machine::model::ErrorModel;
use crate::machine::separation::table::ErrorSource;
use crate::quantity::{Axis, ErrorTerm, Millimetres, rounded};
use crate::read::emulate::CannotEmulate;
use crate::text::{Finding, Problems, Severity, grouped, joined};
use crate::write::compensation::{Compiled, compile};
use crate::write::plan::{Plan, Task, plan};

/// The inputs of a kit, read and checked.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The job.
    pub job: Job,
    /// The control.
    pub profile: Profile,
    /// The errors of the machine without compensation as curves: what the tables are made for.
    pub model: ErrorModel,
    /// The errors as they were measured, where tables were active meanwhile.
    pub under_tables: Option<ErrorModel>,
    /// What these tables added.
    pub old: Field,
    /// What the errors were read from.
    pub errors: ErrorSource,
    /// The table of angular errors, where there is one of their own.
    pub angles: Option<ErrorTable>,
    /// Every file that went in, with its hash.
    pub hashes: Vec<HashedFile>,
    /// The control as it was while measuring, where the job names its files.
    pub active: Option<ActiveControl>,
    /// What the sum of old tables and residual has to say; of an error table, that no job describes it.
    pub notes: Vec<Finding>,
}

impl Inputs {
    /// Puts checked files together.
    pub fn new(
        job: Job,
        profile: Profile,
        errors: impl Into<ErrorSource>,
        hashes: Vec<HashedFile>,
    ) -> Result<Inputs, Problems> {
        Inputs::of(UseOf::Tables, job, profile, errors.into(), hashes)
    }

    /// The same; for figures of the volume angles alone will do.
    pub(crate) fn of(
        use_of: UseOf,
        job: Job,
        profile: Profile,
        errors: ErrorSource,
        hashes: Vec<HashedFile>,
    ) -> Result<Inputs, Problems> {
        let mut model = ErrorModel::of(use_of, &job, &*errors.table(&job)?)?;
        model.lacks_squareness(model.level());
        Ok(Inputs {
            job,
            profile,
            model,
            under_tables: None,
            old: Field::default(),
            errors,
            angles: None,
            hashes,
            active: None,
            notes: Vec::new(),
        })
    }

    /// Adds what was measured apart (`measurement.angles`) and what was active meanwhile, where there is any.
    pub fn with(
        mut self,
        angles: Option<&ErrorTable>,
        active: Option<ActiveControl>,
    ) -> Result<Inputs, Problems> {
        if let Some(table) = angles {
            self.model.add_angles(&self.job, table)?;
            self.angles = Some(table.clone());
        }
        match active {
            Some(active) => self.with_active(active),
            None => Ok(self),
        }
    }

    /// The same measurement for a job that asks for other tables: all that depends on the job is made anew,
    /// so a kit of it is the kit that this job would get.
    pub(crate) fn asking_for(
        &self,
        change: impl FnOnce(&mut Compensation),
    ) -> Result<Inputs, Problems> {
        let mut job = self.job.clone();
        change(&mut job.compensation);
        let (profile, hashes) = (self.profile.clone(), self.hashes.clone());
        let inputs = Inputs::new(job, profile, self.errors.clone(), hashes)?;
        inputs.with(self.angles.as_ref(), self.active.clone())
    }

    /// The same inputs, measured while these tables were active: new = old + residual.
    pub fn with_active(mut self, active: ActiveControl) -> Result<Inputs, Problems> {
        let (mut model, old, notes) =
            active::uncompensated(&self.job, &self.profile, &mut self.model, &active)?;
        // What the old tables correct is known; a residual may well be level.
        let open = model.level();
        self.model.lacks_squareness(open.clone());
        model.lacks_squareness(open);
        self.old = old;
        self.under_tables = Some(std::mem::replace(&mut self.model, model));
        let interpolated =
            family(&self.profile.dialect).take_interpolation(&mut self.job, &self.profile, &active);
        let notes = notes.into_iter().chain(interpolated).map(Finding::from);
        self.notes = active.findings.iter().cloned().chain(notes).collect();
        self.active = Some(active);
        Ok(self)
    }

    /// The errors as they were measured.
    pub fn as_measured(&self) -> &ErrorModel {
        self.under_tables.as_ref().unwrap_or(&self.model)
    }

    /// A forecast of what was measured, to be decided.
    pub(crate) fn judged<'a>(&'a self, figures: &'a Forecast) -> OpenFigures<'a> {
        let (job, errors, model) = (&self.job, Some(&self.errors), self.as_measured());
        OpenFigures { job, errors, model, figures, expected: None }
    }

    /// The machine as measured and without compensation.
    pub fn machine(&self) -> Machine<'_> {
        Machine { as_measured: self.as_measured(), uncompensated: &self.model }
    }

    /// The plan in the control's numbers, beside the tables that were active.
    fn compile(&self, plan: &Plan) -> Result<Compiled, Problems> {
        let mut compiled = compile(self.task(), plan)?;
        if let Some(active) = &self.active {
            active::collisions(&self.job, &self.profile, active, &compiled.tables)?;
            compiled.stale =
                family(&self.profile.dialect).left_over(&active.tables, &compiled.tables);
            compiled.preconditions.extend(active::switched_off(&self.profile, &compiled.stale));
            compiled.assumptions.extend(active.assumptions.clone());
            compiled.notes.extend(self.notes.clone());
        }
        Ok(compiled)
    }

    pub(super) fn task(&self) -> Task<'_> {
        Task { job: &self.job, profile: &self.profile, model: &self.model }
    }
}

/// What a job asks of its control.
pub(crate) struct JobTables<'a> {
    pub(crate) inputs: &'a Inputs,
    pub(crate) plan: Plan,
    pub(crate) compiled: Compiled,
}

impl JobTables<'_> {
    /// The plan of a job, and what it compiles to.
    pub(crate) fn of(inputs: &Inputs) -> Result<JobTables<'_>, Problems> {
        let plan = plan(inputs.task())?;
        Ok(JobTables { inputs, compiled: inputs.compile(&plan)?, plan })
    }
}

/// Tables whose effect the semantics do not tell.
impl From<CannotEmulate> for Problems {
    fn from(reason: CannotEmulate) -> Problems {
        refusals::not_emulated(reason.0).into()
    }
}

/// Terms without a table, parts of the travel that were not measured, figures that become worse,
/// and the notes but for questions, which stand beside the verdict.
pub fn remarks(plan: &Plan, compiled: &Compiled, forecast: Option<&Forecast>) -> Vec<String> {
    let unmeasured = forecast.map(not_measured).unwrap_or_default();
    let worsened = forecast.map(Forecast::worsened).unwrap_or_default();
    let worsened = worsened.iter().map(|words| format!("WARNING: {words}"));
    let notes = compiled.notes.iter().filter(|note| note.severity() != Severity::Question);
    let notes = notes.map(|note| format!("note: {note}"));
    without_table(plan).into_iter().chain(unmeasured).chain(worsened).chain(notes).collect()
}

/// One line for each reason, with all terms that it holds for.
fn without_table(plan: &Plan) -> Vec<String> {
    let reasons = grouped(plan.omitted.iter().map(|own| (&own.reason, own.term))).into_iter();
    let line = |(reason, terms)| format!("no table for {}: {reason}", joined::<ErrorTerm>(terms));
    reasons.map(line).collect()
}

fn not_measured(forecast: &Forecast) -> Vec<String> {
    let sentence = |axis: Axis, (from, to): &(Millimetres, Millimetres)| {
        let [from, to] = [from, to].map(|at| rounded(at.mm(), 6));
        format!("not measured: {axis} from {from} to {to} mm; the table holds the end value there")
    };
    let unmeasured = forecast.unmeasured.iter();
    unmeasured
        .flat_map(|(axis, parts)| parts.iter().map(move |part| sentence(axis, part)))
        .collect()
}

/// Forecast against the acceptance; doubtful errors decide nothing in favour.
pub(super) fn judged(forecast: &Forecast, inputs: &Inputs, doubts: &[Finding]) -> Verdict {
    let doubtful = (!doubts.is_empty()).then_some(Verdict::Undecided);
    let verdict = forecast.verdict(inputs.job.acceptance);
    doubtful.map_or(verdict, |doubtful| verdict.max(doubtful))
}
