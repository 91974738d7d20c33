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
use crate::inputs::error_table::{Component, Kind, Series};
use crate::inputs::import::findings::ImportFinding;
use crate::inputs::import::reading::{FileContents, Placing, Squareness, deviation, tidy};
use crate::inputs::import::stated::Stated;
use crate::inputs::import::words::{AGAIN, Piece, lines, rows};
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
    fn of(name: &Piece<'_>, positions_mm: Vec<f64>, values: Vec<f64>) -> Parameter {
        let place = name.place();
        // A name in brackets may be written small.
        let inside = name.text.strip_prefix('[').and_then(|text| text.strip_suffix(']'));
        let name = inside.map_or(name.text.to_string(), |inside| inside.trim().to_uppercase());
        Parameter { name, place, positions_mm, values }
    }

    fn problem(&self, message: String, help: &str) -> Problem {
        Problem::new(message).at(self.place.clone()).help(help)
    }

    /// Takes it by its name; one quantity may have two names: `C0Y` and `EC0Y`.
    fn take(
        &self,
        before: &[Parameter],
        sign: TableSign,
        reading: &mut FileContents,
    ) -> Result<(), Problem> {
        let name = shown(&self.name);
        let meaning = Name::of(&self.name);
        let is_same = |other: &&Parameter| match meaning {
            Some(Name::Component(_) | Name::Squareness(..)) => Name::of(&other.name) == meaning,
            _ => other.name == self.name,
        };
        if let Some(twin) = before.iter().find(is_same) {
            let message = format!("`{name}` gives the same as `{}` before it", shown(&twin.name));
            return Err(self.problem(message, "keep one of the two"));
        }
        let is_zero = self.values.iter().all(|value| *value == 0.0);
        let what = match meaning {
            Some(Name::Component(component)) => {
                return self.add(component, sign, &mut reading.series);
            }
            Some(Name::Squareness(pair, name, of_phi)) => {
                let um_per_m = tidy(of_phi * deviation(sign, self.single_value()?).um() * MICRO);
                reading.squareness.push(Squareness { pair, um_per_m, name });
                return Ok(());
            }
            Some(Name::OtherLocation) if is_zero => "a location that is none of C0Y, B0Z, A0Z",
            Some(Name::OtherLocation) => {
                let message = format!(
                    "`{name}` is a location that is none of C0Y, B0Z, A0Z, and it is not zero"
                );
                let help = "export with the X axis as primary and the Y axis as secondary axis";
                return Err(self.problem(message, help));
            }
            Some(Name::LeftOut(what)) => what,
            None => {
                let message = format!("unknown parameter `{name}`");
                return Err(self.problem(message, "expected EXX … ECZ, or C0Y, B0Z, A0Z"));
            }
        };
        reading.find([ImportFinding::LeftOut { name: self.name.clone(), what }]);
        Ok(())
    }

    /// A squareness is one number, not a curve.
    fn single_value(&self) -> Result<f64, Problem> {
        if let ([value], []) = (&self.values[..], &self.positions_mm[..]) {
            return Ok(*value);
        }
        let message = format!(
            "`{}` has {} values, expected one without argument",
            shown(&self.name),
            self.values.len()
        );
        Err(self.problem(message, "a squareness is one angle between two axes: export it as such"))
    }

    /// Adds a curve to the series of its axis: at least two points, ascending also after rounding, with a value
    /// each, and all curves of an axis at the same positions.
    fn add(
        &self,
        component: Component,
        sign: TableSign,
        series: &mut Vec<Series>,
    ) -> Result<(), Problem> {
        let placing = Placing::on_machine(&self.positions_mm);
        let positions = placing.positions();
        let ascends = positions.windows(2).all(|pair| pair[0] < pair[1]);
        if positions.len() < 2 || positions.len() != self.values.len() || !ascends {
            let message = format!(
                "`{}` is no curve, expected two or more ascending positions with a value each",
                shown(&self.name)
            );
            return Err(self.problem(message, AGAIN));
        }
        let along = component.along;
        let known = series.iter().position(|series| series.axis == along);
        let known = known.unwrap_or_else(|| {
            series.push(Series::new(along, None, positions.clone()));
            series.len() - 1
        });
        let of_axis = &mut series[known];
        let mut pairs = of_axis.positions.iter().zip(&positions);
        if of_axis.positions.len() != positions.len()
            || pairs.any(|(a, b)| (a.mm() - b.mm()).abs() >= 1e-6)
        {
            let message = format!(
                "{component} stands at other positions than the components of {along} before it"
            );
            let help = "export all components of an axis on one grid: a value between points is never made up";
            return Err(self.problem(message, help));
        }
        let to_ours = match component.kind {
            Kind::Deviation(_) => UM_PER_MM,
            Kind::Angle(_) => MICRO,
        };
        let values = self.values.iter().map(|value| value * to_ours).collect();
        placing.put(of_axis, component, sign, &[values]);
        Ok(())
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
        problems.take(parameter.take(&parameters[..index], sign, &mut reading));
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

/// Reads the Etalon exchange format.
pub(super) fn read_etalon(source: &Source, stated: &Stated) -> Result<FileContents, Problems> {
    let mut problems = Problems::none();
    let mut blocks: Vec<Parameter> = Vec::new();
    let mut is_grid = false; // between `Gridpoints = {` and `}`
    for line in lines(source).iter().map(|line| line.before("//")).filter(|line| !line.is_blank()) {
        let compact: String = line.text.to_lowercase().split_whitespace().collect();
        if compact.starts_with('[') && compact.ends_with(']') {
            problems.extend(unfinished(blocks.last(), is_grid, problems.is_empty()));
            is_grid = false;
            blocks.push(Parameter::of(&line.part(0, line.text.len()), Vec::new(), Vec::new()));
            continue;
        }
        let value = line.text.find('=').map(|at| line.part(at + 1, line.text.len()));
        if let Some(block) = blocks.last().filter(|block| !block.values.is_empty())
            && !is_grid
            && value.is_some()
        {
            let message = format!(
                "`{}` has values already, expected one `VALUE` or one `Gridpoints` a block",
                block.name
            );
            problems.push_with(|| {
                line.problem(message, "which of the two is meant is not known: keep one of them")
            });
        }
        match (blocks.last_mut(), value) {
            (Some(_), _) if is_grid && compact == "}" => is_grid = false,
            (Some(block), _) if is_grid => {
                if let Some(words) = line.row(2, char::is_whitespace, &mut problems) {
                    block.positions_mm.extend(words[0].number("an argument", &mut problems));
                    block.values.extend(words[1].number("a value", &mut problems));
                }
            }
            (Some(_), _) if compact == "gridpoints={" => is_grid = true,
            (Some(block), Some(value)) if compact.starts_with("value=") => {
                block.values.extend(value.number("a value", &mut problems));
            }
            _ => {
                let message = "expected `[NAME]`, `VALUE = …` or `Gridpoints = {`";
                problems.push_with(|| line.problem(message, AGAIN));
            }
        }
    }
    problems.extend(unfinished(blocks.last(), is_grid, problems.is_empty()));
    assemble(&blocks, stated, problems)
}

/// What a block lacks that has ended.
fn unfinished(block: Option<&Parameter>, is_grid: bool, is_whole: bool) -> Problems {
    let mut problems = Problems::none();
    match block {
        Some(block) if is_grid => {
            let message = format!("the grid of `{}` is not closed by `}}`", block.name);
            problems.push(block.problem(message, AGAIN));
        }
        Some(block) if block.values.is_empty() && is_whole => {
            problems.push(block.problem(format!("`{}` has no value", block.name), AGAIN));
        }
        _ => {}
    }
    problems
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
        if let Some((header, lines)) = block.split_first() {
            let read = problems.take(read_block(header, lines));
            parameters.extend(read.into_iter().flatten());
        }
    }
    assemble(&parameters, stated, problems)
}

