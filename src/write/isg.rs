//! ISG kernel, TwinCAT CNC: all errors into the parameters of one volumetric compensation.
//!
//! * The file holds errors, not corrections: deviations in mm, angles in rad (docs/isg.md §3).
//! * Squareness stands in the slopes of the deviations, as in the job; no constant `C0Y` is written beside them.
//! * Angles are written where they were measured. Deviations then hold what was measured less what the control
//!   takes off for the angles on the line of measurement, so nothing is taken off twice.
//! * One curve for both directions.

use crate::control::claims::Precondition;
use crate::control::controller::{ControlUnit, IsgFacts, LeverOrigin, Mechanism};
use crate::control::table::Tables;
use crate::control::table::isg::{IsgCurve, IsgPoint, IsgTables, Parameter};
use crate::inputs::job::WantedTerms;
use crate::machine::model::TermCurves;
use crate::quantity::{
    Axis, Chain, Deviation, ErrorCurve, ErrorTerm, Interpolation, Millimetres, PerAxis, Rotation,
    UM_PER_MM, power_of_ten, rounded, unit,
};
use crate::text::{Problem, Problems};
use crate::write::control_text::{Seen, fixed, seen};
use crate::write::family::{
    Compiled, Family, FileSource, Placement, ProofOf, backlash_parameter, backlash_text,
    control_state,
};
use crate::write::findings::TableFinding;
use crate::write::grid::LengthDigit;
use crate::write::refusals;
use crate::write::task::{Plan, PlannedTable, Target, Task, axis_key};

impl Family for IsgFacts {
    fn expected_name(&self, _axis: Axis, name: &str) -> Option<&'static str> {
        let number = name.parse::<u16>().ok().filter(|n| *n > 0);
        let is_logical = number.is_some_and(|number| number.to_string() == name);
        (!is_logical).then_some("a logical axis number, \"1\" to \"65535\"")
    }

    /// Positions are in mm whatever the control is in.
    fn length_digit(&self, _unit: ControlUnit) -> LengthDigit {
        LengthDigit { unit: ControlUnit::Millimetre, decimals: self.position_decimals.value }
    }

    fn point_limit(&self, _targets: &[&Target]) -> (u32, &'static str) {
        (self.records.value, "a compensation")
    }

    fn takes_angles(&self, task: Task<'_>) -> bool {
        task.job.compensation.terms == WantedTerms::All
    }

    fn compile(&self, task: Task<'_>, plan: &Plan) -> Result<Compiled, Problems> {
        let axes = logical_axes(task, plan)?;
        let angles = self.angles(task, plan)?;
        let deviation = |planned: &PlannedTable| self.deviations(task, planned, &angles);
        let mut curves: Vec<IsgCurve> = plan.tables.iter().map(deviation).collect();
        let notes = self.notes(task, &angles).map(Into::into).collect();
        curves.extend(angles);
        curves.sort_by_key(|curve| curve.parameter);
        let tables = IsgTables { axes, chain: chain(task).order(), curves, ..IsgTables::NONE };
        let count_um = UM_PER_MM / power_of_ten(self.value_decimals.value);
        let placed = plan.tables.iter();
        let placed =
            placed.map(|own| Placement::of(own, format!("by {}", own.term.along), count_um));
        let backlash_um = |axis| plan.backlash_um[axis].map_or(0.0, |um| backlash_text(um).1);
        let state = control_state(task, plan, backlash_um);
        Ok(Compiled {
            preconditions: preconditions(task, plan, &tables),
            notes,
            ..Compiled::of(Tables::Isg(tables), placed.collect(), state)
        })
    }

    fn uses(&self, mechanism: Mechanism, _plan: &Plan, tables: &Tables) -> bool {
        mechanism != Mechanism::VolcompAngles || tables.own::<IsgTables>().has_angles()
    }

    fn context(&self, emitted: &FileSource<'_>) -> Seen {
        let tables: &IsgTables = emitted.tables.own();
        let axis = |(axis, number): (Axis, &Option<u32>)| {
            let number = number.map_or(String::new(), |number| number.to_string());
            seen! { "letter": axis.to_string(), "number": number }
        };
        seen! {
            "axes": tables.axes.iter().map(axis).collect::<Vec<Seen>>(),
            "chain": Axis::letters(&tables.chain),
            "blocks": self.blocks(tables),
        }
    }

    /// Angles are 0 too, so nothing but the bump acts.
    fn proof_tables(&self, proof: &ProofOf<'_>) -> Option<Tables> {
        let kit: &IsgTables = proof.kit.own();
        let of_kit = kit.curves.iter().map(|curve| {
            let has_bump = curve.parameter == Parameter::Deviation(proof.term);
            let points = curve.points.iter().zip(proof.deviations(has_bump, curve.points.len()));
            let point =
                |(point, d): (&IsgPoint, Deviation)| IsgPoint { value: self.value(d), ..*point };
            IsgCurve { points: points.map(point).collect(), ..curve.clone() }
        });
        Some(Tables::Isg(IsgTables { curves: of_kit.collect(), ..kit.clone() }))
    }
}

