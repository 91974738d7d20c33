//! What a file is, and which of its columns holds what: as stated by `--columns "NAME=COLUMN,…"`, or as understood of it,
//! which is shown, and taken with `--yes`; sign, unit, material and first target are never understood.
//!
//! `NAME` is a column as the file writes it, or `#3` for the third one. `COLUMN` is a column of our error table
//! (contract §2.1), which states content and unit at once; `target_mm`, `target_in` … for positions that count
//! from the instrument's zero; `run`; or a reading at these targets of the term that is stated: `deviation_um`,
//! `actual_mm`, and where each run has a column of its own `up1_deviation_um`, `dn1_actual_mm`, `run1_…`.

use crate::inputs::error_table::{Component, Kind, known_columns};
use crate::inputs::import::intake::Intake;
use crate::inputs::import::parameters::is_isg_header;
use crate::inputs::import::stated::{AXIS, DIRECTION, Format, ImportFacts, Travel};
use crate::inputs::import::{pos, rtl};
use crate::inputs::kind::head;
use crate::inputs::refusals;
use crate::inputs::table::{Column, Content, LENGTHS, Reading, Unit, named};
use crate::inputs::target_runs::{Values, approach};
use crate::quantity::Axis;
use crate::text::{LengthUnit, Line, Problem, Problems, Source, did_you_mean, lines, shown};

/// Within so many lines the columns are named.
const MOST_LINES: usize = 100;
/// A line of more cells names no columns.
const MOST_COLUMNS: usize = 1000;

/// The format of a file, and what was stated with what is understood beside it.
pub(super) fn recognised(
    source: &Source,
    stated: &ImportFacts,
) -> Result<(Format, ImportFacts), Problem> {
    let mut whole = stated.clone();
    let known = if stated.columns.is_some() { Some(Format::Columns) } else { format_of(source) };
    let mut format = stated.from.or(known);
    let is_open = stated.columns.is_none() && format.is_none_or(|own| own == Format::Columns);
    let understood = || lines(source).take(MOST_LINES).find_map(|line| columns(&line));
    if let Some((columns, mapping)) = is_open.then(understood).flatten() {
        format = Some(Format::Columns);
        whole.columns = Some(columns);
        whole.travel = stated.travel.or((!mapping.has_directions()).then_some(Travel::Both));
    }
    let Some(format) = format else {
        let first = 0..head(&source.text, "//").len().min(source.text.len());
        return Err(refusals::not_recognised(&source.name).at(source.place(&first)));
    };
    // In a `.pos` the name of the axis is often left as it was.
    let moved = match format {
        Format::Rtl => stated.axis.or_else(|| rtl::axis(&Intake::of(source, stated, format))),
        Format::Pos => stated.axis,
        _ => None,
    };
    let positioning = moved.map(|along| Component { kind: Kind::Deviation(along), along });
    whole.term = stated.term.or(positioning);
    Ok((format, whole))
}

/// The format, by what stands in the file, else by the ending of its name.
fn format_of(source: &Source) -> Option<Format> {
    let first = head(&source.text, "//");
    let has_key = |key: &str| {
        let mut lines = source.text.lines().map(str::trim);
        lines.any(|line| line.starts_with(key) && line.contains(':'))
    };
    let name = source.name.to_ascii_lowercase();
    let signs = [
        (Format::Rtl, first.eq_ignore_ascii_case("HEADER::")),
        (Format::Ren, has_key("Compensation start") || has_key("Compensation type")),
        (Format::Etalon, first.starts_with('[')),
        (Format::Isg, is_isg_header(first)),
        (Format::Pos, pos::is_first_line(first) || name.ends_with(".pos")),
        (Format::Rtl, name.ends_with(".rtl")),
        (Format::Ren, name.ends_with(".ren")),
    ];
    signs.into_iter().find(|(_, is)| *is).map(|(format, _)| format)
}

