//! `--columns "NAME=COLUMN,…"`: which column of a delimited text holds what.
//!
//! `NAME` is a column as the file writes it, or `#3` for the third one. `COLUMN` is a column of our
//! error table (contract §2.1), which states content and unit at once; or `target_mm`, `target_in`
//! for positions that count from the instrument's zero; or `run`.

use crate::inputs::import::Kind;
use crate::inputs::import::stated::{Stated, missing};
use crate::quantity::axis::Axis;
use crate::quantity::units::UM_PER_MM;
use crate::text::delimited::LengthUnit;
use crate::text::problem::{Problem, Problems, nearest, shown};

pub(super) const EXAMPLE: &str = "e.g. `--columns \"AXn [mm]=position_mm,Delta [mm]=ex_mm\"`";

/// A unit of angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AngleUnit {
    Urad,
    Mrad,
    Rad,
    Arcsec,
}

impl AngleUnit {
    const ALL: [AngleUnit; 4] = [
        AngleUnit::Urad,
        AngleUnit::Mrad,
        AngleUnit::Rad,
        AngleUnit::Arcsec,
    ];

    const fn word(self) -> &'static str {
        match self {
            AngleUnit::Urad => "urad",
            AngleUnit::Mrad => "mrad",
            AngleUnit::Rad => "rad",
            AngleUnit::Arcsec => "arcsec",
        }
    }

    const fn urad(self) -> f64 {
        match self {
            AngleUnit::Urad => 1.0,
            AngleUnit::Mrad => 1e3,
            AngleUnit::Rad => 1e6,
            AngleUnit::Arcsec => std::f64::consts::PI / (180.0 * 3600.0) * 1e6,
        }
    }

    fn from_text(text: &str) -> Option<AngleUnit> {
        match text.trim().to_lowercase().as_str() {
            "urad" | "µrad" | "μrad" => Some(AngleUnit::Urad),
            "mrad" => Some(AngleUnit::Mrad),
            "rad" => Some(AngleUnit::Rad),
            "arcsec" | "\"" | "arc sec" => Some(AngleUnit::Arcsec),
            _ => None,
        }
    }
}

/// The unit of a column of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    Length(LengthUnit),
    Angle(AngleUnit),
}

impl Unit {
    pub(super) const fn word(self) -> &'static str {
        match self {
            Unit::Length(unit) => unit.word(),
            Unit::Angle(unit) => unit.word(),
        }
    }

    fn from_text(text: &str) -> Option<Unit> {
        let length = LengthUnit::from_text(text).map(Unit::Length);
        length.or_else(|| AngleUnit::from_text(text).map(Unit::Angle))
    }

    /// The unit that the name of a column ends with: `Delta [mm]`, `Delta (mm)`, `delta_mm`,
    /// `Delta / mm`, `Delta mm`. A last word `in` may be a word of the language.
    pub(super) fn of_name(name: &str) -> Option<Unit> {
        let name = name.trim();
        for (open, close) in [('[', ']'), ('(', ')')] {
            let inside = name.strip_suffix(close).and_then(|n| n.rsplit_once(open));
            if let Some((_, unit)) = inside {
                return Unit::from_text(unit);
            }
        }
        if let Some((_, unit)) = name.rsplit_once(['_', '/']) {
            return Unit::from_text(unit);
        }
        let (_, unit) = name.rsplit_once(' ')?;
        Unit::from_text(unit).filter(|_| unit != "in")
    }
}

/// What a mapped column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
    Axis,
    Direction,
    Run,
    /// Machine coordinate.
    Position(LengthUnit),
    /// Counted from the instrument's zero.
    Target(LengthUnit),
    Value(Kind, Unit),
    Uncertainty(Axis, LengthUnit),
}

impl Content {
    /// The unit of its numbers; none where it holds words or counts.
    pub(super) fn unit(self) -> Option<Unit> {
        match self {
            Content::Axis | Content::Direction | Content::Run => None,
            Content::Position(unit) | Content::Target(unit) | Content::Uncertainty(_, unit) => {
                Some(Unit::Length(unit))
            }
            Content::Value(_, unit) => Some(unit),
        }
    }

