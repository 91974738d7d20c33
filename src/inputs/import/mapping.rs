//! `--columns "NAME=COLUMN,…"`: which column of a delimited text holds what.
//!
//! `NAME` is a column as the file writes it, or `#3` for the third one. `COLUMN` is a column of our error table
//! (contract §2.1), which states content and unit at once; `target_mm`, `target_in` … for positions that count
//! from the instrument's zero; `run`; or a reading at these targets of the term that is stated: `deviation_um`,
//! `actual_mm`, and where each run has a column of its own `up1_deviation_um`, `dn1_actual_mm`, `run1_…`.

use crate::inputs::error_table::{Column, Kind, Quantity, known_columns};
use crate::inputs::import::stated::{AXIS, DIRECTION, Stated};
use crate::inputs::target_runs::Values;
use crate::quantity::axis::{Axis, Direction};
use crate::quantity::units::UM_PER_MM;
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
    /// What was read at the target, of the term that is stated.
    Reading(Reading),
}

/// A reading at a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    /// The way of the axis, where the column has one of its own.
    pub(super) direction: Option<Direction>,
    /// The run, where the column has one of its own.
    pub(super) run: Option<usize>,
    /// Where the axis stood, or how far from the target.
    pub(super) values: Values,
}

impl Content {
    /// Whether it is measured, and neither says where nor in which run.
    fn is_value(self) -> bool {
        matches!(self, Content::Table(Quantity::Value(_)) | Content::Reading(_))
    }

    fn is_reading(self) -> bool {
        matches!(self, Content::Reading(_))
    }

    /// Whether it says where the axis stood.
    fn is_position(self) -> bool {
        matches!(self, Content::Reading(Reading { values: Values::Positions, .. }))
    }

    pub(super) fn is_uncertainty(self) -> bool {
        matches!(self, Content::Table(Quantity::Uncertainty(_)))
    }

    /// The reading of a sheet that has a column for each run.
    fn wide(self) -> Option<Reading> {
        match self {
            Content::Reading(reading) => Some(reading).filter(|reading| reading.run.is_some()),
            _ => None,
        }
    }

    /// Whether two columns give the same.
    fn is_same(self, other: Content) -> bool {
        match (self, other) {
            (Content::Reading(own), Content::Reading(other)) => {
                (own.direction, own.run) == (other.direction, other.run)
            }
            _ => self == other,
        }
    }
}

/// How the mapping names a column of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Named {
    /// By the text in its header.
    Text(String),
    /// By its place in the row, from 1.
    Number(usize),
}

