//! Tables → template context → text.
//!
//! A context holds finished strings only: numbers are rounded in [`crate::write::compensation`] and
//! turned into text here, once, so a template decides about layout and nothing else. What a
//! template sees is printed by `nonius context JOB` and explained in docs/own-control.md §3.

mod templates;

pub(crate) use crate::write::family::FileSource;
pub(crate) use templates::page;
pub(super) use templates::text;

use crate::control::checklist::{ChecklistPart, Paragraph};
use crate::control::controller::{
    EmittedFile, Encoding, KitFile, Profile, Role, Template, builtin,
};
use crate::inputs::error_table::SIMULATED;
use crate::inputs::job::{ActiveTables, Job};
use crate::quantity::Direction;
use crate::text::{Finding, Problem, Problems, escaped, is_unseen, marked, plain, shown};
use crate::write::compensation::{Compiled, Placement};
use crate::write::control_text::{COMMENT_TEXT, Seen, ascii, is_comment_text, seen, with};
use crate::write::family::family;
use crate::write::findings::TableFinding;
use crate::write::refusals;
use crate::write::task::Task;
use serde::Serialize;
use serde_json::Value;
use std::cell::LazyCell;
use tera::Map;

/// The name and version of the program, as it stands in files and manifests.
pub const TOOL: &str = concat!("nonius ", env!("CARGO_PKG_VERSION"));

/// How the pages of a kit look, on the screen and printed.
const PAGE_STYLE: &str = include_str!("../../templates/page.css");

/// Names as the engine takes them.
pub(super) fn engine_context(names: &Seen) -> tera::Context {
    let mut seen = tera::Context::new();
    let named = names.as_map().into_iter().flatten();
    let named = named.filter_map(|(name, own)| Some((name.as_str()?.to_string(), own.clone())));
    named.for_each(|(name, own)| seen.insert_value(name, own));
    seen
}

/// The same with every text as HTML, and the style of a page.
fn page_of(names: &Seen, text: fn(&str) -> String) -> Seen {
    with(as_html(names, text), "style", PAGE_STYLE.into())
}

fn as_html(seen: &Seen, text: fn(&str) -> String) -> Seen {
    match (seen.as_str(), seen.as_array(), seen.as_map()) {
        (Some(own), ..) => text(own).into(),
        (_, Some(list), _) => {
            list.iter().map(|own| as_html(own, text)).collect::<Vec<Seen>>().into()
        }
        (.., Some(names)) => {
            let each = names.iter().map(|(name, own)| (name.clone(), as_html(own, text)));
            each.collect::<Map>().into()
        }
        _ => seen.clone(),
    }
}

/// A list that a profile asks for; one that this control does not have is a problem: its file would never be written.
fn list_of<'a>(
    seen: &'a tera::Context,
    file: &EmittedFile,
    (key, list): (&str, &str),
) -> Result<&'a [tera::Value], Problem> {
    seen.get(list)
        .and_then(tera::Value::as_array)
        .ok_or_else(|| refusals::no_such_list(key, shown(list), shown(&file.path)))
}

/// The files of a profile's file: one, or one for each item of a list, with the item; none where its list is empty.
fn items(seen: &tera::Context, file: &EmittedFile) -> Result<Vec<(String, tera::Value)>, Problem> {
    let asked = file.when.as_deref().map(|list| list_of(seen, file, ("when", list))).transpose()?;
    if asked.is_some_and(<[_]>::is_empty) {
        return Ok(Vec::new());
    }
    let Some(list) = file.each.as_deref() else {
        return Ok(vec![(file.path.clone(), tera::Value::none())]);
    };
    let named = |item: &tera::Value| Some((path_of(file, item)?, item.clone()));
    Ok(list_of(seen, file, ("each", list))?.iter().filter_map(named).collect())
}

/// The name of the file of an item.
fn path_of(file: &EmittedFile, item: &tera::Value) -> Option<String> {
    let [before, field, behind] = file.field()?;
    Some(format!("{before}{}{behind}", item.get_from_path(field)?.as_str()?))
}

/// What the templates of a control see. Every number is finished text.
pub fn context(task: Task<'_>, compiled: &Compiled) -> Result<impl Serialize + use<>, Problems> {
    refuse_unsafe_text(task)?;
    Ok(context_of(&FileSource::of_kit(task, compiled)))
}