/// The parameters of a block: the names of its columns, the first one that of the argument, and rows of numbers.
fn read_block(header: &Piece<'_>, lines: &[&Piece<'_>]) -> Result<Vec<Parameter>, Problems> {
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
    let rows = rows(lines.iter().copied(), names.len(), is_separator)?;
    let mut problems = Problems::none();
    if rows.is_empty() || (arguments == 0 && rows.len() > 1) {
        let message = format!(
            "the block has {} rows, expected one without an argument, else at least two",
            rows.len()
        );
        let help = "put a line with `#` between the blocks; the file may be incomplete";
        problems.push(header.problem(message, help));
    }
    let column = |index: usize| rows.iter().map(|row| row.numbers[index]).collect::<Vec<f64>>();
    let along = names[..arguments].first().and_then(|name| Axis::from_letter(name.text));
    for name in &names[arguments..] {
        let component = Component::from_name(name.text);
        if let Some(component) = component.filter(|component| Some(component.along) != along) {
            let along = component.along;
            let message = format!(
                "`{component}` is a curve along {along}, but it does not stand under this argument"
            );
            problems.push_with(|| name.problem(message, "each block has its own moving axis"));
        }
    }
    let positions = || if arguments == 0 { Vec::new() } else { column(0) };
    let parameters = names.iter().enumerate().skip(arguments);
    let parameters =
        parameters.map(|(index, name)| Parameter::of(name, positions(), column(index)));
    problems.or_ok(parameters.collect())
}
