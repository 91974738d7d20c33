//! ISG volumetric compensation (`ISG_CSV`): blocks of columns, a line with `#` between them.
//!
//! ```text
//!   X      EXX     EYX     EAX        argument and parameters; separated by blanks
//!   0.0    0.0000  0.0000  0.0
//!   100.0  0.0021  0.0004  0.000002
//!   #
//!   C0Y                               no argument: one row
//!   0.000012
//! ```

use crate::inputs::import::components::{Name, Parameter, assemble};
use crate::inputs::import::lines::{Line, Word, lines, looks_like_number};
use crate::inputs::import::stated::Stated;
use crate::inputs::import::{Component, Reading};
use crate::quantity::axis::Axis;
use crate::text::document::Source;
use crate::text::problem::{Problem, Problems, shown};

/// Whether a line names arguments and parameters.
pub(super) fn is_header(line: &str) -> bool {
    let names: Vec<&str> = line.split(is_separator).filter(|n| !n.is_empty()).collect();
    let parameters = names.iter().filter(|name| Name::is_one(name)).count();
    let is_known = |name: &&str| is_argument(name) || Name::is_one(name);
    parameters > 0 && names.iter().all(is_known)
}

fn is_argument(name: &str) -> bool {
    matches!(name, "X" | "Y" | "Z" | "A" | "B" | "C")
}

fn is_separator(c: char) -> bool {
    c.is_whitespace() || c == ';'
}

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let mut problems = Problems::none();
    let mut parameters = Vec::new();
    let mut block: Vec<Line<'_>> = Vec::new();
    for line in lines(source) {
        let line = line.before("//");
        if line.text.trim_start().starts_with('#') {
            parameters.extend(read_block(&block, &mut problems));
            block.clear();
        } else if !line.is_blank() {
            block.push(line);
        }
    }
    parameters.extend(read_block(&block, &mut problems));
    let sign = stated.required_sign(&mut problems);
    if let (Some(sign), true) = (sign, problems.is_empty()) {
        return assemble(&parameters, sign);
    }
    Err(problems)
}

fn read_block(block: &[Line<'_>], problems: &mut Problems) -> Vec<Parameter> {
    let Some((header, rows)) = block.split_first() else {
        return Vec::new();
    };
    let names = header.words(is_separator);
    if names.iter().any(|name| looks_like_number(name.text)) {
        problems.push(
            Problem::new("numbers stand where the names of the columns are expected")
                .at(header.place())
                .help("each block begins with its arguments and parameters, e.g. `X EXX EYX EZX`"),
        );
        return Vec::new();
    }
    let arguments = names
        .iter()
        .take_while(|name| is_argument(name.text))
        .count();
    if arguments > 1 {
        problems.push(
            Problem::new(format!("the block has {arguments} arguments, expected one or none"))
                .at(header.place())
                .help("an error table holds curves along one axis; export component errors instead of a map"),
        );
        return Vec::new();
    }
    let columns = read_columns(&names, rows, problems);
    if columns.iter().any(Vec::is_empty) {
        problems.push_with(|| {
            Problem::new("the block has no rows")
                .at(header.place())
                .help("the file is incomplete or damaged: export it again")
        });
        return Vec::new();
    }
    refuse_several_constants(arguments, header, rows, problems);
    let positions = match arguments {
        0 => Vec::new(),
        _ => columns.first().cloned().unwrap_or_default(),
    };
    let parameters = names.iter().zip(columns).skip(arguments);
    parameters
        .map(|(name, values)| {
            refuse_wrong_argument(arguments, names[0], name, problems);
            Parameter {
                name: name.text.to_string(),
                place: name.place(),
                positions_mm: positions.clone(),
                values,
            }
        })
        .collect()
}

/// One list of numbers for each name.
fn read_columns(names: &[Word<'_>], rows: &[Line<'_>], problems: &mut Problems) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::new(); names.len()];
    for row in rows {
        let words = row.words(is_separator);
        if words.len() != names.len() {
            problems.push_with(|| {
                Problem::new(format!(
                    "the row has {} numbers, expected {} as in the header of its block",
                    words.len(),
                    names.len()
                ))
                .at(row.place())
                .help("a missing value is never filled in: export the file again")
            });
            continue;
        }
        for (column, word) in columns.iter_mut().zip(&words) {
            column.extend(word.number("a value", problems));
        }
    }
    columns
}

fn refuse_several_constants(
    arguments: usize,
    header: &Line<'_>,
    rows: &[Line<'_>],
    problems: &mut Problems,
) {
    if arguments == 0 && rows.len() > 1 {
        problems.push(
            Problem::new(format!(
                "a block without argument has {} rows, expected one",
                rows.len()
            ))
            .at(header.place())
            .help("put a line with `#` between the blocks"),
        );
    }
}

/// `EXY` is a curve along Y: its argument cannot be X.
fn refuse_wrong_argument(
    arguments: usize,
    argument: Word<'_>,
    name: &Word<'_>,
    problems: &mut Problems,
) {
    let Some(component) = Component::from_name(name.text) else {
        return;
    };
    let along = (arguments == 1)
        .then(|| Axis::from_letter(argument.text))
        .flatten();
    if along != Some(component.along) {
        problems.push_with(|| {
            Problem::new(format!(
                "`{}` is a curve along {}, but it does not stand under this argument",
                shown(name.text),
                component.along
            ))
            .at(name.place())
            .help("each block has its own moving axis")
        });
    }
}
