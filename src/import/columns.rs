//! Any delimited text, by a mapping of its columns: `NAME=COLUMN,NAME=COLUMN`.
//!
//! `COLUMN` is a column of our error table (contract §2.1), which states content and unit at once;
//! or `target_mm`, `target_in` for positions that count from the instrument's zero; or `run`.
//! Separator `;`, tab or comma; quotation marks; a decimal comma unless the comma separates.

use crate::axis::{Axis, Direction};
use crate::document::Source;
use crate::error_table::DraftSeries;
use crate::import::lines::{Line, Word, lines};
use crate::import::placing::{Placing, mean, tidy};
use crate::import::stated::{Sign, Stated, Travel, Unit, missing};
use crate::import::{Component, Kind, Reading};
use crate::problem::{Problem, Problems, nearest, shown};
use crate::units::MM_PER_INCH;
use std::collections::BTreeMap;

const EXAMPLE: &str = "e.g. `--columns \"AXn [mm]=position_mm,Delta [mm]=ex_mm\"`";

pub(super) fn read(source: &Source, stated: &Stated) -> Result<Reading, Problems> {
    let Some(mapping) = &stated.columns else {
        return Err(missing(
            "--columns",
            "which column holds what cannot be seen from the file",
            &format!("add the mapping, {EXAMPLE}"),
        )
        .into());
    };
    let mapping = Mapping::read(mapping)?;
    let mut problems = Problems::none();
    let table = problems.take(Table::read(source, &mapping));
    mapping.refuse_double_statements(stated, &mut problems);
    let sign = stated.required_sign(&mut problems);
    mapping.require(stated, &mut problems);
    let Some(table) = table else {
        return Err(problems);
    };
    let rows = table.rows(&mapping, stated, &mut problems);
    let (Some(sign), true) = (sign, problems.is_empty()) else {
        return Err(problems);
    };
    let mut reading = Reading {
        facts: vec![format!(
            "table: its columns are named in line {}",
            table.header_line
        )],
        ..Reading::default()
    };
    let mut groups: BTreeMap<(Axis, Option<Direction>), Vec<&Row<'_>>> = BTreeMap::new();
    for row in &rows {
        groups
            .entry((row.axis, row.direction))
            .or_default()
            .push(row);
    }
    let first_target = rows.first().map_or(0.0, |row| row.position);
    let order = target_order(&rows, &mapping, &mut problems);
    for ((axis, direction), rows) in groups {
        let group = Group {
            mapping: &mapping,
            order,
            first_target,
            axis,
            direction,
            rows,
        };
        reading
            .series
            .extend(group.series(sign, stated, &mut reading.facts, &mut problems));
    }
    problems.or_ok(reading)
}

/// What a mapped column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Axis,
    Direction,
    Run,
    /// Machine coordinate.
    Position {
        to_mm: f64,
    },
    /// Counted from the instrument's zero.
    Target {
        to_mm: f64,
    },
    Value {
        kind: Kind,
        factor: f64,
    },
    Uncertainty {
        of: Axis,
        factor: f64,
    },
}

impl Content {
    fn is_number(&self) -> bool {
        !matches!(self, Content::Axis | Content::Direction | Content::Run)
    }
}

/// Microradians in one second of arc.
const ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0) * 1e6;

/// Every name that may stand behind `=`.
fn known_columns() -> Vec<(String, Content)> {
    let mut known = vec![
        ("axis".to_string(), Content::Axis),
        ("direction".to_string(), Content::Direction),
        ("run".to_string(), Content::Run),
    ];
    for (unit, to_mm) in [("mm", 1.0), ("in", MM_PER_INCH)] {
        known.push((format!("position_{unit}"), Content::Position { to_mm }));
        known.push((format!("target_{unit}"), Content::Target { to_mm }));
    }
    for of in Axis::ALL {
        for unit in [Unit::Um, Unit::Mm, Unit::In, Unit::Uin] {
            let (kind, factor) = (Kind::Deviation(of), unit.um());
            let name = format!("e{}_{}", of.key(), unit.word());
            known.push((format!("u_{name}"), Content::Uncertainty { of, factor }));
            known.push((name, Content::Value { kind, factor }));
        }
    }
    for (about, letter) in [(Axis::X, 'a'), (Axis::Y, 'b'), (Axis::Z, 'c')] {
        for (unit, factor) in [
            ("urad", 1.0),
            ("mrad", 1e3),
            ("rad", 1e6),
            ("arcsec", ARCSEC),
        ] {
            let kind = Kind::Angle(about);
            known.push((format!("e{letter}_{unit}"), Content::Value { kind, factor }));
        }
    }
    known
}

