//! `nonius controllers list|show|check`

use crate::cli::outcome::Outcome;
use crate::cli::show::{Column, table};
use crate::cli::{Format, inputs};
use crate::control::controller::{Evidence, Origin, Profile, Statement, builtin};
use crate::inputs::error_table::ErrorTable;
use crate::inputs::job::Job;
use crate::kit::program_kit;
use crate::kit::{Inputs, generate};
use crate::text::document::Source;
use crate::text::problem::Problems;
use clap::Subcommand;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// What `controllers` does.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// List the built-in controls
    List {
        /// What to print
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
    },
    /// Show the facts of a control with their sources
    Show {
        /// An id of `controllers list`, or the path of a profile of your own
        id: String,
        /// What to print
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
        /// Print the profile as it is, to start one of your own
        #[arg(long, conflicts_with = "format")]
        toml: bool,
    },
    /// Check a profile of your own and its templates
    Check {
        /// The profile (TOML)
        file: PathBuf,
        /// What to print
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
    },
}

pub(super) fn run(command: &Command) -> Result<Outcome, Problems> {
    match command {
        Command::List { format } => list(*format),
        Command::Show { id, format, toml } => show(id, *format, *toml),
        Command::Check { file, format } => check(file, *format),
    }
}

fn list(format: Format) -> Result<Outcome, Problems> {
    let profiles: Vec<Profile> = builtin::ids()
        .into_iter()
        .map(builtin::profile)
        .collect::<Result<_, _>>()?;
    if format == Format::Json {
        let list: Vec<Value> = profiles.iter().map(summary_json).collect();
        return Outcome::json(&json!({ "schema": 1, "controllers": list }));
    }
    let columns = [
        Column::Left("id"),
        Column::Left("control"),
        Column::Right("facts"),
        Column::Right("manual"),
        Column::Right("assumed"),
        Column::Right("executed"),
    ];
    let rows = profiles.iter().map(|profile| {
        vec![
            profile.id.clone(),
            profile.name.clone(),
            profile.statements.len().to_string(),
            count(profile, Evidence::Manual).to_string(),
            count(profile, Evidence::Assumed).to_string(),
            count(profile, Evidence::Executed).to_string(),
        ]
    });
    Ok(Outcome::text(&table(&columns, rows)))
}

fn count(profile: &Profile, evidence: Evidence) -> usize {
    profile
        .statements
        .iter()
        .filter(|s| s.evidence == evidence)
        .count()
}

fn summary_json(profile: &Profile) -> Value {
    json!({
        "id": profile.id,
        "name": profile.name,
        "dialect": profile.dialect.word(),
        "manual": count(profile, Evidence::Manual),
        "assumed": count(profile, Evidence::Assumed),
        "executed": count(profile, Evidence::Executed),
    })
}

fn show(id: &str, format: Format, toml: bool) -> Result<Outcome, Problems> {
    let profile = inputs::profile(id, Path::new(""), &mut Vec::new())?;
    if toml {
        let page = match builtin::page(id) {
            Some(page) => page.to_string(),
            None => String::from_utf8_lossy(&inputs::read_file(Path::new(id))?).into_owned(),
        };
        return Ok(Outcome::text(&page));
    }
    if format == Format::Json {
        return Outcome::json(&profile_json(&profile));
    }
    Ok(Outcome::text(&profile_text(&profile)))
}

fn profile_json(profile: &Profile) -> Value {
    let files: Vec<Value> = profile
        .files
        .iter()
        .map(|file| json!({ "path": file.path, "role": file.role.word(), "template": file.template_name }))
        .collect();
    let mut document = summary_json(profile);
    document["schema"] = json!(1);
    document["facts"] = facts_json(&profile.statements);
    document["files"] = json!(files);
    document["program"] = json!(profile.program.as_ref().map(|program| {
        json!({
            "language": program.language.word(),
            "template": program.template_name,
            "facts": facts_json(&program.statements),
        })
    }));
    document
}

fn facts_json(statements: &[Statement]) -> Value {
    let fact = |s: &Statement| {
        json!({
            "fact": s.fact,
            "value": s.value,
            "evidence": s.evidence.word(),
            "source": s.source,
            "consequence": s.consequence,
        })
    };
    json!(statements.iter().map(fact).collect::<Vec<Value>>())
}

