//! `nonius report JOB [--tables DIR] [--after FILE|JOB] -o report.html`

use crate::cli::campaign::read_campaign;
use crate::cli::files::read_argument;
use crate::cli::outcome::{Content, Outcome, Output, json_of};
use crate::cli::screen::Screen;
use crate::cli::verify::Judged;
use crate::cli::{assess, inputs, separate};
use crate::inputs::job::MeasuredData;
use crate::judge::conformity::Verdict;
use crate::kit::manifest::MANIFEST;
use crate::kit::{Inputs, generate, verify};
use crate::page::{Picture, Report, Shown, Texts};
use crate::quantity::diagonal::PathKind;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

// Options of `report`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required(true)
    .help("The page to write (HTML); `-` = standard output")))]
pub(super) struct Options {
    /// The job (TOML)
    job: PathBuf,
    /// Directory with the control's files [default: those that `generate` would write]
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// A measurement with these tables active: an error table (CSV) or a job (TOML)
    #[arg(long, value_name = "FILE|JOB", requires = "tables")]
    after: Option<PathBuf>,
    /// en, de, zh, or a file of texts (TOML)
    #[arg(long, value_name = "LANGUAGE|FILE", default_value = "en")]
    language: String,
    /// Unit of lengths on the page
    #[arg(long, value_enum, default_value_t = Unit::Mm)]
    unit: Unit,
    /// Sign of the company (PNG, JPEG or SVG)
    #[arg(long, value_name = "FILE")]
    logo: Option<PathBuf>,
    /// A template of one's own (docs/report.md)
    #[arg(long, value_name = "FILE")]
    template: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Unit {
    /// mm and µm
    Mm,
    /// Inches and µin
    Inch,
}

pub(super) fn run(options: &Options) -> Result<Outcome, Problems> {
    options.output.ensure_new("the report")?;
    let inputs = inputs::read(&options.job)?;
    let mut visit = Visit::default();
    let judged = visit.judged(options, &inputs)?;
    let page = judged.page(&inputs)?;
    let verdict = page.verdict();
    visit.documents.push(("verify", json_of(&page.document())?));
    visit.pictures.push(("curves", page.picture()?));
    visit.add_volume(options, &inputs)?;
    visit.add_readings(options, &inputs)?;
    let texts = texts(&options.language)?;
    let report = Report {
        texts: &texts,
        shown: match options.unit {
            Unit::Mm => Shown::Metric,
            Unit::Inch => Shown::Inch,
        },
        logo: options.logo.as_deref().map(logo).transpose()?,
        template: options.template.as_deref().map(own_template).transpose()?,
        job: &inputs.job,
        control: &inputs.profile.name,
        is_rehearsal: page.is_simulated(),
        doubts: page.doubts().iter().map(ToString::to_string).collect(),
        is_measured: options.after.is_some(),
        asked: page.asked(),
        documents: visit.documents,
        sizes: visit.sizes,
        pictures: visit.pictures,
    };
    let content = Content::Bytes(report.html()?.into_bytes());
    let screen = || Screen {
        verdict: format!("verdict on the page: {}", verdict.word()),
        ..Screen::default()
    };
    let document = || json!({ "schema": 1, "verdict": verdict.word() });
    let outcome = options
        .output
        .deliver(Some(content), screen, document, "")?;
    Ok(outcome.answering(verdict == Verdict::Pass))
}

/// What the page is made of.
#[derive(Default)]
struct Visit {
    documents: Vec<(&'static str, Value)>,
    pictures: Vec<(&'static str, Picture)>,
    sizes: Vec<(String, usize)>,
}

impl Visit {
    /// The tables of a directory, or those that `generate` would write.
    fn judged<'a>(
        &mut self,
        options: &'a Options,
        inputs: &Inputs,
    ) -> Result<Judged<'a>, Problems> {
        let Some(directory) = options.tables.as_deref() else {
            let kit = generate(inputs)?;
            self.documents.push(("kit", json_of(&kit.manifest)?));
            self.sizes = kit
                .files
                .iter()
                .map(|f| (f.path.clone(), f.bytes.len()))
                .collect();
            let state = Some(&kit.manifest.state);
            let verification = verify(inputs, &kit.kit_files(), state, Vec::new())?;
            return Ok(Judged::made(&options.job, verification));
        };
        let judged = Judged::read(inputs, &options.job, directory, options.after.as_deref())?;
        if let Ok((_, bytes)) = read_argument(&directory.join(MANIFEST)) {
            let manifest: Value = serde_json::from_slice(&bytes).unwrap_or_default();
            for file in manifest["files"].as_array().into_iter().flatten() {
                let name = file["path"].as_str().unwrap_or_default();
                // A manifest of others may name any path: only what lies in the directory is looked at.
                if Path::new(name).file_name() != Some(name.as_ref()) {
                    continue;
                }
                let size = std::fs::metadata(directory.join(name)).map(|found| found.len());
                let size = size.ok().and_then(|size| usize::try_from(size).ok());
                self.sizes.extend(size.map(|size| (name.to_string(), size)));
            }
            self.documents.push(("kit", manifest));
        }
        Ok(judged)
    }

