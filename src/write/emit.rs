//! Tables → template context → text. The only user of Tera.
//!
//! A context holds finished strings only: numbers are rounded in [`crate::write::compensation`] and
//! turned into text here, once, so a template decides about layout and nothing else. What a
//! template sees is printed by `nonius context JOB` and explained in docs/templates.md.

mod ascii;
mod fanuc;
mod generic;
mod layout;
mod number;
pub mod program;
mod siemens;
mod switch;
mod templates;

pub use self::switch::Switch;

use self::number::fixed;

use crate::control::checklist::Part;
use crate::control::controller::{Dialect, EmittedFile, Role};
use crate::control::table::Tables;
use crate::inputs::error_table::SIMULATED;
use crate::inputs::job::{ActiveTables, Job};
use crate::quantity::axis::Direction;
use crate::text::plain;
use crate::text::problem::{Problem, Problems};
use crate::write::compensation::{Compiled, Placement};
use crate::write::emit::ascii::ascii;
use crate::write::plan::Task;
use serde::Serialize;
pub use templates::Templates;

/// A file of the kit, ready to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RenderedFile {
    /// Name in the kit.
    pub path: String,
    /// What it is for.
    pub role: Role,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// The name and version of the program, as it stands in files and manifests.
pub const TOOL: &str = concat!("nonius ", env!("CARGO_PKG_VERSION"));

/// What the templates of a control see. Every number is finished text.
#[derive(Clone, Debug, Serialize)]
pub struct Context {
    tool: &'static str,
    controller: ControllerContext,
    machine: MachineContext,
    measurement: MeasurementContext,
    unit: &'static str,
    header: Vec<String>,
    terms: Vec<TermContext>,
    #[serde(flatten)]
    tables: TablesContext,
}

#[derive(Clone, Debug, Serialize)]
struct ControllerContext {
    id: String,
    name: String,
}

#[derive(Clone, Debug, Serialize)]
struct MachineContext {
    name: String,
    serial: String,
    chain: String,
}

#[derive(Clone, Debug, Serialize)]
struct MeasurementContext {
    date: String,
    active: &'static str,
}

#[derive(Clone, Debug, Serialize)]
struct TermContext {
    term: String,
    direction: &'static str,
    place: String,
    points: String,
}

#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
enum TablesContext {
    Siemens(siemens::SiemensContext),
    Fanuc(fanuc::FanucContext),
    Generic(generic::GenericContext),
}

impl Context {
    /// Whether a list of tables (`lec`, `cec`, `points`, …) holds something; profiles ask with `when`.
    fn holds(&self, list: &str) -> bool {
        match (&self.tables, list) {
            (TablesContext::Siemens(tables), "lec") => !tables.lec.is_empty(),
            (TablesContext::Siemens(tables), "cec") => !tables.cec.is_empty(),
            (TablesContext::Siemens(tables), "switches") => !tables.switches.is_empty(),
            (TablesContext::Fanuc(tables), "points") => !tables.points.is_empty(),
            (TablesContext::Fanuc(tables), "parameters") => !tables.parameters.is_empty(),
            (TablesContext::Generic(tables), "rows") => !tables.rows.is_empty(),
            _ => false,
        }
    }
}

/// What a file that stands apart writes in place of the tables of the kit.
#[derive(Clone, Debug, Default)]
pub struct Instead<'a> {
    /// What it is, in place of the measurement that the tables of the kit are from.
    pub notice: &'a str,
    /// Whether the places are those of the kit, so that their terms may be named.
    pub names_terms: bool,
    /// Whether numbers keep the digits they were read with, also beyond those of the profile.
    pub as_read: bool,
    /// Machine data that it restores (Siemens).
    pub switches: Vec<Switch>,
}

/// What the templates of a control see.
pub fn context(task: Task<'_>, compiled: &Compiled) -> Result<Context, Problems> {
    let own = Instead {
        names_terms: true,
        ..Instead::default()
    };
    let context = context_of(task, compiled, &compiled.tables, &own)?;
    if task.profile.comments.value {
        refuse_unsafe_text(task, &context)?;
    }
    Ok(context)
}