impl IsgFacts {
    /// A deviation as it stands in the file, mm; rounded here, once.
    fn value(&self, deviation: Deviation) -> f64 {
        let mm = self.error_sign.value.table_um(deviation) / UM_PER_MM;
        rounded(mm, self.value_decimals.value) + 0.0 // −0 is 0
    }

    /// The deviations of a term, less what the control takes off there for the angles of its axis.
    fn deviations(&self, task: Task<'_>, planned: &PlannedTable, angles: &[IsgCurve]) -> IsgCurve {
        let ErrorTerm { of, along } = planned.term;
        let grid = &planned.grid;
        let arm = self.arm(task, along);
        let of_rotation = |about| {
            let parameter = Parameter::Angle(Rotation { about, along });
            angles.iter().find(move |curve| curve.parameter == parameter)
        };
        let curves = PerAxis::from_fn(of_rotation);
        let swung = |index: usize| {
            let urad = PerAxis::from_fn(|about| {
                let point = curves[about].and_then(|curve| curve.points.get(index));
                let urad = point.map_or(0.0, |point| point.value * Parameter::PER_RAD);
                -self.angle_sign.value.correction(urad).um()
            });
            urad.cross(arm)[of] / UM_PER_MM
        };
        let points = (grid.first..=grid.last).zip(&planned.values).enumerate();
        let points = points.map(|(index, (at, value))| IsgPoint {
            position: grid.written(at),
            value: self.value(Deviation::from_um(value.um() - swung(index))),
        });
        IsgCurve { parameter: Parameter::Deviation(planned.term), points: points.collect() }
    }

    /// The lever of the angles of an axis while the others rest, as the control counts it, mm.
    fn arm(&self, task: Task<'_>, along: Axis) -> PerAxis<f64> {
        let axes = &task.job.machine.axes;
        let rest = task.job.measurement.levers.origin(axes);
        let origin = |axis: Axis| match (self.lever_origin.value, axes[axis]) {
            (LeverOrigin::Reference, Some(machine)) => machine.reference.mm(),
            _ => 0.0,
        };
        let carried = chain(task).carried_by(along).into_iter();
        let arms = carried.map(|axis| unit(axis).times(rest[axis] - origin(axis)));
        arms.fold(PerAxis::default(), PerAxis::plus)
    }

    /// The measured angles of the axes that have a grid, as the model of the machine has them; the table is zero at
    /// `angles_zero_mm`, on a node or between two.
    fn angles(&self, task: Task<'_>, plan: &Plan) -> Result<Vec<IsgCurve>, Problem> {
        if !self.takes_angles(task) {
            return Ok(Vec::new());
        }
        let zeros = &task.job.measurement.levers.angles_zero;
        let mut angles = Vec::new();
        for rotation in Rotation::all() {
            let along = rotation.along;
            let measured = task.model.rotations[rotation].as_ref().map(TermCurves::mean);
            let Some((curve, grid)) = measured.zip(plan.grids[along]) else {
                continue;
            };
            let places: Vec<Millimetres> =
                (grid.first..=grid.last).map(|at| grid.position(at)).collect();
            let urad: Vec<Deviation> = places.iter().map(|at| curve.at(*at)).collect();
            let table = ErrorCurve::through(&places, &urad, Interpolation::Linear);
            let table = match zeros[along] {
                Some(zero) => table.rezeroed_at(zero),
                None => table,
            };
            let points = (grid.first..=grid.last).map(|at| {
                let urad = self.angle_sign.value.table_um(table.at(grid.position(at)));
                let value = rounded(urad / Parameter::PER_RAD, self.angle_decimals.value) + 0.0;
                IsgPoint { position: grid.written(at), value }
            });
            angles
                .push(IsgCurve { parameter: Parameter::Angle(rotation), points: points.collect() });
        }
        if !angles.is_empty() {
            let chain = task.job.chain_for_angles("machine");
            chain.map_err(|problem| problem.help(refusals::STATE_CHAIN))?;
        }
        Ok(angles)
    }

