//! Tables → template context → text. The only user of Tera.
//!
//! A context holds finished strings only: numbers are rounded in [`crate::write::compensation`] and
//! turned into text here, once, so a template decides about layout and nothing else. What a
//! template sees is printed by `nonius context JOB` and explained in docs/templates.md.

mod layout;
pub mod program;
mod templates;

pub use crate::write::control_text::{Instead, Switch};
pub(crate) use crate::write::family::Emitted;
pub use templates::Templates;

use crate::control::controller::{EmittedFile, Encoding, Role, builtin};
use crate::inputs::error_table::SIMULATED;
use crate::inputs::job::{ActiveTables, Job};
use crate::quantity::axis::Direction;
use crate::text::finding::Finding;
use crate::text::html::{each_text, escaped, marked};
use crate::text::plain;
use crate::text::problem::{Problem, Problems, shown};
use crate::write::compensation::{Compiled, Placement};
use crate::write::control_text::{COMMENT_TEXT, ascii, is_comment_text};
use crate::write::family::family;
use crate::write::findings::TableFinding;
use crate::write::task::Task;
use serde::Serialize;
use serde_json::{Value, json};

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

/// How the pages of a kit look, on the screen and printed.
const PAGE_STYLE: &str = include_str!("../../templates/page.css");

/// What the templates of a control see. Every number is finished text.
#[derive(Clone, Debug, Serialize)]
pub struct Context(Value);

impl Context {
    /// Whether a list of tables (`lec`, `cec`, `points`, …) holds something; profiles ask with `when`.
    fn holds(&self, list: &str) -> bool {
        let list = self.0.get(list).and_then(Value::as_array);
        list.is_some_and(|list| !list.is_empty())
    }
}

/// The files of a profile's file: one, or one for each item of a list, with the item.
fn items<'a>(context: &'a Value, file: &EmittedFile) -> Vec<(String, &'a Value)> {
    let Some(list) = &file.each else {
        return vec![(file.path.clone(), &Value::Null)];
    };
    let items = context.get(list).and_then(Value::as_array);
    let named = |item| Some((path_of(file, item)?, item));
    items.into_iter().flatten().filter_map(named).collect()
}

/// Lists that a profile asks for and this control does not have: its file would never be written.
fn unknown_lists(context: &Context, file: &EmittedFile) -> impl Iterator<Item = Problem> {
    let asked = [("each", &file.each), ("when", &file.when)].into_iter();
    let asked = asked.filter_map(|(key, list)| Some((key, list.as_deref()?)));
    asked.filter(|(_, list)| !context.0[list].is_array()).map(|(key, list)| {
        let message = format!(
            "`{key} = \"{}\"` of `{}`: this control has no such list",
            shown(list),
            shown(&file.path)
        );
        let lists = context.0.as_object().into_iter().flatten();
        let lists: Vec<&str> =
            lists.filter(|(_, value)| value.is_array()).map(|(name, _)| name.as_str()).collect();
        Problem::new(message).help(format!("its lists: {}", lists.join(", ")))
    })
}

/// The name of the file of an item.
fn path_of(file: &EmittedFile, item: &Value) -> Option<String> {
    let [before, field, behind] = file.field()?;
    Some(format!("{before}{}{behind}", item.get(field)?.as_str()?))
}

/// What the templates of a control see.
pub fn context(task: Task<'_>, compiled: &Compiled) -> Result<Context, Problems> {
    let own = Instead { names_terms: true, ..Instead::default() };
    let context = context_of(&Emitted { task, compiled, tables: &compiled.tables, instead: &own })?;
    if task.profile.comments.value.are_allowed() {
        refuse_unsafe_text(task)?;
    }
    Ok(context)
}

