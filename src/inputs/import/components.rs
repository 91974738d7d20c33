//! Component errors and squareness with the names of ISO 230-1, as Etalon and ISG files give them.
//!
//! Deviations in mm, angles and squareness in rad, arguments in mm: machine coordinates.

use crate::inputs::error_table::DraftSeries;
use crate::inputs::import::choices::Sign;
use crate::inputs::import::placing::tidy;
use crate::inputs::import::{Component, Kind, Reading, Squareness};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::units::UM_PER_MM;
use crate::text::problem::{Place, Problem, Problems, shown};

/// Micrometres per metre, or microradians, in one radian.
const MICRO: f64 = 1e6;

/// What a parameter name stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Name {
    /// EXX … ECZ.
    Component(Component),
    /// C0Y, B0Z, A0Z: the pair, and the sign of φ in it.
    Squareness(&'static str, &'static str, f64),
    /// Something that an error table of three linear axes does not hold.
    Other(&'static str),
}

impl Name {
    /// Of a name in capital letters, with or without `E` before a location.
    pub(super) fn of(name: &str) -> Option<Name> {
        if let Some(component) = Component::from_name(name) {
            return Some(Name::Component(component));
        }
        let location = match name.len() {
            4 => name.strip_prefix('E')?,
            _ => name,
        };
        // ISO 230-1: EC0Y = −φxy, EB0Z = +φxz, EA0Z = −φyz (contract §1).
        match location.as_bytes() {
            b"C0Y" => Some(Name::Squareness("xy", "C0Y", -1.0)),
            b"B0Z" => Some(Name::Squareness("xz", "B0Z", 1.0)),
            b"A0Z" => Some(Name::Squareness("yz", "A0Z", -1.0)),
            [b'X' | b'Y' | b'Z', b'0', b'X' | b'Y' | b'Z'] => {
                Some(Name::Other("a constant, which is zeroed at the reference"))
            }
            [b'A' | b'B' | b'C', b'0', b'X' | b'Y' | b'Z'] => {
                Some(Name::Other("a location that is none of C0Y, B0Z, A0Z"))
            }
            [
                b'E' | b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C',
                _,
                b'A' | b'B' | b'C',
            ] => Some(Name::Other("of a rotary axis")),
            [b'P' | b'N', b'0', _] | [b'P' | b'V', b'X' | b'Y' | b'Z', _] => {
                Some(Name::Other("a parameter of the control's kernel"))
            }
            _ => None,
        }
    }

    /// Whether a text is the name of a parameter.
    pub(super) fn is_one(text: &str) -> bool {
        Name::of(text).is_some()
    }
}

/// A parameter as it stands in the file.
pub(super) struct Parameter {
    pub(super) name: String,
    pub(super) place: Place,
    /// Arguments, mm; none for a single value.
    pub(super) positions_mm: Vec<f64>,
    /// mm or rad.
    pub(super) values: Vec<f64>,
}

/// Parameters → series and squareness.
pub(super) fn assemble(parameters: &[Parameter], sign: Sign) -> Result<Reading, Problems> {
    let mut problems = Problems::none();
    let mut reading = Reading {
        facts: vec![
            "unit: positions and deviations in mm, angles in rad (the format's); positions are machine coordinates".to_string(),
        ],
        ..Reading::default()
    };
    let mut series: PerAxis<Option<DraftSeries>> = PerAxis::default();
    for (index, parameter) in parameters.iter().enumerate() {
        if problems.is_full() {
            break; // each is compared with all before it
        }
        refuse_twice(&parameters[..index], parameter, &mut problems);
        match Name::of(&parameter.name) {
            Some(Name::Component(component)) => {
                add(&mut series, component, parameter, sign, &mut problems);
            }
            Some(Name::Squareness(pair, name, of_phi)) => {
                let angle = single_value(parameter, &mut problems);
                reading.squareness.extend(angle.map(|rad| Squareness {
                    pair,
                    um_per_m: tidy(of_phi * sign.deviation(rad) * MICRO),
                    name,
                }));
            }
            Some(Name::Other(what)) => leave_out(parameter, what, &mut reading, &mut problems),
            None => problems.push_with(|| unknown(parameter)),
        }
    }
    reading.squareness.sort_by_key(|squareness| squareness.pair);
    reading.series = [series.x, series.y, series.z]
        .into_iter()
        .flatten()
        .collect();
    if reading.series.is_empty() && problems.is_empty() {
        problems.push(
            Problem::new("the file holds no component error of a linear axis, expected EXX … ECZ")
                .help("squareness alone makes no table: write it into the job"),
        );
    }
    problems.or_ok(reading)
}

