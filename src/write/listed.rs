//! Tables that list their points one by one: a plan into the numbers of any such control ([`Form`]).
//!
//! * One table for each pair of axes, with a column for each direction where its form has two.
//! * Values are rounded to the last decimal once; increments are differences of rounded values, so that rounding
//!   never adds up.

use crate::control::controller::{Form, Order, Outside, PointLists, Rounding, ValueForm};
use crate::control::table::{ListedTable, ListedTables, Point, Tables};
use crate::quantity::{Axis, Deviation, Direction, Millimetres, UM_PER_MM, rounded};
use crate::text::Problems;
use crate::write::control_text::fixed;
use crate::write::family::{
    Compiled, Family, Placement, ProofOf, backlash_text, column, control_state,
};
use crate::write::refusals;
use crate::write::task::{Plan, PlannedTable, Task, axis_key};

/// A plan in the numbers of a control, without preconditions and notes.
pub(super) fn compile(
    own: &impl PointLists,
    task: Task<'_>,
    plan: &Plan,
    place: impl Fn(&PlannedTable) -> String,
) -> Result<Compiled, Problems> {
    let backlash_um = |axis| match own.replaces_parameter() {
        true => 0.0,
        false => plan.backlash_um[axis].map_or(0.0, |um| backlash_text(um).1),
    };
    let state = control_state(task, plan, backlash_um);
    let cancels = |planned: &PlannedTable, way| {
        let replaced = own.replaces_parameter() && planned.term.is_positioning();
        let axis = plan.names[planned.term.of].first().and_then(|own| state.axis(own));
        column(plan, planned.term, axis.filter(|_| replaced), way)
    };
    let form = |planned: &PlannedTable| form_of(own, task, planned);
    let tables = tables(plan, form, |_| true, cancels);
    check(own, task, &tables)?;
    check_ends(task, plan, form, cancels)?;
    let placed = plan.tables.iter().map(|own| Placement::of(own, place(own), form(own).count_um()));
    Ok(Compiled::of(Tables::Listed(ListedTables::of(tables)), placed.collect(), state))
}

/// What the numbers mean of a planned table. Of the generic table each direction has its own block, and values without
/// digits of their own are multiples of the detection unit.
pub(super) fn form_of(own: &impl PointLists, task: Task<'_>, planned: &PlannedTable) -> Form {
    let unit = task.job.compensation.control_unit;
    let unit_um = task.detection_unit_um(planned.term.of);
    let form = own.form(planned.term.is_positioning(), unit);
    let form = match unit_um {
        Some(um) => form.on_axis(um),
        None => form, // no control emulates counts of a unit that is not known
    };
    match form.names_terms {
        false => form,
        true => Form {
            has_two: planned.direction.is_some(),
            rounding: match (form.rounding, unit_um) {
                (Rounding::None, Some(um)) => Rounding::Multiple(um),
                (own, _) => own,
            },
            ..form
        },
    }
}

/// The tables of one mechanism; both columns of those of the term have the bump.
pub(super) fn proof_tables<F: PointLists + Family>(own: &F, proof: &ProofOf<'_>) -> Tables {
    let belongs = |planned: &PlannedTable| own.belongs(proof.mechanism, planned);
    let form = |planned: &PlannedTable| form_of(own, proof.task, planned);
    let bump = |planned: &PlannedTable, _| {
        proof.deviations(planned.term == proof.term, planned.values.len())
    };
    Tables::Listed(ListedTables::of(tables(proof.plan, form, belongs, bump)))
}

/// The tables of some of a plan, one for each pair of axes, from what each column cancels.
fn tables(
    plan: &Plan,
    form: impl Fn(&PlannedTable) -> Form,
    is_wanted: impl Fn(&PlannedTable) -> bool,
    cancels: impl Fn(&PlannedTable, Direction) -> Vec<Deviation>,
) -> Vec<ListedTable> {
    let mut tables: Vec<ListedTable> = Vec::new();
    for planned in plan.tables.iter().filter(|own| is_wanted(own)) {
        for output in &plan.names[planned.term.of] {
            let base = plan.base_of(planned.term, output);
            if tables.iter().any(|own| own.is_for(base, output)) {
                continue; // of two directions the first wrote both columns
            }
            let ways = Direction::BOTH.map(|way| cancels(planned, way));
            let form = form(planned);
            tables.push(ListedTable {
                term: form.names_terms.then_some(planned.term),
                base: base.to_string(),
                output: output.clone(),
                points: points(&form, planned, ways),
            });
        }
    }
    tables
}

/// The points of a table in the order of the file; rounded here, once.
fn points(form: &Form, planned: &PlannedTable, ways: [Vec<Deviation>; 2]) -> Vec<Point> {
    let grid = &planned.grid;
    let place = |at: i64| file_place(form, grid.written(at));
    let places: Vec<f64> = (grid.first..=grid.last).map(place).collect();
    let [forward, reverse] = ways.map(|values| numbers(form, &places, &values));
    let rows = places.iter().zip(forward).zip(reverse);
    let point = |((position, forward), reverse): ((&f64, f64), f64)| Point {
        position: *position,
        forward,
        reverse: form.has_two.then_some(reverse),
    };
    let mut points: Vec<Point> = rows.map(point).collect();
    if form.order == Order::Descending {
        points.reverse();
    }
    points
}

