//! Files of a user → the measurement with the tables active.

use crate::cli::inputs::{self, file_name, read_argument};
use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::{ActiveTables, Job, MeasuredData};
use crate::judge::active::ActiveControl;
use crate::judge::after::{AfterMeasurement, ensure_same_machine};
use crate::judge::disagreement::{compare, measuring_systems};
use crate::kit::manifest::HashedFile;
use crate::kit::{Inputs, Verification, cannot_emulate, emulator, hashed};
use crate::machine::model::ErrorModel;
use crate::quantity::diagonal::PathKind;
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems};
use std::path::Path;

/// A second measurement, and every file that it was read from.
pub(super) struct Second {
    pub(super) measurement: AfterMeasurement,
    pub(super) hashes: Vec<HashedFile>,
    /// What its job states or leaves open, one sentence each.
    pub(super) notes: Vec<String>,
    /// Its job, and the tables that were active as it names them, where they lie elsewhere.
    active: Option<(Job, ActiveControl)>,
}

/// Reads an error table, or a job with errors, readings or straight diagonals, measured with the
/// tables of a directory active.
pub(super) fn read(first: &Inputs, path: &Path, tables: &Path) -> Result<Second, Problems> {
    let (name, bytes) = read_argument(path)?;
    let mut hashes = vec![hashed(&file_name(path), &bytes)];
    let source = Source::from_bytes(&name, &bytes)?;
    if !is_job(path, &source.text) {
        return Ok(Second {
            measurement: of_table(first, source)?,
            hashes,
            notes: Vec::new(),
            active: None,
        });
    }
    let job = Job::read(source)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    ensure_same_machine(&first.job, &job)?;
    let active = active(first, &job, folder, tables)?;
    Ok(Second {
        measurement: of_job(&job, folder, &mut hashes)?,
        hashes,
        notes: notes(&job, tables),
        active: active.map(|active| (job, active)),
    })
}

const ACTIVE: &str = "measurement.active_while_measuring";

/// What was active as the second job names it; `None` where it says nothing, or names the tables
/// that are judged.
fn active(
    first: &Inputs,
    job: &Job,
    folder: &Path,
    tables: &Path,
) -> Result<Option<ActiveControl>, Problems> {
    match &job.measurement.active {
        ActiveTables::NotStated => Ok(None),
        ActiveTables::None => Err(job
            .problem_at(
                ACTIVE,
                format!("the measurement afterwards shows the machine with `{}` active, but its job says that no table was", tables.display()),
            )
            .help("name the kit that was loaded, relative to this job; if none was loaded, it is a measurement to make tables from")
            .into()),
        ActiveTables::Path(path) => {
            let place = |path: &Path| std::fs::canonicalize(path).ok();
            let own = place(&folder.join(path));
            if own.is_some() && own == place(tables) {
                return Ok(None);
            }
            inputs::active_control(job, &first.profile, folder, &mut Vec::new())
        }
    }
}

/// What a second job states that its figures do not hold, and what it leaves open.
fn notes(job: &Job, tables: &Path) -> Vec<String> {
    let mut notes = job.measurement.notes();
    if job.measurement.active == ActiveTables::NotStated {
        notes.push(format!(
            "the job of the second measurement does not state `active_while_measuring`: the tables in {} are taken to have been active",
            tables.display()
        ));
    }
    notes
}

impl Second {
    /// Refuses a measurement that was taken with other tables than those that are judged.
    pub(super) fn ensure_active(
        &self,
        first: &Inputs,
        verification: &Verification,
    ) -> Result<(), Problems> {
        let Some((job, active)) = &self.active else {
            return Ok(());
        };
        let mut state = verification.state.clone();
        for (axis, um) in active.backlash_um.iter() {
            let names = &verification.plan.names[axis];
            let own = state.axes.iter_mut().filter(|a| names.contains(&a.name));
            own.for_each(|a| a.backlash_um = um.unwrap_or(a.backlash_um));
        }
        let control = |tables, state| {
            emulator(&first.profile, tables, state).map_err(|reason| cannot_emulate(&reason))
        };
        let judged = control(&verification.found, &verification.state)?;
        let active_then = control(&active.tables, &state)?;
        let mut words = measuring_systems(&verification.found, &active.tables);
        words.extend(compare(&verification.plan, judged.as_ref(), active_then.as_ref()).findings);
        if words.is_empty() {
            return Ok(());
        }
        let mut problems = Problems::from(
            job.problem_at(ACTIVE, "the measurement afterwards was taken with other tables active than those that are judged; below, `the tables` are the active ones and `the job` stands for the judged ones")
                .help("name with `--tables` what was active, or with `active_while_measuring` what was loaded"),
        );
        words
            .into_iter()
            .for_each(|words| problems.push(Problem::new(words.to_string())));
        Err(problems)
    }
}

/// A job is a `.toml` file, or begins with a key or a section.
fn is_job(path: &Path, text: &str) -> bool {
    let ending = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    let lines = text.lines().map(str::trim);
    let mut content = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    let begins = content.next().is_some_and(|line| line.contains(['=', '[']));
    ending.is_some_and(|ending| ending == "toml") || begins
}

/// An error table counts in the coordinates of the first job.
fn of_table(first: &Inputs, source: Source) -> Result<AfterMeasurement, Problems> {
    refuse_readings(&source)?;
    let table = ErrorTable::read(source)?;
    if !first.job.measurement.squareness.is_empty() {
        return Err(Problem::new(
            "the first job adds `squareness_um_per_m` to its errors; whether the slopes of this table hold the squareness is not stated",
        )
        .at(table.header.clone())
        .help("give a job with `errors` and its own `squareness_um_per_m` (none, if the slopes hold it)")
        .into());
    }
    Ok(AfterMeasurement::Errors(Box::new(ErrorModel::build(
        &first.job, &table,
    )?)))
}

/// Readings by themselves do not say how they were taken.
fn refuse_readings(source: &Source) -> Result<(), Problem> {
    let mut lines = source.text.lines().zip(1..);
    let is_head = |line: &str| !line.trim().is_empty() && !line.starts_with('#');
    let head = lines.find(|(line, _)| is_head(line));
    match head.filter(|(line, _)| line.to_ascii_lowercase().contains("diagonal")) {
        None => Ok(()),
        Some((text, line)) => Err(Problem::new(
            "these are readings of the diagonals, expected an error table (CSV) or a job (TOML)",
        )
        .at(Place {
            line,
            ..Place::in_text(&source.name, text, 0, text.len())
        })
        .help(
            "write a job that names them with `readings = …`: how they were walked stands there",
        )),
    }
}

fn of_job(
    job: &Job,
    folder: &Path,
    hashes: &mut Vec<HashedFile>,
) -> Result<AfterMeasurement, Problems> {
    if let MeasuredData::Diagonals(measurement) = &job.measurement.data
        && measurement.kind == PathKind::Straight
    {
        let files = inputs::campaign_files(job, measurement, folder, hashes)?;
        return Ok(AfterMeasurement::Diagonals(files.straight_runs()?));
    }
    let table = inputs::error_table(job, folder, hashes)?;
    Ok(AfterMeasurement::Errors(Box::new(ErrorModel::build(
        job, &table,
    )?)))
}