/// One quantity may have two names: `C0Y` and `EC0Y`.
fn refuse_twice(before: &[Parameter], parameter: &Parameter, problems: &mut Problems) {
    let is_same = |other: &&Parameter| match (Name::of(&other.name), Name::of(&parameter.name)) {
        (Some(Name::Other(_)), _) | (None, _) => other.name == parameter.name,
        (other, this) => other == this,
    };
    if let Some(twin) = before.iter().find(is_same) {
        problems.push_with(|| {
            let name = shown(&parameter.name);
            let message = if twin.name == parameter.name {
                format!("`{name}` stands twice")
            } else {
                format!(
                    "`{name}` gives the same as `{}` before it",
                    shown(&twin.name)
                )
            };
            Problem::new(message)
                .at(parameter.place.clone())
                .help("keep one of the two")
        });
    }
}

/// A squareness is one number, not a curve.
fn single_value(parameter: &Parameter, problems: &mut Problems) -> Option<f64> {
    if let ([value], []) = (&parameter.values[..], &parameter.positions_mm[..]) {
        return Some(*value);
    }
    problems.push_with(|| {
        Problem::new(format!(
            "`{}` is given at {} positions, expected one value without argument",
            shown(&parameter.name),
            parameter.positions_mm.len()
        ))
        .at(parameter.place.clone())
        .help("a squareness is one angle between two axes: export it as such")
    });
    None
}

fn unknown(parameter: &Parameter) -> Problem {
    Problem::new(format!("unknown parameter `{}`", shown(&parameter.name)))
        .at(parameter.place.clone())
        .help("expected EXX … ECZ, or C0Y, B0Z, A0Z")
}

/// A parameter that our table cannot hold: said, unless it would change the squareness.
fn leave_out(parameter: &Parameter, what: &str, reading: &mut Reading, problems: &mut Problems) {
    let is_zero = parameter.values.iter().all(|value| *value == 0.0);
    if what.starts_with("a location") && !is_zero {
        problems.push(
            Problem::new(format!(
                "`{}` is {what}, and it is not zero",
                parameter.name
            ))
            .at(parameter.place.clone())
            .help("export with the X axis as primary and the Y axis as secondary axis"),
        );
        return;
    }
    let name = &parameter.name;
    reading.facts.push(format!("left out: {name} ({what})"));
}

fn add(
    series: &mut PerAxis<Option<DraftSeries>>,
    component: Component,
    parameter: &Parameter,
    sign: Sign,
    problems: &mut Problems,
) {
    if !is_curve(parameter, problems) {
        return;
    }
    let positions = &parameter.positions_mm;
    let of_axis = series[component.along].get_or_insert_with(|| {
        DraftSeries::new(
            component.along,
            None,
            positions.iter().map(|mm| tidy(*mm)).collect(),
        )
    });
    let same = of_axis.positions_mm.len() == positions.len()
        && of_axis
            .positions_mm
            .iter()
            .zip(positions)
            .all(|(a, b)| (a - b).abs() < 1e-6);
    if !same {
        problems.push(
            Problem::new(format!(
                "{component} stands at other positions than the components of {} before it",
                Axis::letter(component.along)
            ))
            .at(parameter.place.clone())
            .help("export all components of an axis on one grid: a value between points is never made up"),
        );
        return;
    }
    let to_ours = match component.kind {
        Kind::Deviation(_) => UM_PER_MM,
        Kind::Angle(_) => MICRO,
    };
    let values = parameter
        .values
        .iter()
        .map(|value| tidy(sign.deviation(*value) * to_ours));
    component.put(of_axis, values.collect());
}

/// At least two points, ascending also after rounding, with a value each.
fn is_curve(parameter: &Parameter, problems: &mut Problems) -> bool {
    let positions = &parameter.positions_mm;
    let what = if positions.len() < 2 {
        "has fewer than two points"
    } else if positions.len() != parameter.values.len() {
        "has positions without a value"
    } else if positions
        .windows(2)
        .any(|pair| tidy(pair[1]) <= tidy(pair[0]))
    {
        "has positions that do not ascend"
    } else {
        return true;
    };
    problems.push_with(|| {
        Problem::new(format!(
            "`{}` {what}, expected ascending positions of a curve",
            parameter.name
        ))
        .at(parameter.place.clone())
        .help("the file is incomplete or damaged: export it again")
    });
    false
}
