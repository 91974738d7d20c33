//! Rows of a complete walk → the deviations and temperatures of its run.
//!
//! A deviation is measured − nominal displacement, positive along the forward direction, at the
//! nodes of the forward path. A run that carries the name of the reverse run (`NNN` …) counts all
//! three from its own start: its sign is turned and its nodes are renumbered here. Its zero is the
//! far corner, and what the forward runs read there belongs to another set of readings; so only
//! its increments mean anything, and [`crate::inputs::readings::Readings::offset_known`] says so.

use crate::inputs::job::DiagonalMeasurement;
use crate::inputs::readings::columns::{Columns, Quantity};
use crate::inputs::readings::rows::{Row, Walk};
use crate::inputs::readings::walks::Walks;
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{PerDiagonal, Run};
use crate::quantity::units::{Deviation, UM_PER_MM};
use crate::text::problem::{Problem, Problems};

/// No machine tool is off by a centimetre: the readings or the job are not what they seem.
const LARGEST_DEVIATION_UM: f64 = 1e4;
/// Last digit of a laser's display: what still counts as zero.
const ZERO_UM: f64 = 1e-3;
/// Nobody measures outside these temperatures; they refuse degrees Fahrenheit as well.
const TEMPERATURES_C: std::ops::RangeInclusive<f64> = -10.0..=50.0;

/// Measured − nominal displacement of a row in the direction that its walk counts, µm.
fn deviation_um(row: &Row<'_>, quantity: Quantity, measurement: &DiagonalMeasurement) -> f64 {
    let measured = match measurement.laser_sign {
        Direction::Plus => row.um,
        Direction::Minus => -row.um,
    };
    match quantity {
        Quantity::Deviation => measured,
        Quantity::Displacement => measured - nominal_mm(row, measurement) * UM_PER_MM,
    }
}

fn nominal_mm(row: &Row<'_>, measurement: &DiagonalMeasurement) -> f64 {
    let (volume, kind) = (&measurement.volume, measurement.kind);
    let nominal = |node| volume.nominal_mm(row.walk.diagonal, kind, node);
    let last = volume.last_node(kind);
    if row.walk.is_own() {
        nominal(last) - nominal(last - row.node.min(last))
    } else {
        nominal(row.node)
    }
}

/// Notes readings that are no deviation of a machine, and forward runs that do not begin at zero.
pub(super) fn check(
    walks: &Walks<'_, '_>,
    columns: &Columns<'_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) {
    let first_forward = PerDiagonal::from_fn(|diagonal| {
        let forward = |walk: &&Walk| walk.diagonal == diagonal && !walk.is_own();
        walks.keys().find(forward).copied()
    });
    for (walk, rows) in walks {
        let deviation = |row: &Row<'_>| deviation_um(row, columns.quantity, measurement);
        let last = measurement.volume.last_node(measurement.kind);
        let implausible =
            |row: &&&Row<'_>| row.node <= last && deviation(row).abs() > LARGEST_DEVIATION_UM;
        let start = rows.first().filter(|row| row.node == 0);
        if let Some(row) = rows.iter().find(implausible) {
            problems.push(implausible_reading(row, columns.quantity, measurement));
        } else if let Some(row) = start
            && first_forward[walk.diagonal] == Some(*walk)
            && deviation(row).abs() > ZERO_UM
        {
            problems.push(
                Problem::new(format!(
                    "{walk} begins with {} µm at node 0, expected 0",
                    rounded(deviation(row))
                ))
                .at(row.line.whole())
                .help("the readings are zero where the run begins: subtract this reading from all of the run, the way back included"),
            );
        }
    }
}

fn implausible_reading(
    row: &Row<'_>,
    quantity: Quantity,
    measurement: &DiagonalMeasurement,
) -> Problem {
    let (walk, node) = (row.walk, row.node);
    let read = row.um / UM_PER_MM;
    let (message, help) = match quantity {
        Quantity::Deviation => (
            format!(
                "{walk}, node {node}: the deviation is {} mm, which no machine has",
                rounded(read)
            ),
            if is_near(read, nominal_mm(row, measurement)) {
                "a column of the displacement itself is named `displacement_mm`".to_string()
            } else {
                "check the reading, and the unit in the column's name".to_string()
            },
        ),
        Quantity::Displacement => {
            let expected = match measurement.laser_sign {
                Direction::Plus => nominal_mm(row, measurement),
                Direction::Minus => -nominal_mm(row, measurement),
            };
            let message = format!(
                "{walk}, node {node}: the displacement is {} mm, expected about {} mm",
                rounded(read),
                rounded(expected)
            );
            (
                message,
                other_order(row, measurement)
                    .unwrap_or_else(|| displacement_help(walk, read, expected, measurement)),
            )
        }
    };
    Problem::new(message).at(row.line.whole()).help(help)
}

/// The order of the steps that the displacement of a node fits, where it is not that of the job.
fn other_order(row: &Row<'_>, measurement: &DiagonalMeasurement) -> Option<String> {
    let fits = |order: &[Axis; 3]| {
        let mut other = measurement.clone();
        other.volume.order = *order;
        deviation_um(row, Quantity::Displacement, &other).abs() < LARGEST_DEVIATION_UM / 10.0
    };
    let [first, second, third] = Axis::ORDERS.into_iter().find(fits)?;
    Some(format!(
        "this is what steps that went {first}, {second}, {third} read: check `order` in the job against the program that was run"
    ))
}

