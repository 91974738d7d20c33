//! Files of a user → the measurement with the tables active.

use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::{ActiveTables, Job, MeasuredData, day};
use crate::inputs::kind::FileKind;
use crate::judge::active::{ActiveControl, HashedFile};
use crate::judge::after::{AfterMeasurement, ensure_same_machine, same_slopes};
use crate::judge::causes::{Slip, WithoutSlip};
use crate::judge::disagreement::compare;
use crate::judge::disagreement::contents::measuring_systems;
use crate::judge::findings::AsLeft;
use crate::kit::findings::KitFinding;
use crate::kit::{Inputs, Loaded, emulator};
use crate::machine::model::ErrorModel;
use crate::machine::separation::table::ErrorSource;
use crate::quantity::PathKind;
use crate::text::{Finding, Problem, Problems, Source, header_and_rows, joined};
use crate::visit::files::{Files, printed};
use crate::visit::inputs::{self, ACTIVE};
use crate::visit::job_files::{CampaignFiles, InputFile, JobFiles};
use crate::visit::refusals;
use std::path::Path;

/// A second measurement, and every file that it was read from.
pub(crate) struct Second {
    pub(crate) measurement: AfterMeasurement,
    /// What its errors were read from; absent = an error table alone, or straight runs.
    pub(crate) errors: Option<ErrorSource>,
    pub(crate) hashes: Vec<HashedFile>,
    /// What its job states or leaves open, one sentence each.
    pub(crate) notes: Vec<Finding>,
    /// Its job; absent = an error table alone.
    pub(crate) job: Option<Job>,
    /// The tables that were active as its job names them, where they lie elsewhere.
    active: Option<ActiveControl>,
}

/// What was active as the second job names it; `None` where it says nothing, or names the tables
/// that are judged.
fn active(
    first: &Inputs,
    files: &JobFiles<'_>,
    tables: &Path,
) -> Result<Option<ActiveControl>, Problems> {
    let job = &files.job;
    match &job.measurement.active {
        ActiveTables::NotStated => Ok(None),
        ActiveTables::None => {
            Err(job.source.at(ACTIVE, refusals::says_without_tables(printed(tables))).into())
        }
        ActiveTables::Path(path) => {
            if files.files.same(&files.folder.join(path), tables) {
                return Ok(None);
            }
            inputs::active(files, &first.profile)
        }
    }
}

/// What a second job states that its figures do not hold, and what it leaves open.
fn notes(job: &Job, tables: &Path) -> Vec<Finding> {
    let mut notes = job.measurement.notes();
    if job.measurement.active == ActiveTables::NotStated {
        let tables = printed(tables);
        notes.push(KitFinding::TakenToBeActive { tables }.into());
    }
    notes
}

impl Second {
    /// Reads an error table, or a job with errors, readings or straight diagonals, measured with the
    /// tables of a directory active.
    pub(crate) fn read(
        files: &dyn Files,
        first: &Inputs,
        path: &Path,
        tables: &Path,
    ) -> Result<Second, Problems> {
        let file = InputFile::read(files, path)?;
        let (kind, source) = (file.kind(), file.source()?);
        if kind == FileKind::Readings {
            return Err(readings_alone(&source).into());
        }
        if kind != FileKind::Job {
            return Ok(Second {
                measurement: of_table(first, source)?,
                errors: None,
                hashes: vec![file.hash],
                notes: Vec::new(),
                job: None,
                active: None,
            });
        }
        let job = Job::read_second(source, &first.job)?;
        ensure_same_machine(&first.job, &job)?;
        let named = JobFiles::new(files, job, path);
        let active = active(first, &named, tables)?;
        named.hashes.replace(vec![file.hash]);
        let (measurement, errors) = of_job(&first.job, &named)?;
        let JobFiles { job, hashes, .. } = named;
        Ok(Second {
            measurement,
            errors,
            hashes: hashes.into_inner(),
            notes: notes(&job, tables),
            job: Some(job),
            active,
        })
    }

    /// `date` and protocol of its job: when it was measured, by whom, with what; nothing without a job.
    pub(crate) fn protocol(&self) -> Vec<(String, String)> {
        let measurement = self.job.iter().map(|job| &job.measurement);
        let of = measurement.flat_map(|of| {
            let date = of.date.iter().map(|date| ("date".to_string(), date.clone()));
            date.chain(of.protocol.clone())
        });
        of.collect()
    }

    /// The files that it was read from.
    pub(crate) fn files_words(&self) -> String {
        let names = joined(self.hashes.iter().map(|file| &file.path));
        format!("measured afterwards, with the tables active: {names}")
    }

    /// Refuses a measurement that was taken with other tables than those that are judged.
    pub(crate) fn ensure_active(
        &self,
        first: &Inputs,
        loaded: &Loaded<'_>,
    ) -> Result<(), Problems> {
        let (Some(job), Some(active)) = (&self.job, &self.active) else {
            return Ok(());
        };
        let plan = &loaded.asked.plan;
        let mut state = loaded.state.clone();
        for (axis, um) in active.backlash_um.iter() {
            let names = &plan.names[axis];
            let own = state.axes.iter_mut().filter(|a| names.contains(&a.name));
            own.for_each(|a| a.backlash_um = um.unwrap_or(a.backlash_um));
        }
        let judged = loaded.control()?;
        let active_then = emulator(&first.profile, &active.tables, &state)?;
        let mut words = measuring_systems(&first.profile, &loaded.tables, &active.tables);
        words.extend(compare(plan, judged, active_then.as_ref()).findings);
        if words.is_empty() {
            return Ok(());
        }
        let other = refusals::other_tables_active();
        let mut problems = Problems::from(job.source.at(ACTIVE, other));
        words.into_iter().for_each(|words| problems.push(Problem::new(words.to_string())));
        Err(problems)
    }
}

