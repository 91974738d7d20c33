//! `--columns "NAME=COLUMN,…"`: which column of a delimited text holds what.
//!
//! `NAME` is a column as the file writes it, or `#3` for the third one. `COLUMN` is a column of our
//! error table (contract §2.1), which states content and unit at once; or `target_mm`, `target_in`
//! for positions that count from the instrument's zero; or `run`.

use crate::inputs::error_table::{Column, Quantity, known_columns};
use crate::inputs::import::stated::{AXIS, DIRECTION, Stated};
use crate::quantity::axis::Axis;
use crate::quantity::units::MM_PER_INCH;
use crate::text::delimited::LengthUnit;
use crate::text::problem::{Problem, Problems, did_you_mean, shown};

const EXAMPLE: &str = "e.g. `--columns \"AXn [mm]=position_mm,Delta [mm]=ex_mm\"`";

/// What a mapped column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
    /// As in an error table; a position is a machine coordinate.
    Table(Quantity),
    /// A position that counts from the instrument's zero.
    Target,
    /// The number of the run.
    Run,
}

/// How the mapping names a column of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Named {
    /// By the text in its header.
    Text(String),
    /// By its place in the row, from 1.
    Number(usize),
}

/// A column of the file.
pub(super) struct Mapped {
    pub(super) name: Named,
    pub(super) content: Content,
    /// What turns its numbers into mm, µm or µrad.
    pub(super) factor: f64,
    /// The unit of its numbers; `None` = words or counts.
    pub(super) unit: Option<String>,
}

/// The unit that the name of a column ends with: `Delta [mm]`, `Delta (mm)`, `delta_mm`,
/// `Delta / mm`, `Delta mm`. A last word `in` may be a word of the language.
pub(super) fn unit_of_name(name: &str) -> Option<&'static str> {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        let inside = name.strip_suffix(close).and_then(|n| n.rsplit_once(open));
        if let Some((_, text)) = inside {
            return unit(text);
        }
    }
    if let Some((_, text)) = name.rsplit_once(['_', '/']) {
        return unit(text);
    }
    let (_, text) = name.rsplit_once(' ')?;
    unit(text).filter(|_| text != "in")
}

/// Our word of a unit.
fn unit(text: &str) -> Option<&'static str> {
    let length = LengthUnit::from_text(text).map(LengthUnit::word);
    length.or_else(|| match text.trim().to_lowercase().as_str() {
        "urad" | "µrad" | "μrad" => Some("urad"),
        "mrad" => Some("mrad"),
        "rad" => Some("rad"),
        "arcsec" | "\"" | "arc sec" => Some("arcsec"),
        _ => None,
    })
}

/// Every name that may stand behind `=`.
fn known() -> Vec<(String, Content, f64)> {
    let of_table = known_columns().into_iter();
    let of_table = of_table.map(|(name, column): (String, Column)| {
        (name, Content::Table(column.holds), column.factor)
    });
    let is_held = |(_, content, _): &(String, Content, f64)| {
        !matches!(content, Content::Table(Quantity::AngleUncertainty(_)))
    };
    let in_rad = Axis::ALL.into_iter().zip(["ea_rad", "eb_rad", "ec_rad"]);
    let in_rad = in_rad.map(|(about, name)| (name, Content::Table(Quantity::Angle(about)), 1e6));
    let own = [
        ("run", Content::Run, 1.0),
        ("target_mm", Content::Target, 1.0),
        ("target_in", Content::Target, MM_PER_INCH),
    ];
    let own = own.into_iter().chain(in_rad);
    let own = own.map(|(name, content, factor)| (name.to_string(), content, factor));
    of_table.filter(is_held).chain(own).collect()
}

/// What the columns of the file hold.
pub(super) struct Mapping {
    pub(super) columns: Vec<Mapped>,
}

impl Mapping {
    pub(super) fn read(text: &str) -> Result<Mapping, Problems> {
        let known = known();
        let mut problems = Problems::none();
        let mut columns: Vec<Mapped> = Vec::new();
        for pair in pairs(text) {
            let Some((name, target)) = pair.rsplit_once('=') else {
                let message = format!("`{}` of `--columns` has no `=`", shown(&pair));
                problems.push(Problem::new(message).help(format!("write NAME=COLUMN, {EXAMPLE}")));
                continue;
            };
            let (name, target) = (name.trim(), target.trim());
            let number = name.strip_prefix('#').and_then(|n| n.trim().parse().ok());
            let name = number.map_or_else(|| Named::Text(name.to_string()), Named::Number);
            let Some((_, content, factor)) = known.iter().find(|(known, ..)| known == target)
            else {
                let names = known.iter().map(|(name, ..)| name.as_str());
                problems.push(unknown_target(target, names));
                continue;
            };
            let mut refuse = |message: String, help: &str| {
                problems.push(Problem::new(message).help(help));
            };
            if columns.iter().any(|other| other.content == *content) {
                let message =
                    format!("`{target}` of `--columns` gives the same as a column before it");
                refuse(message, "keep one of the two");
            }
            if columns.iter().any(|other| other.name == name) {
                let message =
                    format!("the column mapped to `{target}` is mapped to something else before");
                refuse(message, "a column holds one thing: map each once");
            }
            columns.push(Mapped {
                name,
                content: *content,
                factor: *factor,
                unit: target.rsplit_once('_').map(|(_, unit)| unit.to_string()),
            });
        }
        let is_number = |column: &Mapped| matches!(column.name, Named::Number(_));
        if columns.iter().all(is_number) && problems.is_empty() {
            let message =
                "`--columns` names no column, so the line above the numbers cannot be found";
            let help = format!("give at least one column by its name, {EXAMPLE}");
            problems.push(Problem::new(message).help(help));
        }
        problems.or_ok(Mapping { columns })
    }

