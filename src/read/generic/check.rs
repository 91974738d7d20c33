//! What a row of the generic table must be, and what the rows must be to each other.

use super::refusals;
use crate::quantity::{Axis, Direction, ErrorTerm};
use crate::read::emulate::step_of;
use crate::text::{Problem, Problems};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Two increments closer than this are the same, µm: the rounding of a difference of two
/// corrections, far below any count of a control.
const SAME_INCREMENT_UM: f64 = 1e-9;
/// Part of a position by which it may be from its equally spaced place, for its rounding.
const OFF_GRID_RELATIVE: f64 = 1e-9;
/// Names of axes in one file; no control has more.
const MOST_AXES: usize = 32;

/// Nobody reads further.
const MOST_RELATIONS: usize = 200;

/// One row: one point of one term (and direction).
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with the nine columns as keys")]
pub struct GenericRow {
    /// Which error, by its name.
    pub term: String,
    /// Name of the moving axis.
    pub base_axis: String,
    /// Name of the corrected axis.
    pub output_axis: String,
    /// Direction of the moving axis the row is for, `+` or `-`; `None` = both.
    #[serde(deserialize_with = "Option::deserialize")] // the key has to be there
    pub direction: Option<String>,
    /// Index of the point, from 0.
    pub index: u32,
    /// Machine coordinate, mm.
    pub position_mm: f64,
    /// Deviation relative to the reference, µm.
    pub deviation_um: f64,
    /// Correction, µm.
    pub correction_um: f64,
    /// Change of the correction from the point before, µm; `None` at the first.
    #[serde(deserialize_with = "Option::deserialize")]
    pub increment_um: Option<f64>,
}

impl GenericRow {
    /// Its error; every row that was checked has one.
    pub fn term(&self) -> Option<ErrorTerm> {
        ErrorTerm::from_name(&self.term)
    }

    /// Its direction.
    pub(super) fn way(&self) -> Option<Direction> {
        self.direction.as_deref().and_then(Direction::from_symbol)
    }

    /// `EYX+ from `X` to `Y`, index 3`.
    pub(super) fn name(&self) -> String {
        let GenericRow { term, base_axis, output_axis, index, .. } = self;
        let direction = self.direction.as_deref().unwrap_or_default();
        format!("{term}{direction} from `{base_axis}` to `{output_axis}`, index {index}")
    }

    /// Its cells as text, in the order of the columns; different numbers have different texts.
    pub(super) fn texts(&self) -> [String; 9] {
        [
            self.term.clone(),
            self.base_axis.clone(),
            self.output_axis.clone(),
            self.direction.clone().unwrap_or_default(),
            self.index.to_string(),
            self.position_mm.to_string(),
            self.deviation_um.to_string(),
            self.correction_um.to_string(),
            self.increment_um.map_or(String::new(), |um| um.to_string()),
        ]
    }
}

/// What is wrong with a row, counted from 0, and the column it is shown at.
pub(super) struct Flaw {
    pub(super) row: usize,
    pub(super) column: &'static str,
    pub(super) problem: Problem,
}

impl Flaw {
    fn new(row: usize, column: &'static str, problem: Problem) -> Flaw {
        Flaw { row, column, problem }
    }
}

/// These rows, each as it has to be. What the rows are to each other is told where each of them can be read: a
/// row that is lost would only be missed there again. `problem` knows the places of the form.
pub(super) fn checked(
    read: impl Iterator<Item = Result<GenericRow, Problems>>,
    problem: impl Fn(Flaw) -> Problem,
) -> Result<Vec<GenericRow>, Problems> {
    let mut problems = Problems::none();
    let (mut rows, mut flaws) = (Vec::new(), Vec::new());
    for (number, row) in read.enumerate() {
        if problems.is_full() {
            break;
        }
        if let Some(row) = problems.take(row) {
            check(number, &row, &mut flaws);
            rows.push(row);
        }
        flaws.drain(..).for_each(|flaw| problems.push(problem(flaw)));
    }
    if problems.is_empty() {
        flaws = relations(&rows);
        flaws.sort_by_key(|flaw| flaw.row);
        flaws.truncate(MOST_RELATIONS);
        flaws.into_iter().for_each(|flaw| problems.push(problem(flaw)));
    }
    problems.or_ok(rows)
}

/// Notes what is wrong inside a row.
fn check(number: usize, row: &GenericRow, flaws: &mut Vec<Flaw>) {
    let mut flaw = |column, problem| flaws.push(Flaw::new(number, column, problem));
    if row.term().is_none() {
        let names = ErrorTerm::ALL.map(|term| term.to_string()).join(" ");
        flaw("term", refusals::other_term(&row.term, names));
    }
    refuse_nameless_axes(row, &mut flaw);
    if let (Some(symbol), None) = (&row.direction, row.way()) {
        flaw("direction", refusals::other_direction(symbol));
    }
    refuse_other_values(row, &mut flaw);
}