/// Names of the file's columns with what they hold.
struct Mapping {
    columns: Vec<(String, Content)>,
}

impl Mapping {
    fn read(text: &str) -> Result<Mapping, Problems> {
        let known = known_columns();
        let mut problems = Problems::none();
        let mut columns: Vec<(String, Content)> = Vec::new();
        for pair in pairs(text) {
            let Some((name, target)) = pair.rsplit_once('=') else {
                problems.push(
                    Problem::new(format!("`{}` of `--columns` has no `=`", shown(&pair)))
                        .help(format!("write NAME=COLUMN, {EXAMPLE}")),
                );
                continue;
            };
            let (name, target) = (name.trim(), target.trim());
            match known.iter().find(|(known, _)| known == target) {
                None => problems.push(unknown_target(target, &known)),
                Some((_, content)) if columns.iter().any(|(_, other)| same(*other, *content)) => {
                    problems.push(
                        Problem::new(format!(
                            "`{target}` of `--columns` gives the same as a column before it"
                        ))
                        .help("keep one of the two"),
                    );
                }
                Some((_, content)) => columns.push((name.to_string(), *content)),
            }
        }
        problems.or_ok(Mapping { columns })
    }

    fn has(&self, is: impl Fn(&Content) -> bool) -> bool {
        self.columns.iter().any(|(_, content)| is(content))
    }

    fn has_targets(&self) -> bool {
        self.has(|content| matches!(content, Content::Target { .. }))
    }