fn context_of(emitted: &Emitted<'_>) -> Result<Context, Problems> {
    let (task, instead) = (emitted.task, emitted.instead);
    let placements = match instead.names_terms {
        true => emitted.compiled.placements.as_slice(),
        false => &[],
    };
    let seen = family(task.profile).context(emitted);
    let mut seen =
        seen.ok_or_else(|| Problem::new("the tables are not of the profile's dialect"))?;
    let machine = &task.job.machine;
    let said = |text: &str| match task.profile.comments.value.are_allowed() {
        true => ascii(text).into_owned(),
        false => text.to_string(),
    };
    let text = |value: Option<&str>| said(value.unwrap_or("not stated"));
    let date = text(task.job.measurement.date.as_deref());
    let active = match &task.job.measurement.active {
        ActiveTables::None => "none",
        ActiveTables::NotStated => "not stated",
        ActiveTables::Path(_) => "yes, the tables of this kit contain it",
    };
    let mut context = json!({
        "tool": TOOL,
        "controller": { "id": task.profile.id, "name": said(&task.profile.name) },
        "machine": {
            "name": said(&machine.name),
            "serial": text(machine.serial.as_deref()),
            "chain": text(machine.chain.map(|chain| chain.to_string()).as_deref()),
        },
        "measurement": { "date": date, "active": active },
        "unit": task.job.compensation.control_unit.word(),
        "header": header(task, &date, active, instead.notice),
        "terms": placements.iter().map(term).collect::<Vec<Value>>(),
    });
    for (name, own) in seen.as_object_mut().into_iter().flatten() {
        context[name] = own.take();
    }
    Ok(Context(context))
}

/// First comments of a file, where the control's files may carry comments: where its values are
/// from. Only the kit's own tables hold a measurement.
fn header(task: Task<'_>, date: &str, active: &str, notice: &str) -> Vec<String> {
    let simulated = task.model.remarks.simulated().next();
    let simulated = simulated.map(|_| format!("{SIMULATED}: predicted readings, a rehearsal"));
    let origin = match notice {
        "" => format!("measured {date}, compensation active while measuring: {active}"),
        notice => notice.to_string(),
    };
    simulated.into_iter().chain([origin]).collect()
}

fn term(placement: &Placement) -> Value {
    json!({
        "term": placement.term.to_string(),
        "direction": placement.direction.map_or("both", Direction::symbol),
        "place": placement.place,
        "points": placement.points.to_string(),
    })
}

/// Text of a job that reaches a control's file must not be able to end a comment, start a block
/// or a program (contract §2.3, `name`).
fn refuse_unsafe_text(task: Task<'_>) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for (path, text) in comment_texts(task.job) {
        if !is_comment_text(&ascii(text)) {
            problems.push(
                task.job
                    .problem_at(path, format!("`{path}` goes into comments of the control's files, expected {COMMENT_TEXT}"))
                    .help("write it in plain letters and digits"),
            );
        }
    }
    if !is_comment_text(&ascii(&task.profile.name)) {
        problems.push(
            Problem::new(format!("the profile's `name` goes into comments of the control's files, expected {COMMENT_TEXT}"))
                .help("write it in plain letters and digits"),
        );
    }
    problems.or_ok(())
}

/// Texts of a job that stand in comments, with their keys.
fn comment_texts(job: &Job) -> impl Iterator<Item = (&'static str, &str)> {
    let machine = &job.machine;
    let texts = [
        ("machine.name", Some(machine.name.as_str())),
        ("machine.serial", machine.serial.as_deref()),
        ("measurement.date", job.measurement.date.as_deref()),
    ];
    texts.into_iter().filter_map(|(key, text)| Some((key, text?)))
}

/// Names that stand in the control's files in other letters than in the job.
pub(crate) fn other_letters(job: &Job, profile_name: &str) -> Vec<Finding> {
    let texts = comment_texts(job).chain([("name of the profile", profile_name)]);
    let changed = texts.filter(|(_, text)| !text.is_ascii());
    let found = changed.map(|(key, text)| TableFinding::OtherLetters {
        key,
        text: text.to_string(),
        written: ascii(text).into_owned(),
    });
    found.map(Finding::from).collect()
}

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
    templates: &Templates,
    emitted: &Emitted<'_>,
    is_wanted: impl Fn(&EmittedFile) -> bool,
) -> Result<Vec<RenderedFile>, Problems> {
    let context = context_of(emitted)?;
    render_those(emitted.task, templates, &context, is_wanted)
}