fn context_of(
    task: Task<'_>,
    compiled: &Compiled,
    tables: &Tables,
    instead: &Instead<'_>,
) -> Result<Context, Problems> {
    let placements = if instead.names_terms {
        compiled.placements.as_slice()
    } else {
        &[]
    };
    let tables = match (tables, &task.profile.dialect) {
        (Tables::Siemens(tables), Dialect::Siemens(facts)) => {
            let (state, as_read) = (&compiled.state, instead.as_read);
            let mut context = siemens::context(task, placements, tables, facts, state, as_read);
            context.switches.clone_from(&instead.switches);
            TablesContext::Siemens(context)
        }
        (Tables::Fanuc(memory), Dialect::Fanuc(facts)) => {
            TablesContext::Fanuc(fanuc::context(memory, facts))
        }
        (Tables::Generic(table), _) => TablesContext::Generic(generic::context(table)),
        _ => return Err(Problem::new("the tables are not of the profile's dialect").into()),
    };
    Ok(with_header(task, placements, tables, instead))
}

fn with_header(
    task: Task<'_>,
    placements: &[Placement],
    tables: TablesContext,
    instead: &Instead<'_>,
) -> Context {
    let machine = &task.job.machine;
    let said = |text: &str| match task.profile.comments.value {
        true => ascii(text).into_owned(),
        false => text.to_string(),
    };
    let text = |value: &Option<String>| said(value.as_deref().unwrap_or("not stated"));
    let measurement = MeasurementContext {
        date: text(&task.job.measurement.date),
        active: match &task.job.measurement.active {
            ActiveTables::None => "none",
            ActiveTables::NotStated => "not stated",
            ActiveTables::Path(_) => "yes, the tables of this kit contain it",
        },
    };
    Context {
        tool: TOOL,
        controller: ControllerContext {
            id: task.profile.id.clone(),
            name: said(&task.profile.name),
        },
        machine: MachineContext {
            name: said(&machine.name),
            serial: text(&machine.serial),
            chain: text(&machine.chain.map(|chain| chain.to_string())),
        },
        header: header(task, &measurement, instead.notice),
        measurement,
        unit: task.job.compensation.control_unit.word(),
        terms: placements.iter().map(term_context).collect(),
        tables,
    }
}

/// First comments of a file, where the control's files may carry comments: where its values are
/// from. Only the kit's own tables hold a measurement.
fn header(task: Task<'_>, measurement: &MeasurementContext, notice: &str) -> Vec<String> {
    let simulated = task.model.remarks.simulated().next();
    let simulated = simulated.map(|_| format!("{SIMULATED}: predicted readings, a rehearsal"));
    let origin = match notice {
        "" => format!(
            "measured {}, compensation active while measuring: {}",
            measurement.date, measurement.active
        ),
        notice => notice.to_string(),
    };
    simulated.into_iter().chain([origin]).collect()
}

fn term_context(placement: &Placement) -> TermContext {
    TermContext {
        term: placement.term.to_string(),
        direction: direction_word(placement.direction),
        place: placement.place.clone(),
        points: placement.points.to_string(),
    }
}

/// `both`, `+` or `-`.
fn direction_word(direction: Option<Direction>) -> &'static str {
    direction.map_or("both", Direction::symbol)
}

/// Text of a job that reaches a control's file must not be able to end a comment, start a block
/// or a program (contract §2.3, `name`).
fn refuse_unsafe_text(task: Task<'_>, context: &Context) -> Result<(), Problems> {
    let mut problems = Problems::none();
    let fields = [
        ("machine.name", &context.machine.name),
        ("machine.serial", &context.machine.serial),
        ("measurement.date", &context.measurement.date),
    ];
    for (path, text) in fields {
        if is_comment_text(text) {
            continue;
        }
        problems.push(
            task.job
                .problem_at(path, format!("`{path}` goes into comments of the control's files, expected {COMMENT_TEXT}"))
                .help("write it in plain letters and digits"),
        );
    }
    if !is_comment_text(&ascii(&task.profile.name)) {
        problems.push(
            Problem::new(format!("the profile's `name` goes into comments of the control's files, expected {COMMENT_TEXT}"))
                .help("write it in plain letters and digits"),
        );
    }
    problems.or_ok(())
}

/// Names that stand in the control's files in other letters than in the job.
pub(crate) fn other_letters(job: &Job, profile_name: &str) -> Vec<String> {
    let machine = &job.machine;
    let texts = [
        ("machine.name", Some(machine.name.as_str())),
        ("machine.serial", machine.serial.as_deref()),
        ("measurement.date", job.measurement.date.as_deref()),
        ("name of the profile", Some(profile_name)),
    ];
    let texts = texts
        .into_iter()
        .filter_map(|(key, text)| Some((key, text?)));
    let changed = texts.filter(|(_, text)| !text.is_ascii());
    let words = changed.map(|(key, text)| {
        format!(
            "{key} `{text}` stands as `{}` in the control's files, which are ASCII",
            ascii(text)
        )
    });
    words.collect()
}

