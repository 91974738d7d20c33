//! The list of a volumetric compensation: `key value` in each line, `#` begins a comment.

use crate::quantity::{Axis, PerAxis};
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, lines, located, words};
use crate::text::{Problems, shown};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// What a list says.
#[derive(Debug)]
pub(super) struct List {
    pub(super) axes: PerAxis<Option<u32>>,
    /// From the workpiece to the tool.
    pub(super) chain: [Axis; 3],
    pub(super) negated: PerAxis<bool>,
    pub(super) zeroed: PerAxis<bool>,
    /// Paths of the parameter files.
    pub(super) files: Vec<String>,
}

/// Whether a text is a list: it names a parameter file.
pub(super) fn is_list(text: &str) -> bool {
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

/// What is read from the lines.
struct Reading {
    list: List,
    paths: BTreeMap<u32, String>,
    /// Files whose form is stated.
    formats: BTreeSet<u32>,
}

impl List {
    /// Reads a text.
    pub(super) fn read(file: &str, text: &str) -> Result<List, Problems> {
        let mut reading = Reading::default();
        let (mut known, mut complaints) = (BTreeSet::new(), Vec::new());
        for setting in lines(text).filter_map(|line| setting(text, line)) {
            let taken = match known.insert(setting.key.clone()) {
                true => reading.take(&setting),
                false => Err("each key once"),
            };
            complaints.extend(taken.err().map(|expected| wrong(&setting, expected)));
            if complaints.len() >= MOST_COMPLAINTS {
                break;
            }
        }
        complaints.extend(reading.missing().map(|missing| {
            let message = format!("the list does not say {missing}");
            Complaint::new(0..0, message, "name the complete list of the control")
        }));
        match complaints.is_empty() {
            true => Ok(reading.whole()),
            false => Err(located(file, text, complaints)),
        }
    }
}

impl Default for Reading {
    /// What the control takes where the list does not say it.
    fn default() -> Self {
        Reading {
            list: List {
                axes: PerAxis::default(),
                chain: Axis::ALL,
                negated: PerAxis::default(),
                zeroed: PerAxis::default(),
                files: Vec::new(),
            },
            paths: BTreeMap::new(),
            formats: BTreeSet::new(),
        }
    }
}

impl Reading {
    /// Takes a setting; `Err` = what was expected.
    fn take(&mut self, setting: &Setting<'_>) -> Result<(), &'static str> {
        let Setting { key, value, .. } = setting;
        if let Some(axis) = Axis::ALL.into_iter().find(|axis| axis.key() == key) {
            self.list.axes[axis] = Some(logical(value)?);
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
            "chain" => self.list.chain = chain(value)?,
            "negate" => self.list.negated = set(value)?,
            "set_to_zero" => self.list.zeroed = set(value)?,
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
            _ => return Err("a key of this list that this program knows (docs/isg.md §1)"),
        }
        Ok(())
    }

    /// What has to be there and is not.
    fn missing(&self) -> impl Iterator<Item = String> {
        let axes = self.list.axes.iter().filter(|(_, number)| number.is_none());
        let axes = axes.map(|(axis, _)| format!("the logical axis number of {axis}"));
        let without = self.paths.keys().filter(|index| !self.formats.contains(index));
        axes.chain(without.map(|index| format!("file_format[{index}]")))
    }

    fn whole(self) -> List {
        List { files: self.paths.into_values().collect(), ..self.list }
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

fn axis(letter: char) -> Option<Axis> {
    let is_it = |axis: &Axis| axis.letter() == letter.to_ascii_uppercase();
    Axis::ALL.into_iter().find(is_it)
}

fn chain(value: &str) -> Result<[Axis; 3], &'static str> {
    let letters: Option<Vec<Axis>> = value.chars().map(axis).collect();
    let order = letters.and_then(|letters| <[Axis; 3]>::try_from(letters).ok());
    let each_once = |order: &[Axis; 3]| Axis::ALL.iter().all(|axis| order.contains(axis));
    order.filter(each_once).ok_or("each of X, Y, Z once, from the workpiece to the tool")
}

fn set(value: &str) -> Result<PerAxis<bool>, &'static str> {
    let letters: Option<Vec<Axis>> = value.chars().map(axis).collect();
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