fn context_of(emitted: &FileSource<'_>) -> Seen {
    let own = family(emitted.task.profile).context(emitted);
    [head_of(emitted), own].into_iter().filter_map(Seen::into_map).flatten().collect::<Map>().into()
}

/// What a context holds of every control.
fn head_of(emitted: &FileSource<'_>) -> Seen {
    let task = emitted.task;
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
    seen! {
        "tool": TOOL,
        "controller": seen! { "id": task.profile.id.as_str(), "name": said(&task.profile.name) },
        "machine": seen! {
            "name": said(&machine.name),
            "serial": text(machine.serial.as_deref()),
            "chain": text(machine.chain.map(|chain| chain.to_string()).as_deref()),
        },
        "measurement": seen! { "date": date.as_str(), "active": active },
        "unit": task.job.compensation.control_unit.word(),
        "header": header(emitted, &date, active),
        "terms": emitted.placements.iter().map(term).collect::<Vec<Seen>>(),
    }
}

/// First comments of a file, where the control's files may carry comments: where its values are
/// from. Only the kit's own tables hold a measurement.
fn header(emitted: &FileSource<'_>, date: &str, active: &str) -> Vec<String> {
    let simulated = emitted.task.model.remarks.simulated().next();
    let simulated = simulated.map(|_| format!("{SIMULATED}: predicted readings, a rehearsal"));
    let measured = || format!("measured {date}, compensation active while measuring: {active}");
    simulated.into_iter().chain([emitted.notice.map_or_else(measured, str::to_string)]).collect()
}

fn term(placement: &Placement) -> Seen {
    seen! {
        "term": placement.term.to_string(),
        "direction": placement.direction.map_or("both", Direction::symbol),
        "place": placement.place.as_str(),
        "points": placement.points.to_string(),
    }
}

/// Text of a job that reaches a control's file must not be able to end a comment, start a block
/// or a program (contract §2.3, `name`).
fn refuse_unsafe_text(task: Task<'_>) -> Result<(), Problems> {
    if !task.profile.comments.value.are_allowed() {
        return Ok(());
    }
    const OF: &str = "the control's files";
    let mut problems = refused_texts(task.job, comment_texts(task.job), OF);
    if !is_comment_text(&ascii(&task.profile.name)) {
        problems.push(refusals::no_comment("the profile's `name`", OF, COMMENT_TEXT));
    }
    problems.or_ok(())
}

/// Texts of a job that cannot stand in comments of these files.
pub(super) fn refused_texts<'a>(
    job: &Job,
    texts: impl Iterator<Item = (&'static str, &'a str)>,
    files: &str,
) -> Problems {
    let mut problems = Problems::none();
    for (path, _) in texts.filter(|(_, text)| !is_comment_text(&ascii(text))) {
        let wrong = refusals::no_comment(format!("`{path}`"), files, COMMENT_TEXT);
        problems.push(job.source.at(path, wrong));
    }
    problems
}

