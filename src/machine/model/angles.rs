//! The nine angular errors: columns `ea_…`, `eb_…`, `ec_…` of the error table, or a table of their own.

use super::{Measured, check_axis};
use crate::inputs::error_table::{ErrorTable, Series};
use crate::inputs::job::Job;
use crate::quantity::axis::{Axis, PerTerm, Rotation};
use crate::quantity::curve::ErrorCurve;
use crate::quantity::units::Deviation;
use crate::text::problem::{Problem, Problems};

/// The measured rotations of a table, µrad in place of µm.
pub(super) fn rotations(job: &Job, table: &ErrorTable) -> PerTerm<Option<Measured>> {
    let mut measured = PerTerm::from_fn(|_| None);
    for rotation in Rotation::all() {
        measured[rotation] = of_rotation(job, table.series(rotation.along), rotation);
    }
    measured
}

fn of_rotation(job: &Job, series: &[Series], rotation: Rotation) -> Option<Measured> {
    let zero_at = job.measurement.levers.angles_zero[rotation.along];
    let curves = series.iter().filter_map(|series| {
        let angles = series.angles_urad[rotation.about].as_ref()?;
        let angles: Vec<Deviation> = angles.iter().copied().map(Deviation::from_um).collect();
        let curve = ErrorCurve::through(&series.positions, &angles, job.compensation.curve);
        let curve = zero_at.map_or(curve.clone(), |place| curve.rezeroed_at(place));
        Some((series.direction, curve))
    });
    Measured::of(curves)
}

/// Places where angles are to be zero and were not measured: nothing is known of them there.
pub(super) fn check_zeros(job: &Job, table: &ErrorTable, problems: &mut Problems) {
    for (axis, place) in job.measurement.levers.angles_zero.iter() {
        let Some(place) = *place else { continue };
        let has_angles = |s: &&Series| s.angles_urad.iter().any(|(_, angles)| angles.is_some());
        let series = table.series(axis).iter().filter(has_angles);
        let ends = series.filter_map(|s| s.positions.first().zip(s.positions.last()));
        let outside = ends
            .into_iter()
            .find(|(low, high)| place < **low || place > **high);
        if let Some((low, high)) = outside {
            let key = format!("measurement.angles_zero_mm.{}", axis.key());
            let words = format!(
                "the angles of {axis} are to be zero at {} mm, but they were measured from {} to {} mm only",
                place.mm(),
                low.mm(),
                high.mm()
            );
            problems.push(
                job.problem_at(&key, words)
                    .help("give a place where they were measured: nothing is extrapolated"),
            );
        }
    }
}

/// Both tables' rotations as one.
pub(super) fn added(
    job: &Job,
    table: &ErrorTable,
    known: &PerTerm<Option<Measured>>,
) -> Result<PerTerm<Option<Measured>>, Problems> {
    let mut problems = Problems::none();
    for axis in Axis::ALL {
        check_axis(job, table, axis, &mut problems);
    }
    check_zeros(job, table, &mut problems);
    let refuse = |message: String, help: &str| {
        let problem = Problem::new(message).at(table.header.clone());
        problem.help(help)
    };
    let mut all = rotations(job, table);
    if Rotation::all().all(|rotation| all[rotation].is_none()) {
        problems.push(refuse(
            format!(
                "`{}` holds no angles, expected columns such as `ea_urad`",
                table.source.name
            ),
            "name a table with ea, eb or ec, or remove `angles`",
        ));
    }
    for rotation in Rotation::all() {
        match (&known[rotation], &all[rotation]) {
            (Some(_), Some(_)) => problems.push(refuse(
                format!("{rotation} stands in the error table and in `angles`"),
                "give each angular error in one table",
            )),
            (Some(_), None) => all[rotation].clone_from(&known[rotation]),
            _ => {}
        }
    }
    problems.or_ok(all)
}

/// What a kit has to say of measured angles.
pub(super) fn not_compensated(table: &ErrorTable) -> Option<String> {
    let has_angles = |axis: Axis| {
        let series = table.series(axis).iter();
        series
            .flat_map(|s| Axis::ALL.map(|about| s.angles_urad[about].is_some()))
            .any(|measured| measured)
    };
    Axis::ALL.into_iter().any(has_angles).then(|| "angular errors (`ea_…`, `eb_…`, `ec_…`) are not compensated by these tables; `nonius assess` counts what they do in the volume".to_string())
}

/// What a table of `angles` holds that nobody reads.
pub(super) fn deviations_beside(table: &ErrorTable) -> Option<String> {
    let deviation = |series: &Series| series.deviations.iter().any(|(_, d)| d.is_some());
    let has = |axis: Axis| table.series(axis).iter().any(deviation);
    Axis::ALL.into_iter().any(has).then(|| {
        format!(
            "`{}` is named as `angles`; the deviations that stand beside them are not used",
            table.source.name
        )
    })
}