impl Named {
    /// `#3`, or the name itself.
    pub(super) fn of(text: &str) -> Named {
        let number = text.trim().strip_prefix('#').and_then(|number| number.trim().parse().ok());
        number.map_or_else(|| Named::Text(text.trim().to_string()), Named::Number)
    }
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

/// Every name that may stand behind `=`, but for those of readings.
fn known() -> Vec<(String, Content, f64)> {
    let of_table = known_columns().into_iter();
    let of_table = of_table.map(|(name, column): (String, Column)| {
        (name, Content::Table(column.holds), column.factor)
    });
    let in_rad = Axis::ALL.into_iter().zip(["ea_rad", "eb_rad", "ec_rad"]);
    let in_rad = in_rad
        .map(|(about, name)| (name, Content::Table(Quantity::Value(Kind::Angle(about))), 1e6));
    let in_rad = in_rad.map(|(name, content, factor)| (name.to_string(), content, factor));
    let targets = LengthUnit::ALL
        .map(|unit| (format!("target_{}", unit.word()), Content::Target, unit.um() / UM_PER_MM));
    let run = ("run".to_string(), Content::Run, 1.0);
    of_table.chain(targets).chain(in_rad).chain([run]).collect()
}

/// What a word such as `ex_um` or `up1_actual_mm` says, with its factor.
pub(super) fn content_of(word: &str) -> Option<(Content, f64)> {
    let known = known().into_iter().find(|(known, ..)| known == word);
    known.map(|(_, content, factor)| (content, factor)).or_else(|| {
        let (name, unit) = word.rsplit_once('_')?;
        let unit = LengthUnit::ALL.into_iter().find(|known| known.word() == unit)?;
        let (own, what) = name.rsplit_once('_').map_or((None, name), |(own, w)| (Some(own), w));
        let values = match what {
            "actual" => Values::Positions,
            "deviation" => Values::Deviations,
            _ => return None,
        };
        let (direction, run) = match own {
            None => (None, None),
            Some(own) => {
                let way = own.trim_end_matches(|c: char| c.is_ascii_digit());
                let direction = match way {
                    "up" => Some(Direction::Plus),
                    "dn" => Some(Direction::Minus),
                    "run" => None,
                    _ => return None,
                };
                (direction, Some(own[way.len()..].parse().ok()?))
            }
        };
        Some((Content::Reading(Reading { direction, run, values }), unit.um()))
    })
}

/// What the columns of the file hold.
pub(super) struct Mapping {
    pub(super) columns: Vec<Mapped>,
}

impl Mapping {
    pub(super) fn read(text: &str) -> Result<Mapping, Problems> {
        let mut problems = Problems::none();
        let mut columns: Vec<Mapped> = Vec::new();
        for pair in pairs(text) {
            let Some((name, target)) = pair.rsplit_once('=') else {
                let message = format!("`{}` of `--columns` has no `=`", shown(&pair));
                problems.push(Problem::new(message).help(format!("write NAME=COLUMN, {EXAMPLE}")));
                continue;
            };
            let target = target.trim();
            let Some((content, factor)) = content_of(target) else {
                problems.push(unknown_target(target));
                continue;
            };
            if columns.iter().any(|other| other.content.is_same(content)) {
                let message =
                    format!("`{target}` of `--columns` gives the same as a column before it");
                problems.push(Problem::new(message).help("keep one of the two"));
            }
            let unit = target.rsplit_once('_').map(|(_, unit)| unit.to_string());
            columns.push(Mapped { name: Named::of(name), content, factor, unit });
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

    /// Whether it holds readings of the term that is stated.
    pub(super) fn has_readings(&self) -> bool {
        self.has_any(Content::is_reading)
    }

    /// Whether a column, or each of several, says which way the axis went.
    pub(super) fn has_directions(&self) -> bool {
        let of_its_own = |reading: Reading| reading.direction.is_some();
        self.has(Content::Table(Quantity::Direction))
            || self.has_any(|content| content.wide().is_some_and(of_its_own))
    }

    /// Whether all that was measured are positions, from which deviations as measured − target are taken.
    pub(super) fn holds_positions(&self) -> bool {
        let mut values = self.columns.iter().filter(|column| column.content.is_value()).peekable();
        values.peek().is_some() && values.all(|column| column.content.is_position())
    }

    /// What the mapping has to hold, what has to be stated beside it, and what the mapping says already.
    pub(super) fn require(&self, stated: &Stated, problems: &mut Problems) {
        let positions = self.has(Content::Table(Quantity::Position));
        let (targets, runs) = (self.has(Content::Target), self.has(Content::Run));
        let only_positions = positions && !targets;
        let (directions, readings) = (self.has_directions(), self.has_readings());
        let wide = self.has_any(|content| content.wide().is_some());
        let others = self.has_any(|content| content.is_value() && content.wide().is_none());
        let other_values = self.has_any(|content| content.is_value() && !content.is_reading());
        let uncertain = self.has_any(Content::is_uncertainty);
        let axes = self.has(Content::Table(Quantity::Axis));
        let first_target = stated.first_target_at_mm.is_some();
        let twice = [
            (stated.travel.is_some() && directions, "--direction", "direction"),
            (first_target && only_positions, "--first-target-at-mm", "position"),
            (stated.targets_run.is_some() && only_positions, "--targets-run", "position"),
            (targets && positions, "`target`", "`position`"),
            (uncertain && runs, "an uncertainty", "`run`"),
            (wide && runs, "a column for each run", "`run`"),
            (wide && (others || uncertain), "a column for each run", "other values"),
            (axes && readings, "a reading of `--term`", "`axis`"),
            (readings && other_values, "a reading of `--term`", "components by name"),
            (
                self.has_any(Content::is_position) && !self.holds_positions(),
                "where the axis stood",
                "deviations",
            ),
        ];
        for (_, option, mapped) in twice.into_iter().filter(|(is, ..)| *is) {
            let message = match option.starts_with("--") {
                true => format!("`{option}` is stated, but the mapping gives `{mapped}`"),
                false => format!("the mapping gives both {option} and {mapped}"),
            };
            problems.push(Problem::new(message).help("keep one of the two"));
        }
        let lacking = [
            (
                !positions && !targets,
                "`--columns` maps no column to a position",
                "map one to `position_mm` (machine coordinate) or `target_mm` (counted from the laser's zero)",
            ),
            (
                !wide && !others,
                "`--columns` maps no column to a deviation",
                "map one to `ex_um`, `ex_mm`, `ey_um` … `ec_urad`",
            ),
            (
                readings && !targets,
                "`--columns` maps a reading, but no column to its target",
                "map one to `target_mm` or `target_in`, or the reading to a column such as `ex_um`",
            ),
            (
                stated.plus_moves.is_some() && !directions,
                "`--plus-moves` is stated, but no column is mapped to `direction`",
                "leave it out, or map the column whose `+` it explains",
            ),
            (
                stated.term.is_some() && !readings,
                "`--term` is stated, but the mapping names the components itself",
                "leave it out, or map a column to `deviation_um` or `actual_mm`",
            ),
        ];
        for (_, message, help) in lacking.into_iter().filter(|(is, ..)| *is) {
            problems.push(Problem::new(message).help(help));
        }
        if stated.axis.is_none() && !axes && !readings {
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

fn unknown_target(target: &str) -> Problem {
    let columns = "columns: axis, direction, run, position_mm, target_mm, ex_um, ex_mm … ec_urad, u_ex_um, deviation_um, actual_mm, up1_actual_mm …";
    let known = known();
    let help = did_you_mean(target, known.iter().map(|(name, ..)| name.as_str()), columns);
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