/// Texts of a job that stand in comments, with their keys.
pub(super) fn comment_texts(job: &Job) -> impl Iterator<Item = (&'static str, &str)> {
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
pub fn render(task: Task<'_>, compiled: &Compiled) -> Result<Vec<KitFile>, Problems> {
    refuse_unsafe_text(task)?;
    render_those(&FileSource::of_kit(task, compiled), |file| {
        !file.role.stands_apart() && file.role != Role::Checklist
    })
}

/// Of these the files that a control may load and no reader takes; nearly no profile has one.
pub(crate) fn render_unread(task: Task<'_>, compiled: &Compiled) -> Result<Vec<KitFile>, Problems> {
    render_those(&FileSource::of_kit(task, compiled), EmittedFile::is_loaded_unread)
}

/// What a checklist says.
#[derive(Serialize)]
pub(crate) struct Words {
    pub(crate) head: Vec<Paragraph>,
    pub(crate) parts: Vec<ChecklistPart>,
    /// What to know of this kit.
    pub(crate) about: Vec<String>,
}

/// The checklist, for people: line ends of every computer, not of the control.
pub(crate) fn render_checklist(
    task: Task<'_>,
    compiled: &Compiled,
    words: &Words,
) -> Result<Vec<KitFile>, Problems> {
    let words = Seen::try_from_serializable(words).map_err(refusals::no_context)?;
    let head = head_of(&FileSource::of_kit(task, compiled));
    const NAMES: [&str; 4] = ["tool", "controller", "machine", "measurement"];
    let names = head.into_map().unwrap_or_default().into_iter();
    let names = names.filter(|(name, _)| name.as_str().is_some_and(|own| NAMES.contains(&own)));
    let names = Seen::from(names.collect::<Map>());
    let mut rendered = Vec::new();
    for file in task.profile.files.iter().filter(|file| file.role == Role::Checklist) {
        // As HTML where the file is a page.
        let [mut seen, names] = match file.is_page() {
            true => {
                [page_of(&words, marked), as_html(&names, escaped)].map(|own| engine_context(&own))
            }
            false => [&words, &names].map(engine_context),
        };
        seen.extend(names);
        let text = text(&file.template, &seen)?;
        let bytes = plain::page(&text.replace("\r\n", "\n")).into_owned().into_bytes();
        rendered.push(KitFile { path: file.path.clone(), role: file.role, bytes });
    }
    Ok(rendered)
}

/// A built-in template, filled in for people.
pub fn filled(name: &str, context: &Value) -> Result<String, Problem> {
    let text = builtin::template(name).unwrap_or_default();
    page(&Template { name: name.to_string(), text }, context)
}

/// Those files of the profile that are wanted, each in its place: the tables and parameters of a kit, or what stands
/// apart from them with tables of its own (rollback, the sign proof of a mechanism).
pub(crate) fn render_those(
    emitted: &FileSource<'_>,
    is_wanted: impl Fn(&EmittedFile) -> bool,
) -> Result<Vec<KitFile>, Problems> {
    let profile = emitted.task.profile;
    let wanted: Vec<&EmittedFile> = profile.files.iter().filter(|file| is_wanted(file)).collect();
    if wanted.is_empty() {
        return Ok(Vec::new());
    }
    let own = context_of(emitted);
    let of_pages = LazyCell::new(|| page_of(&own, escaped));
    let (mut problems, mut files) = (Problems::none(), Vec::new());
    for file in wanted {
        let mut seen = engine_context(if file.is_page() { &of_pages } else { &own });
        seen.insert("role", file.role.word());
        for (path, item) in problems.take(items(&seen, file)).unwrap_or_default() {
            seen.insert_value("item", item);
            let text = text(&file.template, &seen);
            let bytes = text.and_then(|text| bytes_of(&path, &text, profile));
            let file = |bytes| KitFile { path, role: file.role, bytes };
            files.extend(problems.take(bytes).map(file));
        }
    }
    problems.or_ok(files)
}

/// What a person takes for a blank or for nothing, and a control does not: blanks but the usual one, joiners, empty signs.
fn is_blank(c: char) -> bool {
    c != ' ' && c.is_whitespace() || matches!(c, '\u{200c}' | '\u{200d}' | '\u{2800}' | '\u{1d159}')
}

/// The bytes of a control's file, with its line ends. Wherever its text is from (a template of one's own, a profile):
/// characters that a person does not see go to no control.
pub(crate) fn bytes_of(path: &str, text: &str, profile: &Profile) -> Result<Vec<u8>, Problem> {
    let mut lines = text.split('\n').map(|line| line.strip_suffix('\r').unwrap_or(line));
    let unseen = |c: char| c != '\t' && (is_unseen(c) || is_blank(c));
    let is_plain = |byte: u8| (b' '..=b'~').contains(&byte);
    let has_unseen = |line: &str| !line.bytes().all(is_plain) && line.contains(unseen);
    if let Some((line, number)) = lines.clone().zip(1..).find(|(line, _)| has_unseen(line)) {
        return Err(refusals::unseen(number, shown(path), shown(line)));
    }
    let text = lines.by_ref().collect::<Vec<&str>>().join(profile.line_end.value.text());
    Ok(match profile.encoding() {
        Encoding::Utf8 => text.into_bytes(),
        Encoding::Utf16Le => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
    })
}
