//! What the user states because a file does not carry it: one table of facts, each with its option, the
//! formats that take it, and what is said where it is missing. clap reads the options from here as well,
//! so that a statement has its words in one place.

use crate::control::controller::TableSign;
use crate::inputs::error_table::Component;
use crate::inputs::refusals;
use crate::quantity::{Axis, Direction};
use crate::text::{LONGEST_MM, LengthUnit, Notes, Problem, joined};
use clap::{Args, ValueEnum};
use encoding_rs::{Encoding, GBK, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1250, WINDOWS_1252};

/// Formats that can be read, in the order of the documentation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Renishaw static data, linear
    Rtl,
    /// Renishaw compensation table
    Ren,
    /// API position export, linear
    Pos,
    /// Etalon exchange format
    Etalon,
    /// ISG volumetric compensation
    Isg,
    /// delimited text with a stated mapping
    Columns,
    /// captures in order without their places, into a form
    List,
}

/// How the values of a compensation table count; others than absolute ones cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Values {
    /// Each value is the whole deviation or correction at its position
    Absolute,
}

/// How the runs of a measurement were travelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Runs {
    /// All runs from the first target to the last
    Unidirectional,
    /// Odd runs from the first target to the last, even runs back
    Bidirectional,
}

/// Direction of travel of rows that do not name one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Travel {
    /// Towards larger coordinates
    #[value(name = "+")]
    Plus,
    /// Towards smaller coordinates
    #[value(name = "-")]
    Minus,
    /// Not distinguished
    Both,
}

impl Travel {
    /// `None` = not distinguished.
    pub(super) const fn direction(self) -> Option<Direction> {
        match self {
            Travel::Plus => Some(Direction::Plus),
            Travel::Minus => Some(Direction::Minus),
            Travel::Both => None,
        }
    }
}

/// What the values of a list of captures count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Counting {
    /// From the first capture
    Cumulative,
    /// From the capture before; the first value is that of the second capture
    Incremental,
}

/// The sign before the decimals of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Decimal {
    /// `1.5`
    Point,
    /// `1,5`
    Comma,
}

/// Whether the instrument brought the readings to 20 °C of the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MaterialCorrected {
    /// The expansion of the material is taken out already
    Yes,
    /// It is still in the readings
    No,
    /// Nobody knows any more
    NotStated,
}

/// The word of a choice on the command line.
pub fn word(choice: impl ValueEnum) -> String {
    let value = choice.to_possible_value();
    value.map_or_else(String::new, |value| value.get_name().to_string())
}

/// A format with its word, for a comment of the table.
pub(super) fn described(format: Format) -> String {
    let value = format.to_possible_value();
    let help = value.as_ref().and_then(|value| value.get_help());
    let help = help.map_or_else(String::new, ToString::to_string);
    format!("{} ({help})", word(format))
}

/// What was stated on the command line; `None` = nothing.
#[derive(Args, Clone, Debug, Default)]
pub struct ImportFacts {
    /// Format of the file [default: by what stands in it]
    #[arg(long, value_name = "FORMAT")]
    pub from: Option<Format>,
    /// Encoding of its text, where it does not show: windows-1252 (= latin-1), windows-1250, gbk,
    /// utf-16le, utf-16be or utf-8
    #[arg(long, value_name = "ENCODING", value_parser = encoding_word)]
    pub encoding: Option<&'static Encoding>,
    /// The moving axis
    #[arg(long, value_parser = axis_word)]
    pub axis: Option<Axis>,
    /// What was measured, e.g. EXX (positioning of X) or EYX (deviation in Y while X moves)
    #[arg(long, value_parser = term_word)]
    pub term: Option<Component>,
    /// Machine coordinate of the first target, mm
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = millimetres)]
    pub first_target_at_mm: Option<f64>,
    /// Way of the axis from the first target to the last, in machine coordinates: + or -
    #[arg(long, value_name = "+|-", allow_hyphen_values = true, value_parser = direction_word)]
    pub targets_run: Option<Direction>,
    /// Direction of travel of rows that do not name one
    #[arg(long = "direction", value_name = "+|-|both", allow_hyphen_values = true)]
    pub travel: Option<Travel>,
    /// Way of the axis, in machine coordinates, in rows whose direction is +: + or -
    #[arg(long, value_name = "+|-", allow_hyphen_values = true, value_parser = direction_word)]
    pub plus_moves: Option<Direction>,
    /// as-error = measured - target, as the file counts; as-correction = what has to be added
    #[arg(long, hide_possible_values = true)]
    pub sign: Option<TableSign>,
    /// Unit of the values
    #[arg(long)]
    pub unit: Option<LengthUnit>,
    /// How the values of a compensation table count: absolute (others cannot be read)
    #[arg(long)]
    pub values: Option<Values>,
    /// unidirectional, or bidirectional (even runs go back)
    #[arg(long)]
    pub runs: Option<Runs>,
    /// Whether the instrument brought the readings to 20 °C of the material
    #[arg(long)]
    pub material_corrected: Option<MaterialCorrected>,
    /// Sheet of a workbook [default: the first one]
    #[arg(long, value_name = "NAME")]
    pub sheet: Option<String>,
    /// What the values of lists count from: the first capture, or the one before
    #[arg(long, value_name = "cumulative|incremental", hide_possible_values = true)]
    pub captures: Option<Counting>,
    /// Sign before the decimals of a delimited text, where it does not show
    #[arg(long)]
    pub decimal: Option<Decimal>,
    /// Which column holds what (#3 = the third one), e.g. "AXn [mm]=position_mm,Delta [mm]=ex_mm"
    #[arg(long, value_name = "NAME=COLUMN,…")]
    pub columns: Option<String>,
    /// Take what was understood from the file (never sign, unit, material, first target)
    #[arg(long)]
    pub yes: bool,
}

