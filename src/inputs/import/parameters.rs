//! Component errors and squareness with the names of ISO 230-1, as the Etalon exchange format (variant
//! "Vendor") and ISG volumetric compensation (`ISG_CSV`) give them: deviations in mm, angles and squareness in
//! rad, arguments in mm = machine coordinates.
//!
//! ```text
//!   [C0Y]                      X      EXX     EYX     EAX        argument and parameters
//!   VALUE = 0.000012           0.0    0.0000  0.0000  0.0
//!   [EXX]                      100.0  0.0021  0.0004  0.000002
//!   Gridpoints = {             #
//!      0.0 0.0000              C0Y                               no argument: one row
//!    100.0 0.0021              0.000012
//!   } // end of EXX
//! ```

use crate::control::controller::TableSign;
use crate::inputs::error_table::DraftSeries;
use crate::inputs::import::component::{Component, Kind};
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::reading::{FileContents, Placing, Squareness, deviation, tidy};
use crate::inputs::import::stated::Stated;
use crate::inputs::import::words::{AGAIN, Piece, lines};
use crate::quantity::axis::Axis;
use crate::quantity::units::UM_PER_MM;
use crate::text::document::Source;
use crate::text::problem::{Place, Problem, Problems, shown};

/// Micrometres per metre, or microradians, in one radian.
const MICRO: f64 = 1e6;

/// What a parameter name stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Name {
    /// EXX … ECZ.
    Component(Component),
    /// C0Y, B0Z, A0Z: the pair, the name, and the sign of φ in it.
    Squareness(&'static str, &'static str, f64),
    /// A location that is none of the three.
    OtherLocation,
    /// Something that an error table of three linear axes does not hold.
    LeftOut(&'static str),
}

impl Name {
    /// Of a name in capital letters, with or without `E` before a location.
    fn of(name: &str) -> Option<Name> {
        if let Some(component) = Component::from_name(name) {
            return Some(Name::Component(component));
        }
        let location = match name.len() {
            4 => name.strip_prefix('E')?,
            _ => name,
        };
        // ISO 230-1: EC0Y = −φxy, EB0Z = +φxz, EA0Z = −φyz (contract §1).
        Some(match location.as_bytes() {
            b"C0Y" => Name::Squareness("xy", "C0Y", -1.0),
            b"B0Z" => Name::Squareness("xz", "B0Z", 1.0),
            b"A0Z" => Name::Squareness("yz", "A0Z", -1.0),
            [b'X' | b'Y' | b'Z', b'0', b'X' | b'Y' | b'Z'] => {
                Name::LeftOut("a constant, which is zeroed at the reference")
            }
            [b'A' | b'B' | b'C', b'0', b'X' | b'Y' | b'Z'] => Name::OtherLocation,
            [b'E' | b'X'..=b'Z' | b'A'..=b'C', _, b'A'..=b'C'] => Name::LeftOut("of a rotary axis"),
            [b'P' | b'N', b'0', _] | [b'P' | b'V', b'X' | b'Y' | b'Z', _] => {
                Name::LeftOut("a parameter of the control's kernel")
            }
            _ => return None,
        })
    }
}

/// A parameter as it stands in the file.
struct Parameter {
    name: String,
    place: Place,
    /// Arguments, mm; none for a single value.
    positions_mm: Vec<f64>,
    /// mm or rad.
    values: Vec<f64>,
}

impl Parameter {
    fn problem(&self, message: String, help: &str) -> Problem {
        Problem::new(message).at(self.place.clone()).help(help)
    }
}