    /// A number of the column in our unit: mm for places, µm for deviations, µrad for angles.
    pub(super) fn converted(self, number: f64) -> f64 {
        match (self, self.unit()) {
            (Content::Position(LengthUnit::Mm) | Content::Target(LengthUnit::Mm), _) => number,
            (Content::Position(unit) | Content::Target(unit), _) => number * unit.um() / UM_PER_MM,
            (_, Some(Unit::Length(unit))) => number * unit.um(),
            (_, Some(Unit::Angle(unit))) => number * unit.urad(),
            (_, None) => number,
        }
    }
}

/// Every name that may stand behind `=`.
fn known_columns() -> Vec<(String, Content)> {
    let mut known = vec![
        ("axis".to_string(), Content::Axis),
        ("direction".to_string(), Content::Direction),
        ("run".to_string(), Content::Run),
    ];
    for unit in [LengthUnit::Mm, LengthUnit::In] {
        let word = unit.word();
        known.push((format!("position_{word}"), Content::Position(unit)));
        known.push((format!("target_{word}"), Content::Target(unit)));
    }
    for of in Axis::ALL {
        for unit in LengthUnit::ALL {
            let name = format!("e{}_{}", of.key(), unit.word());
            known.push((format!("u_{name}"), Content::Uncertainty(of, unit)));
            let kind = Kind::Deviation(of);
            known.push((name, Content::Value(kind, Unit::Length(unit))));
        }
    }
    for (about, letter) in [(Axis::X, 'a'), (Axis::Y, 'b'), (Axis::Z, 'c')] {
        for unit in AngleUnit::ALL {
            let content = Content::Value(Kind::Angle(about), Unit::Angle(unit));
            known.push((format!("e{letter}_{}", unit.word()), content));
        }
    }
    known
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
    fn from_text(text: &str) -> Named {
        let number = text.strip_prefix('#').and_then(|n| n.trim().parse().ok());
        number.map_or_else(|| Named::Text(text.to_string()), Named::Number)
    }
}

/// Names of the file's columns with what they hold.
pub(super) struct Mapping {
    pub(super) columns: Vec<(Named, Content)>,
}

impl Mapping {
    pub(super) fn read(text: &str) -> Result<Mapping, Problems> {
        let known = known_columns();
        let mut problems = Problems::none();
        let mut columns: Vec<(Named, Content)> = Vec::new();
        for pair in pairs(text) {
            let Some((name, target)) = pair.rsplit_once('=') else {
                problems.push(
                    Problem::new(format!("`{}` of `--columns` has no `=`", shown(&pair)))
                        .help(format!("write NAME=COLUMN, {EXAMPLE}")),
                );
                continue;
            };
            let (name, target) = (Named::from_text(name.trim()), target.trim());
            match known.iter().find(|(known, _)| known == target) {
                None => problems.push(unknown_target(target, &known)),
                Some((_, content)) => {
                    refuse_twice(&columns, &name, *content, target, &mut problems);
                    columns.push((name, *content));
                }
            }
        }
        if columns.iter().all(|(n, _)| matches!(n, Named::Number(_))) && problems.is_empty() {
            problems.push(
                Problem::new(
                    "`--columns` names no column, so the line above the numbers cannot be found",
                )
                .help(format!("give at least one column by its name, {EXAMPLE}")),
            );
        }
        problems.or_ok(Mapping { columns })
    }

    pub(super) fn has(&self, is: impl Fn(&Content) -> bool) -> bool {
        self.columns.iter().any(|(_, content)| is(content))
    }

    pub(super) fn has_targets(&self) -> bool {
        self.has(|content| matches!(content, Content::Target(_)))
    }

    fn has_positions(&self) -> bool {
        self.has(|content| matches!(content, Content::Position(_)))
    }

    pub(super) fn has_directions(&self) -> bool {
        self.has(|content| *content == Content::Direction)
    }

