//! `nonius report JOB|ERRORS [--tables DIR] [--after FILE|JOB] [--linear FILE] -o report.html`

use crate::cli::outcome::{Outcome, Output, held};
use crate::cli::refusals;
use crate::cli::screen::Screen;
use crate::cli::{assess, standards, verify};
use crate::control::controller::Template;
use crate::inputs::job::{Job, UseOf};
use crate::inputs::kind::FileKind;
use crate::judge::active::{HashedFile, KitManifest};
use crate::judge::conformity::Verdict;
use crate::kit::manifest::{MANIFEST, rounded};
use crate::kit::{self, Inputs, generate};
use crate::machine::separation::table::ErrorSource;
use crate::page::{
    Curves, DisplayUnit, Locale, PagePicture, Report, Texts, Visit, linear_document, terms,
};
use crate::text::{Finding, Problem, Problems, joined, json_page, template_text};
use crate::visit::files::{Files, PathEntry, file_name};
use crate::visit::inputs;
use crate::visit::job_files::{InputFile, JobFiles};
use clap::Args;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

// Options of `report`.
#[derive(Args, Debug)]
#[command(mut_arg("output", |arg| arg.required(true)
    .help("The page to write (HTML); `-` = standard output")))]
pub(super) struct Options {
    /// The job (TOML), or an error table (CSV); `-` = standard input
    job: PathBuf,
    /// Directory with the control's files [default: those that `generate` would write; as found
    /// where the job states no [compensation.axes]]
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// A measurement with these tables active: an error table (CSV) or a job (TOML)
    #[arg(long, value_name = "FILE|JOB", requires = "tables")]
    after: Option<PathBuf>,
    /// Runs of one axis (CSV): its figures by ISO 230-2; may be given several times
    #[arg(long, value_name = "FILE")]
    linear: Vec<PathBuf>,
    /// en, de, zh, or a file of texts (TOML)
    #[arg(long, value_name = "LANGUAGE|FILE", default_value = "en")]
    language: String,
    /// Unit of lengths on the page
    #[arg(long, value_enum, default_value_t = DisplayUnit::Metric)]
    unit: DisplayUnit,
    /// Sign of the company (PNG, JPEG or SVG)
    #[arg(long, value_name = "FILE")]
    logo: Option<PathBuf>,
    /// A template of one's own (docs/visit.md §11)
    #[arg(long, value_name = "FILE")]
    template: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

pub(super) fn run(options: &Options, files: &dyn Files) -> Result<Outcome, Problems> {
    options.output.ensure_new(files, "the report")?;
    let texts = texts(files, &options.language)?;
    let locale = Locale { texts: &texts, shown: options.unit };
    let (job, mut visit) = visit(options, files, locale)?;
    for file in &options.linear {
        visit.add_linear(files, locale, file)?;
    }
    let report = Report {
        locale,
        logo: options.logo.as_deref().map(|path| logo(files, path)).transpose()?,
        template: options.template.as_deref().map(|path| own_template(files, path)).transpose()?,
        job: &job,
        visit: &visit,
    };
    let content = held(report.html()?);
    let is_found = visit.verdict.is_none();
    let word = visit.verdict.map_or(AS_FOUND, Verdict::word);
    let screen = || {
        Screen::of(match is_found {
            true => "the page shows the machine as found: no job states tables ([compensation.axes]), so nothing is forecast or judged".to_string(),
            false => format!("verdict on the page: {word}"),
        })
    };
    let document = || Document { verdict: word };
    let outcome = options.output.deliver(files, Some(content), screen, document, "")?;
    Ok(outcome.answering(is_found || visit.verdict == Some(Verdict::Pass)))
}

/// What scripts read.
#[derive(Serialize)]
struct Document {
    verdict: &'static str,
}

/// What stands for the verdict where there are no tables.
const AS_FOUND: &str = "as-found";

/// A job, and what was measured and found of it.
type OfJob = (Job, Visit);

/// With the tables of a directory or of the job; as found where neither are there.
fn visit(options: &Options, files: &dyn Files, locale: Locale<'_>) -> Result<OfJob, Problems> {
    let file = InputFile::read(files, &options.job)?;
    let without_tables = options.tables.is_none();
    let is_table = without_tables && file.kind() == FileKind::Table;
    let is_found = is_table || without_tables && !states_tables(files, &file)?;
    let mut inputs = match is_table {
        true => inputs::of_table(&file, file_name(Path::new(&file.name)), None)?,
        false => inputs::read_job(files, None, &file, UseOf::with(!is_found))?,
    };
    let mut visit = match is_found {
        true => Visit::found(locale, &inputs)?,
        false => with_tables(options, files, locale, &inputs)?,
    };
    if is_table {
        inputs.job.machine.name.clear();
    }
    let is_stated = inputs.job.source.place_of("compensation.controller");
    visit.control = is_stated.map_or_else(String::new, |_| inputs.profile.name.clone());
    visit.inputs.clone_from(&inputs.hashes);
    if let ErrorSource::Separated { separation, readings, .. } = &inputs.errors {
        let page = standards::of_separation(readings, separation)?;
        let picture = page.picture(locale, &locale.words("readings_corrected"));
        visit.add("standards", &page, ("readings", picture))?;
    }
    Ok((inputs.job, visit))
}

/// Whether the job says how the points of any axis are chosen.
fn states_tables(files: &dyn Files, file: &InputFile<'_>) -> Result<bool, Problems> {
    let named = JobFiles::of(files, file, UseOf::Figures)?;
    Ok(named.job.compensation.axes.iter().any(|(_, axis)| axis.is_some()))
}

/// The tables of a directory, or those that `generate` would write.
fn with_tables(
    options: &Options,
    files: &dyn Files,
    locale: Locale<'_>,
    inputs: &Inputs,
) -> Result<Visit, Problems> {
    let mut visit = Visit::default();
    let page = match options.tables.as_deref() {
        None => of_own_tables(&mut visit, inputs)?,
        Some(directory) => of_files(&mut visit, options, files, inputs, directory)?,
    };
    visit.verdict = Some(page.verdict());
    visit.is_rehearsal = page.is_simulated();
    let said = |findings: &[Finding]| findings.iter().map(ToString::to_string).collect();
    visit.doubts = said(page.doubts());
    visit.disagreements = said(&page.verification.disagreements());
    let assumed = page.assumptions().iter().filter(|assumed| assumed.without_effect.is_none());
    visit.assumptions = assumed.cloned().collect();
    visit.is_sign_shown = page.sign_shown().is_some();
    visit.is_measured = options.after.is_some();
    visit.grounds = page.grounds();
    visit.decides.clone_from(&page.decides);
    visit.add("verify", &page.document(), ("curves", page.picture(locale)))?;
    match assess::for_report(inputs, Some(&page.verification.loaded)) {
        Ok(page) => visit.add("assess", &page, ("volume", page.picture(locale)))?,
        Err(problems) => visit.without_volume = problems.iter().map(words).collect(),
    }
    Ok(visit)
}

/// A problem in one line.
fn words(problem: &Problem) -> String {
    let help = problem.help.iter().map(|help| format!("; {help}"));
    format!("{}{}", problem.message, help.collect::<String>())
}

impl Visit {
    /// The machine as found.
    fn found(locale: Locale<'_>, inputs: &Inputs) -> Result<Visit, Problems> {
        let (page, model) = (assess::for_report(inputs, None)?, inputs.as_measured());
        let doubts = page.doubts().iter().cloned();
        let doubts = doubts.chain(model.doubts(|_| true)).map(|doubt| doubt.to_string());
        let doubts = doubts.collect::<BTreeSet<_>>().into_iter().collect();
        let is_rehearsal = model.remarks.simulated().next().is_some();
        let mut visit = Visit { is_rehearsal, doubts, ..Visit::default() };
        let curves = Curves { inputs, loaded: None, as_left: None };
        let heading = format!("{}: {}", page.name, locale.words("nine_errors_found"));
        visit.pictures.push(("curves", terms(locale, &heading, &curves)));
        visit.add("assess", &page, ("volume", page.picture(locale)))?;
        Ok(visit)
    }

