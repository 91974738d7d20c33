//! Reader of the ISG kernel's volumetric compensation: the list (`.lis`) and the parameter files that it names.
//!
//! ```text
//!   texts ─┬ with a line `file[0] …` ── list ──→ axes, chain, switches; names of the files
//!          └ those that it names ── csv ──→ curves of the parameters
//! ```
//! Written from the pages of the maker named in docs/isg.md §3; it knows nothing of the program's own templates.

pub mod control;
mod csv;

use self::control::IsgControl;
use crate::control::control_state::ControlState;
use crate::control::controller::IsgFacts;
use crate::control::table::Tables;
use crate::control::table::isg::{Curve, IsgTables, Parameter};
use crate::quantity::{Axis, PerAxis};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, KitText, ReadBack, file_name, own, quoted};
use crate::read::findings::ReadFinding;
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, lines, located, words};
use crate::text::{Finding, Problem, Problems, shown};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

impl Family for IsgFacts {
    fn read_kit(&self, files: &[KitText<'_>]) -> Result<ReadBack, Problems> {
        let texts: Vec<(&str, &str)> = files.iter().map(|file| (file.path, file.text)).collect();
        let (tables, notes) = read(&texts)?;
        Ok(ReadBack { notes, ..Tables::Isg(tables).into() })
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        Ok(Box::new(IsgControl::new(own(tables)?, self, state)?))
    }

    fn may_obey(&self, text: &str) -> bool {
        let names: Vec<String> = Parameter::all().map(|p| p.to_string()).collect();
        let mut words = text.split(|c: char| !c.is_ascii_alphanumeric());
        is_list(text) || words.any(|word| names.iter().any(|name| name == word))
    }
}

/// Reads a list and the parameter files that it names; names and texts in any order.
///
/// **shape** each parameter once · **unit** mm and rad, as in the files · **limits** refuses what the emulator
/// does not do: rotary axes, axes of the workpiece, several arguments, other interpolations
pub(crate) fn read(texts: &[(&str, &str)]) -> Result<(IsgTables, Vec<Finding>), Problems> {
    let (lists, others): (Vec<_>, Vec<_>) = texts.iter().partition(|(_, text)| is_list(text));
    let (list_name, text) = match lists[..] {
        [(name, text)] => (name, text),
        _ => return Err(not_one_list(&lists, &others).into()),
    };
    let list = list(list_name, text)?;
    let mut problems = Problems::none();
    let mut curves: Vec<Curve> = Vec::new();
    let mut named: Vec<&str> = Vec::new();
    for path in list.paths.values() {
        let is_it =
            |(name, _): &&(&str, &str)| file_name(name).eq_ignore_ascii_case(file_name(path));
        let Some((name, text)) = others.iter().find(is_it) else {
            problems.push(not_there(list_name, path));
            continue;
        };
        named.push(name);
        for curve in problems.take(csv::curves(name, text)).into_iter().flatten() {
            if let Some(problem) = too_many(name, &curve) {
                problems.push(problem);
            }
            let is_twin = |other: &Curve| other.parameter == curve.parameter;
            match curves.iter().any(is_twin) {
                true => problems.push(twice(name, curve.parameter)),
                false => curves.push(curve),
            }
        }
    }
    curves.sort_by_key(|curve| curve.parameter);
    let unnamed = others.iter().filter(|(name, _)| !named.contains(name));
    let unnamed = unnamed.map(|(name, _)| ReadFinding::NotListed { file: shown(name) }.into());
    let unnamed = unnamed.collect();
    problems.or_ok((IsgTables { curves, ..list.tables }, unnamed))
}

fn not_one_list(lists: &[(&str, &str)], others: &[(&str, &str)]) -> Problem {
    let message = match lists {
        [] => format!(
            "no list stands beside {}: parameter files do not say their form, the axes or the chain",
            quoted(others)
        ),
        _ => format!("several lists, of which one can be read: {}", quoted(lists)),
    };
    let help = "name one list (`.lis`, the file of `vol_comp[0].file_name`) with the files of its `file[…]`";
    Problem::new(message).help(help)
}

fn not_there(list: &str, path: &str) -> Problem {
    let (list, path) = (shown(list), shown(path));
    Problem::new(format!("`{list}` names `{path}`, which is not there"))
        .help("name the parameter file together with the list")
}

fn twice(file: &str, parameter: Parameter) -> Problem {
    let file = shown(file);
    Problem::new(format!("{parameter} stands in `{file}` and in a file before it"))
        .help("give each parameter once")
}

/// Most points of a parameter: ten times and more what a control takes.
const MOST_POINTS: usize = 20_000;

fn too_many(file: &str, curve: &Curve) -> Option<Problem> {
    let points = curve.points.len();
    let (file, parameter) = (shown(file), curve.parameter);
    let words =
        format!("`{file}`: {parameter} has {points} points, expected at most {MOST_POINTS}");
    (points > MOST_POINTS).then(|| Problem::new(words).help("name the files of the control"))
}

// The list of a volumetric compensation: `key value` in each line, `#` begins a comment.

/// Whether a text is a list: it names a parameter file.
fn is_list(text: &str) -> bool {
    lines(text).any(|line| {
        let key = text[line].trim_start().to_ascii_lowercase();
        key.starts_with("file[")
    })
}

/// A line `key value`.
struct Setting<'a> {
    key: String,
    value: &'a str,
    span: Range<usize>,
}

