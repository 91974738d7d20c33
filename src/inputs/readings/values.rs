//! Rows of a complete walk → the deviations and temperatures of its run.
//!
//! A deviation is measured − nominal displacement, positive along the forward direction, at the
//! nodes of the forward path. A run that carries the name of the reverse run (`NNN` …) counts all
//! three from its own start: its sign is turned and its nodes are renumbered here. Its zero is the
//! far corner, and what the forward runs read there belongs to another set of readings; so only
//! its increments mean anything, and [`crate::inputs::readings::Readings::offset_known`] says so.

use crate::inputs::job::DiagonalMeasurement;
use crate::inputs::readings::nodes::{Walks, at_row};
use crate::inputs::readings::rows::{Column, Columns, Quantity, Row, Walk};
use crate::quantity::axis::{Axis, Direction, PerAxis};
use crate::quantity::diagonal::{Pass, Run};
use crate::quantity::units::{Deviation, Millimetres, UM_PER_MM};
use crate::text::problem::{Problem, Problems};

/// No machine tool is off by a centimetre: the readings or the job are not what they seem.
const LARGEST_DEVIATION_UM: f64 = 1e4;
/// Last digit of a laser's display: what still counts as zero.
const ZERO_UM: f64 = 1e-3;
/// Nobody measures outside these temperatures; they refuse degrees Fahrenheit as well.
const TEMPERATURES_C: std::ops::RangeInclusive<f64> = -10.0..=50.0;

/// Measured − nominal displacement of a row in the direction that its walk counts, µm.
fn deviation_um(row: &Row<'_>, quantity: Quantity, measurement: &DiagonalMeasurement) -> f64 {
    let measured = signed(row.um, measurement);
    match quantity {
        Quantity::Deviation => measured,
        Quantity::Displacement => measured - nominal_mm(row, measurement) * UM_PER_MM,
    }
}