/// Parameters → series and squareness.
fn assemble(
    parameters: &[Parameter],
    stated: &Stated,
    mut problems: Problems,
) -> Result<FileContents, Problems> {
    let (Some(sign), true) = (stated.required_sign(&mut problems), problems.is_empty()) else {
        return Err(problems);
    };
    let unit = "positions and deviations in mm, angles in rad (the format's); positions are machine coordinates";
    let mut reading = FileContents::saying([ImportFinding::UnitOfFormat { unit }]);
    for (index, parameter) in parameters.iter().enumerate() {
        if problems.is_full() {
            break; // each is compared with all before it
        }
        refuse_twice(&parameters[..index], parameter, &mut problems);
        if let Err(problem) = take(parameter, sign, &mut reading) {
            problems.push(problem);
        }
    }
    reading.squareness.sort_by_key(|squareness| squareness.pair);
    reading.series.sort_by_key(|series| series.axis);
    if reading.series.is_empty() && problems.is_empty() {
        let message = "the file holds no component error of a linear axis, expected EXX … ECZ";
        let help = "squareness alone makes no table: write it into the job";
        problems.push(Problem::new(message).help(help));
    }
    problems.or_ok(reading)
}

/// Takes a parameter by its name.
fn take(parameter: &Parameter, sign: TableSign, reading: &mut FileContents) -> Result<(), Problem> {
    let name = &parameter.name;
    let is_zero = parameter.values.iter().all(|value| *value == 0.0);
    let what = match Name::of(name) {
        Some(Name::Component(component)) => {
            return add(&mut reading.series, component, parameter, sign);
        }
        Some(Name::Squareness(pair, name, of_phi)) => {
            let rad = single_value(parameter)?;
            let um_per_m = tidy(of_phi * deviation(sign, rad).um() * MICRO);
            reading.squareness.push(Squareness { pair, um_per_m, name });
            return Ok(());
        }
        Some(Name::OtherLocation) if is_zero => "a location that is none of C0Y, B0Z, A0Z",
        Some(Name::OtherLocation) => {
            let message =
                format!("`{name}` is a location that is none of C0Y, B0Z, A0Z, and it is not zero");
            let help = "export with the X axis as primary and the Y axis as secondary axis";
            return Err(parameter.problem(message, help));
        }
        Some(Name::LeftOut(what)) => what,
        None => {
            let message = format!("unknown parameter `{}`", shown(name));
            return Err(parameter.problem(message, "expected EXX … ECZ, or C0Y, B0Z, A0Z"));
        }
    };
    let name = name.clone();
    reading.find([ImportFinding::LeftOut { name, what }]);
    Ok(())
}

/// One quantity may have two names: `C0Y` and `EC0Y`.
fn refuse_twice(before: &[Parameter], parameter: &Parameter, problems: &mut Problems) {
    let is_same = |other: &&Parameter| match Name::of(&parameter.name) {
        Some(name @ (Name::Component(_) | Name::Squareness(..))) => {
            Name::of(&other.name) == Some(name)
        }
        _ => other.name == parameter.name,
    };
    if let Some(twin) = before.iter().find(is_same) {
        let (name, twin) = (shown(&parameter.name), shown(&twin.name));
        let message = format!("`{name}` gives the same as `{twin}` before it");
        problems.push_with(|| parameter.problem(message, "keep one of the two"));
    }
}

/// A squareness is one number, not a curve.
fn single_value(parameter: &Parameter) -> Result<f64, Problem> {
    if let ([value], []) = (&parameter.values[..], &parameter.positions_mm[..]) {
        return Ok(*value);
    }
    let message = format!(
        "`{}` is given at {} positions, expected one value without argument",
        shown(&parameter.name),
        parameter.positions_mm.len()
    );
    let help = "a squareness is one angle between two axes: export it as such";
    Err(parameter.problem(message, help))
}