/// A place of a grid in the unit of the file.
fn file_place(form: &Form, written: f64) -> f64 {
    let unit_um = if form.is_inch() { form.position_um } else { UM_PER_MM };
    rounded(written * (unit_um / form.position_um), form.position_decimals) + 0.0
}

/// Multiples of a detection unit are freed from binary dust at a femtometre.
pub(super) const DUST_DECIMALS: u32 = 9;

/// The numbers of a column that cancels deviations.
fn numbers(form: &Form, places: &[f64], deviations: &[Deviation]) -> Vec<f64> {
    let mut before: Option<f64> = None;
    let value = |(place, deviation): (&f64, &Deviation)| {
        let um = form.sign.table_um(*deviation);
        let amount = match form.rounding {
            Rounding::None => um / form.value_um,
            Rounding::LastDecimal | Rounding::Multiple(_) => {
                let count_um = form.count_um();
                let counts = rounded(um / count_um, DUST_DECIMALS).round(); // a decimal tie is one
                rounded(counts * count_um / form.value_um, DUST_DECIMALS)
            }
        };
        let last = before.replace(amount).unwrap_or(amount);
        0.0 + match form.value {
            ValueForm::Amount => amount,
            ValueForm::Position => rounded(place + amount, form.decimals()),
            ValueForm::Increment => rounded(amount - last, form.value_decimals),
        }
    };
    places.iter().zip(deviations).map(value).collect()
}

/// What the control does not take, or does not say what it does with.
fn check(own: &impl PointLists, task: Task<'_>, tables: &[ListedTable]) -> Result<(), Problems> {
    let mut problems = Problems::none();
    let unit = task.job.compensation.control_unit;
    for table in tables {
        let form = own.form(table.is_own(), unit);
        let most = form.largest;
        let numbers = table.points.iter().flat_map(|point| [Some(point.forward), point.reverse]);
        let largest = numbers.flatten().fold(0.0_f64, |most, number| most.max(number.abs()));
        if largest > most {
            let largest = fixed(largest, form.decimals());
            let wrong = refusals::large_value(own.table_name(table), largest, most);
            problems.push(task.job.source.at("compensation.axes", wrong));
        }
    }
    problems.or_ok(())
}

/// Tables that end inside the travel, where what the control adds outside is not known, or nothing and the value at the
/// end is something.
fn check_ends(
    task: Task<'_>,
    plan: &Plan,
    form: impl Fn(&PlannedTable) -> Form,
    cancels: impl Fn(&PlannedTable, Direction) -> Vec<Deviation>,
) -> Result<(), Problems> {
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        let Some(machine) = task.job.machine.axes[axis] else {
            continue;
        };
        let is_short = |planned: &&PlannedTable| {
            let ways = Direction::BOTH.map(|way| cancels(planned, way));
            planned.term.along == axis
                && ends_short(planned, [machine.low, machine.high], &form(planned), &ways)
        };
        let Some(planned) = plan.tables.iter().find(is_short) else {
            continue;
        };
        let wrong = refusals::ends_inside(axis, form(planned).outside.why());
        problems.push(task.job.source.at(&axis_key(axis, ""), wrong));
    }
    problems.or_ok(())
}

fn ends_short(
    planned: &PlannedTable,
    [low, high]: [Millimetres; 2],
    form: &Form,
    ways: &[Vec<Deviation>; 2],
) -> bool {
    /// A table may end short of the travel by this much (rounding of positions), mm.
    const END_MM: f64 = 1e-3;
    let is_nothing = |value: Option<&Deviation>| {
        rounded(value.map_or(0.0, |own| own.um() / form.count_um()), 0).abs() < 1.0
    };
    let may_end = |end: fn(&[Deviation]) -> Option<&Deviation>| match form.outside {
        Outside::Hold => true,
        Outside::Zero => ways.iter().all(|own| is_nothing(end(own))),
        Outside::Unknown => false,
    };
    let (from, to) = planned.grid.range();
    from.mm() > low.mm() + END_MM && !may_end(<[Deviation]>::first)
        || to.mm() < high.mm() - END_MM && !may_end(<[Deviation]>::last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::controller::{ControlUnit, Dialect, builtin};

    /// Counts of 0.1 µm: none of these decimal numbers is a binary one.
    #[test]
    fn a_tie_of_decimal_numbers_goes_away_from_zero() {
        let Dialect::Declared(facts) = builtin::profile("isg-axis").unwrap().dialect else {
            panic!("it is declared");
        };
        let form = facts.form(true, ControlUnit::Millimetre);
        let um = [0.15, 0.35, 0.45, 1.15, -0.15, 0.149_999, 1.05].map(Deviation::from_um);
        let counts = numbers(&form, &[0.0; 7], &um);
        assert_eq!(counts, [2.0, 4.0, 5.0, 12.0, -2.0, 1.0, 11.0]);
    }
}
