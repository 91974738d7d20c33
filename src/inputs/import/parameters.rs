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
use crate::inputs::findings::ImportFinding;
use crate::inputs::import::intake::{Contents, Intake, Piece, Squareness};
use crate::inputs::import::reading::{Placing, deviation, tidy};
use crate::inputs::refusals;
use crate::quantity::{Axis, UM_PER_MM};
use crate::text::shown;

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
struct Parameter<'a> {
    piece: Piece<'a>,
    name: String,
    /// Arguments, mm; none for a single value.
    positions_mm: Vec<f64>,
    /// mm or rad.
    values: Vec<f64>,
}

impl<'a> Parameter<'a> {
    fn of(piece: Piece<'a>, positions_mm: Vec<f64>, values: Vec<f64>) -> Parameter<'a> {
        // A name in brackets may be written small.
        let inside = piece.text.strip_prefix('[').and_then(|text| text.strip_suffix(']'));
        let name = inside.map_or(piece.text.to_string(), |inside| inside.trim().to_uppercase());
        Parameter { piece, name, positions_mm, values }
    }

    /// Takes it by its name; one quantity may have two names: `C0Y` and `EC0Y`.
    fn take(&self, before: &[Parameter<'_>], sign: TableSign, found: &mut Contents) -> Option<()> {
        let (name, meaning) = (shown(&self.name), Name::of(&self.name));
        let is_same = |other: &&Parameter<'_>| match meaning {
            Some(Name::Component(_) | Name::Squareness(..)) => Name::of(&other.name) == meaning,
            _ => other.name == self.name,
        };
        if let Some(twin) = before.iter().find(is_same) {
            return self.piece.refused(refusals::same_parameter(name, shown(&twin.name)));
        }
        let is_zero = self.values.iter().all(|value| *value == 0.0);
        let what = match meaning {
            Some(Name::Component(component)) => return self.add(component, sign, &mut found.0),
            Some(Name::Squareness(pair, name, of_phi)) => {
                let um_per_m = tidy(of_phi * deviation(sign, self.single_value()?).um() * MICRO);
                found.1.push(Squareness { pair, um_per_m, name });
                return Some(());
            }
            Some(Name::OtherLocation) if is_zero => "a location that is none of C0Y, B0Z, A0Z",
            Some(Name::OtherLocation) => return self.piece.refused(refusals::other_location(name)),
            Some(Name::LeftOut(what)) => what,
            None => return self.piece.refused(refusals::unknown_parameter(name)),
        };
        self.piece.intake.say([ImportFinding::LeftOut { name: self.name.clone(), what }]);
        Some(())
    }

    /// A squareness is one number, not a curve.
    fn single_value(&self) -> Option<f64> {
        if let ([value], []) = (&self.values[..], &self.positions_mm[..]) {
            return Some(*value);
        }
        self.piece.refused(refusals::no_single_value(shown(&self.name), self.values.len()))
    }

    /// Adds a curve to the series of its axis: at least two points, ascending also after rounding, with a value
    /// each, and all curves of an axis at the same positions.
    fn add(&self, component: Component, sign: TableSign, series: &mut Vec<Series>) -> Option<()> {
        let placing = Placing::on_machine(&self.positions_mm);
        let positions = &placing.positions;
        let ascends = positions.is_sorted_by(|a, b| a < b);
        if positions.len() < 2 || positions.len() != self.values.len() || !ascends {
            return self.piece.refused(refusals::no_curve(shown(&self.name)));
        }
        let along = component.along;
        let known = series.iter().position(|series| series.axis == along).unwrap_or_else(|| {
            series.push(Series::new(along, None, positions.clone()));
            series.len() - 1
        });
        let of_axis = &mut series[known];
        let mut pairs = of_axis.positions.iter().zip(positions);
        if of_axis.positions.len() != positions.len()
            || pairs.any(|(a, b)| (a.mm() - b.mm()).abs() >= 1e-6)
        {
            return self.piece.refused(refusals::other_grid(component, along));
        }
        let to_ours = match component.kind {
            Kind::Deviation(_) => UM_PER_MM,
            Kind::Angle(_) => MICRO,
        };
        let values = self.values.iter().map(|value| value * to_ours).collect();
        placing.put(of_axis, component, sign, &[values]);
        Some(())
    }
}

/// Parameters → series and squareness.
fn assemble(parameters: &[Parameter<'_>], intake: &Intake<'_>) -> Option<Contents> {
    let sign = intake.if_sound(intake.sign(None))??;
    let unit = "positions and deviations in mm, angles in rad (the format's); positions are machine coordinates";
    intake.say([ImportFinding::UnitOfFormat { unit }]);
    let mut found = Contents::default();
    for (index, parameter) in parameters.iter().enumerate() {
        if intake.notes.is_full() {
            break; // each is compared with all before it
        }
        parameter.take(&parameters[..index], sign, &mut found);
    }
    found.1.sort_by_key(|squareness| squareness.pair);
    found.0.sort_by_key(|series| series.axis);
    if found.0.is_empty() && intake.notes.is_sound() {
        intake.notes.refuse(refusals::no_component());
    }
    Some(found)
}

/// Reads the Etalon exchange format.
pub(super) fn read_etalon<'a>(intake: &'a Intake<'a>) -> Option<Contents> {
    let mut blocks: Vec<Parameter<'a>> = Vec::new();
    let mut is_grid = false; // between `Gridpoints = {` and `}`
    let lines = intake.lines();
    for line in lines.iter().map(|line| line.before("//")).filter(|line| !line.is_blank()) {
        let compact: String = line.text.to_lowercase().split_whitespace().collect();
        if compact.starts_with('[') && compact.ends_with(']') {
            refuse_unfinished(blocks.last(), is_grid, intake);
            is_grid = false;
            blocks.push(Parameter::of(line.part(0, line.text.len()), Vec::new(), Vec::new()));
            continue;
        }
        let value = line.behind('=');
        if let Some(block) = blocks.last().filter(|block| !block.values.is_empty())
            && !is_grid
            && value.is_some()
        {
            line.refuse(refusals::two_values(&block.name));
        }
        match (blocks.last_mut(), value) {
            (Some(_), _) if is_grid && compact == "}" => is_grid = false,
            (Some(block), _) if is_grid => {
                if let Some(words) = line.row(2, char::is_whitespace) {
                    block.positions_mm.extend(words[0].number("an argument"));
                    block.values.extend(words[1].number("a value"));
                }
            }
            (Some(_), _) if compact == "gridpoints={" => is_grid = true,
            (Some(block), Some(value)) if compact.starts_with("value=") => {
                block.values.extend(value.number("a value"));
            }
            _ => line.refuse(refusals::no_block()),
        }
    }
    refuse_unfinished(blocks.last(), is_grid, intake);
    assemble(&blocks, intake)
}

/// What a block lacks that has ended.
fn refuse_unfinished(block: Option<&Parameter<'_>>, is_grid: bool, intake: &Intake<'_>) {
    match block {
        Some(block) if is_grid => block.piece.refuse(refusals::open_grid(&block.name)),
        Some(block) if block.values.is_empty() && intake.notes.is_sound() => {
            block.piece.refuse(refusals::no_value(&block.name));
        }
        _ => {}
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
pub(super) fn read_isg<'a>(intake: &'a Intake<'a>) -> Option<Contents> {
    let lines: Vec<Piece<'_>> = intake.lines().iter().map(|line| line.before("//")).collect();
    let blocks = lines.split(|line| line.text.trim_start().starts_with('#')).map(|block| {
        let block: Vec<Piece<'_>> = block.iter().filter(|line| !line.is_blank()).copied().collect();
        let (header, lines) = block.split_first()?;
        read_block(header, lines)
    });
    assemble(&blocks.flatten().flatten().collect::<Vec<_>>(), intake)
}

/// The parameters of a block: the names of its columns, the first one that of the argument, and rows of numbers.
fn read_block<'a>(header: &Piece<'a>, lines: &[Piece<'a>]) -> Option<Vec<Parameter<'a>>> {
    let names = header.words(is_separator);
    if names.iter().any(Piece::begins_with_number) {
        return header.refused(refusals::no_names());
    }
    let arguments = names.iter().take_while(|name| is_argument(name.text)).count();
    if arguments > 1 {
        return header.refused(refusals::many_arguments(arguments));
    }
    let columns = header.intake.numbers(lines, names.len(), is_separator)?;
    if lines.is_empty() || (arguments == 0 && lines.len() > 1) {
        header.refuse(refusals::other_block(lines.len()));
    }
    let (argument, parameters) = names.split_at(arguments);
    let along = argument.first().and_then(|name| Axis::from_letter(name.text));
    for name in parameters {
        let component = Component::from_name(name.text);
        if let Some(component) = component.filter(|component| Some(component.along) != along) {
            name.refuse(refusals::other_argument(component, component.along));
        }
    }
    let positions = columns.iter().take(arguments).flatten().copied().collect::<Vec<f64>>();
    let parameters = parameters.iter().zip(&columns[arguments..]);
    Some(
        parameters
            .map(|(name, own)| Parameter::of(*name, positions.clone(), own.clone()))
            .collect(),
    )
}