    /// What must be mapped or stated.
    pub(super) fn require(&self, stated: &Stated, problems: &mut Problems) {
        if !self.has_positions() && !self.has_targets() {
            problems.push(Problem::new("`--columns` maps no column to a position").help(
                "map one to `position_mm` (machine coordinate) or `target_mm` (counted from the laser's zero)",
            ));
        }
        if !self.has(|c| matches!(c, Content::Value(..))) {
            problems.push(
                Problem::new("`--columns` maps no column to a deviation")
                    .help("map one to `ex_um`, `ex_mm`, `ey_um` … `ec_urad`"),
            );
        }
        if stated.axis.is_none() && !self.has(|c| *c == Content::Axis) {
            problems.push(missing(
                "--axis",
                "no column is mapped to the moving axis",
                "add e.g. `--axis x`, or map a column to `axis`",
            ));
        }
        if stated.travel.is_none() && !self.has_directions() {
            problems.push(missing(
                "--direction",
                "no column is mapped to the direction of travel",
                "add `--direction +`, `--direction -` or `--direction both` (not distinguished), or map a column to `direction`",
            ));
        }
    }

    /// Statements that the mapping makes already, or that it gives no meaning.
    pub(super) fn refuse_double_statements(&self, stated: &Stated, problems: &mut Problems) {
        let mut refuse = |option: &str, mapped: &str| {
            problems.push(
                Problem::new(format!(
                    "`{option}` is stated, but the mapping gives `{mapped}`"
                ))
                .help("keep one of the two"),
            );
        };
        if stated.travel.is_some() && self.has_directions() {
            refuse("--direction", "direction");
        }
        if !self.has_targets() && self.has_positions() {
            if stated.first_target_at_mm.is_some() {
                refuse("--first-target-at-mm", "position");
            }
            if stated.targets_run.is_some() {
                refuse("--targets-run", "position");
            }
        }
        if self.has_targets() && self.has_positions() {
            refuse("target", "position");
        }
        if self.has(|c| matches!(c, Content::Uncertainty(..))) && self.has(|c| *c == Content::Run) {
            refuse("an uncertainty", "run");
        }
        if stated.plus_moves.is_some() && !self.has_directions() {
            problems.push(
                Problem::new("`--plus-moves` is stated, but no column is mapped to `direction`")
                    .help("leave it out, or map the column whose `+` it explains"),
            );
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

/// One column has one meaning, and one meaning stands in one column.
fn refuse_twice(
    columns: &[(Named, Content)],
    name: &Named,
    content: Content,
    target: &str,
    problems: &mut Problems,
) {
    if columns.iter().any(|(_, other)| same(*other, content)) {
        problems.push(
            Problem::new(format!(
                "`{target}` of `--columns` gives the same as a column before it"
            ))
            .help("keep one of the two"),
        );
    }
    if columns.iter().any(|(other, _)| other == name) {
        problems.push(
            Problem::new(format!(
                "the column mapped to `{target}` is mapped to something else before"
            ))
            .help("a column holds one thing: map each once"),
        );
    }
}

/// Whether two columns give the same quantity, whatever their units.
fn same(a: Content, b: Content) -> bool {
    match (a, b) {
        (Content::Value(a, _), Content::Value(b, _)) => a == b,
        (Content::Uncertainty(a, _), Content::Uncertainty(b, _)) => a == b,
        _ => std::mem::discriminant(&a) == std::mem::discriminant(&b),
    }
}

fn unknown_target(target: &str, known: &[(String, Content)]) -> Problem {
    let names = known.iter().map(|(name, _)| name.as_str());
    let help = nearest(target, names).map_or_else(
        || "columns: axis, direction, run, position_mm, target_mm, ex_um, ex_mm … ec_urad, u_ex_um …".to_string(),
        |near| format!("did you mean `{near}`?"),
    );
    Problem::new(format!("unknown column `{}` in `--columns`", shown(target))).help(help)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_name_is_its_end() {
        let mm = Some(Unit::Length(LengthUnit::Mm));
        for name in [
            "Delta [mm]",
            "Delta (mm)",
            "delta_mm",
            "Delta / mm",
            "Fahrt in mm",
        ] {
            assert_eq!(Unit::of_name(name), mm, "{name}");
        }
        assert_eq!(
            Unit::of_name("Pitch [arcsec]"),
            Some(Unit::Angle(AngleUnit::Arcsec))
        );
        for name in ["Delta", "Run in", "Time [s]", "mm", "Delta_x"] {
            assert_eq!(Unit::of_name(name), None, "{name}");
        }
    }
}