/// An axis from its letter.
pub fn axis_word(text: &str) -> Result<Axis, String> {
    Axis::from_letter(text).ok_or_else(|| "expected x, y or z".to_string())
}

/// A direction from `+` or `-`.
pub fn direction_word(text: &str) -> Result<Direction, String> {
    Direction::from_symbol(text).ok_or_else(|| "expected +, -".to_string())
}

fn term_word(text: &str) -> Result<Component, String> {
    Component::from_name(text).ok_or_else(|| "expected EXX, EYX … EZZ, EAX … ECZ".to_string())
}

/// A length that fits into a machine.
pub fn millimetres(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|mm| mm.abs() <= LONGEST_MM);
    number.ok_or_else(|| "expected a number of mm, with a decimal point".to_string())
}

/// Encodings that may be stated, and who writes them.
pub(super) const ENCODINGS: [(&Encoding, &str); 6] = [
    (UTF_8, "newer programs"),
    (WINDOWS_1252, "Windows in western Europe"),
    (WINDOWS_1250, "Windows in central Europe"),
    (GBK, "Windows in China"),
    (UTF_16LE, ""),
    (UTF_16BE, ""),
];

/// The encoding of a word such as `gbk`; `latin-1` is another word for `windows-1252`.
pub fn encoding_word(text: &str) -> Result<&'static Encoding, String> {
    let name = if text == "latin-1" { "windows-1252" } else { text };
    let found = ENCODINGS.iter().find(|(known, _)| encoding_name(known) == name);
    let words = || joined(ENCODINGS.map(|(known, _)| encoding_name(known)));
    found.map(|(known, _)| *known).ok_or_else(|| format!("expected {}", words()))
}

/// Its name in small letters.
pub(super) fn encoding_name(encoding: &'static Encoding) -> String {
    encoding.name().to_ascii_lowercase()
}

/// A fact that a file may not carry.
pub(super) struct Fact {
    /// The option that states it.
    pub(super) option: &'static str,
    /// The formats for which it has a meaning.
    formats: &'static [Format],
    /// What was stated, in words.
    value: fn(&ImportFacts) -> Option<String>,
    /// Why it has to be stated.
    pub(super) why: &'static str,
    /// What to add.
    add: &'static str,
}

const WITH_TARGETS: &[Format] = &[Format::Rtl, Format::Ren, Format::Pos, Format::Columns];
const WITH_MATERIAL: &[Format] = &[Format::Rtl, Format::Pos];
const MAPPED: &[Format] = &[Format::Columns, Format::List];
const SIGNED: &[Format] =
    &[Format::Rtl, Format::Ren, Format::Pos, Format::Etalon, Format::Isg, Format::Columns];

/// The facts, each a constant, and all of them in the order in which the statements are told.
macro_rules! facts {
    ($($name:ident: $option:literal of $formats:expr, $value:expr, $why:literal, $add:literal;)*) => {
        $(pub(super) const $name: Fact =
            Fact { option: $option, formats: $formats, value: $value, why: $why, add: $add };)*
        const FACTS: &[&Fact] = &[$(&$name),*];
    };
}

