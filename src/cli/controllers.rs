//! `nonius controllers list|show|check`, and `nonius context`: what is known of a control, and what its
//! templates see.

use crate::cli::outcome::{Format, Outcome, Print};
use crate::cli::screen::{Screen, paragraphs, table};
use crate::control::controller::program::Language;
use crate::control::controller::{
    Evidence, JobKey, Profile, ProfileSource, Role, Statement, builtin,
};
use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::Job;
use crate::kit::{Inputs, generate, program_kit, template_context};
use crate::read::check_examples;
use crate::text::{Problems, Source};
use crate::visit::files::{Files, printed};
use crate::visit::inputs;
use crate::visit::job_files::profile;
use clap::{Args, Subcommand};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What `controllers` does.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List the built-in controls
    List {
        #[command(flatten)]
        print: Print,
    },
    /// Show the facts of a control with their sources
    Show {
        /// An id of `controllers list`, or the path of a profile of your own
        id: String,
        #[command(flatten)]
        print: Print,
        /// Print the profile as it is, to start one of your own
        #[arg(long, conflicts_with = "format")]
        toml: bool,
    },
    /// Check a profile of your own and its templates
    Check {
        /// The profile (TOML)
        file: PathBuf,
        #[command(flatten)]
        print: Print,
    },
}

/// Options of `context`.
#[derive(Args, Debug)]
pub(super) struct Context {
    /// The job (TOML); `-` = standard input
    job: PathBuf,
    /// Both print the same JSON document
    #[arg(long, value_enum, default_value_t = Format::Json)]
    format: Format,
}

/// What the templates of a job's control see.
pub(super) fn context(options: &Context, files: &dyn Files) -> Result<Outcome, Problems> {
    Outcome::json(&template_context(&inputs::read(files, &options.job)?)?)
}

/// Without a command the list.
pub(super) fn run(command: Option<&Command>, files: &dyn Files) -> Result<Outcome, Problems> {
    match command {
        None => list(Print::default()),
        Some(Command::List { print }) => list(*print),
        Some(Command::Show { id, print, toml }) => show(files, id, *print, *toml),
        Some(Command::Check { file, print }) => check(files, file, *print),
    }
}

fn list(print: Print) -> Result<Outcome, Problems> {
    let profiles = builtin::ids().into_iter().map(builtin::profile);
    let profiles: Vec<Profile> = profiles.collect::<Result<_, _>>()?;
    let list = List { controllers: profiles.iter().map(Summary::of).collect() };
    let rows = list.controllers.iter().zip(&profiles).map(|(of, profile)| {
        let Summary { id, name, manual, assumed, executed, .. } = of;
        format!("{id}\t{name}\t{}\t{manual}\t{assumed}\t{executed}", profile.statements.len())
    });
    let heading = "id\tcontrol\t>facts\t>manual\t>assumed\t>executed";
    print.outcome(|| Screen::of(table(heading, rows)), || &list)
}

#[derive(Serialize)]
struct List<'a> {
    controllers: Vec<Summary<'a>>,
}

/// A control, and how many of its facts are how well known.
#[derive(Serialize)]
struct Summary<'a> {
    id: &'a str,
    name: &'a str,
    dialect: &'static str,
    manual: usize,
    assumed: usize,
    executed: usize,
}

impl Summary<'_> {
    fn of(profile: &Profile) -> Summary<'_> {
        let count = |evidence| profile.statements.iter().filter(|s| s.evidence == evidence).count();
        Summary {
            id: &profile.id,
            name: &profile.name,
            dialect: profile.family.word,
            manual: count(Evidence::Manual),
            assumed: count(Evidence::Assumed),
            executed: count(Evidence::Executed),
        }
    }
}

fn show(files: &dyn Files, id: &str, print: Print, toml: bool) -> Result<Outcome, Problems> {
    let (profile, _) = profile(files, id, Path::new(""))?;
    if toml {
        let page = match builtin::page(id) {
            Some(page) => page.to_string(),
            None => String::from_utf8_lossy(&files.bytes(Path::new(id))?).into_owned(),
        };
        return Ok(Outcome::text(&page));
    }
    print.as_it_is(|| Screen::of(profile_text(&profile)), || Document::of(&profile))
}

/// A profile, as scripts read it.
#[derive(Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    summary: Summary<'a>,
    schema: u32,
    facts: &'a [Statement],
    files: Vec<OfFile<'a>>,
    program: Option<OfProgram<'a>>,
    job: &'a [JobKey],
    examples: Vec<&'a str>,
}

#[derive(Serialize)]
struct OfFile<'a> {
    path: &'a str,
    role: Role,
    template: &'a str,
}

/// How its part programs are written.
#[derive(Serialize)]
struct OfProgram<'a> {
    language: Language,
    template: &'a str,
    facts: &'a [Statement],
}