/// The checklist, for people: line ends of every computer, not of the control.
pub(crate) fn render_checklist(
    task: Task<'_>,
    templates: &Templates,
    context: &Context,
    words: Value,
) -> Result<Vec<RenderedFile>, Problems> {
    let names = ["tool", "controller", "machine", "measurement"];
    let names = names.map(|name| (name.to_string(), context.0[name].clone()));
    let names = Value::Object(names.into_iter().collect());
    let files = task.profile.files.iter();
    let mut rendered = Vec::new();
    for file in files.filter(|file| file.role == Role::Checklist) {
        let seen = checklist_context(file, names.clone(), words.clone())?;
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

/// What the template of a checklist sees: names and words, as HTML where the file is a page.
fn checklist_context(
    file: &EmittedFile,
    mut names: Value,
    mut words: Value,
) -> Result<tera::Context, Problem> {
    if file.is_page() {
        each_text(&mut names, escaped);
        each_text(&mut words, marked);
        names["style"] = PAGE_STYLE.into();
    }
    let mut seen = tera_context(&names)?;
    seen.extend(tera_context(&words)?);
    Ok(seen)
}

fn tera_context(context: &impl Serialize) -> Result<tera::Context, Problem> {
    let refuse =
        |error| Problem::new(format!("the context of the templates cannot be made: {error}"));
    tera::Context::from_serialize(context).map_err(refuse)
}

/// A built-in template, filled in for people.
pub fn filled(name: &str, context: &Value) -> Result<String, Problem> {
    let refuse = |error| Problem::new(format!("the context of `{name}` cannot be made: {error}"));
    let seen = tera::Context::from_serialize(context).map_err(refuse)?;
    let template = builtin::template(name).unwrap_or_default();
    Templates::default().text(name, &template, &seen)
}

fn render_those(
    task: Task<'_>,
    templates: &Templates,
    context: &Context,
    is_own: impl Fn(&EmittedFile) -> bool,
) -> Result<Vec<RenderedFile>, Problems> {
    let escaped = page_context(context);
    let (mut seen, mut page) = (tera_context(context)?, tera_context(&escaped)?);
    let mut problems = Problems::none();
    let mut files = Vec::new();
    let is_wanted =
        |file: &EmittedFile| file.when.as_deref().is_none_or(|list| context.holds(list));
    let files_of_profile = || task.profile.files.iter().filter(|file| is_own(file));
    let unknown = files_of_profile().flat_map(|file| unknown_lists(context, file));
    unknown.for_each(|problem| problems.push(problem));
    for file in files_of_profile().filter(|file| is_wanted(file)) {
        let (values, seen) = match file.is_page() {
            true => (&escaped, &mut page),
            false => (&context.0, &mut seen),
        };
        for (path, item) in items(values, file) {
            seen.insert("item", item);
            seen.insert("role", file.role.word());
            match templates.text(&file.template_name, &file.template, seen) {
                Ok(text) => files.push(RenderedFile {
                    path,
                    role: file.role,
                    bytes: encoded(
                        with_line_ends(text, task.profile.line_end.value.text()),
                        task.profile.encoding(),
                    ),
                }),
                Err(problem) => problems.push(problem),
            }
        }
    }
    problems.or_ok(files)
}

/// What the template of a page sees: the same texts as HTML, and the style of pages.
fn page_context(context: &Context) -> Value {
    let mut page = context.0.clone();
    each_text(&mut page, escaped);
    page["style"] = PAGE_STYLE.into();
    page
}

fn encoded(text: String, encoding: Encoding) -> Vec<u8> {
    match encoding {
        Encoding::Utf8 => text.into_bytes(),
        Encoding::Utf16Le => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
    }
}

fn with_line_ends(text: String, line_end: &str) -> String {
    let text = if text.contains('\r') { text.replace("\r\n", "\n") } else { text };
    if line_end == "\n" { text } else { text.replace('\n', line_end) }
}