fn is_comment_text(text: &str) -> bool {
    let safe = |c: char| (' '..='~').contains(&c) && !"%;()[]{}<>".contains(c);
    text.chars().all(safe) && text.len() <= LONGEST_TEXT
}

/// Longest name in a comment: the line stays below 80 characters.
const LONGEST_TEXT: usize = 60;
const COMMENT_TEXT: &str =
    "up to 60 printable characters without line breaks, `%`, `;` or brackets";

/// The tables, parameters and switches of the kit, with the control's line ends.
pub fn render(
    task: Task<'_>,
    templates: &Templates,
    context: &Context,
) -> Result<Vec<RenderedFile>, Problems> {
    render_those(task, templates, context, |file| {
        !file.role.stands_apart() && file.role != Role::Checklist
    })
}

/// Files that stand apart, from tables of their own: rollback, or the sign proof of a mechanism.
pub(crate) fn render_apart(
    task: Task<'_>,
    templates: &Templates,
    compiled: &Compiled,
    tables: &Tables,
    instead: &Instead<'_>,
    is_wanted: impl Fn(&EmittedFile) -> bool,
) -> Result<Vec<RenderedFile>, Problems> {
    render_those(
        task,
        templates,
        &context_of(task, compiled, tables, instead)?,
        is_wanted,
    )
}

/// The checklist, for people: line ends of every computer, not of the control. `head` stands above
/// the steps, one paragraph each.
pub(crate) fn render_checklist(
    task: Task<'_>,
    templates: &Templates,
    context: &Context,
    head: &[String],
    parts: &[Part],
) -> Result<Vec<RenderedFile>, Problems> {
    let mut seen = tera::Context::new();
    seen.insert("tool", &context.tool);
    seen.insert("controller", &context.controller);
    seen.insert("machine", &context.machine);
    seen.insert("measurement", &context.measurement);
    seen.insert("head", head);
    seen.insert("parts", parts);
    let files = task.profile.files.iter();
    let mut rendered = Vec::new();
    for file in files.filter(|file| file.role == Role::Checklist) {
        let text = templates.text(&file.template_name, &file.template, &seen)?;
        let text = plain::page(&with_line_ends(text, "\n")).into_owned();
        rendered.push(RenderedFile {
            path: file.path.clone(),
            role: file.role,
            bytes: text.into_bytes(),
        });
    }
    Ok(rendered)
}

fn render_those(
    task: Task<'_>,
    templates: &Templates,
    context: &Context,
    is_own: impl Fn(&EmittedFile) -> bool,
) -> Result<Vec<RenderedFile>, Problems> {
    let seen = tera::Context::from_serialize(context).map_err(|error| {
        Problem::new(format!(
            "the context of the templates cannot be made: {error}"
        ))
    })?;
    let mut problems = Problems::none();
    let mut files = Vec::new();
    let is_wanted =
        |file: &EmittedFile| file.when.as_deref().is_none_or(|list| context.holds(list));
    let files_of_profile = task.profile.files.iter();
    for file in files_of_profile.filter(|file| is_own(file) && is_wanted(file)) {
        match templates.text(&file.template_name, &file.template, &seen) {
            Ok(text) => files.push(RenderedFile {
                path: file.path.clone(),
                role: file.role,
                bytes: with_line_ends(text, task.profile.line_end.value.text()).into_bytes(),
            }),
            Err(problem) => problems.push(problem),
        }
    }
    problems.or_ok(files)
}

fn with_line_ends(text: String, line_end: &str) -> String {
    let text = if text.contains('\r') {
        text.replace("\r\n", "\n")
    } else {
        text
    };
    if line_end == "\n" {
        text
    } else {
        text.replace('\n', line_end)
    }
}

#[cfg(test)]
mod tests {
    use super::fixed;

    #[test]
    fn numbers_have_their_decimals_and_no_negative_zero() {
        assert_eq!(fixed(-0.0004, 3), "0.000");
        assert_eq!(fixed(-0.012, 3), "-0.012");
        assert_eq!(fixed(1234.5, 0), "1234"); // half to even, as the formatter of numbers does
        assert_eq!(fixed(-0.3, 1), "-0.3");
        assert_eq!(fixed(-1e12, 0), "-1000000000000");
        assert_eq!(fixed(-1.0, 12), "-1.000000000000");
        assert_eq!(fixed(-0.05, 13), "-0.0500000000000");
        assert_eq!(fixed(f64::NAN, 3), "NaN"); // no input brings one here; a control would refuse it
    }
}
