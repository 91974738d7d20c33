//! All readings of a file together → [`Runs`]. Nothing is guessed: not a reading that is missing,
//! and not whether a value is a position or a deviation, unless the values leave no doubt.

use crate::inputs::target_runs::header::{Content, Form, Layout, STATE_VALUES, and_more};
use crate::inputs::target_runs::reading::Reading;
use crate::inputs::target_runs::{Runs, Values};
use crate::quantity::axis::Direction;
use crate::quantity::units::{Figure, UM_PER_MM};
use crate::text::delimited::Line;
use crate::text::problem::{Problem, Problems};
use std::collections::{BTreeMap, BTreeSet};

/// Readings of one target: direction and run to the reading.
type OfTarget<'r, 'a> = BTreeMap<(Direction, u32), &'r Reading<'a>>;
/// Targets in mm, ascending, with their readings.
type Targets<'r, 'a> = Vec<(f64, OfTarget<'r, 'a>)>;

/// Runs from readings that are complete, each once.
pub(super) fn complete(
    layout: &Layout,
    header: &Line<'_>,
    readings: &[Reading<'_>],
) -> Result<Runs, Problems> {
    let mut problems = Problems::none();
    let targets = by_target(layout, readings, &mut problems);
    if targets.len() < 2 {
        problems.push(
            Problem::new("there is one target only, expected at least two")
                .at(header.whole())
                .help("a positioning test has five or more targets"),
        );
    }
    let runs: BTreeSet<(Direction, u32)> = readings.iter().map(|r| (r.direction, r.run)).collect();
    for (_, of_target) in &targets {
        refuse_gaps(layout, of_target, &runs, &mut problems);
    }
    // Without its neighbours a reading cannot be told to be far.
    problems.or_ok(())?;
    let values = values_of(layout, header, &targets)?;
    refuse_far_readings(layout, values, &targets)?;
    let of = |direction: Direction| {
        let measured = runs.iter().any(|(of, _)| *of == direction);
        measured.then(|| {
            let deviations = |of_target: &OfTarget<'_, '_>| {
                let of_direction = of_target.iter().filter(|((of, _), _)| *of == direction);
                of_direction
                    .map(|(_, reading)| reading.deviation_um(values))
                    .collect()
            };
            targets
                .iter()
                .map(|(_, of_target)| deviations(of_target))
                .collect()
        })
    };
    let targets_mm = targets.iter().map(|(mm, _)| *mm).collect();
    Ok(Runs::new(
        targets_mm,
        of(Direction::Plus),
        of(Direction::Minus),
    )?)
}

/// Targets in ascending order with their readings; a reading that comes twice is refused.
fn by_target<'r, 'a>(
    layout: &Layout,
    readings: &'r [Reading<'a>],
    problems: &mut Problems,
) -> Targets<'r, 'a> {
    let mut sorted: Vec<&Reading<'_>> = readings.iter().collect();
    sorted.sort_by(|a, b| a.target_mm().total_cmp(&b.target_mm()));
    let mut targets: Targets<'_, '_> = Vec::new();
    for reading in sorted {
        let target_mm = reading.target_mm();
        if targets.last().is_none_or(|(mm, _)| *mm < target_mm) {
            targets.push((target_mm, BTreeMap::new()));
        }
        let Some((_, of_target)) = targets.last_mut() else {
            continue;
        };
        let key = (reading.direction, reading.run);
        match of_target.get(&key) {
            None => {
                of_target.insert(key, reading);
            }
            Some(first) => problems.push_with(|| twice(layout, first, reading)),
        }
    }
    targets
}

fn twice(layout: &Layout, first: &Reading<'_>, second: &Reading<'_>) -> Problem {
    let mm = second.target_mm();
    let what = match layout.form {
        Form::RowForTarget => format!("target {mm} mm"),
        Form::RowForReading { .. } => format!(
            "target {mm} mm, run {} moving {}",
            second.run, second.direction
        ),
    };
    Problem::new(format!(
        "{what} stands here again, the first time in line {}",
        first.line.number()
    ))
    .at(second.line.cell_place(layout.target))
    .help("keep one of the two rows")
}