fn refuse_nameless_axes(row: &GenericRow, flaw: &mut impl FnMut(&'static str, Problem)) {
    let is_name = |name: &str| {
        !name.trim().is_empty() && !name.contains(|c: char| c.is_control() || c == '"')
    };
    for (column, name) in [("base_axis", &row.base_axis), ("output_axis", &row.output_axis)] {
        if !is_name(name) {
            flaw(column, refusals::nameless_axis(column, name));
        }
    }
}

/// A correction that is not the opposite of its deviation, and an increment at the wrong place.
fn refuse_other_values(row: &GenericRow, flaw: &mut impl FnMut(&'static str, Problem)) {
    if (row.deviation_um + row.correction_um).abs() > 0.0 {
        let opposite = 0.0 - row.deviation_um;
        flaw("correction_um", refusals::not_opposite(row.correction_um, opposite));
    }
    match (row.index, row.increment_um) {
        (0, Some(um)) => flaw("increment_um", refusals::first_increment(um)),
        (1.., None) => flaw("increment_um", refusals::no_increment()),
        _ => {}
    }
}

/// What the rows are to each other: one axis for each name, and equal steps in each block.
fn relations(rows: &[GenericRow]) -> Vec<Flaw> {
    let mut flaws = names(rows);
    let mut blocks = Blocks::new();
    for (number, row) in rows.iter().enumerate() {
        let axes = [&row.base_axis, &row.output_axis].map(|name| name.to_ascii_uppercase());
        blocks.entry((row.term(), axes, row.way())).or_default().push(number);
    }
    for block in blocks.values() {
        let before = flaws.len();
        flaws.extend(index_flaw(rows, block));
        if flaws.len() == before {
            flaws.extend(step_flaws(rows, block));
        }
        if flaws.len() == before {
            flaws.extend(spacing_flaw(rows, block));
        }
    }
    if flaws.is_empty() {
        flaws.extend(blocks.keys().filter_map(|own| direction_flaw(rows, &blocks, own)));
    }
    flaws
}

/// The blocks of a file by term, axes and direction, each with its rows.
type Blocks = BTreeMap<Whose, Vec<usize>>;
type Whose = (Option<ErrorTerm>, [String; 2], Option<Direction>);

/// What a block of one direction contradicts: one for both directions, or that of the other one.
fn direction_flaw(rows: &[GenericRow], blocks: &Blocks, (term, axes, way): &Whose) -> Option<Flaw> {
    let of = |way| blocks.get(&(*term, axes.clone(), way));
    let (own, other) = (of(*way)?, of(Some((*way)?.opposite())));
    if let Some(both) = of(None) {
        let row = own[0].max(both[0]);
        let GenericRow { base_axis, output_axis, .. } = &rows[row];
        let wrong = refusals::with_and_without(base_axis, output_axis);
        return Some(Flaw::new(row, "direction", wrong));
    }
    let at = |row: &usize| rows[*row].position_mm;
    let same = own.iter().zip(other?).take_while(|(a, b)| (at(a) - at(b)).abs() <= 0.0).count();
    let row = *own.get(same).filter(|_| own.len() >= other.map_or(0, Vec::len))?;
    Some(Flaw::new(row, "position_mm", refusals::one_way_position()))
}

/// The name of an axis stands for one axis of the machine; so a pair of axes has one term,
/// and a straightness cannot act on its own moving axis.
fn names(rows: &[GenericRow]) -> Vec<Flaw> {
    let mut flaws = Vec::new();
    let mut known: Vec<(&str, Axis)> = Vec::new();
    let terms = rows.iter().enumerate().filter_map(|(n, row)| Some((n, row, row.term()?)));
    for (number, row, term) in terms {
        for (column, name, axis) in [
            ("base_axis", row.base_axis.as_str(), term.along),
            ("output_axis", row.output_axis.as_str(), term.of),
        ] {
            match known.iter().find(|(met, _)| met.eq_ignore_ascii_case(name)) {
                None if known.len() == MOST_AXES => {
                    flaws.push(Flaw::new(number, column, refusals::another_axis(name, MOST_AXES)));
                    return flaws;
                }
                None => known.push((name, axis)),
                Some((_, other)) if *other == axis => {}
                Some((_, other)) => {
                    let wrong = refusals::two_axes(name, axis, &row.term, other);
                    flaws.push(Flaw::new(number, column, wrong));
                }
            }
        }
    }
    flaws
}

/// The first row that is not the next one of its block, or a block of one row.
fn index_flaw(rows: &[GenericRow], block: &[usize]) -> Option<Flaw> {
    let mut counted = block.iter().zip(0_u32..);
    if let Some((row, expected)) = counted.find(|(row, expected)| rows[**row].index != *expected) {
        return Some(Flaw::new(*row, "index", refusals::not_next(rows[*row].index, expected)));
    }
    let [only] = block else {
        return None;
    };
    Some(Flaw::new(*only, "term", refusals::one_point()))
}

/// Rows that do not lie behind the one before, or whose increment is not the change.
fn step_flaws(rows: &[GenericRow], block: &[usize]) -> impl Iterator<Item = Flaw> {
    block.windows(2).filter_map(|pair| {
        let (before, row) = (&rows[pair[0]], &rows[pair[1]]);
        let (from, to) = (before.position_mm, row.position_mm);
        if to <= from {
            return Some(Flaw::new(pair[1], "position_mm", refusals::not_behind(to, from)));
        }
        let change = row.correction_um - before.correction_um;
        let increment = row.increment_um?;
        let other = || refusals::other_increment(increment, change);
        ((increment - change).abs() > SAME_INCREMENT_UM)
            .then(|| Flaw::new(pair[1], "increment_um", other()))
    })
}

/// The row with the most unusual step, if the positions are not equally spaced.
fn spacing_flaw(rows: &[GenericRow], block: &[usize]) -> Option<Flaw> {
    let at: Vec<f64> = block.iter().map(|row| rows[*row].position_mm).collect();
    if step_of(&at, OFF_GRID_RELATIVE).is_some() {
        return None;
    }
    let steps: Vec<f64> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    // Of two middle ones the smaller, as a missing row makes a step longer.
    let usual = *sorted.get(sorted.len().saturating_sub(1) / 2)?;
    let off = |step: &f64| (step - usual).abs();
    let worst = (0..steps.len())
        .rev() // the first of equal ones
        .max_by(|a, b| off(&steps[*a]).total_cmp(&off(&steps[*b])))?;
    let wrong = refusals::other_spacing(steps[worst], usual);
    Some(Flaw::new(block[worst + 1], "position_mm", wrong))
}
