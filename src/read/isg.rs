//! Reader of the ISG kernel's volumetric compensation: the list (`.lis`) and the parameter files that it names.
//!
//! ```text
//!   texts ─┬ with a line `file[0] …` ── list ──→ axes, chain, switches; names of the files
//!          └ those that it names ── csv ──→ curves of the parameters
//! ```
//! Written from the pages of the maker named in docs/isg.md §3; it knows nothing of the program's own templates.

pub mod control;

use self::control::IsgControl;
use crate::control::control_state::ControlState;
use crate::control::controller::{IsgFacts, Role};
use crate::control::table::Tables;
use crate::control::table::isg::{IsgCurve, IsgPoint, IsgTables, Parameter};
use crate::quantity::{Axis, PerAxis};
use crate::read::emulate::{Emulated, Emulator};
use crate::read::family::{Family, ReadBack, file_name, quoted};
use crate::read::findings::ReadFinding;
use crate::read::lexer::{Complaint, complaints, lines, located, number, words};
use crate::read::refusals;
use crate::text::{Finding, Problems, shown};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

impl Family for IsgFacts {
    fn read_kit(&self, texts: &[(&str, &str)], _roles: &[Role]) -> Result<ReadBack, Problems> {
        let (tables, notes) = read(texts)?;
        Ok(ReadBack { notes, ..Tables::Isg(tables).into() })
    }

    fn control(&self, tables: &Tables, state: &ControlState) -> Emulated<Box<dyn Emulator>> {
        Ok(Box::new(IsgControl::new(tables.own(), self, state)?))
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
        [] => return Err(refusals::no_list(quoted(&others)).into()),
        _ => return Err(refusals::several_lists(quoted(&lists)).into()),
    };
    let list = list(list_name, text)?;
    let mut problems = Problems::none();
    let mut curves: Vec<IsgCurve> = Vec::new();
    let mut named: Vec<&str> = Vec::new();
    for path in list.paths.values() {
        let is_it =
            |(name, _): &&(&str, &str)| file_name(name).eq_ignore_ascii_case(file_name(path));
        let Some((name, text)) = others.iter().find(is_it) else {
            problems.push(refusals::not_listed_file(shown(list_name), shown(path)));
            continue;
        };
        named.push(name);
        for curve in problems.take(curves_of(name, text)).into_iter().flatten() {
            let (parameter, points) = (curve.parameter, curve.points.len());
            if points > MOST_POINTS {
                problems.push(refusals::points(shown(name), parameter, points, MOST_POINTS));
            }
            match curves.iter().any(|other| other.parameter == parameter) {
                true => problems.push(refusals::in_two_files(parameter, shown(name))),
                false => curves.push(curve),
            }
        }
    }
    curves.sort_by_key(|curve| curve.parameter);
    let unnamed = others.iter().filter(|(name, _)| !named.contains(name));
    let unnamed = unnamed.map(|(name, _)| ReadFinding::NotListed { file: shown(name) }.into());
    problems.or_ok((IsgTables { curves, ..list.tables }, unnamed.collect()))
}

/// Most points of a parameter: ten times and more what a control takes.
const MOST_POINTS: usize = 20_000;

// The list of a volumetric compensation: `key value` in each line, `#` begins a comment.

/// Whether a text is a list: it names a parameter file.
fn is_list(text: &str) -> bool {
    lines(text).any(|line| text[line].trim_start().to_ascii_lowercase().starts_with("file["))
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
    let mut known = BTreeSet::new();
    let settings = lines(text).filter_map(|line| setting(text, line));
    let mut complaints = complaints(settings, |setting| {
        let taken = match known.insert(setting.key.clone()) {
            true => list.take(&setting),
            false => Err("each key once"),
        };
        taken.map_err(|expected| wrong(&setting, expected))
    });
    let missing = list.missing().map(|what| Complaint::new(0..0, refusals::list_without(what)));
    complaints.extend(missing);
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
    words.iter().any(|word| word.eq_ignore_ascii_case(value)).then_some(()).ok_or(expected)
}

fn wrong(setting: &Setting<'_>, expected: &str) -> Complaint {
    let (key, value) = (shown(&setting.key), shown(setting.value));
    Complaint::new(setting.span.clone(), refusals::other_setting(key, value, expected))
}

// `ISG_CSV`: blocks of a header and rows of numbers between blanks; `//` begins a comment, `#` ends a block.

/// What a column holds.
enum IsgColumn {
    /// The position of an axis.
    Argument(Axis),
    Parameter(Parameter),
    /// A parameter that is not emulated: it has to be 0.
    Zero(String),
}

/// A block while its rows are read.
struct Block {
    columns: Vec<IsgColumn>,
    /// Of the header.
    span: Range<usize>,
    rows: Vec<Vec<f64>>,
}