/// Adds a curve to the series of its axis: at least two points, ascending also after rounding, with a value
/// each, and all curves of an axis at the same positions.
fn add(
    series: &mut Vec<DraftSeries>,
    component: Component,
    parameter: &Parameter,
    sign: TableSign,
) -> Result<(), Problem> {
    let placing = Placing::on_machine(&parameter.positions_mm);
    let positions = placing.positions_mm();
    let ascends = positions.windows(2).all(|pair| pair[0] < pair[1]);
    if positions.len() < 2 || positions.len() != parameter.values.len() || !ascends {
        let name = shown(&parameter.name);
        let message = format!(
            "`{name}` is no curve, expected two or more ascending positions with a value each"
        );
        return Err(parameter.problem(message, AGAIN));
    }
    let along = component.along;
    let known = series.iter().position(|series| series.axis == along);
    let known = known.unwrap_or_else(|| {
        series.push(DraftSeries::new(along, None, positions.clone()));
        series.len() - 1
    });
    let of_axis = &mut series[known];
    let mut pairs = of_axis.positions_mm.iter().zip(&positions);
    if of_axis.positions_mm.len() != positions.len() || pairs.any(|(a, b)| (a - b).abs() >= 1e-6) {
        let message = format!(
            "{component} stands at other positions than the components of {along} before it"
        );
        let help =
            "export all components of an axis on one grid: a value between points is never made up";
        return Err(parameter.problem(message, help));
    }
    let to_ours = match component.kind {
        Kind::Deviation(_) => UM_PER_MM,
        Kind::Angle(_) => MICRO,
    };
    let values = parameter.values.iter().map(|value| value * to_ours);
    placing.put(of_axis, component, sign, &[values.collect()]);
    Ok(())
}

/// Reads the Etalon exchange format.
pub(super) fn read_etalon(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let mut problems = Problems::none();
    let mut blocks = Blocks::default();
    for line in lines(source) {
        let line = line.before("//");
        if !line.is_blank() {
            blocks.take(&line, &mut problems);
        }
    }
    blocks.close(&mut problems);
    assemble(&blocks.done, stated, problems)
}

#[derive(Default)]
struct Blocks {
    done: Vec<Parameter>,
    /// Between `Gridpoints = {` and `}`.
    inside: bool,
    /// Whether the values of the last block have begun.
    begun: bool,
}

impl Blocks {
    fn take(&mut self, line: &Piece<'_>, problems: &mut Problems) {
        let text = line.text.trim();
        let compact: String = text.to_lowercase().split_whitespace().collect();
        let name = text.strip_prefix('[').and_then(|text| text.strip_suffix(']'));
        if let Some(name) = name {
            self.close(problems);
            (self.inside, self.begun) = (false, false);
            self.done.push(Parameter {
                name: name.trim().to_uppercase(),
                place: line.place(),
                positions_mm: Vec::new(),
                values: Vec::new(),
            });
            return;
        }
        let is_grid = compact == "gridpoints={";
        match self.done.last_mut() {
            Some(_) if text == "}" && self.inside => self.inside = false,
            Some(block) if self.inside => {
                let Some(words) = line.row(2, char::is_whitespace, problems) else {
                    return;
                };
                block.positions_mm.extend(words[0].number("an argument", problems));
                block.values.extend(words[1].number("a value", problems));
            }
            Some(block) if is_grid || compact.starts_with("value=") => {
                if self.begun {
                    let name = shown(&block.name);
                    let message = format!(
                        "`{name}` has values already, expected one `VALUE` or one `Gridpoints` a block"
                    );
                    let help = "which of the two is meant is not known: keep one of them";
                    problems.push_with(|| line.problem(message, help));
                }
                (self.inside, self.begun) = (is_grid, true);
                if !is_grid {
                    let at = line.text.find('=').map_or(0, |at| at + 1);
                    let value = line.part(at, line.text.len());
                    block.values.extend(value.number("a value", problems));
                }
            }
            _ => {
                let message = "expected `[NAME]`, `VALUE = …` or `Gridpoints = {`";
                problems.push_with(|| line.problem(message, AGAIN));
            }
        }
    }

    /// The block before must be complete.
    fn close(&self, problems: &mut Problems) {
        let Some(block) = self.done.last() else {
            return;
        };
        let name = &block.name;
        if self.inside {
            let message = format!("the grid of `{name}` is not closed by `}}`");
            problems.push(block.problem(message, AGAIN));
        } else if block.values.is_empty() && problems.is_empty() {
            problems.push(block.problem(format!("`{name}` has no value"), AGAIN));
        }
    }
}