/// Our words of columns, and how people write them.
const WORDS: [(&str, &[&str]); 9] = [
    ("axis", &["axis"]),
    ("target", &["target", "targets", "nominal"]),
    ("position", &["position", "pos"]),
    ("actual", &["actual"]),
    ("deviation", &["deviation", "dev", "delta", "error"]),
    ("up", &["up"]),
    ("dn", &["dn", "down"]),
    ("run", &["run"]),
    ("direction", &["direction", "dir"]),
];

/// The mapping of a line that names a place and what was read there, each with its unit.
fn columns(line: &Line<'_>) -> Option<(String, Mapping)> {
    let cells = line.cells();
    let is_word =
        |wanted| cells.iter().any(|c| word_of(c).is_some_and(|(word, ..)| word == wanted));
    let has_targets = is_word("target");
    if !(2..=MOST_COLUMNS).contains(&cells.len()) || !(has_targets || is_word("position")) {
        return None;
    }
    // Without an axis beside it a position is a target, whose machine coordinate a person states.
    let is_target = |name: &str| name == "position_mm" && !is_word("axis");
    let ours = |name: &str| match word_of(name) {
        Some(("position", "", unit)) if has_targets => Some(format!("actual_{}", unit?)),
        _ if column_of(name).is_some() && !is_target(name) => Some(name.to_string()),
        Some(("position", "", unit)) => Some(format!("target_{}", unit?)),
        Some((word @ ("run" | "direction" | "axis"), "", _)) => Some(word.to_string()),
        Some((word, run, unit)) => Some(format!("{word}{run}_{}", unit?)),
        None => None,
    };
    // A word that is known but whose unit is not said is no column to be left out.
    let is_unclear = |name: &str| word_of(name).is_some() && ours(name).is_none();
    let named = cells.iter().filter_map(|name| Some(format!("{name}={}", ours(name)?)));
    let columns = named.collect::<Vec<String>>().join(",");
    let is_clear = !cells.iter().any(|cell| is_unclear(cell));
    let mapping = Mapping::read(&columns).ok().filter(|mapping| is_clear && mapping.is_whole())?;
    Some((columns, mapping))
}

/// The word of a column, the number behind it and its unit.
fn word_of(name: &str) -> Option<(&'static str, &str, Option<&'static str>)> {
    let named = unit_of_name(name).map(|(before, unit)| (before, Some(unit)));
    let (before, unit) = named.unwrap_or((name, None));
    let before = before.trim();
    let letters = before.trim_end_matches(|c: char| c.is_ascii_digit());
    let word = letters.trim().to_lowercase();
    let (ours, _) = WORDS.iter().find(|(_, known)| known.contains(&&*word))?;
    Some((ours, &before[letters.len()..], unit))
}

/// Whether it is measured, and neither says where nor in which run.
fn is_value(content: Content) -> bool {
    matches!(content, Content::Value(_) | Content::Reading(_))
}

/// Whether it says where the axis stood, or may say so.
fn is_position(content: Content) -> bool {
    content.as_reading().is_some_and(|reading| reading.values != Some(Values::Deviations))
}

/// How the mapping names a column of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ColumnName {
    /// By the text in its header.
    Text(String),
    /// By its place in the row, from 1.
    Number(usize),
}

impl ColumnName {
    /// `#3`, or the name itself.
    pub(super) fn of(text: &str) -> ColumnName {
        let number = text.trim().strip_prefix('#').and_then(|number| number.trim().parse().ok());
        number.map_or_else(|| ColumnName::Text(text.trim().to_string()), ColumnName::Number)
    }
}

