//! `ETALON_EXCHANGE`: a section for each parameter, `[EXY]` with `Gridpoints = {`, rows and `}`, or `[C0Y]` with
//! `VALUE = …`; `//` begins a comment.

use super::line::{number, without_comment};
use crate::control::table::isg::{Curve, Parameter, Point};
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, lines, located, words};
use crate::text::problem::{Problems, shown};
use std::ops::Range;

/// The parameters of a file.
pub(super) fn curves(file: &str, text: &str) -> Result<Vec<Curve>, Problems> {
    let mut reading = Reading::default();
    let mut complaints: Vec<Complaint> = Vec::new();
    for line in lines(text) {
        let line = without_comment(text, line);
        let start = line.start + (text[line.clone()].len() - text[line.clone()].trim_start().len());
        let span = start..start + text[line].trim().len();
        if span.is_empty() {
            continue;
        }
        let taken = reading.take(text, span.clone());
        complaints.extend(taken.err().map(|expected| wrong(text, span, &expected)));
        if complaints.len() >= MOST_COMPLAINTS {
            break;
        }
    }
    if reading.is_open {
        let end = text.len();
        complaints.push(wrong(text, end..end, "a `}` behind the last point"));
    }
    let empty = reading.curves.iter().find(|curve| curve.points.is_empty());
    if let (Some(curve), false) = (empty, reading.is_open) {
        let message = format!("values of {}", curve.parameter);
        complaints.push(wrong(text, 0..0, &message));
    }
    match complaints.is_empty() {
        true => Ok(reading.curves),
        false => Err(located(file, text, complaints)),
    }
}

fn wrong(text: &str, span: Range<usize>, expected: &str) -> Complaint {
    let message = match &text[span.clone()] {
        "" => format!("expected {expected}"),
        found => format!("`{}`, expected {expected}", shown(found)),
    };
    Complaint::new(span, message, "a file of the exchange format, variant Vendor")
}

/// What was read so far.
#[derive(Default)]
struct Reading {
    curves: Vec<Curve>,
    /// Whether a section was begun.
    has_section: bool,
    /// Between `{` and `}`.
    is_open: bool,
}

impl Reading {
    /// Takes a line; `Err` = what was expected.
    fn take(&mut self, text: &str, span: Range<usize>) -> Result<(), String> {
        let line = &text[span.clone()];
        if self.is_open {
            return match line {
                "}" => {
                    self.is_open = false;
                    Ok(())
                }
                _ => self.point(text, span),
            };
        }
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            return self.begin(name);
        }
        let (key, value) = line.split_once('=').map_or((line, ""), |(a, b)| (a.trim(), b.trim()));
        let is_value = key.eq_ignore_ascii_case("value");
        let is_grid = key.eq_ignore_ascii_case("gridpoints") && value == "{";
        match self.curves.last_mut() {
            Some(curve) if curve.points.is_empty() && is_value => constant(curve, value),
            Some(curve) if curve.points.is_empty() && is_grid => {
                self.is_open = curve.parameter.along().is_some();
                self.is_open.then_some(()).ok_or("`VALUE = …` of a constant".to_string())
            }
            _ => Err("`[parameter]`, then `VALUE = …` or `Gridpoints = {`, once each".to_string()),
        }
    }

    fn begin(&mut self, name: &str) -> Result<(), String> {
        if self.has_section && self.curves.last().is_some_and(|curve| curve.points.is_empty()) {
            return Err("values of the parameter before".to_string());
        }
        let upper = name.to_ascii_uppercase();
        let parameter = Parameter::all().find(|own| own.to_string() == upper);
        let expected = "a parameter that is emulated: EXX to EZZ, EAX to ECZ, A0X to C0Z";
        let parameter = parameter.ok_or(expected)?;
        if self.curves.iter().any(|curve| curve.parameter == parameter) {
            return Err("each parameter once".to_string());
        }
        self.has_section = true;
        let points = Vec::new();
        self.curves.push(Curve { parameter, points });
        Ok(())
    }

    fn point(&mut self, text: &str, span: Range<usize>) -> Result<(), String> {
        let expected = || "position in mm and value, or `}`".to_string();
        let words = words(text, span);
        let [(position, _), (value, _)] = words[..] else {
            return Err(expected());
        };
        let (position, value) = number(position).zip(number(value)).ok_or_else(expected)?;
        let Some(curve) = self.curves.last_mut() else {
            return Err(expected());
        };
        if curve.points.last().is_some_and(|last| position <= last.position) {
            return Err("positions that ascend, each once".to_string());
        }
        curve.points.push(Point { position, value });
        Ok(())
    }
}

fn constant(curve: &mut Curve, value: &str) -> Result<(), String> {
    let value = number(value).filter(|_| curve.parameter.along().is_none());
    let value = value.ok_or("`Gridpoints = {`, or a number of a constant")?;
    let position = 0.0;
    curve.points.push(Point { position, value });
    Ok(())
}