    /// What a command says, under its name, and the picture of it with the part that it stands in.
    fn add(&mut self, name: &str, of: &impl Serialize, drawn: PagePicture) -> Result<(), Problem> {
        self.documents[name] = rounded(of)?;
        self.pictures.push(drawn);
        Ok(())
    }

    /// Runs of one axis by standard.
    fn add_linear(
        &mut self,
        files: &dyn Files,
        locale: Locale<'_>,
        file: &Path,
    ) -> Result<(), Problems> {
        let file = InputFile::read(files, file)?;
        let page = standards::of_axis(&file)?;
        self.linear.push(file.hash.path.clone());
        self.add(&linear_document(self.linear.len()), &page, ("linear", page.picture(locale)))?;
        self.inputs.push(file.hash);
        Ok(())
    }
}

/// The tables that `generate` would write.
fn of_own_tables<'a>(visit: &mut Visit, inputs: &'a Inputs) -> Result<verify::Page<'a>, Problems> {
    let kit = generate(inputs)?;
    visit.documents["kit"] = rounded(&kit.manifest)?;
    let sizes = kit.files.iter().map(|f| (f.path.clone(), f.bytes.len()));
    visit.sizes = sizes.collect();
    let state = Some(&kit.manifest.state);
    let verification = kit::verify(inputs, &kit.files, state, Vec::new())?;
    Ok(verify::Page::of_kit(verification, kit.manifest.what_decides))
}