    /// What must be mapped or stated.
    fn require(&self, stated: &Stated, problems: &mut Problems) {
        if !self.has(|c| matches!(c, Content::Position { .. } | Content::Target { .. })) {
            problems.push(Problem::new("`--columns` maps no column to a position").help(
                "map one to `position_mm` (machine coordinate) or `target_mm` (counted from the laser's zero)",
            ));
        }
        if !self.has(|c| matches!(c, Content::Value { .. })) {
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
        if stated.travel.is_none() && !self.has(|c| *c == Content::Direction) {
            problems.push(missing(
                "--direction",
                "no column is mapped to the direction of travel",
                "add `--direction +`, `--direction -` or `--direction both` (not distinguished), or map a column to `direction`",
            ));
        }
    }

    /// Statements that the mapping makes already.
    fn refuse_double_statements(&self, stated: &Stated, problems: &mut Problems) {
        let mut refuse = |option: &str, mapped: &str| {
            problems.push(
                Problem::new(format!(
                    "`{option}` is stated, but the mapping gives `{mapped}`"
                ))
                .help("keep one of the two"),
            );
        };
        if stated.travel.is_some() && self.has(|c| *c == Content::Direction) {
            refuse("--direction", "direction");
        }
        if !self.has_targets() && self.has(|c| matches!(c, Content::Position { .. })) {
            if stated.first_target_at_mm.is_some() {
                refuse("--first-target-at-mm", "position");
            }
            if stated.targets_run.is_some() {
                refuse("--targets-run", "position");
            }
        }
        let both = self.has_targets() && self.has(|c| matches!(c, Content::Position { .. }));
        let repeated = self.has(|c| matches!(c, Content::Uncertainty { .. }))
            && self.has(|c| *c == Content::Run);
        if both {
            refuse("target", "position");
        }
        if repeated {
            refuse("an uncertainty", "run");
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

/// Whether two columns give the same quantity, whatever their units.
fn same(a: Content, b: Content) -> bool {
    match (a, b) {
        (Content::Value { kind: a, .. }, Content::Value { kind: b, .. }) => a == b,
        (Content::Uncertainty { of: a, .. }, Content::Uncertainty { of: b, .. }) => a == b,
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

/// The part of the file below the names of its columns.
struct Table<'a> {
    header_line: usize,
    lines: Vec<Line<'a>>,
    delimiter: char,
    width: usize,
    /// For each mapped column: its place in a row.
    indices: Vec<usize>,
}

impl<'a> Table<'a> {
    fn read(source: &'a Source, mapping: &Mapping) -> Result<Table<'a>, Problems> {
        let lines = lines(source);
        for (at, line) in lines.iter().enumerate() {
            let delimiter = [';', '\t', ',']
                .into_iter()
                .find(|d| line.text.contains(*d));
            let Some(delimiter) = delimiter else {
                continue;
            };
            let cells = cells(line, delimiter);
            let index = |name: &String| cells.iter().position(|cell| cell.text == name);
            let indices: Option<Vec<usize>> = mapping
                .columns
                .iter()
                .map(|(name, _)| index(name))
                .collect();
            if let Some(indices) = indices {
                return Ok(Table {
                    header_line: at + 1,
                    lines: lines[at + 1..].to_vec(),
                    delimiter,
                    width: cells.len(),
                    indices,
                });
            }
        }
        Err(no_header(&lines, mapping))
    }

    fn rows(&self, mapping: &Mapping, stated: &Stated, problems: &mut Problems) -> Vec<Row<'a>> {
        let mut rows = Vec::new();
        let mut with_comma = None;
        for line in &self.lines {
            let empty = |c: char| c == self.delimiter || c == '"' || c.is_whitespace();
            if line.text.chars().all(empty) {
                continue;
            }
            let cells = cells(line, self.delimiter);
            if cells.len() != self.width {
                problems.push_with(|| {
                    Problem::new(format!("the row has {} cells, expected {} as in line {}", cells.len(), self.width, self.header_line))
                        .at(line.place())
                        .help("a decimal comma needs another separator between the columns; remove what does not belong to the table")
                });
                continue;
            }
            let chosen: Vec<Word<'a>> = self.indices.iter().map(|index| cells[*index]).collect();
            for cell in chosen
                .iter()
                .zip(&mapping.columns)
                .filter(|(_, (_, c))| c.is_number())
            {
                refuse_mixed_decimals(&mut with_comma, cell.0, problems);
            }
            rows.extend(Row::read(line, &chosen, mapping, stated, problems));
        }
        rows
    }
}

/// One file writes its decimals in one way; else a comma may stand between thousands.
fn refuse_mixed_decimals(with_comma: &mut Option<bool>, cell: &Word<'_>, problems: &mut Problems) {
    let (comma, point) = (cell.text.contains(','), cell.text.contains('.'));
    if comma == point {
        return; // none, or a number that is refused anyway
    }
    if *with_comma.get_or_insert(comma) != comma {
        problems.push_with(|| {
            Problem::new(format!(
                "`{}` has another decimal separator than the numbers above it",
                shown(cell.text)
            ))
            .at(cell.place())
            .help("write all numbers with a decimal point or all with a comma, and nothing between thousands")
        });
    }
}

/// The line that comes nearest to the names of the mapping shows what is missing.
fn no_header(lines: &[Line<'_>], mapping: &Mapping) -> Problems {
    let found_in = |line: &Line<'_>| {
        let names = mapping.columns.iter();
        names
            .filter(|(name, _)| line.text.contains(name.as_str()))
            .count()
    };
    let first = lines.iter().position(|line| !line.is_blank()).unwrap_or(0);
    let best = (0..lines.len())
        .rev()
        .max_by_key(|at| found_in(&lines[*at]));
    let best = best.filter(|at| found_in(&lines[*at]) > 0).unwrap_or(first);
    let mut problems = Problems::none();
    for (name, _) in &mapping.columns {
        if !lines[best].text.contains(name.as_str()) {
            problems.push(
                Problem::new(format!("the file has no column `{}`", shown(name)))
                    .at(lines[best].place())
                    .help("copy the names for `--columns` from the file, letter by letter"),
            );
        }
    }
    if problems.is_empty() {
        problems.push(
            Problem::new("the names of `--columns` do not stand in one line as separated cells")
                .at(lines[best].place())
                .help("the separator is `;`, a tab or a comma"),
        );
    }
    problems
}

/// Cells without blanks and quotation marks around them.
fn cells<'a>(line: &Line<'a>, delimiter: char) -> Vec<Word<'a>> {
    let mut cells = Vec::new();
    let (mut start, mut quoted) = (0, false);
    for (at, c) in line.text.char_indices() {
        quoted ^= c == '"';
        if c == delimiter && !quoted {
            cells.push(cell(line, start, at));
            start = at + c.len_utf8();
        }
    }
    cells.push(cell(line, start, line.text.len()));
    cells
}

fn cell<'a>(line: &Line<'a>, start: usize, end: usize) -> Word<'a> {
    let text = &line.text[start..end];
    let inside = text.trim();
    let is_quoted = inside.len() >= 2 && inside.starts_with('"') && inside.ends_with('"');
    if !is_quoted {
        return line.part(start, end);
    }
    let from = start + text.find('"').unwrap_or(0) + 1;
    line.part(from, from + inside.len() - 2)
}

/// A row whose mapped cells could be read.
struct Row<'a> {
    line: Line<'a>,
    axis: Axis,
    direction: Option<Direction>,
    run: usize,
    /// mm.
    position: f64,
    /// Of each mapped column; only those of values and uncertainties have one.
    numbers: Vec<Option<f64>>,
}

