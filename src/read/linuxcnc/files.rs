//! What LinuxCNC reads beside the tables of joints: the ini file of a machine, or lines of it, and the HAL file of a kit.
//!
//! Of two sections of one name LinuxCNC reads the first only, and of two settings of one name the first; a
//! value goes to the end of its line. `#` and `;` begin a comment where a line begins.

use crate::control::controller::{Columns, ControlUnit, LinuxcncFacts, MOST_JOINTS};
use crate::control::table::{ListedTable, Point};
use crate::quantity::rounded;
use crate::read::lexer::{Complaint, Words, complaints, lines, located, number, words};
use crate::read::refusals;
use crate::text::{Problems, shown};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// What an ini says of a joint; lengths in the machine unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Joint {
    /// The file of its table.
    pub(crate) comp_file: Option<String>,
    /// What the columns of that file hold; not stated is type 0.
    pub(crate) columns: Option<Columns>,
    /// Without effect beside a table; not stated is 0.
    pub(crate) backlash: Option<f64>,
    /// Where homing sets the position; not stated is 0.
    pub(crate) home_offset: Option<f64>,
    /// Speed of the move in which homing sets the position; not stated or 0: it is set without a move.
    pub(crate) home_latch: Option<f64>,
}

/// What one text says.
#[derive(Default)]
pub(super) struct Ini {
    pub(super) joints: BTreeMap<u32, Joint>,
    pub(super) unit: Option<ControlUnit>,
}

/// One line `KEY = value` of a section.
struct Setting<'a> {
    section: &'a str,
    key: &'a str,
    value: &'a str,
    /// Of the line.
    span: Range<usize>,
}

/// Whether a text is an ini: one of its lines begins a section.
pub(super) fn is_ini(text: &str) -> bool {
    sections(text).next().is_some()
}

/// The sections of a text.
pub(super) fn sections(text: &str) -> impl Iterator<Item = &str> {
    lines(text).filter_map(|line| section(&text[line]))
}

fn section(line: &str) -> Option<&str> {
    let (name, _) = line.trim().strip_prefix('[')?.split_once(']')?;
    Some(name)
}

const OF_JOINT: [&str; 5] =
    ["COMP_FILE", "COMP_FILE_TYPE", "BACKLASH", "HOME_OFFSET", "HOME_LATCH_VEL"];

fn is_read(setting: &Setting<'_>) -> bool {
    let of_joint = setting.section.starts_with("JOINT_") && OF_JOINT.contains(&setting.key);
    of_joint || (setting.section, setting.key) == ("TRAJ", "LINEAR_UNITS")
}

fn setting<'a>(section: &'a str, line: &'a str, span: Range<usize>) -> Option<Setting<'a>> {
    if line.starts_with(['#', ';']) {
        return None;
    }
    let (key, value) = line.split_once('=')?;
    Some(Setting { section, key: key.trim_end(), value: value.trim_start(), span })
}

impl Ini {
    /// Reads the settings of concern that LinuxCNC reads of a text.
    pub(super) fn read(file: &str, text: &str) -> Result<Ini, Problems> {
        let mut ini = Ini::default();
        let (mut begun, mut known) = (BTreeSet::new(), BTreeSet::new());
        let (mut within, mut is_second) = ("", false);
        let complaints = complaints(lines(text), |span| {
            let line = text[span.clone()].trim();
            if let Some(name) = section(line) {
                (within, is_second) = (name, !begun.insert(name));
                return Ok(());
            }
            if line.starts_with("#INCLUDE") {
                return Err(Complaint::new(span, refusals::includes()));
            }
            match setting(within, line, span).filter(is_read) {
                Some(setting) if is_second => {
                    Err(Complaint::new(setting.span, refusals::second_section(shown(within))))
                }
                Some(setting) if known.insert((within, setting.key)) => {
                    ini.take(&setting).map_err(|expected| wrong(&setting, expected))
                }
                _ => Ok(()),
            }
        });
        located(file, text, complaints).or_ok(ini)
    }