/// The unit that the name of a column ends with, and what stands before it: `Delta [mm]`, `Delta (mm)`,
/// `delta_mm`, `Delta / mm`, `Delta mm`. A last word `in` may be a word of the language.
pub(super) fn unit_of_name(name: &str) -> Option<(&str, &'static str)> {
    let name = name.trim();
    let inside = |(open, close)| name.strip_suffix(close).and_then(|n: &str| n.rsplit_once(open));
    let in_brackets = [('[', ']'), ('(', ')')].into_iter().find_map(inside);
    if let Some((before, text)) = in_brackets.or_else(|| name.rsplit_once(['_', '/'])) {
        return unit(text).map(|unit| (before, unit));
    }
    let (before, text) = name.rsplit_once(' ')?;
    unit(text).filter(|_| text != "in").map(|unit| (before, unit))
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
fn known() -> Vec<Column> {
    let mut known = known_columns();
    known.extend(named(&[("target", Content::Target, &LENGTHS), ("run", Content::Run, &[])]));
    for kind in Axis::ALL.map(Kind::Angle) {
        let rad = Unit { word: "rad", factor: 1e6 };
        known.extend(named(&[(&kind.word(), Content::Value(kind), &[rad])]));
    }
    known
}

/// The column of a word such as `ex_um` or `up1_actual_mm`.
pub(super) fn column_of(word: &str) -> Option<Column> {
    let known = known().into_iter().find(|known| known.name == word);
    known.or_else(|| {
        let (name, unit) = word.rsplit_once('_')?;
        let unit = LENGTHS.into_iter().find(|known| known.word == unit)?;
        let (own, values) = match name.rsplit_once('_').unwrap_or(("", name)) {
            (own, "actual") => (own, Some(Values::Positions)),
            (own, "deviation") => (own, Some(Values::Deviations)),
            _ => (name, None),
        };
        let way = own.trim_end_matches(|c: char| c.is_ascii_digit());
        let direction = match way {
            "run" | "" => None,
            word => Some(approach(word)?),
        };
        let run = if way.is_empty() { None } else { Some(own[way.len()..].parse().ok()?) };
        let is_reading = run.is_some() || (own.is_empty() && values.is_some());
        let content = Content::Reading(Reading { direction, run, values });
        let (name, unit) = (word.to_string(), Some(unit));
        is_reading.then_some(Column { index: 0, name, content, unit })
    })
}

/// What the columns of the file hold.
pub(super) struct Mapping {
    pub(super) columns: Vec<(ColumnName, Column)>,
}

impl Mapping {
    pub(super) fn read(text: &str) -> Result<Mapping, Problems> {
        let mut problems = Problems::none();
        let mut columns: Vec<(ColumnName, Column)> = Vec::new();
        for pair in pairs(text) {
            let Some((name, target)) = pair.rsplit_once('=') else {
                problems.push(refusals::no_equals(shown(&pair)));
                continue;
            };
            let target = target.trim();
            let Some(column) = column_of(target) else {
                let known = known();
                let help = did_you_mean(target, known.iter().map(|own| own.name.as_str()), COLUMNS);
                problems.push(refusals::unknown_column(shown(target), help));
                continue;
            };
            if columns.iter().any(|(_, other)| other.content.is_same(column.content)) {
                problems.push(refusals::mapped_like_another(target));
            }
            columns.push((ColumnName::of(name), column));
        }
        let is_number = |(name, _): &(ColumnName, Column)| matches!(name, ColumnName::Number(_));
        if columns.iter().all(is_number) && problems.is_empty() {
            problems.push(refusals::only_numbers());
        }
        problems.or_ok(Mapping { columns })
    }

    fn contents(&self) -> impl Iterator<Item = Content> {
        self.columns.iter().map(|(_, column)| column.content)
    }

    fn has_any(&self, is: impl Fn(Content) -> bool) -> bool {
        self.contents().any(is)
    }

    pub(super) fn has(&self, content: Content) -> bool {
        self.has_any(|own| own == content)
    }

    /// Whether it says where and what was measured.
    pub(super) fn is_whole(&self) -> bool {
        (self.has(Content::Target) || self.has(Content::Position)) && self.has_any(is_value)
    }

    /// Whether it holds readings of the term that is stated.
    pub(super) fn has_readings(&self) -> bool {
        self.has_any(Content::is_reading)
    }

    /// Whether a column, or each of several, says which way the axis went.
    pub(super) fn has_directions(&self) -> bool {
        let is_directed = |reading: Reading| reading.direction.is_some();
        self.has(Content::Direction)
            || self.has_any(|content| content.of_run().is_some_and(is_directed))
    }

    /// Whether all that was measured are positions, from which deviations as measured − target are taken.
    pub(super) fn holds_positions(&self) -> bool {
        let mut values = self.contents().filter(|content| is_value(*content)).peekable();
        values.peek().is_some() && values.all(is_position)
    }

    /// What the mapping has to hold, what has to be stated beside it, and what the mapping says already.
    pub(super) fn require(&self, intake: &Intake<'_>) {
        let stated = intake.stated;
        let (positions, axes) = (self.has(Content::Position), self.has(Content::Axis));
        let (targets, runs) = (self.has(Content::Target), self.has(Content::Run));
        let only_positions = positions && !targets;
        let (directions, readings) = (self.has_directions(), self.has_readings());
        let wide = self.has_any(|content| content.of_run().is_some());
        let others = self.has_any(|own| is_value(own) && own.of_run().is_none());
        let other_values = self.has_any(|own| matches!(own, Content::Value(_)));
        let uncertain = self.has_any(|own| matches!(own, Content::Uncertainty(_)));
        let mixed = self.has_any(is_position) && !self.holds_positions();
        let first_target = stated.first_target_at_mm.is_some();
        let runs_apart = "a column for each run";
        let reading = "a reading of `--term`";
        let own = |option, mapped| refusals::stated_and_mapped(option, mapped);
        let wrong = [
            (stated.travel.is_some() && directions, own("--direction", "direction")),
            (first_target && only_positions, own("--first-target-at-mm", "position")),
            (stated.targets_run.is_some() && only_positions, own("--targets-run", "position")),
            (targets && positions, refusals::mapped_both("`target`", "`position`")),
            (uncertain && runs, refusals::mapped_both("an uncertainty", "`run`")),
            (wide && runs, refusals::mapped_both(runs_apart, "`run`")),
            (wide && (others || uncertain), refusals::mapped_both(runs_apart, "other values")),
            (axes && readings, refusals::mapped_both(reading, "`axis`")),
            (readings && other_values, refusals::mapped_both(reading, "components by name")),
            (mixed, refusals::mapped_both("where the axis stood", "deviations")),
            (!positions && !targets, refusals::no_position()),
            (!wide && !others, refusals::no_deviation()),
            (readings && !targets, refusals::no_target()),
            (stated.plus_moves.is_some() && !directions, refusals::plus_of_nothing()),
            (stated.term.is_some() && !readings, refusals::term_of_nothing()),
        ];
        let wrong = wrong.into_iter().filter(|(is, _)| *is);
        wrong.for_each(|(_, problem)| intake.notes.refuse(problem));
        if stated.axis.is_none() && !axes && !readings {
            intake.notes.refuse(AXIS.missing());
        }
        if stated.travel.is_none() && !directions {
            intake.notes.refuse(DIRECTION.missing());
        }
    }
}

/// Parts of the mapping; a comma belongs to a name if no `=` stands before the next one.
fn pairs(text: &str) -> Vec<String> {
    let mut pairs: Vec<String> = Vec::new();
    for part in text.split(',') {
        match pairs.last_mut().filter(|open| !open.is_empty() && !open.contains('=')) {
            Some(open) => *open += &format!(",{part}"),
            None => pairs.push(part.to_string()),
        }
    }
    pairs.retain(|pair| !pair.trim().is_empty());
    pairs
}

const COLUMNS: &str = "columns: axis, direction, run, position_mm, target_mm, ex_um, ex_mm … ec_urad, u_ex_um, deviation_um, actual_mm, up1_actual_mm …";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_name_is_its_end() {
        for name in ["Delta [mm]", "Delta (mm)", "delta_mm", "Delta / mm", "Fahrt in mm"] {
            assert_eq!(unit_of_name(name).map(|(_, unit)| unit), Some("mm"), "{name}");
        }
        assert_eq!(unit_of_name("Pitch [arcsec]"), Some(("Pitch ", "arcsec")));
        for name in ["Delta", "Run in", "Time [s]", "mm", "Delta_x"] {
            assert_eq!(unit_of_name(name), None, "{name}");
        }
    }
}