impl<'a> Row<'a> {
    fn read(
        line: &Line<'a>,
        cells: &[Word<'a>],
        mapping: &Mapping,
        stated: &Stated,
        problems: &mut Problems,
    ) -> Option<Row<'a>> {
        let mut axis = stated.axis;
        let mut direction = match stated.travel {
            Some(Travel::One(direction)) => Some(direction),
            _ => None,
        };
        let (mut run, mut position) = (1, None);
        let mut numbers = Vec::new();
        for (cell, (name, content)) in cells.iter().zip(&mapping.columns) {
            let mut number = None;
            match content {
                Content::Axis => axis = row_axis(cell, stated.axis, problems),
                Content::Direction => direction = Some(row_direction(cell, problems)?),
                Content::Run => run = cell.count(&format!("`{name}`"), problems)?,
                Content::Position { to_mm } | Content::Target { to_mm } => {
                    position = Some(cell.number_or_comma(&format!("`{name}`"), problems)? * to_mm);
                }
                Content::Value { factor, .. } | Content::Uncertainty { factor, .. } => {
                    number = Some(cell.number_or_comma(&format!("`{name}`"), problems)? * factor);
                }
            }
            numbers.push(number);
        }
        Some(Row {
            line: *line,
            axis: axis?,
            direction,
            run,
            position: position?,
            numbers,
        })
    }
}

fn row_axis(cell: &Word<'_>, stated: Option<Axis>, problems: &mut Problems) -> Option<Axis> {
    let axis = Axis::from_letter(cell.text);
    let message = match (axis, stated) {
        (None, _) => format!("the axis is `{}`, expected X, Y or Z", shown(cell.text)),
        (Some(axis), Some(stated)) if axis != stated => {
            format!(
                "the file says axis {axis}, but `--axis {}` was stated",
                stated.key()
            )
        }
        _ => return axis,
    };
    problems.push_with(|| {
        Problem::new(message)
            .at(cell.place())
            .help("leave `--axis` out, or take the right file")
    });
    None
}

fn row_direction(cell: &Word<'_>, problems: &mut Problems) -> Option<Direction> {
    let direction = Direction::from_symbol(cell.text);
    if direction.is_none() {
        problems.push_with(|| {
            Problem::new(format!(
                "the direction is `{}`, expected `+` or `-`",
                shown(cell.text)
            ))
            .at(cell.place())
            .help("write the direction in which the axis moved, in machine coordinates")
        });
    }
    direction
}

/// Order of the targets from the first one of the file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Order {
    Ascending,
    Descending,
}