facts! {
    COLUMNS: "--columns" of MAPPED, |stated| stated.columns.as_ref().map(|c| format!("\"{c}\"")), "which column holds what cannot be seen from the file", "add the mapping, e.g. `--columns \"AXn [mm]=position_mm,Delta [mm]=ex_mm\"`";
    AXIS: "--axis" of WITH_TARGETS, |stated| stated.axis.map(|axis| axis.key().to_string()), "no column is mapped to `axis`, the moving axis", "add the axis that moved, e.g. `--axis x`";
    TERM: "--term" of WITH_TARGETS, |stated| stated.term.map(|term| term.to_string()), "the file does not say which deviation was measured", "add e.g. `--term EXX` (positioning of X) or `--term EYX` (deviation in Y while X moves)";
    FIRST_TARGET: "--first-target-at-mm" of WITH_TARGETS, |stated| stated.first_target_at_mm.map(|mm| format!("{}", mm + 0.0)), "the targets of the file count from the laser's zero, not from the machine's", "add the machine coordinate of target 1, e.g. `--first-target-at-mm -200`";
    TARGETS_RUN: "--targets-run" of WITH_TARGETS, |stated| stated.targets_run.map(|way| way.to_string()), "the file does not say whether the targets go towards larger or smaller machine coordinates", "add `--targets-run +` or `--targets-run -`: the way of the axis from the first target to the last";
    DIRECTION: "--direction" of &[Format::Columns], |stated| stated.travel.map(word), "no column is mapped to the direction of travel", "add `--direction +`, `--direction -` or `--direction both` (not distinguished), or map a column to `direction`";
    PLUS_MOVES: "--plus-moves" of &[Format::Columns], |stated| stated.plus_moves.map(|way| way.to_string()), "targets and axis do not both count up, so `+` of the file may be the machine's, that of the targets or the outward run", "add `--plus-moves +` or `--plus-moves -`: the way of the axis, in machine coordinates, in rows whose direction is `+`";
    SIGN: "--sign" of SIGNED, |stated| stated.sign.map(word), "the file does not say whether its values are deviations or corrections", "add `--sign as-error` (measured - target) or `--sign as-correction` (what has to be added)";
    UNIT: "--unit" of &[Format::Ren], |stated| stated.unit.map(word), "the file has no line `Compensation resolution`", "add the unit of the values: `--unit um`, `mm`, `in` or `uin`";
    VALUES: "--values" of &[Format::Ren], |stated| stated.values.map(word), "the file has no line `Compensation type`", "add `--values absolute` if each value is the whole deviation at its position";
    RUNS: "--runs" of &[Format::Rtl], |stated| stated.runs.map(word), "the second number of `Flags` does not say whether even runs go back", "add `--runs bidirectional` (even runs go back) or `--runs unidirectional` (every run goes from the first target to the last; even runs of zeros were never made)";
    MATERIAL_CORRECTED: "--material-corrected" of WITH_MATERIAL, |stated| stated.material_corrected.map(word), "the file notes a temperature of the material, but not whether the readings were brought to 20 °C", "add `--material-corrected yes` (the instrument did it), `no`, or `not-stated`";
    CAPTURES: "--captures" of &[Format::List], |stated| stated.captures.map(word), "a list does not say whether its values count from the first capture or from the one before", "add `--captures cumulative`, or `--captures incremental` if the first value is that of the second capture";
    SHEET: "--sheet" of MAPPED, |stated| stated.sheet.clone(), "the first sheet is read", "add the name of the sheet, e.g. `--sheet Readings`";
    DECIMAL: "--decimal" of MAPPED, |stated| stated.decimal.map(word), "no number of the file shows what its comma means", "add `--decimal comma` or `--decimal point`";
}

/// The mapping of lists.
pub(super) const LIST_COLUMNS: Fact = Fact {
    why: "what the lists hold, in which unit and in which column cannot be seen from them",
    add: "add e.g. `--columns \"#1=displacement_mm\"`: the first column holds the readings, mm",
    ..COLUMNS
};

impl Fact {
    /// The option with what was stated.
    pub(super) fn statement(&self, stated: &ImportFacts) -> Option<String> {
        Some(format!("{} {}", self.option, (self.value)(stated)?))
    }

    /// The problem that neither file nor user says it.
    pub(super) fn missing(&self) -> Problem {
        self.missing_because(self.why)
    }

    /// The same, with a reason that the file gives.
    pub(super) fn missing_because(&self, why: &str) -> Problem {
        Problem::new(format!("`{}` is not stated: {why}", self.option)).help(self.add)
    }
}

impl ImportFacts {
    /// Every option with its value, in a fixed order.
    pub fn given(&self) -> Vec<(&'static str, String)> {
        FACTS.iter().filter_map(|fact| Some((fact.option, (fact.value)(self)?))).collect()
    }

    /// A comment for each option.
    pub(super) fn comments(&self) -> impl Iterator<Item = String> {
        self.given().into_iter().map(|(option, value)| format!("stated: {option} {value}"))
    }

    /// What is given here, but not there, as options.
    pub(super) fn beyond(&self, other: &ImportFacts) -> Option<String> {
        let other = other.given();
        let own = self.given().into_iter().filter(|own| !other.contains(own));
        let own = own.map(|(option, value)| format!("{option} {value}")).collect::<Vec<_>>();
        (!own.is_empty()).then(|| own.join(" "))
    }

    /// Notes statements that have no meaning for the format: mistakes of the user.
    pub(super) fn refuse_foreign(&self, format: Format, notes: &Notes) {
        let of_format = FACTS.iter().filter(|fact| fact.formats.contains(&format));
        let takes: Vec<&str> = of_format.map(|fact| fact.option).collect();
        for (option, _) in self.given().iter().filter(|(option, _)| !takes.contains(option)) {
            notes.refuse(refusals::no_meaning(option, word(format), takes.join(", ")));
        }
    }
}