    /// Takes a setting; `Err` = what was expected.
    fn take(&mut self, setting: &Setting<'_>) -> Result<(), &'static str> {
        let Some(number) = setting.section.strip_prefix("JOINT_") else {
            self.unit = Some(unit(setting.value)?);
            return Ok(());
        };
        let number = number.parse().ok().filter(|number| *number < MOST_JOINTS);
        let number = number.ok_or("a joint from [JOINT_0] to [JOINT_15]")?;
        let joint = self.joints.entry(number).or_default();
        match setting.key {
            "COMP_FILE" => joint.comp_file = Some(setting.value.to_string()),
            "COMP_FILE_TYPE" => joint.columns = Some(columns(setting.value)?),
            "BACKLASH" => joint.backlash = Some(length(setting.value)?),
            "HOME_LATCH_VEL" => joint.home_latch = Some(length(setting.value)?),
            _ => joint.home_offset = Some(length(setting.value)?),
        }
        Ok(())
    }
}

fn columns(value: &str) -> Result<Columns, &'static str> {
    match value {
        "0" => Ok(Columns::Reached),
        "1" => Ok(Columns::Trims),
        _ => Err("0 (positions reached) or 1 (values to add) and nothing else"),
    }
}

/// No joint is longer and none is faster, in mm or inch, in a second.
const LONGEST: f64 = 1e6;

fn length(value: &str) -> Result<f64, &'static str> {
    let number = value.parse().ok();
    let number = number.filter(|number: &f64| number.abs() <= LONGEST);
    number.ok_or("a number in the machine unit and nothing else")
}

fn unit(value: &str) -> Result<ControlUnit, &'static str> {
    match value {
        "mm" | "metric" => Ok(ControlUnit::Millimetre),
        "in" | "inch" | "imperial" => Ok(ControlUnit::Inch),
        _ => Err("mm or inch"),
    }
}

fn wrong(setting: &Setting<'_>, expected: &str) -> Complaint {
    let [section, key, value] = [setting.section, setting.key, setting.value].map(shown);
    Complaint::new(setting.span.clone(), refusals::ini_value(key, section, value, expected))
}

// The HAL file of a kit, which corrects joints by the positions of others, in the form of docs/linuxcnc.md §3.
//
// ```text
//   net … lincurve.N.in, lincurve.N.out ──→ base and output of each curve ──→ all lines, in their order
//   setp lincurve.N.x-val-…, y-val-…    ──→ its points
// ```
// A line that differs is refused, because it could add something: LinuxCNC itself has executed this form alone.

/// Stands for a number in a line of the form.
const NUMBER: &str = "NUMBER";

/// The tables of a file, ascending by output and base.
///
/// **limits** names the first line that is wrong: those behind it would only repeat it
pub(super) fn tables(
    file: &str,
    text: &str,
    facts: &LinuxcncFacts,
) -> Result<Vec<ListedTable>, Problems> {
    read(text, facts).map_err(|complaint| located(file, text, vec![complaint]))
}

/// Whether a text is a HAL file: one of its lines is a statement of one.
pub(super) fn is_hal(text: &str) -> bool {
    statements(text).any(|words| ["loadrt", "addf", "net", "setp"].contains(&words[0].0))
}

/// The words of each line that is neither blank nor a comment: at least one.
fn statements(text: &str) -> impl Iterator<Item = Words<'_>> {
    let is_statement =
        |words: &Words<'_>| words.first().is_some_and(|(first, _)| !first.starts_with('#'));
    lines(text).map(|line| words(text, line)).filter(is_statement)
}

/// The words of one line.
type HalLine<'a> = [(&'a str, Range<usize>)];

/// A curve: the joint that it looks up, the one that it corrects, and how many points it has.
struct HalCurve {
    base: u32,
    output: u32,
    points: usize,
}

fn read(text: &str, facts: &LinuxcncFacts) -> Result<Vec<ListedTable>, Complaint> {
    let lines: Vec<Words<'_>> = statements(text).collect();
    let curves = curves(&lines, facts)?;
    let mut numbers = numbers(text, &lines[1..], &form(&curves))?.into_iter();
    let mut tables: BTreeMap<(u32, u32), Vec<Vec<Point>>> = BTreeMap::new();
    for HalCurve { base, output, points } in curves {
        let mut piece: Vec<Point> = Vec::new();
        while piece.len() < points
            && let Some(((position, at), (value, _))) = numbers.next().zip(numbers.next())
        {
            if piece.last().is_some_and(|last| position <= last.position) {
                return Err(Complaint::new(
                    at,
                    refusals::hal("the points of a curve do not ascend"),
                ));
            }
            piece.push(Point { position, forward: value, reverse: None });
        }
        tables.entry((output, base)).or_default().push(piece);
    }
    let table = |((output, base), pieces): ((u32, u32), Vec<Vec<Point>>)| {
        let [base, output] = [base, output].map(|joint| joint.to_string());
        ListedTable { term: None, base, output, points: added_up(&pieces) }
    };
    Ok(tables.into_iter().map(table).collect())
}