/// The first row of the file holds its first target: one end, the same for every group of rows.
fn target_order(rows: &[Row<'_>], mapping: &Mapping, problems: &mut Problems) -> Order {
    let Some(first) = rows.first().filter(|_| mapping.has_targets()) else {
        return Order::Ascending;
    };
    if let Some(other) = rows.iter().find(|row| row.axis != first.axis) {
        problems.push(
            Problem::new(
                "targets of two axes stand in one file, but one first target can be stated only",
            )
            .at(other.line.place())
            .help("import one axis at a time, or map machine coordinates to `position_mm`"),
        );
    }
    let ends = |row: &Row<'_>| (row.position - first.position).total_cmp(&0.0);
    if rows.iter().all(|row| ends(row).is_ge()) {
        return Order::Ascending;
    }
    if !rows.iter().all(|row| ends(row).is_le()) {
        problems.push(
            Problem::new(
                "the first row is not at an end of the targets, so the first target is not known",
            )
            .at(first.line.place())
            .help("sort the rows, beginning with target 1"),
        );
    }
    Order::Descending
}

/// Rows of one axis and direction.
struct Group<'a, 'b> {
    mapping: &'b Mapping,
    order: Order,
    /// The first target of the file, mm.
    first_target: f64,
    axis: Axis,
    direction: Option<Direction>,
    rows: Vec<&'b Row<'a>>,
}

impl<'a, 'b> Group<'a, 'b> {
    fn series(
        &self,
        sign: Sign,
        stated: &Stated,
        facts: &mut Vec<String>,
        problems: &mut Problems,
    ) -> Option<DraftSeries> {
        let runs = self.runs(problems)?;
        let first = runs.first()?;
        let positions: Vec<f64> = first.iter().map(|row| row.position).collect();
        let placing = if self.mapping.has_targets() {
            let at = first.first()?.line.place();
            if (positions.first()? - self.first_target).abs() > 1e-9 {
                problems.push(
                    Problem::new("these rows do not begin with the first target of the file")
                        .at(at)
                        .help("a missing value is never filled in: leave the run out"),
                );
                return None;
            }
            let placing = Placing::of(&positions, &at, stated, problems)?;
            facts.extend(placing.words(None));
            Some(placing)
        } else {
            None
        };
        if runs.len() > 1 {
            let travel = self.direction.map_or("both", Direction::symbol);
            facts.push(format!(
                "runs: {} of {}, direction {travel}; their mean, u = s/√runs (k = 1)",
                runs.len(),
                self.axis
            ));
        }
        let mm = placing.as_ref().map_or_else(
            || positions.iter().map(|mm| tidy(*mm)).collect(),
            Placing::positions_mm,
        );
        let mut series = DraftSeries::new(self.axis, self.direction, mm);
        for (index, (_, content)) in self.mapping.columns.iter().enumerate() {
            self.put(
                &mut series,
                index,
                *content,
                &runs,
                (sign, placing.as_ref()),
            );
        }
        Some(series)
    }

    /// The rows of each run, in the order of their positions; all runs at the same positions.
    fn runs(&self, problems: &mut Problems) -> Option<Vec<Vec<&'b Row<'a>>>> {
        let mut runs: BTreeMap<usize, Vec<&'b Row<'a>>> = BTreeMap::new();
        for row in &self.rows {
            runs.entry(row.run).or_default().push(row);
        }
        let mut runs: Vec<Vec<&'b Row<'a>>> = runs.into_values().collect();
        for run in &mut runs {
            run.sort_by(|a, b| a.position.total_cmp(&b.position));
            if self.order == Order::Descending {
                run.reverse();
            }
        }
        let before = problems.is_empty();
        for run in &runs {
            for pair in run
                .windows(2)
                .filter(|pair| pair[0].position.total_cmp(&pair[1].position).is_eq())
            {
                problems.push_with(|| {
                    Problem::new(format!("position {} stands twice", pair[1].position))
                        .at(pair[1].line.place())
                        .help("map the number of the run (`…=run`) or the direction of travel (`…=direction`), or leave one row out")
                });
            }
            let first = runs.first()?;
            if run.len() != first.len()
                || run
                    .iter()
                    .zip(first)
                    .any(|(a, b)| (a.position - b.position).abs() > 1e-9)
            {
                let row = run.first()?;
                problems.push_with(|| {
                    Problem::new(format!(
                        "run {} does not have the positions of the first run",
                        row.run
                    ))
                    .at(row.line.place())
                    .help("a missing value is never filled in: leave the run out")
                });
            }
        }
        if let ([run], true) = (&runs[..], before)
            && run.len() < 2
        {
            problems.push(
                Problem::new(format!(
                    "axis {} has a single position, expected at least two",
                    self.axis
                ))
                .at(run.first()?.line.place())
                .help("one position makes no curve"),
            );
        }
        (before && problems.is_empty()).then_some(runs)
    }

    fn put(
        &self,
        series: &mut DraftSeries,
        index: usize,
        content: Content,
        runs: &[Vec<&Row<'_>>],
        (sign, placing): (Sign, Option<&Placing>),
    ) {
        let points = runs.first().map_or(0, Vec::len);
        let figures: Vec<(f64, Option<f64>)> = (0..points)
            .map(|point| {
                let values = runs.iter().filter_map(|run| run.get(point)?.numbers[index]);
                mean(&values.collect::<Vec<f64>>())
            })
            .collect();
        let means: Vec<f64> = figures.iter().map(|(mean, _)| *mean).collect();
        let uncertainties = |u: &[f64]| {
            placing.map_or_else(
                || u.iter().map(|u| tidy(*u)).collect(),
                |p| p.uncertainties(u),
            )
        };
        match content {
            Content::Value { kind, .. } => {
                let component = Component {
                    kind,
                    along: self.axis,
                };
                let values = placing.map_or_else(
                    || {
                        means
                            .iter()
                            .map(|value| tidy(sign.deviation(*value)))
                            .collect()
                    },
                    |placing| placing.deviations(&means, component, sign),
                );
                component.put(series, values);
                let spread: Option<Vec<f64>> = figures.iter().map(|(_, u)| *u).collect();
                if let (Kind::Deviation(of), Some(u)) = (kind, spread) {
                    series.uncertainties_um[of] = Some(uncertainties(&u));
                }
            }
            Content::Uncertainty { of, .. } => {
                series.uncertainties_um[of] = Some(uncertainties(&means))
            }
            _ => {}
        }
    }
}
