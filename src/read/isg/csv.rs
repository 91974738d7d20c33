//! `ISG_CSV`: blocks of a header and rows of numbers between blanks; `//` begins a comment, `#` ends a block.

use crate::control::table::isg::{Curve, Parameter, Point};
use crate::quantity::Axis;
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, lines, located, number, words};
use crate::text::{Problems, shown};
use std::ops::Range;

/// What a column holds.
enum Column {
    /// The position of an axis.
    Argument(Axis),
    Parameter(Parameter),
    /// A parameter that is not emulated: it has to be 0.
    Zero(String),
}

/// A block while its rows are read.
struct Block {
    columns: Vec<Column>,
    /// Of the header.
    span: Range<usize>,
    rows: Vec<Vec<f64>>,
}

/// The parameters of a file.
pub(super) fn curves(file: &str, text: &str) -> Result<Vec<Curve>, Problems> {
    let mut complaints: Vec<Complaint> = Vec::new();
    let mut curves: Vec<Curve> = Vec::new();
    let mut block: Option<Block> = None;
    for line in lines(text) {
        let comment = text[line.clone()].find("//");
        let line = line.start..comment.map_or(line.end, |at| line.start + at);
        let words = words(text, line.clone());
        let ended = words.first().is_some_and(|(word, _)| word.starts_with('#'));
        let done = match (&mut block, &words[..]) {
            (_, []) => Ok(()),
            (_, _) if ended => end(block.take(), &mut curves),
            (None, header) => begin(header, line).map(|begun| block = Some(begun)),
            (Some(block), row) => block.push(row, line),
        };
        complaints.extend(done.err());
        if complaints.len() >= MOST_COMPLAINTS {
            break;
        }
    }
    complaints.extend(end(block, &mut curves).err());
    located(file, text, complaints).or_ok(curves)
}

/// Words of a line with their places.
type Words<'a> = [(&'a str, Range<usize>)];

fn begin(header: &Words<'_>, span: Range<usize>) -> Result<Block, Complaint> {
    let columns = header.iter().map(|(word, span)| column(word, span.clone()));
    let columns: Vec<Column> = columns.collect::<Result<_, _>>()?;
    let arguments = columns.iter().filter_map(|column| match column {
        Column::Argument(axis) => Some(*axis),
        _ => None,
    });
    let arguments: Vec<Axis> = arguments.collect();
    let block = Block { columns, span: span.clone(), rows: Vec::new() };
    let own = |parameter: &Parameter| match parameter.along() {
        Some(axis) => arguments == [axis],
        None => arguments.is_empty(),
    };
    let other = block.parameters().map(|(_, parameter)| parameter);
    let other = other.filter(|parameter| !own(parameter)).last();
    match other {
        None => Ok(block),
        Some(parameter) => Err(Complaint::new(
            span,
            format!(
                "{parameter} depends on something else than the position of its own axis, which is not emulated"
            ),
            "a block has the position of one axis and the parameters of this axis; constants stand in a block of their own",
        )),
    }
}

fn column(word: &str, span: Range<usize>) -> Result<Column, Complaint> {
    if let Some(axis) = Axis::from_letter(word) {
        return Ok(Column::Argument(axis));
    }
    let name = word.to_ascii_uppercase();
    if let Some(parameter) = Parameter::all().find(|own| own.to_string() == name) {
        return Ok(Column::Parameter(parameter));
    }
    let is_name = name.len() == 3 && name.chars().all(|c| c.is_ascii_alphanumeric());
    if is_name && !name.starts_with(|c: char| c.is_ascii_digit()) {
        return Ok(Column::Zero(name));
    }
    Err(Complaint::new(
        span,
        format!("`{}` is neither an axis nor a parameter", shown(word)),
        "the first line of a block names its columns, for instance `X EXX EYX EZX`",
    ))
}

impl Block {
    fn parameters(&self) -> impl Iterator<Item = (usize, Parameter)> {
        let columns = self.columns.iter().enumerate();
        columns.filter_map(|(index, column)| match column {
            Column::Parameter(parameter) => Some((index, *parameter)),
            _ => None,
        })
    }

    /// Where the column of the position stands.
    fn argument(&self) -> Option<usize> {
        let is_it = |column: &Column| matches!(column, Column::Argument(_));
        self.columns.iter().position(is_it)
    }

    fn push(&mut self, row: &Words<'_>, span: Range<usize>) -> Result<(), Complaint> {
        let complaint =
            |message: String, help: &str| Err(Complaint::new(span.clone(), message, help));
        if row.len() != self.columns.len() {
            let (found, expected) = (row.len(), self.columns.len());
            return complaint(
                format!("{found} numbers, expected {expected} as in the header"),
                "a row has a number for each column; `#` in a line ends a block",
            );
        }
        let mut numbers = Vec::new();
        for ((word, span), column) in row.iter().zip(&self.columns) {
            let value = number(word).ok_or_else(|| no_number(word, span))?;
            if let (Column::Zero(name), true) = (column, value.abs() > 0.0) {
                return complaint(
                    format!("{name} is {value}: this parameter is not emulated"),
                    "name files in which it is 0, or that do not hold it",
                );
            }
            numbers.push(value);
        }
        match (self.argument(), self.rows.last()) {
            (None, Some(_)) => complaint(
                "a second row of constants".to_string(),
                "a block without positions has one row",
            ),
            (Some(at), Some(last)) if numbers[at] <= last[at] => complaint(
                format!(
                    "position {} does not lie above {} of the row before",
                    numbers[at], last[at]
                ),
                "rows ascend, each position once",
            ),
            _ => {
                self.rows.push(numbers);
                Ok(())
            }
        }
    }
}

fn no_number(word: &str, span: &Range<usize>) -> Complaint {
    Complaint::new(
        span.clone(),
        format!("`{}` is no number that a machine can mean", shown(word)),
        "positions in mm, deviations in mm, angles in rad, with a decimal point",
    )
}

/// Takes the parameters of a block.
fn end(block: Option<Block>, curves: &mut Vec<Curve>) -> Result<(), Complaint> {
    let Some(block) = block else {
        return Ok(());
    };
    if block.rows.is_empty() {
        let message = "a header without a row";
        return Err(Complaint::new(block.span, message, "the file may have been cut off"));
    }
    let argument = block.argument();
    for (index, parameter) in block.parameters() {
        if curves.iter().any(|curve| curve.parameter == parameter) {
            let message = format!("{parameter} stands twice");
            let span = block.span.clone();
            return Err(Complaint::new(span, message, "give each parameter once"));
        }
        let position = |row: &[f64]| argument.map_or(0.0, |at| row[at]);
        let point = |row: &Vec<f64>| Point { position: position(row), value: row[index] };
        curves.push(Curve { parameter, points: block.rows.iter().map(point).collect() });
    }
    Ok(())
}