/// The sum of curves at the points of all of them, each straight between its points and held outside.
fn added_up(pieces: &[Vec<Point>]) -> Vec<Point> {
    /// Sums are freed from binary dust below every decimal of a file.
    const DUST_DECIMALS: u32 = 12;
    let mut places: Vec<f64> = pieces.iter().flatten().map(|point| point.position).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| a.total_cmp(b).is_eq());
    let sum = |position: f64| {
        let value: f64 = pieces.iter().map(|piece| at(piece, position)).sum();
        Point { position, forward: rounded(value, DUST_DECIMALS) + 0.0, reverse: None }
    };
    places.into_iter().map(sum).collect()
}

fn at(points: &[Point], place: f64) -> f64 {
    let above = points.partition_point(|point| point.position <= place);
    let (below, above) = (above.checked_sub(1).map(|below| points[below]), points.get(above));
    match (below, above) {
        (Some(low), Some(high)) => {
            let share = (place - low.position) / (high.position - low.position);
            low.forward + share * (high.forward - low.forward)
        }
        (Some(end), None) => end.forward,
        (None, first) => first.map_or(0.0, |first| first.forward),
    }
}

/// The numbers of lines that are all those of the form, with their places.
fn numbers(
    text: &str,
    lines: &[Words<'_>],
    form: &[String],
) -> Result<Vec<(f64, Range<usize>)>, Complaint> {
    let mut numbers = Vec::new();
    for (index, expected) in form.iter().enumerate() {
        let line = lines.get(index).map_or(&[][..], Vec::as_slice);
        for (at, wanted) in expected.split(' ').map(Some).chain([None]).enumerate() {
            let (found, span) = line.get(at).cloned().unzip();
            let value = found.filter(|_| wanted == Some(NUMBER)).and_then(number);
            if value.is_none() && found != wanted {
                return Err(differs(text, line, at, &format!("`{expected}`")));
            }
            numbers.extend(value.zip(span));
        }
    }
    let behind = lines.get(form.len());
    behind.map_or(Ok(numbers), |line| Err(differs(text, line, 0, "the end of the file")))
}

/// A line that is not that of the form, at its first word that differs.
fn differs(text: &str, line: &HalLine<'_>, at: usize, expected: &str) -> Complaint {
    let end = line.last().map_or(text.len(), |(_, span)| span.end);
    let found = line.get(at).map(|(word, span)| (format!("`{}`", shown(word)), span.clone()));
    let (found, span) = found.unwrap_or_else(|| ("nothing".to_string(), end..end));
    Complaint::new(span, refusals::hal(format!("{found} stands here, expected {expected}")))
}

/// The curves that the first line loads, each with the joints that it is linked to.
fn curves(lines: &[Words<'_>], facts: &LinuxcncFacts) -> Result<Vec<HalCurve>, Complaint> {
    let first = lines.first().map_or(&[][..], Vec::as_slice);
    let at = first.first().map_or(0..0, |(_, span)| span.clone());
    let wrong = |message: String| Complaint::new(at.clone(), refusals::hal(message));
    let lengths = lengths(first, facts).ok_or_else(|| {
        let [points, most] = [&facts.curve_points, &facts.curves].map(|fact| fact.value);
        wrong(format!("expected `loadrt lincurve count=N personality=LIST` first, of up to {most} curves of 2 to {points} points"))
    })?;
    let joint = |number: usize, pin: &str| {
        let pin = format!("lincurve.{number}.{pin}");
        let line = lines.iter().find(|line| line.iter().any(|(word, _)| *word == pin));
        let signal = line.and_then(|line| match &line[..] {
            [("net", _), (signal, _), _] => signal.strip_prefix("nonius-"),
            _ => None,
        });
        let joint = signal.and_then(|signal| signal.split('-').next()?.parse().ok());
        joint.filter(|joint| *joint < MOST_JOINTS).ok_or_else(|| {
            let at = line.map_or(at.clone(), |line| line[0].1.start..line[line.len() - 1].1.end);
            let message = format!("expected a line `net nonius-J-… {pin}` with the joint J");
            Complaint::new(at, refusals::hal(message))
        })
    };
    let curve = |(number, points)| {
        Ok(HalCurve { base: joint(number, "in")?, output: joint(number, "out")?, points })
    };
    let curves: Vec<HalCurve> =
        lengths.into_iter().enumerate().map(curve).collect::<Result<_, _>>()?;
    if !curves.is_sorted_by_key(|curve| curve.output) {
        return Err(wrong("the curves of a joint do not stand together".to_string()));
    }
    match curves.iter().find(|curve| curve.base == curve.output) {
        None => Ok(curves),
        Some(HalCurve { base, .. }) => {
            Err(wrong(format!("joint {base} corrects itself, which its COMP_FILE does")))
        }
    }
}

/// Points of each curve: a list is used from its beginning again where there are more curves.
fn lengths(line: &HalLine<'_>, facts: &LinuxcncFacts) -> Option<Vec<usize>> {
    let [("loadrt", _), ("lincurve", _), (count, _), (list, _)] = line else {
        return None;
    };
    let count: usize = count.strip_prefix("count=")?.parse().ok()?;
    let numbers = list.strip_prefix("personality=")?.split(',').map(|number| number.parse().ok());
    let numbers: Vec<usize> = numbers.collect::<Option<_>>()?;
    let [most, points, curves] =
        [&facts.personalities, &facts.curve_points, &facts.curves].map(|fact| fact.value as usize);
    let fits = count <= curves
        && numbers.len() == count.min(most)
        && numbers.iter().all(|n| (2..=points).contains(n));
    fits.then(|| (0..count).map(|curve| numbers[curve % most]).collect())
}

/// All lines behind the first one.
///
/// ```text
///   curves of a joint, added up one after the other = correction
///   command + correction = drive        encoder − correction = feedback
/// ```
fn form(curves: &[HalCurve]) -> Vec<String> {
    let bases: BTreeSet<u32> = curves.iter().map(|curve| curve.base).collect();
    let position = |base: u32| format!("nonius-{base}-position");
    let mut nets: Vec<(String, String)> =
        bases.into_iter().map(|base| (position(base), format!("joint.{base}.pos-cmd"))).collect();
    let (mut gains, mut number) = (Vec::new(), 0);
    for of_joint in curves.chunk_by(|a, b| a.output == b.output) {
        let joint = of_joint[0].output;
        let total = |own: usize| match own + 1 == of_joint.len() {
            true => "correction".to_string(),
            false => format!("sum-{own}"),
        };
        let mut sums: Vec<[String; 3]> = Vec::new();
        let mut link = |name: &str, pin: String| nets.push((format!("nonius-{joint}-{name}"), pin));
        for own in 0..of_joint.len() {
            let curve = if own == 0 { total(0) } else { format!("curve-{own}") };
            link(&curve, format!("lincurve.{number}.out"));
            if own > 0 {
                sums.push([total(own - 1), curve, total(own)]);
            }
            number += 1;
        }
        link("command", format!("joint.{joint}.motor-pos-cmd"));
        sums.push(["command", "correction", "drive"].map(str::to_string));
        sums.push(["encoder", "correction", "feedback"].map(str::to_string));
        for [a, b, sum] in sums {
            for (name, pin) in [(&a, "in0"), (&b, "in1"), (&sum, "out")] {
                link(name, format!("sum2.{}.{pin}", gains.len()));
            }
            gains.push(if sum == "feedback" { "-1" } else { "1" });
        }
        link("feedback", format!("joint.{joint}.motor-pos-fb"));
    }
    let inputs = curves.iter().enumerate();
    nets.extend(
        inputs.map(|(number, curve)| (position(curve.base), format!("lincurve.{number}.in"))),
    );
    nets.sort_by(|(a, _), (b, _)| a.cmp(b)); // pins of a signal stay in order
    let mut lines = vec![format!("loadrt sum2 count={}", gains.len())];
    lines.extend((0..curves.len()).map(|curve| format!("addf lincurve.{curve} servo-thread")));
    lines.extend((0..gains.len()).map(|sum| format!("addf sum2.{sum} servo-thread")));
    lines.extend(nets.into_iter().map(|(signal, pin)| format!("net {signal} {pin}")));
    lines.extend(
        gains.iter().enumerate().map(|(sum, gain)| format!("setp sum2.{sum}.gain1 {gain}")),
    );
    for (number, curve) in curves.iter().enumerate() {
        for (point, axis) in (0..curve.points).flat_map(|point| [(point, "x"), (point, "y")]) {
            lines.push(format!("setp lincurve.{number}.{axis}-val-{point:02} {NUMBER}"));
        }
    }
    lines
}