/// A reading in the sign of the job, or a displacement in that of the readings.
fn signed(value: f64, measurement: &DiagonalMeasurement) -> f64 {
    match measurement.laser_sign {
        Direction::Plus => value,
        Direction::Minus => -value,
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

/// What stands at the start of a diagonal's first run and is subtracted from a walk, µm; `None` where the
/// laser was zeroed there, or before this run.
pub(super) fn zero_um(
    walk: Walk,
    walks: &Walks<'_, '_>,
    quantity: Quantity,
    measurement: &DiagonalMeasurement,
) -> Option<f64> {
    let start_um = |walk: &Walk| {
        let um = deviation_um(walks.get(walk)?.first()?, quantity, measurement);
        Some(um).filter(|um| um.abs() > ZERO_UM)
    };
    start_um(&Walk { direction: Pass::Forward, ..walk }).filter(|_| !walk.is_own())?;
    let first = walks.keys().find(|of| of.diagonal == walk.diagonal && !of.is_own());
    first.and_then(start_um)
}

/// Notes readings that are no deviation of a machine.
pub(super) fn check(
    walks: &Walks<'_, '_>,
    quantity: Quantity,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) {
    let last = measurement.volume.last_node(measurement.kind);
    let deviation = |row: &Row<'_>| deviation_um(row, quantity, measurement);
    for rows in walks.values() {
        let is_implausible =
            |row: &&&Row<'_>| row.node <= last && deviation(row).abs() > LARGEST_DEVIATION_UM;
        if let Some(row) = rows.iter().find(is_implausible) {
            problems.push(implausible_reading(row, quantity, measurement));
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
    let shown = rounded(read);
    if quantity == Quantity::Deviation {
        let message =
            format!("{walk}, node {node}: the deviation is {shown} mm, which no machine has");
        return at_row(
            row,
            message,
            "check the reading, and the unit in the column's name; a column of the displacement itself is named `displacement_mm`",
        );
    }
    let expected = signed(nominal_mm(row, measurement), measurement);
    let message = format!(
        "{walk}, node {node}: the displacement is {shown} mm, expected about {} mm",
        rounded(expected)
    );
    let is_turned = (read + expected).abs() * UM_PER_MM <= LARGEST_DEVIATION_UM;
    let help = match (other_order(row, measurement), is_turned) {
        (Some(order), _) => format!("this is what steps that went {order} read: check `order` in the job against the program that was run"),
        (None, true) if walk.is_own() => format!(
            "a run named {} counts along its own travel; give rows that count along {} under that name, with `reverse` and the nodes of the forward run",
            walk.name(),
            walk.diagonal
        ),
        (None, true) => format!(
            "the instrument counts the other way: write `laser_sign = \"{}\"` in the job",
            measurement.laser_sign.opposite()
        ),
        (None, false) => "displacements are counted from the start of the forward run; check the unit in the column's name, and the box in the job".to_string(),
    };
    at_row(row, message, help)
}

/// The order of the steps that the displacement of a node fits, where it is not that of the job.
fn other_order(row: &Row<'_>, measurement: &DiagonalMeasurement) -> Option<String> {
    let fits = |order: &[Axis; 3]| {
        let mut other = measurement.clone();
        other.volume.order = *order;
        deviation_um(row, Quantity::Displacement, &other).abs() < LARGEST_DEVIATION_UM / 10.0
    };
    let [first, second, third] = Axis::ORDERS.into_iter().find(fits)?;
    Some(format!("{first}, {second}, {third}"))
}

/// A number as a sentence shows it.
fn rounded(number: f64) -> f64 {
    Millimetres::new(number).shown()
}

/// Notes temperatures that are missing in part, or that the job does not say how to use.
pub(super) fn check_temperatures(
    walks: &Walks<'_, '_>,
    table: &Columns<'_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) {
    for axis in Axis::ALL {
        let Some(index) = table.find(|column| column == Column::Temperature { of: axis }) else {
            require_temperature(axis, table, measurement, problems);
            continue;
        };
        if let Some((message, help)) = unusable(axis, measurement) {
            problems.push(table.at_column(index, message, &help));
        }
        check_column(axis, (index, &table.names[index]), walks, problems);
    }
}

fn check_column(
    axis: Axis,
    (index, name): (usize, &str),
    walks: &Walks<'_, '_>,
    problems: &mut Problems,
) {
    let at_cell = |row: &Row<'_>, message: String, help: &str| {
        Problem::new(message).at(row.line.cell_place(index)).help(help)
    };
    let (low, high) = (TEMPERATURES_C.start(), TEMPERATURES_C.end());
    for row in walks.values().flatten() {
        if let Some(c) = row.temperatures_c[axis].filter(|c| !TEMPERATURES_C.contains(c)) {
            let message = format!("`{name}` is {c} °C, expected {low} … {high} °C");
            problems.push(at_cell(row, message, "give degrees Celsius"));
            break;
        }
    }
    for (walk, rows) in walks {
        let is_given = |row: &&Row<'_>| row.temperatures_c[axis].is_some();
        let empty = rows.iter().find(|row| !is_given(row));
        if let Some(row) = empty.filter(|_| rows.iter().any(is_given)) {
            let node = row.node;
            let message = format!(
                "{walk}, node {node}: `{name}` is empty, expected a number as in the other rows of this run"
            );
            let help =
                "a missing value is never filled in: leave the column empty for the whole run";
            problems.push(at_cell(row, message, help));
        }
    }
}

fn require_temperature(
    axis: Axis,
    table: &Columns<'_>,
    measurement: &DiagonalMeasurement,
    problems: &mut Problems,
) {
    let material = measurement.material.filter(|m| !m.material_corrected);
    let scale = material.and_then(|material| material.axes[axis]);
    if scale.is_some_and(|scale| scale.temperature_c.is_none()) {
        let key = axis.key();
        let message = format!(
            "there is no temperature of axis {axis}: neither a column `t_{key}_c` nor `temperature_c` in the job's [measurement.step_diagonal.material]"
        );
        let help = "give the mean temperature of the scale in the job, or a column with that of every reading";
        problems.push(table.at_header(message, help));
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

/// The run of a complete walk, less its zero.
pub(super) fn run(
    walk: Walk,
    rows: &[&Row<'_>],
    zero_um: f64,
    quantity: Quantity,
    measurement: &DiagonalMeasurement,
) -> Run {
    let mut forward: Vec<&Row<'_>> = rows.to_vec();
    let mut sign = 1.0;
    if walk.is_own() {
        forward.reverse();
        sign = -1.0;
    }
    let deviation = |row: &&Row<'_>| {
        Deviation::from_um(sign * deviation_um(row, quantity, measurement) - zero_um)
    };
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