/// Every target needs every run that another target has.
fn refuse_gaps(
    layout: &Layout,
    of_target: &OfTarget<'_, '_>,
    runs: &BTreeSet<(Direction, u32)>,
    problems: &mut Problems,
) {
    let Some(first) = of_target.values().next() else {
        return;
    };
    for (direction, run) in runs.iter().filter(|key| !of_target.contains_key(key)) {
        problems.push_with(|| {
            Problem::new(format!(
                "target {} mm has no reading of run {run} moving {direction}, which other targets \
                 have",
                first.target_mm()
            ))
            .at(first.line.cell_place(layout.target))
            .help(
                "a missing reading is not filled in; write a target the same way in every row, or \
                 leave out the run or the target as a whole",
            )
        });
    }
}

// ---------------------------------------------------------------------------------------------
// Positions or deviations

/// Deviations are small beside the distance of the targets: at most this part of it.
const SMALL: f64 = 0.1;

/// Positions or deviations, as named or stated. Else the values are tried as both: they are
/// positions if their deviations are small beside the smallest distance of two targets; anything
/// else has to be stated.
fn values_of(
    layout: &Layout,
    header: &Line<'_>,
    targets: &Targets<'_, '_>,
) -> Result<Values, Problem> {
    if let Some(values) = layout.values {
        return Ok(values);
    }
    let distances = targets.windows(2).map(|pair| pair[1].0 - pair[0].0);
    let small_um = SMALL * distances.fold(f64::INFINITY, f64::min) * UM_PER_MM;
    let fits = |values: Values| {
        let mut readings = targets.iter().flat_map(|(_, of)| of.values());
        readings.all(|reading| reading.deviation_um(values).abs() <= small_um)
    };
    // Both cannot fit: no two targets are that near to zero.
    if fits(Values::Positions) {
        return Ok(Values::Positions);
    }
    let found = if fits(Values::Deviations) {
        "they look like deviations"
    } else {
        "they are far from the targets as either"
    };
    let is_run = |content: Content| matches!(content, Content::RunOf(..));
    let first = layout.columns.iter().position(|c| is_run(c.content));
    let first = first.unwrap_or(layout.target);
    Err(Problem::new(format!(
        "column `{}` does not say whether its values are positions or deviations: {found}",
        layout.names[first]
    ))
    .at(header.cell_place(first))
    .help(STATE_VALUES))
}

/// No machine tool is off by a millimetre and more, unless something else is wrong.
const LARGEST_MM: f64 = 1.0;

/// An axis stands nearer to its own target than to the next one. Where it does not, and by more
/// than a machine can be off, positions were taken for deviations or the other way round, or a row
/// is wrong.
fn refuse_far_readings(
    layout: &Layout,
    values: Values,
    targets: &Targets<'_, '_>,
) -> Result<(), Problem> {
    let mut far = Vec::new();
    for (index, (mm, of_target)) in targets.iter().enumerate() {
        let before = index.checked_sub(1).and_then(|before| targets.get(before));
        let neighbours = [before, targets.get(index + 1)].into_iter().flatten();
        let distances = neighbours.map(|(other, _)| (other - mm).abs());
        let half_mm = distances.fold(f64::INFINITY, f64::min) / 2.0;
        let limit_um = half_mm.max(LARGEST_MM) * UM_PER_MM;
        let is_far = |reading: &&&Reading<'_>| reading.deviation_um(values).abs() >= limit_um;
        let readings = of_target.values().filter(is_far);
        far.extend(readings.map(|reading| (limit_um / UM_PER_MM, *reading)));
    }
    let first = far.iter().min_by_key(|(_, r)| (r.line.number(), r.cell));
    let Some((limit_mm, reading)) = first else {
        return Ok(());
    };
    Err(Problem::new(format!(
        "the reading is {:.4} mm from its target at {} mm, expected less than {:.4} mm (half the \
         way to the next target, or {LARGEST_MM} mm where they are closer){}",
        Figure(reading.deviation_um(values) / UM_PER_MM),
        reading.target_mm(),
        limit_mm,
        and_more(far.len() - 1, " reading is as far", " readings are as far"),
    ))
    .at(reading.line.cell_place(reading.cell))
    .help(far_help(layout.form, values)))
}

const fn far_help(form: Form, values: Values) -> &'static str {
    match (form, values) {
        (Form::RowForTarget, Values::Positions) => {
            "the values are read as positions; if they are deviations add `--values deviations`"
        }
        (Form::RowForTarget, Values::Deviations) => {
            "the values are read as deviations; if they are positions add `--values positions`"
        }
        (Form::RowForReading { .. }, _) => {
            "check the row and the units; `position_mm` is where the axis stood, `deviation_um` its distance from the target"
        }
    }
}