impl Document<'_> {
    fn of(profile: &Profile) -> Document<'_> {
        let program = profile.program.as_ref().map(|of| OfProgram {
            language: of.language,
            template: &of.template.name,
            facts: &of.statements,
        });
        Document {
            summary: Summary::of(profile),
            schema: 1,
            facts: &profile.statements,
            files: files_of(profile).collect(),
            program,
            job: &profile.job_keys,
            examples: profile.examples.iter().map(|own| own.source.as_str()).collect(),
        }
    }
}

fn files_of(profile: &Profile) -> impl Iterator<Item = OfFile<'_>> {
    let files = profile.files.iter();
    files.map(|of| OfFile { path: &of.path, role: of.role, template: &of.template.name })
}

fn profile_text(profile: &Profile) -> String {
    let mut parts =
        vec![format!("{} - {} ({} dialect)", profile.id, profile.name, profile.family.word)];
    if let ProfileSource::File(path) = &profile.origin {
        parts[0] += &format!("\nyour own profile `{path}`");
    }
    parts.push(files_text(profile));
    parts.extend(profile.statements.iter().map(statement_text));
    if let Some(program) = &profile.program {
        parts.push(format!(
            "part programs of measuring runs ({}, {}):",
            program.language.word(),
            program.template.name
        ));
        parts.extend(program.statements.iter().map(statement_text));
    }
    parts.extend(profile.examples.iter().map(|own| format!("example: {}", own.source)));
    parts.extend(profile.no_example.iter().map(|why| format!("no example: {why}")));
    if !profile.job_keys.is_empty() {
        parts.push("keys of a job (nonius new):".to_string());
        parts.extend(profile.job_keys.iter().map(job_key_text));
    }
    paragraphs(&parts)
}

fn job_key_text(key: &JobKey) -> String {
    let fact = format!("[{}] {}", key.section.word(), key.key);
    let JobKey { text: value, evidence, source, consequence, .. } = key.clone();
    statement_text(&Statement { fact, value, evidence, source, consequence, mechanism: None })
}

fn files_text(profile: &Profile) -> String {
    let rows = files_of(profile)
        .map(|OfFile { path, role, template }| format!("{path}\t{}\t{template}", role.word()));
    table("file\trole\ttemplate", rows)
}

/// What is known, and how well.
fn statement_text(of: &Statement) -> String {
    let consequence = of.consequence.iter().map(|words| format!("\n    if wrong: {words}"));
    let evidence = of.evidence.word();
    let text = format!("{} = {}\n    {evidence}: {}", of.fact, of.value, of.source);
    text + &consequence.collect::<String>()
}

/// Checks a profile and renders its templates with a small machine that has everything: nine
/// errors, X in both directions.
fn check(files: &dyn Files, file: &Path, print: Print) -> Result<Outcome, Problems> {
    let path = printed(file);
    // A bare name is still a path here, so it gets a folder in front.
    let reference = if path.contains(['/', '\\']) { path.clone() } else { format!("./{path}") };
    let (profile, _) = profile(files, &reference, Path::new(""))?;
    let sample = |name: &str, text: &str| Source::from_bytes(name, text.as_bytes());
    let job = Job::read(sample("sample job", SAMPLE_JOB)?)?;
    let share = (profile.largest_um() / LARGEST_SAMPLE_UM).min(1.0);
    let row = |(at, [ex, ey, ez]): &(&str, [f64; 3])| {
        format!("{at},{},{},{}\n", ex * share, ey * share, ez * share)
    };
    let rows: String = SAMPLE_ERRORS.iter().map(row).collect();
    let heading = "axis,direction,position_mm,ex_um,ey_um,ez_um\n";
    let table = ErrorTable::read(sample("sample errors", &format!("{heading}{rows}"))?)?;
    if profile.program.is_some() {
        program_kit::make(&job, &profile, &[])?;
    }
    check_examples(&profile)?;
    let kit = generate(&Inputs::new(job, profile.clone(), &table, Vec::new())?)?;
    let examples = match profile.examples.len() {
        0 => "no example shows that it reads files of the control".to_string(),
        count => format!("its examples ({count}) are read as stated"),
    };
    let valid = format!(
        "`{path}` is a valid profile: {} ({}); its templates made {} files of a sample machine; {examples}",
        profile.name,
        profile.id,
        kit.files.len()
    );
    let outcome = print.as_it_is(|| Screen::of(files_text(&profile)), || Document::of(&profile))?;
    Ok(outcome.saying(print.detail, valid))
}

const SAMPLE_JOB: &str = include_str!("../../templates/sample.toml");

/// More than any sample error: their largest table is within what the control takes.
const LARGEST_SAMPLE_UM: f64 = 8.0;

const SAMPLE_ERRORS: [(&str, [f64; 3]); 8] = [
    ("x,+,0", [0.0, 0.0, 0.0]),
    ("x,+,200", [4.0, 2.0, -2.0]),
    ("x,-,0", [3.0, 1.0, 0.0]),
    ("x,-,200", [7.0, 3.0, -2.0]),
    ("y,,0", [0.0, 0.0, 0.0]),
    ("y,,200", [2.0, -4.0, 2.0]),
    ("z,,-200", [2.0, 2.0, 4.0]),
    ("z,,0", [0.0, 0.0, 0.0]),
];
