//! Rows of a complete walk → the deviations and temperatures of its run.
//!
//! A deviation is measured − nominal displacement, positive along the forward direction, at the
//! nodes of the forward path. A run that carries the name of the reverse run (`NNN` …) counts all
//! three from its own start: its sign is turned and its nodes are renumbered here. Its zero is the
//! far corner, and what the forward runs read there belongs to another set of readings; so only
//! its increments mean anything, and [`crate::inputs::readings::Readings::offset_known`] says so.

use crate::inputs::job::TEMPERATURES_C;
use crate::inputs::readings::{Row, Walk, Walked};
use crate::inputs::refusals;
use crate::inputs::table::{Column, Content};
use crate::inputs::target_runs::Values;
use crate::quantity::{Axis, Deviation, Direction, Pass, PerAxis, Run, UM_PER_MM, Volume, rounded};
use crate::text::Problem;

/// No machine tool is off by a centimetre: the readings or the job are not what they seem.
const LARGEST_DEVIATION_UM: f64 = 1e4;
/// Last digit of a laser's display: what still counts as zero.
const ZERO_UM: f64 = 1e-3;

impl Walked<'_, '_> {
    /// Measured − nominal displacement of a row in the direction that its walk counts, µm.
    fn deviation_um(&self, row: &Row<'_>) -> f64 {
        match self.values {
            Values::Deviations => self.signed(row.um),
            Values::Positions => self.beyond_um(row, self.path.volume.order),
        }
    }

    /// How far a displacement goes beyond the nominal one of an order of the axes, µm.
    fn beyond_um(&self, row: &Row<'_>, order: [Axis; 3]) -> f64 {
        self.signed(row.um) - self.nominal_mm(row, order) * UM_PER_MM
    }

    /// A reading in the sign of the job, or a displacement in that of the readings.
    fn signed(&self, value: f64) -> f64 {
        match self.path.laser_sign {
            Direction::Plus => value,
            Direction::Minus => -value,
        }
    }

    fn nominal_mm(&self, row: &Row<'_>, order: [Axis; 3]) -> f64 {
        let volume = Volume { order, ..self.path.volume.clone() };
        let nominal = |node| volume.nominal_mm(row.walk.diagonal, self.path.kind, node);
        match row.walk.is_own() {
            true => nominal(self.last) - nominal(self.last - row.node.min(self.last)),
            false => nominal(row.node),
        }
    }

    /// What stands at the start of a diagonal's first run and is subtracted from a walk, µm; `None` where the
    /// laser was zeroed there, or before this run.
    pub(super) fn zero_um(&self, walk: Walk) -> Option<f64> {
        let start_um = |walk: &Walk| {
            let um = self.deviation_um(self.walks.get(walk)?.first()?);
            Some(um).filter(|um| um.abs() > ZERO_UM)
        };
        start_um(&Walk { direction: Pass::Forward, ..walk }).filter(|_| !walk.is_own())?;
        let mut walks = self.walks.keys();
        walks.find(|of| of.diagonal == walk.diagonal && !of.is_own()).and_then(start_um)
    }

