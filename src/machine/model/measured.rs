//! How a term was measured, and whether its places fit the machine.

use crate::inputs::error_table::{ErrorTable, Series};
use crate::inputs::job::{Job, MachineAxis};
use crate::quantity::axis::{Axis, Direction};
use crate::quantity::curve::ErrorCurve;
use crate::quantity::units::Millimetres;
use crate::text::problem::{Problem, Problems};

/// How a term was measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Measured {
    /// Without regard to direction (or as the mean of both).
    Undirected(ErrorCurve),
    /// In both directions.
    BothWays {
        /// Moving in +.
        plus: ErrorCurve,
        /// Moving in −.
        minus: ErrorCurve,
    },
    /// In one direction only.
    OneWay(Direction, ErrorCurve),
}

impl Measured {
    /// One or two curves with their directions, + before −; `None` = there is none.
    pub(super) fn of(
        mut curves: impl Iterator<Item = (Option<Direction>, ErrorCurve)>,
    ) -> Option<Measured> {
        let (direction, first) = curves.next()?;
        Some(match (direction, curves.next()) {
            (_, Some((_, minus))) => Measured::BothWays { plus: first, minus },
            (Some(direction), None) => Measured::OneWay(direction, first),
            (None, None) => Measured::Undirected(first),
        })
    }

    /// The curve without regard to direction: of two the mean, over the range that both cover.
    pub fn mean(&self) -> ErrorCurve {
        match self {
            Measured::Undirected(curve) | Measured::OneWay(_, curve) => curve.clone(),
            Measured::BothWays { plus, minus } => {
                plus.mean_with(minus).unwrap_or_else(|| plus.clone())
            }
        }
    }

    /// The curve that holds while the axis moves in `direction`, if that direction was measured.
    pub fn curve(&self, direction: Direction) -> Option<&ErrorCurve> {
        match (self, direction) {
            (Measured::Undirected(curve), _)
            | (Measured::BothWays { plus: curve, .. }, Direction::Plus)
            | (Measured::BothWays { minus: curve, .. }, Direction::Minus) => Some(curve),
            (Measured::OneWay(measured, curve), wanted) => (*measured == wanted).then_some(curve),
        }
    }

    /// Whether the two directions were measured apart.
    pub(crate) fn has_both_ways(&self) -> bool {
        matches!(self, Measured::BothWays { .. })
    }
}

pub(super) fn measured_range(series: &[Series]) -> Option<(Millimetres, Millimetres)> {
    let ends = |s: &Series| Some((*s.positions.first()?, *s.positions.last()?));
    series.iter().filter_map(ends).reduce(|a, b| {
        let low = if a.0 > b.0 { a.0 } else { b.0 };
        let high = if a.1 < b.1 { a.1 } else { b.1 };
        (low, high)
    })
}

pub(super) fn check_axis(job: &Job, table: &ErrorTable, axis: Axis, problems: &mut Problems) {
    let series = table.series(axis);
    if series.is_empty() {
        return;
    }
    let Some(machine) = job.machine.axes[axis] else {
        problems.push(
            job.problem_at(
                "machine.axes",
                format!(
                    "axis {axis} was measured, but [machine.axes.{}] is missing",
                    axis.key()
                ),
            )
            .help("add travel_mm and reference_mm of this axis"),
        );
        return;
    };
    for series in series {
        check_inside_travel(table, axis, series, machine, problems);
    }
    if measured_range(series).is_some_and(|(low, high)| low >= high) {
        let problem = Problem::new(format!(
            "the two directions of axis {axis} were measured at places that do not overlap"
        ))
        .help("measure both directions over the same range");
        let second = series.last().and_then(|second| table.place(second, 0));
        problems.push(match second {
            Some(place) => problem.at(place),
            None => problem,
        });
    }
}

/// Targets may miss the stated travel by this much (rounding of inch positions).
const TRAVEL_TOLERANCE_MM: f64 = 0.01;

fn check_inside_travel(
    table: &ErrorTable,
    axis: Axis,
    series: &Series,
    machine: MachineAxis,
    problems: &mut Problems,
) {
    let outside = |p: &Millimetres| {
        p.mm() < machine.low.mm() - TRAVEL_TOLERANCE_MM
            || p.mm() > machine.high.mm() + TRAVEL_TOLERANCE_MM
    };
    let rows: Vec<usize> = (0..series.positions.len())
        .filter(|row| outside(&series.positions[*row]))
        .collect();
    let Some(first) = rows.first() else {
        return;
    };
    let position = series.positions[*first].mm();
    let more = if rows.len() > 1 {
        let rows_too = if rows.len() > 2 { "rows" } else { "row" };
        format!(", and {} more {rows_too}", rows.len() - 1)
    } else {
        String::new()
    };
    let problem = Problem::new(format!(
        "position {position} mm of axis {axis} lies outside its travel {} … {} mm{more}",
        machine.low.mm(),
        machine.high.mm()
    ))
    .help("positions are machine coordinates in the unit of their column; correct them or `travel_mm`");
    problems.push(match table.place(series, *first) {
        Some(place) => problem.at(place),
        None => problem,
    });
}