    fn has_any(&self, is: impl Fn(Content) -> bool) -> bool {
        self.columns.iter().any(|column| is(column.content))
    }

    pub(super) fn has(&self, content: Content) -> bool {
        self.has_any(|own| own == content)
    }

    /// Statements that the mapping makes already.
    pub(super) fn refuse_twice(&self, stated: &Stated, problems: &mut Problems) {
        let positions = self.has(Content::Table(Quantity::Position));
        let directions = self.has(Content::Table(Quantity::Direction));
        let (targets, runs) = (self.has(Content::Target), self.has(Content::Run));
        let uncertainties =
            self.has_any(|content| matches!(content, Content::Table(Quantity::Uncertainty(_))));
        let only_positions = positions && !targets;
        let twice = [
            (stated.travel.is_some() && directions, "--direction", "direction"),
            (
                stated.first_target_at_mm.is_some() && only_positions,
                "--first-target-at-mm",
                "position",
            ),
            (stated.targets_run.is_some() && only_positions, "--targets-run", "position"),
            (targets && positions, "target", "position"),
            (uncertainties && runs, "an uncertainty", "run"),
        ];
        for (_, option, mapped) in twice.into_iter().filter(|(is, ..)| *is) {
            let message = format!("`{option}` is stated, but the mapping gives `{mapped}`");
            problems.push(Problem::new(message).help("keep one of the two"));
        }
    }

    /// What must be mapped or stated, and what is stated without a meaning.
    pub(super) fn require(&self, stated: &Stated, problems: &mut Problems) {
        let positions = self.has(Content::Table(Quantity::Position)) || self.has(Content::Target);
        let directions = self.has(Content::Table(Quantity::Direction));
        let values = self.has_any(|content| {
            matches!(content, Content::Table(Quantity::Deviation(_) | Quantity::Angle(_)))
        });
        let without = [
            (
                !positions,
                "`--columns` maps no column to a position",
                "map one to `position_mm` (machine coordinate) or `target_mm` (counted from the laser's zero)",
            ),
            (
                !values,
                "`--columns` maps no column to a deviation",
                "map one to `ex_um`, `ex_mm`, `ey_um` … `ec_urad`",
            ),
            (
                stated.plus_moves.is_some() && !directions,
                "`--plus-moves` is stated, but no column is mapped to `direction`",
                "leave it out, or map the column whose `+` it explains",
            ),
        ];
        for (_, message, help) in without.into_iter().filter(|(is, ..)| *is) {
            problems.push(Problem::new(message).help(help));
        }
        if stated.axis.is_none() && !self.has(Content::Table(Quantity::Axis)) {
            problems.push(AXIS.missing());
        }
        if stated.travel.is_none() && !directions {
            problems.push(DIRECTION.missing());
        }
    }
}

/// Parts of the mapping; a comma belongs to a name if no `=` stands before the next one.
fn pairs(text: &str) -> Vec<String> {
    let mut pairs = Vec::new();
    let mut open = String::new();
    for part in text.split(',') {
        if !open.is_empty() {
            open.push(',');
        }
        open.push_str(part);
        if part.contains('=') {
            pairs.push(std::mem::take(&mut open));
        }
    }
    if !open.trim().is_empty() {
        pairs.push(open);
    }
    pairs
}

fn unknown_target<'a>(target: &str, known: impl Iterator<Item = &'a str>) -> Problem {
    let columns =
        "columns: axis, direction, run, position_mm, target_mm, ex_um, ex_mm … ec_urad, u_ex_um …";
    let help = did_you_mean(target, known, columns);
    Problem::new(format!("unknown column `{}` in `--columns`", shown(target))).help(help)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_name_is_its_end() {
        for name in ["Delta [mm]", "Delta (mm)", "delta_mm", "Delta / mm", "Fahrt in mm"] {
            assert_eq!(unit_of_name(name), Some("mm"), "{name}");
        }
        assert_eq!(unit_of_name("Pitch [arcsec]"), Some("arcsec"));
        for name in ["Delta", "Run in", "Time [s]", "mm", "Delta_x"] {
            assert_eq!(unit_of_name(name), None, "{name}");
        }
    }
}