/// Whether a line names arguments and parameters of ISG.
pub(super) fn is_isg_header(line: &str) -> bool {
    let names = || line.split(is_separator).filter(|name| !name.is_empty());
    let is_parameter = |name: &str| Name::of(name).is_some();
    names().any(is_parameter) && names().all(|name| is_argument(name) || is_parameter(name))
}

fn is_argument(name: &str) -> bool {
    matches!(name, "X" | "Y" | "Z" | "A" | "B" | "C")
}

fn is_separator(c: char) -> bool {
    c.is_whitespace() || c == ';'
}

/// Reads ISG volumetric compensation.
pub(super) fn read_isg(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let mut problems = Problems::none();
    let mut parameters = Vec::new();
    let lines: Vec<Piece<'_>> = lines(source).iter().map(|line| line.before("//")).collect();
    for block in lines.split(|line| line.text.trim_start().starts_with('#')) {
        let block: Vec<&Piece<'_>> = block.iter().filter(|line| !line.is_blank()).collect();
        if let Some((header, rows)) = block.split_first() {
            let read = problems.take(read_block(header, rows));
            parameters.extend(read.into_iter().flatten());
        }
    }
    assemble(&parameters, stated, problems)
}

fn read_block(header: &Piece<'_>, rows: &[&Piece<'_>]) -> Result<Vec<Parameter>, Problems> {
    let names = header.words(is_separator);
    if names.iter().any(Piece::begins_with_number) {
        let message = "numbers stand where the names of the columns are expected";
        let help = "each block begins with its arguments and parameters, e.g. `X EXX EYX EZX`";
        return Err(header.problem(message, help).into());
    }
    let arguments = names.iter().take_while(|name| is_argument(name.text)).count();
    if arguments > 1 {
        let message = format!("the block has {arguments} arguments, expected one or none");
        let help =
            "an error table holds curves along one axis; export component errors instead of a map";
        return Err(header.problem(message, help).into());
    }
    let columns = read_columns(header, rows, (arguments, names.len()))?;
    let positions_mm = if arguments == 0 { Vec::new() } else { columns[0].clone() };
    let along =
        names.first().filter(|_| arguments == 1).and_then(|name| Axis::from_letter(name.text));
    let (mut problems, mut parameters) = (Problems::none(), Vec::new());
    for (name, values) in names.iter().zip(columns).skip(arguments) {
        let component = Component::from_name(name.text);
        if let Some(component) = component.filter(|component| Some(component.along) != along) {
            let along = component.along;
            let message = format!(
                "`{component}` is a curve along {along}, but it does not stand under this argument"
            );
            problems.push_with(|| name.problem(message, "each block has its own moving axis"));
        }
        parameters.push(Parameter {
            name: name.text.to_string(),
            place: name.place(),
            positions_mm: positions_mm.clone(),
            values,
        });
    }
    problems.or_ok(parameters)
}

/// The numbers below each name of a block.
fn read_columns(
    header: &Piece<'_>,
    rows: &[&Piece<'_>],
    (arguments, width): (usize, usize),
) -> Result<Vec<Vec<f64>>, Problems> {
    let mut problems = Problems::none();
    let mut columns = vec![Vec::new(); width];
    for row in rows {
        let words = row.row(width, is_separator, &mut problems);
        for (column, word) in columns.iter_mut().zip(words.unwrap_or_default()) {
            column.extend(word.number("a value", &mut problems));
        }
    }
    if rows.is_empty() || (arguments == 0 && rows.len() > 1) {
        let count = rows.len();
        let message = format!(
            "the block has {count} rows, expected one without an argument, else at least two"
        );
        let help = "put a line with `#` between the blocks; the file may be incomplete";
        problems.push(header.problem(message, help));
    }
    problems.or_ok(columns)
}
