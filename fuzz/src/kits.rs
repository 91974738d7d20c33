//! Kits from end to end in this process: what `generate`, `verify`, `separate` and `program` do, without files.

use crate::bundle::Bundle;
use crate::grammar;
use crate::oracles;
use crate::readers::{Answer, built_in, profile_of};
use nonius::control::controller::{KitFile, Profile, Role};
use nonius::inputs::error_table::{self, Draft, ErrorTable};
use nonius::inputs::job::{ActiveTables, DiagonalMeasurement, Job, LinearSlope, MeasuredData};
use nonius::inputs::readings::Readings;
use nonius::judge::active::KitManifest;
use nonius::judge::active::{ReadOutFor, from_kit, from_read_out};
use nonius::kit::{Inputs, generate as make, hashed, verify as judge};
use nonius::machine::separation::campaign::{NamedTables, campaign};
use nonius::machine::separation::straight::straight;
use nonius::machine::separation::{separate, table};
use nonius::text::{Problem, Problems, Source};

fn source(bundle: &Bundle, name: &str) -> Result<Source, Problems> {
    let bytes = bundle.file(name).ok_or_else(|| Problem::new("no such file"))?;
    Source::from_bytes(name, bytes)
}

fn job_of(bundle: &Bundle) -> Result<(Job, Profile), Problems> {
    let job = Job::read(source(bundle, "job.toml")?)?;
    let controller = job.compensation.controller.clone();
    let profile = match controller.ends_with(".toml") {
        true => profile_of(bundle, Some(&controller))?,
        false => built_in(&controller)?,
    };
    Ok((job, profile))
}

/// What a kit of the bundle is made from.
pub fn inputs_of(bundle: &Bundle) -> Result<Inputs, Problems> {
    let (job, profile) = job_of(bundle)?;
    let table = match &job.measurement.data {
        MeasuredData::Errors(paths) => {
            let tables = paths.iter().map(|path| ErrorTable::read(source(bundle, path)?));
            let tables = tables.collect::<Result<Vec<ErrorTable>, Problems>>()?;
            ErrorTable::merged(tables)?.ok_or_else(|| Problem::new("no table"))?
        }
        MeasuredData::Diagonals(measurement) => separated(bundle, &job, measurement)?,
    };
    let hashes = bundle.0.iter().map(|(name, bytes)| hashed(name, bytes)).collect();
    let angles = job.measurement.angles.clone();
    let mut inputs = Inputs::new(job, profile, &table, hashes)?;
    if let Some(path) = angles {
        inputs = inputs.with(Some(&ErrorTable::read(source(bundle, &path)?)?), None)?;
    }
    match inputs.job.measurement.active.clone() {
        ActiveTables::Path(path) => with_active(bundle, inputs, &path),
        _ => Ok(inputs),
    }
}

/// The tables that were active: a file, or the files of a folder.
fn with_active(bundle: &Bundle, inputs: Inputs, path: &str) -> Result<Inputs, Problems> {
    let folder = format!("{path}/");
    let own = bundle.0.iter().filter(|(name, _)| name == path || name.starts_with(&folder));
    let mut files: Vec<(String, Vec<u8>)> = own.cloned().collect();
    for (name, _) in &mut files {
        *name = name.trim_start_matches(&folder).to_string();
    }
    let manifest = files.iter().position(|(name, _)| name == "manifest.json");
    let active = match manifest.map(|at| files.remove(at).1) {
        Some(manifest) => from_kit(&inputs.job, &inputs.profile, path, &manifest, files)?,
        None => from_read_out(&inputs.job, &inputs.profile, path, files, ReadOutFor::OldTables)?,
    };
    inputs.with_active(active)
}