fn displacement_help(
    walk: Walk,
    read: f64,
    expected: f64,
    measurement: &DiagonalMeasurement,
) -> String {
    if !is_near(-read, expected) {
        return "displacements are counted from the start of the forward run; check the unit in the column's name, and the box in the job".to_string();
    }
    if walk.is_own() {
        return format!(
            "a run named {} counts along its own travel; give rows that count along {} under that name, with `reverse` and the nodes of the forward run",
            walk.name(),
            walk.diagonal
        );
    }
    match measurement.laser_sign {
        Direction::Plus => {
            "the instrument counts the other way: write `laser_sign = \"-\"` in the job"
        }
        Direction::Minus => {
            "the instrument counts along the diagonal: write `laser_sign = \"+\"` in the job"
        }
    }
    .to_string()
}

fn is_near(mm: f64, other: f64) -> bool {
    (mm - other).abs() * UM_PER_MM <= LARGEST_DEVIATION_UM
}

/// A number as a sentence shows it.
fn rounded(number: f64) -> f64 {
    (number * 1e3).round() / 1e3 + 0.0
}

/// Notes temperatures that are missing in part, or that the job does not say how to use.
pub(super) fn check_temperatures(
    walks: &Walks<'_, '_>,
    columns: &Columns<'_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) {
    let temperatures = columns.temperatures();
    for axis in Axis::ALL {
        let Some(index) = temperatures[axis] else {
            require_temperature(axis, columns, measurement, problems);
            continue;
        };
        let place = columns.header.cell_place(index);
        if let Some((message, help)) = unusable(axis, measurement) {
            problems.push(Problem::new(message).at(place).help(help));
        }
        if let Some(problem) = implausible_temperature(axis, index, walks, columns) {
            problems.push(problem);
        }
        for (walk, rows) in walks {
            let empty = |row: &&&Row<'_>| row.temperatures_c[axis].is_none();
            let Some(row) = rows.iter().find(empty) else {
                continue;
            };
            if rows.iter().all(|row| row.temperatures_c[axis].is_none()) {
                continue;
            }
            problems.push(
                Problem::new(format!(
                    "{walk}, node {}: `{}` is empty, expected a number as in the other rows of this run",
                    row.node, columns.names[index]
                ))
                .at(row.line.cell_place(index))
                .help("a missing value is never filled in: leave the column empty for the whole run"),
            );
        }
    }
}

/// The first temperature of a column that nobody measures at.
fn implausible_temperature(
    axis: Axis,
    index: usize,
    walks: &Walks<'_, '_>,
    columns: &Columns<'_>,
) -> Option<Problem> {
    let beyond = |row: &&&Row<'_>| {
        let temperature = row.temperatures_c[axis];
        temperature.is_some_and(|c| !TEMPERATURES_C.contains(&c))
    };
    let row = walks.values().flatten().find(beyond)?;
    let (low, high) = (TEMPERATURES_C.start(), TEMPERATURES_C.end());
    let message = format!(
        "`{}` is {} °C, expected {low} … {high} °C",
        columns.names[index], row.temperatures_c[axis]?
    );
    let place = row.line.cell_place(index);
    Some(Problem::new(message).at(place).help("give degrees Celsius"))
}

fn require_temperature(
    axis: Axis,
    columns: &Columns<'_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) {
    let Some(material) = measurement.material.filter(|m| !m.material_corrected) else {
        return;
    };
    let without = |scale: crate::inputs::job::AxisMaterial| scale.temperature_c.is_none();
    if material.axes[axis].is_some_and(without) {
        problems.push(
            Problem::new(format!(
                "there is no temperature of axis {axis}: neither a column `t_{0}_c` nor `temperature_c` in the job's [measurement.step_diagonal.material]",
                axis.key()
            ))
            .at(columns.header.whole())
            .help("give the mean temperature of the scale in the job, or a column with that of every reading"),
        );
    }
}

/// Why a column of temperatures cannot be used with what the job states.
fn unusable(axis: Axis, measurement: &DiagonalMeasurement) -> Option<(String, String)> {
    let column = format!("`t_{}_c`", axis.key());
    let Some(material) = measurement.material else {
        return Some((
            format!("{column} gives temperatures, but the job does not say whether the readings are corrected for them already"),
            "add `[measurement.step_diagonal.material]` with `material_corrected` and `air_corrected`".to_string(),
        ));
    };
    match material.axes[axis] {
        Some(scale) if scale.temperature_c.is_some() => Some((
            format!(
                "the temperature of axis {axis} is given twice: by {column} and by `temperature_c` in the job"
            ),
            "keep one of the two".to_string(),
        )),
        None if !material.material_corrected => Some((
            format!(
                "{column} gives temperatures, but the job does not give the expansion of axis {axis}"
            ),
            format!(
                "add `{} = {{ alpha_per_k = … }}` to [measurement.step_diagonal.material]",
                axis.key()
            ),
        )),
        _ => None,
    }
}

/// The run of a complete walk.
pub(super) fn run(
    walk: Walk,
    rows: &[&Row<'_>],
    quantity: Quantity,
    measurement: &DiagonalMeasurement,
) -> Run {
    let mut forward: Vec<&Row<'_>> = rows.to_vec();
    if walk.is_own() {
        forward.reverse();
    }
    let sign = if walk.is_own() { -1.0 } else { 1.0 };
    let deviation =
        |row: &&Row<'_>| Deviation::from_um(sign * deviation_um(row, quantity, measurement));
    Run {
        diagonal: walk.diagonal,
        number: walk.run,
        pass: walk.pass(),
        deviations: forward.iter().map(deviation).collect(),
        temperatures_c: PerAxis::from_fn(|axis| {
            forward.iter().map(|row| row.temperatures_c[axis]).collect()
        }),
    }
}
