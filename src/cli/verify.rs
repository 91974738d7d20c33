//! `nonius verify JOB --tables DIR [--after FILE|JOB]`

mod page;
mod records;
mod second;

use self::records::First;
use crate::cli::directory::{Found, read_directory};
use crate::cli::inputs;
use crate::cli::outcome::Outcome;
use crate::cli::screen::{Detail, More, Screen};
use crate::cli::{Answer, Format, show};
use crate::judge::conformity::Verdict;
use crate::judge::forecast::Forecast;
use crate::kit::manifest::{MANIFEST, diagonals, picometres};
use crate::kit::{Inputs, Verification, remarks, verify, verify_read_out};
use crate::text::finding::{Finding, Severity};
use crate::text::problem::{Problems, shown};
use clap::Args;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

// Options of `verify`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Directory with the control's files
    #[arg(long, value_name = "DIR")]
    tables: PathBuf,
    /// A measurement with these tables active, against the forecast: an error table (CSV) or a job (TOML)
    #[arg(long, value_name = "FILE|JOB")]
    after: Option<PathBuf>,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    detail: Detail,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    let (directory, format) = (options.tables.as_path(), options.format);
    let inputs = inputs::read(&options.job)?;
    let second = options
        .after
        .as_deref()
        .map(|path| second::read(&inputs, path, directory))
        .transpose()?;
    let found = read_directory(&inputs, directory)?;
    let mut verification = judged(&inputs, directory, &found)?;
    if found.names_missing {
        let is_note = |found: &Finding| found.severity() == Severity::Note;
        verification.findings.retain(|found| !is_note(found)); // a listed file that is missing was named
    }
    let notes = found.notes.iter().chain(&found.other_inputs);
    notes.for_each(|words| verification.note(words.clone()));
    if let Some(second) = second {
        let folder = options.job.parent().unwrap_or(Path::new(""));
        let first = First {
            inputs: &inputs,
            folder,
        };
        return page::answer(
            first,
            directory,
            &verification,
            &second,
            (format, options.detail),
        );
    }
    let outcome = match format {
        Format::Json => Outcome::json(&document(&inputs, &verification))?,
        Format::Text => {
            let screen = screen(&inputs, directory, &verification);
            Outcome::text(&screen.page(options.detail))
        }
    };
    Ok(outcome.answering(Answer::yes(verification.verdict == Verdict::Pass)))
}

/// The files of a directory against the job.
fn judged(inputs: &Inputs, directory: &Path, found: &Found) -> Result<Verification, Problems> {
    match found.read_out(inputs, directory)? {
        Some(control) => verify_read_out(inputs, &control),
        None => judged_as_kit(inputs, found),
    }
}

fn judged_as_kit(inputs: &Inputs, found: &Found) -> Result<Verification, Problems> {
    let named = found.state.as_ref();
    let mut verification = verify(inputs, &found.kit_files(), named, found.remarks.clone())
        .map_err(|problems| found.instead_of(problems))?;
    if named.is_none() {
        let words = format!(
            "there is no {MANIFEST}, so nothing tells whether all files are there and as they were made"
        );
        verification.note(words);
        let called = found.called_as_a_kit(&inputs.profile).map(|name| {
            format!(
                "judged as a kit that is to be loaded, because `{}` is called as in one: give files that were read out of the control other names",
                shown(name)
            )
        });
        called
            .into_iter()
            .for_each(|words| verification.note(words));
    }
    let differences = verification.disagreements().len();
    if differences > 0 && differences == found.changed && found.remarks.len() == differences {
        let words = "read back, tables and switches are as the job asks: what differs is something else (line ends, comments, words such as NEWCONF, more memory); copy the files from the kit again";
        verification.note(words.to_string());
    }
    Ok(verification)
}

fn heading(inputs: &Inputs, directory: &Path) -> String {
    format!(
        "{} - {}, tables read from {}",
        inputs.job.machine.name,
        inputs.profile.name,
        directory.display()
    )
}

fn agreement(verification: &Verification) -> String {
    match verification.disagreements().as_slice() {
        [] => "job and tables agree".to_string(),
        some => format!("job and tables DISAGREE:\n  - {}", some.join("\n  - ")),
    }
}

fn verdict(inputs: &Inputs, verification: &Verification) -> String {
    show::verdict(
        verification.verdict,
        &inputs.job,
        verification.forecast.as_ref(),
        !verification.agrees(),
        &verification.doubts,
    )
}

fn screen(inputs: &Inputs, directory: &Path, verification: &Verification) -> Screen {
    let (forecast, compiled) = (verification.forecast.as_ref(), &verification.compiled);
    let table = |forecast| show::forecast(forecast, &compiled.placements);
    let remarks = remarks(&verification.plan, compiled, forecast);
    Screen {
        verdict: [
            verdict(inputs, verification),
            agreement(verification),
            heading(inputs, directory),
        ]
        .join("\n"),
        figures: forecast.map(table).into_iter().collect(),
        findings: [absent(&verification.notes()), remarks].concat(),
        always: show::assumed_signs(&compiled.assumptions, &[]),
        more: vec![More {
            count: show::effective(&compiled.assumptions),
            what: "assumptions",
            text: show::assumptions(&compiled.assumptions),
        }],
    }
}

fn absent(notes: &[String]) -> Vec<String> {
    notes.iter().map(|note| format!("note: {note}")).collect()
}

fn document(inputs: &Inputs, verification: &Verification) -> Value {
    let mut terms = Map::new();
    for term in verification.forecast.iter().flat_map(|f| &f.terms) {
        terms.insert(
            term.term.to_string(),
            json!({
                "before_um": picometres(term.before_um),
                "forecast_um": picometres(term.after_um),
                "u_um": term.u_um.map(picometres),
                "expanded_um": term.expanded_um.map(picometres),
                "max_residual_um": picometres(term.after_um),
            }),
        );
    }
    let forecast = verification.forecast.as_ref();
    let notes: Vec<String> = verification
        .notes()
        .into_iter()
        .chain(verification.compiled.notes.clone())
        .chain(forecast.map(Forecast::worsened).unwrap_or_default())
        .collect();
    let misses = forecast.map(|f| f.misses(inputs.job.acceptance));
    let causes: Vec<String> = verification
        .disagreements()
        .into_iter()
        .chain(misses.unwrap_or_default())
        .chain(verification.doubts.iter().cloned())
        .collect();
    json!({
        "schema": 1,
        "verdict": verification.verdict.word(),
        "terms": terms,
        "max_residual_um": forecast.map(|f| picometres(f.max_residual_um())),
        "max_residual_expanded_um": forecast.and_then(Forecast::max_expanded_um).map(picometres),
        "diagonals": forecast.map(|f| diagonals(&f.diagonals, "forecast_um")),
        "causes": causes,
        "assumptions": verification.compiled.assumptions,
        "notes": notes,
    })
}