fn setting(text: &str, line: Range<usize>) -> Option<Setting<'_>> {
    let (key, span) = words(text, line.clone()).into_iter().next()?;
    let value = text[span.end..line.end].split(" #").next().unwrap_or("");
    (!key.starts_with('#')).then(|| Setting {
        key: key.to_ascii_lowercase(),
        value: value.trim(),
        span: span.start..line.end,
    })
}

/// What a list says.
struct List {
    /// All but their curves.
    tables: IsgTables,
    /// Of the parameter files.
    paths: BTreeMap<u32, String>,
    /// Files whose form is stated.
    formats: BTreeSet<u32>,
}

/// Reads a list; where it does not say a thing, the control takes what [`IsgTables::NONE`] says.
fn list(file: &str, text: &str) -> Result<List, Problems> {
    let (tables, paths, formats) = (IsgTables::NONE, BTreeMap::new(), BTreeSet::new());
    let mut list = List { tables, paths, formats };
    let (mut known, mut complaints) = (BTreeSet::new(), Vec::new());
    for setting in lines(text).filter_map(|line| setting(text, line)) {
        let taken = match known.insert(setting.key.clone()) {
            true => list.take(&setting),
            false => Err("each key once"),
        };
        complaints.extend(taken.err().map(|expected| wrong(&setting, expected)));
        if complaints.len() >= MOST_COMPLAINTS {
            break;
        }
    }
    complaints.extend(list.missing().map(|missing| {
        let message = format!("the list does not say {missing}");
        Complaint::new(0..0, message, "name the complete list of the control")
    }));
    located(file, text, complaints).or_ok(list)
}

impl List {
    /// Takes a setting; `Err` = what was expected.
    fn take(&mut self, setting: &Setting<'_>) -> Result<(), &'static str> {
        let Setting { key, value, .. } = setting;
        if let Some(axis) = Axis::from_letter(key) {
            self.tables.axes[axis] = Some(logical(value)?);
            return Ok(());
        }
        if let Some(index) = indexed(key, "file") {
            self.paths.insert(index, (*value).to_string());
            return Ok(());
        }
        if let Some(index) = indexed(key, "file_format") {
            self.formats.insert(index);
            return one_of(
                value,
                &["ISG_CSV"],
                "ISG_CSV: write the parameters in that format, no other is read",
            );
        }
        match key.as_str() {
            "chain" => self.tables.chain = chain(value)?,
            "negate" => self.tables.negated = set(value)?,
            "set_to_zero" => self.tables.zeroed = set(value)?,
            "interpolation" => one_of(value, &["GRID"], "GRID: nothing else is emulated")?,
            "workpiece_axes" => one_of(value, &["0"], "0: axes of the workpiece are not emulated")?,
            "alternative_model" | "use_axis_offsets" | "enable_splicing" => one_of(
                value,
                &["0", "FALSE"],
                "0: what it changes is not known, so it is not emulated",
            )?,
            "filter_steps" | "manual_activation" | "associate_to_channel" | "diagnosis_file" => {}
            "a" | "b" | "c" => {
                return Err("no rotary axis: errors of rotary axes are not emulated");
            }
            _ => return Err("a key of this list that this program knows (docs/isg.md §3)"),
        }
        Ok(())
    }

    /// What has to be there and is not.
    fn missing(&self) -> impl Iterator<Item = String> {
        let axes = self.tables.axes.iter().filter(|(_, number)| number.is_none());
        let axes = axes.map(|(axis, _)| format!("the logical axis number of {axis}"));
        let without = self.paths.keys().filter(|index| !self.formats.contains(index));
        axes.chain(without.map(|index| format!("file_format[{index}]")))
    }
}

/// The number in `file[0]`.
fn indexed(key: &str, name: &str) -> Option<u32> {
    const FILES: u32 = 10;
    let index = key.strip_prefix(name)?.strip_prefix('[')?.strip_suffix(']')?;
    index.parse().ok().filter(|index| *index < FILES)
}

fn logical(value: &str) -> Result<u32, &'static str> {
    let number = value.parse::<u16>().ok().filter(|number| *number > 0);
    number.map(u32::from).ok_or("the logical number of an axis, 1 to 65535")
}

fn chain(value: &str) -> Result<[Axis; 3], &'static str> {
    let is_it = |order: &[Axis; 3]| Axis::letters(order).eq_ignore_ascii_case(value);
    let order = Axis::ORDERS.into_iter().find(is_it);
    order.ok_or("each of X, Y, Z once, from the workpiece to the tool")
}

fn set(value: &str) -> Result<PerAxis<bool>, &'static str> {
    let letters = value.chars().map(|letter| Axis::from_letter(letter.encode_utf8(&mut [0; 4])));
    let letters: Option<Vec<Axis>> = letters.collect();
    let letters = letters.ok_or("letters of axes, for instance XY")?;
    Ok(PerAxis::from_fn(|axis| letters.contains(&axis)))
}

fn one_of(value: &str, words: &[&str], expected: &'static str) -> Result<(), &'static str> {
    let is_one = words.iter().any(|word| word.eq_ignore_ascii_case(value));
    is_one.then_some(()).ok_or(expected)
}

fn wrong(setting: &Setting<'_>, expected: &str) -> Complaint {
    let (key, value) = (shown(&setting.key), shown(setting.value));
    Complaint::new(
        setting.span.clone(),
        format!("`{key}` is `{value}`, expected {expected}"),
        "a line holds a key and its value; `#` begins a comment",
    )
}

#[cfg(test)]
mod tests;