    /// Notes readings that are no deviation of a machine.
    pub(super) fn check_readings(&self) {
        for rows in self.walks.values() {
            let is_implausible = |row: &&&Row<'_>| {
                row.node <= self.last && self.deviation_um(row).abs() > LARGEST_DEVIATION_UM
            };
            if let Some(row) = rows.iter().find(is_implausible) {
                self.refuse(row, self.implausible(row));
            }
        }
    }

    fn implausible(&self, row: &Row<'_>) -> Problem {
        let (walk, node) = (row.walk, row.node);
        let read = row.um / UM_PER_MM;
        if self.values == Values::Deviations {
            return refusals::no_such_deviation(walk, node, rounded(read, 3));
        }
        let expected = self.signed(self.nominal_mm(row, self.path.volume.order));
        let is_turned = (read + expected).abs() * UM_PER_MM <= LARGEST_DEVIATION_UM;
        let fits =
            |order: &[Axis; 3]| self.beyond_um(row, *order).abs() < LARGEST_DEVIATION_UM / 10.0;
        let help = match (Axis::ORDERS.into_iter().find(fits), is_turned) {
            (Some([first, second, third]), _) => format!("this is what steps that went {first}, {second}, {third} read: check `order` in the job against the program that was run"),
            (None, true) if walk.is_own() => format!("a run named {} counts along its own travel; give rows that count along {} under that name, with `reverse` and the nodes of the forward run", walk.name(), walk.diagonal),
            (None, true) => format!("the instrument counts the other way: write `laser_sign = \"{}\"` in the job", self.path.laser_sign.opposite()),
            (None, false) => "displacements are counted from the start of the forward run; check the unit in the column's name, and the box in the job".to_string(),
        };
        refusals::other_displacement(walk, node, rounded(read, 3), rounded(expected, 3), help)
    }

    /// Notes temperatures that are missing in part, or that the job does not say how to use.
    pub(super) fn check_temperatures(&self) {
        for axis in Axis::ALL {
            if let Some(column) = self.table.column(Content::Temperature(axis)) {
                let unusable = self.unusable(axis, &column.name);
                let unusable = unusable.map(|problem| self.table.at(column, problem));
                unusable.into_iter().for_each(|problem| self.table.notes.refuse(problem));
                self.check_column(axis, column);
            } else if self.needs_temperature(axis) {
                self.table.refuse(refusals::no_temperature(axis, axis.key()));
            }
        }
    }

    fn check_column(&self, axis: Axis, column: &Column) {
        let name = &column.name;
        let refuse = |row: &Row<'_>, problem: Problem| {
            self.table.notes.refuse(problem.at(row.line.cell_place(column.index)));
        };
        let mut given = self.walks.values().flatten();
        let given = given.find_map(|row| {
            let c = row.temperatures_c[axis].filter(|c| !TEMPERATURES_C.contains(c))?;
            Some((*row, c))
        });
        if let Some((row, c)) = given {
            let (low, high) = (TEMPERATURES_C.start(), TEMPERATURES_C.end());
            refuse(row, refusals::no_room_temperature(name, c, low, high));
        }
        for (walk, rows) in &self.walks {
            let is_given = |row: &&Row<'_>| row.temperatures_c[axis].is_some();
            let empty = rows.iter().find(|row| !is_given(row));
            if let Some(row) = empty.filter(|_| rows.iter().any(is_given)) {
                refuse(row, refusals::temperature_missing(walk, row.node, name));
            }
        }
    }

    /// Whether the job corrects the expansion of a scale and states no temperature of it.
    fn needs_temperature(&self, axis: Axis) -> bool {
        let material = self.path.material.filter(|m| !m.material_corrected);
        let scale = material.and_then(|material| material.axes[axis]);
        scale.is_some_and(|scale| scale.temperature_c.is_none())
    }

    /// Why a column of temperatures cannot be used with what the job states.
    fn unusable(&self, axis: Axis, column: &str) -> Option<Problem> {
        let Some(material) = self.path.material else {
            return Some(refusals::temperatures_for_what(column));
        };
        match material.axes[axis] {
            Some(scale) if scale.temperature_c.is_some() => {
                Some(refusals::two_temperatures(axis, column))
            }
            None if !material.material_corrected => {
                Some(refusals::no_expansion(column, axis, axis.key()))
            }
            _ => None,
        }
    }

    /// The run of a complete walk, less its zero.
    pub(super) fn run(&self, walk: Walk, rows: &[&Row<'_>]) -> Run {
        let mut forward: Vec<&Row<'_>> = rows.to_vec();
        let mut sign = 1.0;
        if walk.is_own() {
            forward.reverse();
            sign = -1.0;
        }
        let zero_um = self.zero_um(walk).unwrap_or(0.0);
        let deviation =
            |row: &&Row<'_>| Deviation::from_um(sign * self.deviation_um(row) - zero_um);
        let temperatures = |axis| forward.iter().map(|row| row.temperatures_c[axis]).collect();
        Run {
            diagonal: walk.diagonal,
            number: walk.run,
            pass: walk.pass(),
            deviations: forward.iter().map(deviation).collect(),
            temperatures_c: PerAxis::from_fn(temperatures),
        }
    }
}