    /// The volume, where three axes and the order of angles are known.
    fn add_volume(&mut self, options: &Options, inputs: &Inputs) -> Result<(), Problems> {
        // A machine of which too little is known has no figures of its volume.
        let Ok(page) = assess::for_report(inputs, options.tables.as_deref()) else {
            return Ok(());
        };
        self.documents
            .push(("assess", json_of(&assess::document(&page))?));
        self.pictures.push(("volume", page.picture()));
        Ok(())
    }

    fn add_readings(&mut self, options: &Options, inputs: &Inputs) -> Result<(), Problems> {
        let MeasuredData::Diagonals(measurement) = &inputs.job.measurement.data else {
            return Ok(());
        };
        if measurement.kind == PathKind::Step {
            let separation = read_campaign(&options.job)?.separate()?;
            self.pictures
                .push(("readings", separate::diagonals(&separation)?));
        }
        Ok(())
    }
}

fn texts(language: &str) -> Result<Texts, Problems> {
    if let Some(shipped) = Texts::shipped(language) {
        return shipped;
    }
    let path = Path::new(language);
    if !path.is_file() {
        let shipped: Vec<&str> = Texts::languages().collect();
        let help = format!(
            "expected one of {}, or a file of texts (docs/report.md)",
            shipped.join(", ")
        );
        return Err(Problem::new(format!("there are no texts `{language}`"))
            .help(help)
            .into());
    }
    let (name, bytes) = read_argument(path)?;
    let stem = Path::new(language).file_stem();
    let stem = stem.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Texts::read(&Source::from_bytes(&name, &bytes)?, &stem)
}

fn own_template(path: &Path) -> Result<(String, String), Problems> {
    let (name, bytes) = read_argument(path)?;
    let source = Source::from_bytes(&name, &bytes)?;
    Ok((name, source.text))
}

/// A picture as text of the page.
fn logo(path: &Path) -> Result<String, Problems> {
    let (name, bytes) = read_argument(path)?;
    let kinds: [(&[u8], &str); 3] = [
        (b"\x89PNG", "image/png"),
        (b"\xff\xd8\xff", "image/jpeg"),
        (b"<", "image/svg+xml"),
    ];
    let kind = kinds
        .into_iter()
        .find(|(start, _)| bytes.starts_with(start));
    let Some((_, kind)) = kind else {
        let words = format!("`{name}` is no picture that a page can hold");
        return Err(Problem::new(words)
            .help("give a PNG, a JPEG or an SVG")
            .into());
    };
    Ok(format!("data:{kind};base64,{}", base64(&bytes)))
}

/// RFC 4648 §4.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |n: usize| u32::from(three.get(n).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for n in 0..4 {
            let letter = LETTERS[((bits >> (18 - 6 * n)) & 63) as usize];
            text.push(if n as usize <= three.len() {
                char::from(letter)
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_rfc_4648() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