/// The files of a directory.
fn of_files<'a>(
    visit: &mut Visit,
    options: &Options,
    files: &dyn Files,
    inputs: &'a Inputs,
    directory: &Path,
) -> Result<verify::Page<'a>, Problems> {
    let after = options.after.as_deref();
    let page = verify::Page::read(files, inputs, &options.job, directory, after)?;
    visit.protocol_after = page.protocol_after();
    if let Ok((_, bytes)) = files.argument(&directory.join(MANIFEST)) {
        let manifest: KitManifest = json_page(&bytes).unwrap_or_default();
        visit.sizes = sizes(files, directory, &manifest.files);
        visit.documents["kit"] = json_page(&bytes).unwrap_or_default();
    }
    Ok(page)
}

/// Bytes of the files that a manifest lists. One of others may name any path: only what lies in the directory is looked at.
fn sizes(files: &dyn Files, directory: &Path, listed: &[HashedFile]) -> BTreeMap<String, usize> {
    let size = |HashedFile { path: name, .. }: &HashedFile| {
        let is_inside = Path::new(name).file_name() == Some(name.as_ref());
        let path = is_inside.then(|| directory.join(name))?;
        Some((name.clone(), files.bytes(&path).ok()?.len()))
    };
    listed.iter().filter_map(size).collect()
}

fn texts(files: &dyn Files, language: &str) -> Result<Texts, Problems> {
    if let Some(shipped) = Texts::shipped(language) {
        return shipped;
    }
    let path = Path::new(language);
    if !files.is(PathEntry::File, path) {
        return Err(refusals::no_texts(language, joined(Texts::languages())).into());
    }
    let stem = path.file_stem();
    let stem = stem.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Texts::read(&InputFile::read(files, path)?.source()?, &stem)
}

fn own_template(files: &dyn Files, path: &Path) -> Result<Template, Problems> {
    let (name, bytes) = files.argument(path)?;
    let text = template_text(&name, &bytes)?.into();
    Ok(Template { name, text })
}

/// How a picture begins: its signature and the head of its first chunk (PNG, ISO/IEC 15948 §5.2, §11.2.2).
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR";

/// A picture as text of the page.
fn logo(files: &dyn Files, path: &Path) -> Result<String, Problems> {
    let (name, bytes) = files.argument(path)?;
    let kinds = [
        (bytes.starts_with(PNG), "image/png"),
        (is_jpeg(&bytes), "image/jpeg"),
        (is_svg(&bytes), "image/svg+xml"),
    ];
    let kind = kinds.into_iter().find(|(is_such, _)| *is_such);
    let (_, kind) = kind.ok_or_else(|| refusals::no_picture(name))?;
    Ok(format!("data:{kind};base64,{}", base64(&bytes)))
}

/// Whether segments lead to the head of a frame (JPEG, ISO/IEC 10918-1 table B.1).
fn is_jpeg(bytes: &[u8]) -> bool {
    let mut rest = bytes.strip_prefix(b"\xff\xd8").unwrap_or_default();
    while let [0xff, marker, high, low, ..] = *rest {
        if matches!(marker, 0xc0..=0xcf) && !matches!(marker, 0xc4 | 0xc8 | 0xcc) {
            return true;
        }
        let next = match marker {
            0xff => 1, // fills up
            _ => 2 + usize::from(u16::from_be_bytes([high, low])),
        };
        rest = rest.get(next..).unwrap_or_default();
    }
    false
}

/// Whether the first element of a text is a drawing; comments and what begins with `<?` or `<!` are none.
fn is_svg(bytes: &[u8]) -> bool {
    let text = std::str::from_utf8(bytes).unwrap_or_default();
    let shown = text.split("<!--").enumerate().map(|(number, part)| match number {
        0 => part,
        _ => part.split_once("-->").map_or("", |(_, rest)| rest),
    });
    let shown: String = shown.collect();
    let mut tags = shown.split('<').skip(1);
    let first = tags.find(|tag| tag.starts_with(|c: char| c.is_ascii_alphabetic()));
    let name = first.and_then(|tag| tag.split([' ', '\n', '\r', '\t', '>', '/']).next());
    name.is_some_and(|name| name == "svg" || name.ends_with(":svg"))
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
            text.push(if n as usize <= three.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_rfc_4648() {
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg==")]
        {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