    /// What there is to know of angles that are written, and of those that are not.
    fn notes(&self, task: Task<'_>, angles: &[IsgCurve]) -> impl Iterator<Item = TableFinding> {
        let is_written = |rotation: &Rotation| {
            angles.iter().any(|curve| curve.parameter == Parameter::Angle(*rotation))
        };
        let measured = Rotation::all().filter(|rotation| task.model.rotations[*rotation].is_some());
        let measured = measured.filter(|_| self.takes_angles(task));
        let (written, left): (Vec<_>, Vec<_>) = measured.partition(is_written);
        let written =
            (!written.is_empty()).then_some(TableFinding::AnglesWritten { angles: written });
        let left = (!left.is_empty()).then_some(TableFinding::AnglesLeft { angles: left });
        written.into_iter().chain(left)
    }

    /// `ISG_CSV`: of each axis that moves its parameters, row by row.
    fn blocks(&self, tables: &IsgTables) -> Vec<Seen> {
        let along = |axis: Axis| {
            tables.curves.iter().filter(move |curve| curve.parameter.along() == Some(axis))
        };
        let block = |axis: Axis| {
            let first = along(axis).next()?;
            let row = |index: usize| {
                let position = first.points.get(index)?.position;
                let values = along(axis).filter_map(|curve| self.text(curve, index));
                Some(seen! {
                    "position": fixed(position, self.position_decimals.value),
                    "values": values.collect::<Vec<String>>(),
                })
            };
            let rows: Vec<Seen> = (0..first.points.len()).filter_map(row).collect();
            let names = along(axis).map(|curve| curve.parameter.to_string());
            Some(seen! {
                "axis": axis.to_string(),
                "parameters": names.collect::<Vec<String>>(),
                "rows": rows,
            })
        };
        Axis::ALL.into_iter().filter_map(block).collect()
    }

    fn text(&self, curve: &IsgCurve, index: usize) -> Option<String> {
        let decimals = match curve.parameter {
            Parameter::Deviation(_) => self.value_decimals.value,
            Parameter::Angle(_) | Parameter::Turned(_) => self.angle_decimals.value,
        };
        Some(fixed(curve.points.get(index)?.value, decimals))
    }
}

/// The chain of the job; without angles its order has no effect.
fn chain(task: Task<'_>) -> Chain {
    task.job.machine.chain.unwrap_or(Chain::ALL_AXES_MOVE_THE_TOOL)
}

/// One logical axis for each of X, Y, Z.
fn logical_axes(task: Task<'_>, plan: &Plan) -> Result<PerAxis<Option<u32>>, Problems> {
    let mut problems = Problems::none();
    for (axis, names) in plan.names.iter() {
        let (key, wrong) = match names.len() {
            1 => continue,
            0 => ("machine.axes".to_string(), refusals::needs_all_axes(axis.key())),
            count => (axis_key(axis, ".ids"), refusals::takes_one_axis(count, axis)),
        };
        problems.push(task.job.source.at(&key, wrong));
    }
    let number = |axis: Axis| plan.names[axis].first()?.parse().ok();
    problems.or_ok(PerAxis::from_fn(number))
}

/// Where the pages of the maker are named.
const PAGES: &str = "docs/isg.md";

fn preconditions(task: Task<'_>, plan: &Plan, tables: &IsgTables) -> Vec<Precondition> {
    let of_axis = |axis: Axis| {
        let mut curves = tables.curves.iter();
        curves.find(|curve| curve.parameter.along() == Some(axis)).map(|curve| curve.points.len())
    };
    let records: usize = Axis::ALL.into_iter().filter_map(of_axis).sum();
    let mut list = vec![
        Precondition::new(
            "vol_comp[0].max_records of the start-up list",
            format!("at least {records}"),
            "the control reports an error when a parameter file has more records",
            format!("{PAGES} §1"),
        ),
        Precondition::new(
            "lr_param.vol_comp.v_limit of X, Y and Z",
            "above 0",
            "the correction is never changed faster; 0, the default, gives a warning when the control starts",
            format!("{PAGES} §1"),
        ),
        Precondition::new(
            "N0X, N0Y, N0Z in other parameter files of this compensation",
            "absent",
            "the forecast counts without a tool, as the control does unless these are set",
            format!("{PAGES} §2"),
        ),
    ];
    let named = |um| backlash_text(um).0;
    list.extend(plan.backlash_um.iter().filter(|(_, um)| um.is_some()).map(|(axis, _)| {
        let what = format!("{} of {axis}", task.profile.family.backlash_parameter);
        backlash_parameter(task, plan, axis, what, named, PAGES)
    }));
    list
}