fn separated(
    bundle: &Bundle,
    job: &Job,
    measurement: &DiagonalMeasurement,
) -> Result<ErrorTable, Problems> {
    let readings = Readings::read(source(bundle, &measurement.readings)?, measurement)?;
    let mut tables = NamedTables::default();
    for linear in &measurement.linear {
        tables.linear.push(match &linear.slope {
            LinearSlope::Stated(_) | LinearSlope::NotYet => None,
            LinearSlope::Errors(path) => Some(ErrorTable::read(source(bundle, path)?)?),
        });
    }
    if let Some(path) = &job.measurement.angles {
        tables.angles = Some(ErrorTable::read(source(bundle, path)?)?);
    }
    let known = readings.runs.iter().all(|run| readings.offset_known(run));
    let campaign = campaign(job, measurement, &tables, known)?;
    if measurement.kind == nonius::quantity::PathKind::Straight {
        straight(&campaign, &readings.runs, None)?;
        return Err(Problem::new("straight runs").into());
    }
    let separation = separate(&campaign, &readings.runs);
    let draft: Draft = table::draft(&separation, job, Vec::new());
    ErrorTable::read(Source::from_bytes("separated", error_table::write(&draft).as_bytes())?)
}

/// Readings with their job: the table that they are separated into is one that is read.
pub fn readings(input: &[u8]) -> Answer {
    let bundle = Bundle::read(input);
    let job = Job::read(source(&bundle, "job.toml")?)?;
    let MeasuredData::Diagonals(measurement) = &job.measurement.data else {
        return Err(Problem::new("no readings").into());
    };
    separated(&bundle, &job, measurement).map(|table| table.source.text)
}

/// A kit of a job: every file fits the grammar of its family, and `verify` finds what `generate` forecasts.
pub fn generate(input: &[u8]) -> Answer {
    let inputs = inputs_of(&Bundle::read(input))?;
    let kit = make(&inputs)?;
    let manifest = kit.manifest_bytes()?;
    let named: KitManifest = serde_json::from_slice(&manifest).expect("a manifest is read back");
    let found = match judge(&inputs, &kit.files, named.state.as_ref(), Vec::new()) {
        Ok(found) => found,
        Err(problems) => panic!("verify refuses what generate made: {}", problems.render()),
    };
    assert!(found.agrees(), "verify differs from generate: {:?}", found.disagreements());
    assert!(
        found.verdict == kit.verdict,
        "verify says {:?}, generate {:?}",
        found.verdict,
        kit.verdict
    );
    let is_builtin = !inputs.job.compensation.controller.ends_with(".toml");
    let mut text = String::from_utf8_lossy(&manifest).into_owned();
    for file in &kit.files {
        text += &oracles::text(&file.bytes);
        if is_builtin && !matches!(file.role, Role::Checklist | Role::Report) {
            grammar::judge(&inputs.profile.dialect, &file.path, &file.bytes)
                .unwrap_or_else(|wrong| panic!("grammar: {wrong}"));
        }
    }
    Ok(text)
}

/// Files of a control, judged against a job: whatever is not a file of the job is one of the control.
pub fn verify(input: &[u8]) -> Answer {
    let bundle = Bundle::read(input);
    let inputs = inputs_of(&bundle)?;
    let files =
        bundle.0.iter().filter(|(name, _)| !name.ends_with(".toml") && !name.starts_with("errors"));
    let files: Vec<KitFile> = files
        .map(|(path, bytes)| KitFile {
            path: path.to_string(),
            role: role(&inputs.profile, path),
            bytes: bytes.to_vec(),
        })
        .collect();
    let named = bundle.file("manifest.json");
    let named = named.and_then(|bytes| serde_json::from_slice::<KitManifest>(bytes).ok());
    let found = judge(&inputs, &files, named.unwrap_or_default().state.as_ref(), Vec::new())?;
    Ok(format!("{:?} {:?} {:?}", found.verdict, found.disagreements(), found.notes()))
}

fn role(profile: &Profile, name: &str) -> Role {
    let own = profile.files.iter().find(|file| file.is_called(name));
    own.map_or(Role::Report, |file| file.role)
}

/// The part programs of a measuring run, which were walked before they are given away.
pub fn program(input: &[u8]) -> Answer {
    let (job, profile) = job_of(&Bundle::read(input))?;
    let kit = nonius::kit::program_kit::make(&job, &profile, &[])?;
    let texts = kit.files.iter().map(|file| oracles::text(&file.bytes));
    Ok(texts.collect())
}