/// An error table counts in the coordinates of the first job.
fn of_table(first: &Inputs, source: Source) -> Result<AfterMeasurement, Problems> {
    let table = ErrorTable::read(source)?;
    if !first.job.measurement.squareness.is_empty() {
        return Err(refusals::squareness_unclear().at(table.header.clone()).into());
    }
    Ok(AfterMeasurement::Errors(Box::new(ErrorModel::build(&first.job, &table)?)))
}

/// Readings by themselves do not say how they were taken.
fn readings_alone(source: &Source) -> Problem {
    let problem = refusals::readings_alone();
    match header_and_rows(source) {
        Some((header, _)) => problem.at(header.cell_place(0)),
        None => problem,
    }
}

fn of_job(
    first: &Job,
    files: &JobFiles<'_>,
) -> Result<(AfterMeasurement, Option<ErrorSource>), Problems> {
    let job = &files.job;
    if let MeasuredData::Diagonals(measurement) = &job.measurement.data
        && measurement.kind == PathKind::Straight
    {
        let campaign = CampaignFiles::read(files, measurement)?;
        return Ok((AfterMeasurement::Diagonals(campaign.straight_runs()?), None));
    }
    let errors = inputs::errors(files)?;
    let mut model = ErrorModel::build(job, &*errors.table(job)?)?;
    model.remarks.doubts.splice(0..0, same_slopes(first, job));
    model.remarks.doubts.extend(earlier(first, job));
    Ok((AfterMeasurement::Errors(Box::new(model)), Some(errors)))
}

/// A second measurement before the first one, where both dates are written as 2026-11-24.
fn earlier(first: &Job, second: &Job) -> Option<Finding> {
    let [first, second] = [first, second].map(|job| day(job.measurement.date.as_ref()));
    let (first, second) = (first?, second?);
    (second < first).then(|| AsLeft::Earlier { first, second }.into())
}

/// The machine as found under each slip of the records of the first measurement; none where its job
/// gives errors, not readings.
pub(crate) fn corrected(
    files: &dyn Files,
    first: &Inputs,
    job_path: &Path,
) -> Result<Vec<WithoutSlip>, Problems> {
    let Inputs { job, profile, .. } = first;
    let MeasuredData::Diagonals(measurement) = &job.measurement.data else {
        return Ok(Vec::new());
    };
    if measurement.kind != PathKind::Step {
        return Ok(Vec::new());
    }
    let campaign = CampaignFiles::read(&JobFiles::new(files, job.clone(), job_path), measurement)?;
    // The machine without tables, by the way that the job itself is read.
    let model = |slip| -> Result<ErrorModel, Problems> {
        let errors = campaign.without(slip).errors()?;
        let inputs = Inputs::new(job.clone(), profile.clone(), errors, Vec::new())?;
        Ok(inputs.with(None, first.active.clone())?.model)
    };
    let slips = Slip::all(measurement.volume.order).into_iter();
    // Readings that do not go through with a slip taken back do not hold it.
    let corrected = slips.filter_map(|slip| {
        let before = model(slip).ok()?;
        Some(WithoutSlip { slip, before })
    });
    Ok(corrected.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::answer;
    use crate::inputs::job::UseOf;
    use crate::quantity::ErrorTerm;
    use crate::visit::files::Memory;

    #[test]
    fn a_second_measurement_before_the_first_is_a_doubt() {
        let job = |date: &str| {
            let text = format!(
                "schema = 1\n[machine]\nname = \"M\"\n[measurement]\ndate = \"{date}\"\nerrors = \"e.csv\"\n"
            );
            let source = Source::from_bytes("job.toml", text.as_bytes()).unwrap();
            Job::read_for(source, UseOf::Figures).unwrap_or_else(|p| panic!("{}", p.render()))
        };
        let is_earlier = |second: &str| earlier(&job("2026-11-20"), &job(second)).is_some();
        assert!(is_earlier("2026-11-19") && is_earlier("2025-12-01"));
        assert!(!is_earlier("2026-11-20") && !is_earlier("19.11.2026") && !is_earlier("today"));
    }

    /// Over the largest value lies g u, Student's factor once where σ was estimated (docs/method.md §23).
    #[test]
    fn what_errors_as_left_are_at_most_has_students_factor_once() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/start/readings/");
        let text = |name: &str| {
            let text = std::fs::read_to_string(format!("{folder}{name}")).unwrap();
            (name.to_string(), text.replace("angle_urad = 10.0", "angle_urad = 0"))
        };
        let all = ["job.toml", "readings.csv", "after.toml", "after.csv"].map(text);
        let files = Memory::of(all.each_ref().map(|(name, text)| (&**name, text.as_bytes())));
        let answered = |command: &str| answer(&files, command.split(' '));
        assert_eq!(answered("generate job.toml -o kit").status, 0);
        let judged = answered("verify job.toml --tables kit --after after.toml --format json");
        let page: serde_json::Value = serde_json::from_slice(&judged.out).unwrap();
        let times = ErrorTerm::ALL.map(|term| {
            let of = |key: &str| page["terms"][term.to_string()][key].as_f64().unwrap();
            (of("at_most_um") - of("after_um")) / of("u_um")
        });
        // The 95 % quantile of Student's distribution for 9 degrees of freedom is 1.833.
        let most = times.into_iter().fold(0.0, f64::max);
        assert!((most - 1.833).abs() < 0.005, "{times:?}");
    }
}