fn profile_text(profile: &Profile) -> String {
    let mut lines = vec![format!(
        "{} - {} ({} dialect)",
        profile.id,
        profile.name,
        profile.dialect.word()
    )];
    if let Origin::File(path) = &profile.origin {
        lines.push(format!("your own profile `{path}`"));
    }
    lines.push(String::new());
    lines.push(files_text(profile));
    for statement in &profile.statements {
        lines.push(String::new());
        lines.extend(statement_lines(statement));
    }
    if let Some(program) = &profile.program {
        lines.push(String::new());
        lines.push(format!(
            "part programs of measuring runs ({}, {}):",
            program.language.word(),
            program.template_name
        ));
        for statement in &program.statements {
            lines.push(String::new());
            lines.extend(statement_lines(statement));
        }
    }
    lines.join("\n")
}

fn files_text(profile: &Profile) -> String {
    let columns = [
        Column::Left("file"),
        Column::Left("role"),
        Column::Left("template"),
    ];
    let rows = profile.files.iter().map(|file| {
        vec![
            file.path.clone(),
            file.role.word().to_string(),
            file.template_name.clone(),
        ]
    });
    table(&columns, rows)
}

fn statement_lines(statement: &Statement) -> Vec<String> {
    let mut lines = vec![
        format!("{} = {}", statement.fact, statement.value),
        format!("    {}: {}", statement.evidence.word(), statement.source),
    ];
    if let Some(consequence) = &statement.consequence {
        lines.push(format!("    if wrong: {consequence}"));
    }
    lines
}

/// Checks a profile and renders its templates with a small machine that has everything: nine
/// errors, X in both directions.
fn check(file: &Path, format: Format) -> Result<Outcome, Problems> {
    let path = file.display().to_string();
    // A bare name is still a path here, so it gets a folder in front.
    let reference = if path.contains(['/', '\\']) {
        path.clone()
    } else {
        format!("./{path}")
    };
    let profile = inputs::profile(&reference, Path::new(""), &mut Vec::new())?;
    let sample = |name: &str, text: &str| Source::from_bytes(name, text.as_bytes());
    let job = Job::read(sample("sample job", SAMPLE_JOB)?)?;
    let table = ErrorTable::read(sample("sample errors", SAMPLE_ERRORS)?)?;
    if profile.program.is_some() {
        program_kit::make(&job, &profile, &[])?;
    }
    let kit = generate(&Inputs::new(job, profile.clone(), &table, Vec::new())?)?;
    if format == Format::Json {
        return Outcome::json(&profile_json(&profile));
    }
    let valid = format!(
        "`{path}` is a valid profile: {} ({}); its templates made {} files of a sample machine",
        profile.name,
        profile.id,
        kit.files.len()
    );
    Ok(Outcome::text(&files_text(&profile)).saying(valid))
}

const SAMPLE_JOB: &str = r#"
schema = 1
[machine]
name = "sample"
axes.x = { travel_mm = [0, 200], reference_mm = 0, reference_direction = "+" }
axes.y = { travel_mm = [0, 200], reference_mm = 0 }
axes.z = { travel_mm = [-200, 0], reference_mm = 0 }
[measurement]
errors = "errors.csv"
active_while_measuring = "none"
[program]
what = "step-diagonal"
start_mm = { x = 10, y = 10, z = -190 }
size_mm = { x = 180, y = 180, z = 180 }
steps = 2
order = "XYZ"
[compensation]
controller = "generic"
backlash = "two-tables"
axes.x = { points = 5, detection_unit_um = 1 }
axes.y = { points = 5, detection_unit_um = 1 }
axes.z = { points = 5, detection_unit_um = 1 }
"#;

const SAMPLE_ERRORS: &str = "axis,position_mm,ex_um,ey_um,ez_um,direction
x,0,0,0,0,+
x,200,4,2,-2,+
x,0,3,1,0,-
x,200,7,3,-2,-
y,0,0,0,0,
y,200,2,-4,2,
z,-200,2,2,4,
z,0,0,0,0,
";
