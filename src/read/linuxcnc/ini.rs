//! The ini file of a machine, or lines of it: what its joints say of their compensation.
//!
//! Of two sections of one name LinuxCNC reads the first only, and of two settings of one name the first; a
//! value goes to the end of its line. `#` and `;` begin a comment where a line begins.

use crate::control::controller::{Columns, ControlUnit, MOST_JOINTS};
use crate::read::lexer::{Complaint, MOST_COMPLAINTS, lines, located};
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

/// The settings of concern that LinuxCNC reads, and what is wrong with the lines.
fn settings(text: &str) -> (Vec<Setting<'_>>, Vec<Complaint>) {
    let (mut settings, mut complaints) = (Vec::new(), Vec::new());
    let (mut begun, mut known) = (BTreeSet::new(), BTreeSet::new());
    let (mut within, mut is_second) = ("", false);
    for span in lines(text) {
        let line = text[span.clone()].trim();
        if let Some(name) = section(line) {
            (within, is_second) = (name, !begun.insert(name));
        } else if line.starts_with("#INCLUDE") {
            complaints.push(Complaint::new(
                span,
                "this line includes another file, which is not read here",
                "name the file that LinuxCNC makes of both when it starts: the ini file with `.expanded` behind its name",
            ));
        } else if let Some(setting) = setting(within, line, span) {
            if !is_read(&setting) {
                continue;
            }
            if is_second {
                complaints.push(Complaint::new(
                    setting.span,
                    format!("a second section [{}], which LinuxCNC does not read", shown(within)),
                    "put its lines into the first section of this name",
                ));
            } else if known.insert((within, setting.key)) {
                settings.push(setting);
            }
        }
        if complaints.len() >= MOST_COMPLAINTS {
            break;
        }
    }
    (settings, complaints)
}

fn setting<'a>(section: &'a str, line: &'a str, span: Range<usize>) -> Option<Setting<'a>> {
    if line.starts_with(['#', ';']) {
        return None;
    }
    let (key, value) = line.split_once('=')?;
    Some(Setting { section, key: key.trim_end(), value: value.trim_start(), span })
}

impl Ini {
    /// Reads a text.
    pub(super) fn read(file: &str, text: &str) -> Result<Ini, Problems> {
        let (settings, mut complaints) = settings(text);
        let mut ini = Ini::default();
        for setting in &settings {
            let taken = match setting.section.strip_prefix("JOINT_") {
                Some(number) => take(&mut ini.joints, number, setting),
                None => unit(setting.value).map(|unit| ini.unit = Some(unit)),
            };
            let wrong = |expected| wrong(setting, expected);
            complaints.extend(taken.err().map(wrong));
        }
        located(file, text, complaints).or_ok(ini)
    }
}

/// Takes a setting of a joint; `Err` = what was expected.
fn take(
    joints: &mut BTreeMap<u32, Joint>,
    number: &str,
    setting: &Setting<'_>,
) -> Result<(), &'static str> {
    let number = number.parse().ok().filter(|number| *number < MOST_JOINTS);
    let number = number.ok_or("a joint from [JOINT_0] to [JOINT_15]")?;
    let joint = joints.entry(number).or_default();
    match setting.key {
        "COMP_FILE" => joint.comp_file = Some(setting.value.to_string()),
        "COMP_FILE_TYPE" => joint.columns = Some(columns(setting.value)?),
        "BACKLASH" => joint.backlash = Some(length(setting.value)?),
        "HOME_LATCH_VEL" => joint.home_latch = Some(length(setting.value)?),
        _ => joint.home_offset = Some(length(setting.value)?),
    }
    Ok(())
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
    let Setting { section, key, value, .. } = setting;
    let message = format!(
        "`{}` of [{}] is `{}`, expected {expected}",
        shown(key),
        shown(section),
        shown(value)
    );
    Complaint::new(
        setting.span.clone(),
        message,
        "a value goes to the end of its line, comments too",
    )
}