/// The parameters of a file.
fn curves_of(file: &str, text: &str) -> Result<Vec<IsgCurve>, Problems> {
    let mut curves: Vec<IsgCurve> = Vec::new();
    let mut block: Option<Block> = None;
    let mut complaints = complaints(lines(text), |line| {
        let comment = text[line.clone()].find("//");
        let line = line.start..comment.map_or(line.end, |at| line.start + at);
        let words = words(text, line.clone());
        let ended = words.first().is_some_and(|(word, _)| word.starts_with('#'));
        match (&mut block, &words[..]) {
            (_, []) => Ok(()),
            (_, _) if ended => end(block.take(), &mut curves),
            (None, header) => begin(header, line).map(|begun| block = Some(begun)),
            (Some(block), row) => block.push(row, line),
        }
    });
    complaints.extend(end(block, &mut curves).err());
    located(file, text, complaints).or_ok(curves)
}

/// Words of a line with their places.
type Words<'a> = [(&'a str, Range<usize>)];

fn begin(header: &Words<'_>, span: Range<usize>) -> Result<Block, Complaint> {
    let columns = header.iter().map(|(word, span)| column(word, span.clone()));
    let columns: Vec<IsgColumn> = columns.collect::<Result<_, _>>()?;
    let arguments = columns.iter().filter_map(|column| match column {
        IsgColumn::Argument(axis) => Some(*axis),
        _ => None,
    });
    let arguments: Vec<Axis> = arguments.collect();
    let block = Block { columns, span: span.clone(), rows: Vec::new() };
    let own = |parameter: &Parameter| match parameter.along() {
        Some(axis) => arguments == [axis],
        None => arguments.is_empty(),
    };
    let other = block.parameters().map(|(_, parameter)| parameter);
    match other.filter(|parameter| !own(parameter)).last() {
        None => Ok(block),
        Some(parameter) => Err(Complaint::new(span, refusals::other_argument(parameter))),
    }
}

fn column(word: &str, span: Range<usize>) -> Result<IsgColumn, Complaint> {
    if let Some(axis) = Axis::from_letter(word) {
        return Ok(IsgColumn::Argument(axis));
    }
    let name = word.to_ascii_uppercase();
    if let Some(parameter) = Parameter::all().find(|own| own.to_string() == name) {
        return Ok(IsgColumn::Parameter(parameter));
    }
    let is_name = name.len() == 3 && name.chars().all(|c| c.is_ascii_alphanumeric());
    if is_name && !name.starts_with(|c: char| c.is_ascii_digit()) {
        return Ok(IsgColumn::Zero(name));
    }
    Err(Complaint::new(span, refusals::no_parameter(shown(word))))
}

impl Block {
    fn parameters(&self) -> impl Iterator<Item = (usize, Parameter)> {
        self.columns.iter().enumerate().filter_map(|(index, column)| match column {
            IsgColumn::Parameter(parameter) => Some((index, *parameter)),
            _ => None,
        })
    }

    /// Where the column of the position stands.
    fn argument(&self) -> Option<usize> {
        let is_it = |column: &IsgColumn| matches!(column, IsgColumn::Argument(_));
        self.columns.iter().position(is_it)
    }

    fn push(&mut self, row: &Words<'_>, span: Range<usize>) -> Result<(), Complaint> {
        let complaint = |wrong| Err(Complaint::new(span.clone(), wrong));
        if row.len() != self.columns.len() {
            return complaint(refusals::other_count(row.len(), self.columns.len()));
        }
        let mut numbers = Vec::new();
        for ((word, span), column) in row.iter().zip(&self.columns) {
            let no_number = || Complaint::new(span.clone(), refusals::no_number(shown(word)));
            let value = number(word).ok_or_else(no_number)?;
            if let (IsgColumn::Zero(name), true) = (column, value.abs() > 0.0) {
                return complaint(refusals::not_zero(name, value));
            }
            numbers.push(value);
        }
        match (self.argument(), self.rows.last()) {
            (None, Some(_)) => complaint(refusals::second_row()),
            (Some(at), Some(last)) if numbers[at] <= last[at] => {
                complaint(refusals::not_ascending(numbers[at], last[at], ""))
            }
            _ => {
                self.rows.push(numbers);
                Ok(())
            }
        }
    }
}

/// Takes the parameters of a block.
fn end(block: Option<Block>, curves: &mut Vec<IsgCurve>) -> Result<(), Complaint> {
    let Some(block) = block else {
        return Ok(());
    };
    if block.rows.is_empty() {
        return Err(Complaint::new(block.span, refusals::no_row()));
    }
    let argument = block.argument();
    for (index, parameter) in block.parameters() {
        if curves.iter().any(|curve| curve.parameter == parameter) {
            return Err(Complaint::new(block.span.clone(), refusals::twice(parameter)));
        }
        let position = |row: &[f64]| argument.map_or(0.0, |at| row[at]);
        let point = |row: &Vec<f64>| IsgPoint { position: position(row), value: row[index] };
        curves.push(IsgCurve { parameter, points: block.rows.iter().map(point).collect() });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
