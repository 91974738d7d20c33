//! Corrections and slopes against `[limits]` of the job.
//!
//! A column whose unit slipped (micrometres under a heading in mm) passes both limits in every
//! table; that is one cause, told once, at the heading.

use crate::inputs::error_table::Heading;
use crate::inputs::job::Limits;
use crate::quantity::{Deviation, UM_PER_MM};
use crate::text::{Problem, Problems};
use crate::write::task::{PlannedTable, Task, axis_key};

/// No machine tool is off by more, µm: beyond it the unit of the column is the likelier cause.
const NO_MACHINE_UM: f64 = UM_PER_MM;

/// What is asked of a table's steepest and largest value.
struct Extent {
    /// Index of the largest value, and the value.
    largest: (usize, Deviation),
    /// Index of the node before the steepest section, and its slope, µm/mm.
    steepest: (usize, f64),
}

impl Extent {
    fn of(table: &PlannedTable) -> Extent {
        let spacing = table.grid.spacing().mm();
        let slopes = table.values.windows(2);
        let slopes = slopes.map(|pair| ((pair[1] - pair[0]).um() / spacing).abs());
        let values = table.values.iter().copied().enumerate();
        let largest = values.max_by(|a, b| a.1.um().abs().total_cmp(&b.1.um().abs()));
        Extent {
            largest: largest.unwrap_or((0, Deviation::ZERO)),
            steepest: slopes.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0)),
        }
    }

    fn largest_um(&self) -> f64 {
        self.largest.1.um().abs()
    }

    /// Whether values that are `share` of these keep the limits.
    fn keeps(&self, limits: Limits, share: f64) -> bool {
        self.largest_um() * share <= limits.max_correction_um
            && self.steepest.1 * share <= limits.max_slope_um_per_mm
    }
}

/// Refuses tables beyond the limits of the job: a slip of a column's unit once for each file, all
/// else table by table.
pub(super) fn check(task: Task<'_>, tables: &[PlannedTable], problems: &mut Problems) {
    let limits = task.job.limits;
    let extents = tables.iter().map(|table| (table, Extent::of(table)));
    let beyond: Vec<(&PlannedTable, Extent)> =
        extents.filter(|(_, extent)| !extent.keeps(limits, 1.0)).collect();
    let no_machine = |(_, extent): &&(_, Extent)| extent.largest_um() > NO_MACHINE_UM;
    let is_likely = beyond.iter().any(|each| no_machine(&each));
    let mut slipped: Vec<(&Heading, &PlannedTable, &Extent)> = Vec::new();
    for (table, extent) in &beyond {
        match heading(task, table, extent).filter(|_| is_likely) {
            Some(heading) => slipped.push((heading, table, extent)),
            None => check_table(task, table, extent, problems),
        }
    }
    while let Some((first, ..)) = slipped.first() {
        let file = first.place.file.clone();
        let (own, others) = slipped.into_iter().partition(|s| s.0.place.file == file);
        problems.push(unit_slip(limits, own));
        slipped = others;
    }
}

/// The heading of a table's values, where they would keep the limits if its unit were the micrometre.
fn heading<'a>(task: Task<'a>, table: &PlannedTable, extent: &Extent) -> Option<&'a Heading> {
    let heading = task.model.headings[table.term].as_ref()?;
    let is_slip = heading.to_um > 1.0 && extent.keeps(task.job.limits, 1.0 / heading.to_um);
    is_slip.then_some(heading)
}

/// One sentence for all columns of a file.
fn unit_slip(limits: Limits, slipped: Vec<(&Heading, &PlannedTable, &Extent)>) -> Problem {
    let mut headings: Vec<&Heading> = slipped.iter().map(|(heading, ..)| *heading).collect();
    headings.sort_by_key(|heading| heading.place.column);
    headings.dedup_by_key(|heading| heading.place.column);
    let names = |name: &dyn Fn(&Heading) -> String| -> String {
        let names = headings.iter().map(|heading| format!("`{}`", name(heading)));
        names.collect::<Vec<_>>().join(", ")
    };
    let largest = |a: &f64, b: &f64| a.total_cmp(b);
    let corrections = slipped.iter().map(|(_, _, e)| e.largest_um());
    let slopes = slipped.iter().map(|(_, _, e)| e.steepest.1);
    let (um, slope) =
        (corrections.max_by(largest).unwrap_or(0.0), slopes.max_by(largest).unwrap_or(0.0));
    let message = format!(
        "{} would need corrections of up to {um:.1} µm and {slope:.3} µm/mm, the limits are {} µm and {} µm/mm; read as µm the same numbers keep them",
        names(&|heading| heading.name.clone()),
        limits.max_correction_um,
        limits.max_slope_um_per_mm
    );
    let mut problem = Problem::new(message).help(format!(
        "if the numbers are micrometres, rename to {}; else raise `max_correction_um` and `max_slope_um_per_mm` in [limits]",
        names(&Heading::in_micrometres)
    ));
    problem.place = headings.first().map(|first| first.place.clone());
    problem
}

fn check_table(task: Task<'_>, table: &PlannedTable, extent: &Extent, problems: &mut Problems) {
    let limits = task.job.limits;
    // A limit that is not stated has no line of its own.
    let section = axis_key(table.term.along, "");
    let at_limit = |key: &str, message: String| {
        let path = format!("limits.{key}");
        let stated = task.job.source.place_of(&path).is_some();
        let path = if stated { &path } else { &section };
        task.job.problem_at(path, message)
    };
    let place = |index: usize| {
        let grid = &table.grid;
        let index = grid.first + i64::try_from(index).unwrap_or(0);
        grid.position(index).mm()
    };
    let (index, value) = extent.largest;
    if extent.largest_um() > limits.max_correction_um {
        let help = if extent.largest_um() > NO_MACHINE_UM {
            "is the unit of the column right? else raise `max_correction_um` in [limits]"
        } else {
            "check the measurement; else raise `max_correction_um` in [limits]"
        };
        let message = format!(
            "{} would need a correction of {:.1} µm at {} mm, the limit is {} µm",
            table.term,
            (-value).um(),
            place(index),
            limits.max_correction_um
        );
        problems.push(at_limit("max_correction_um", message).help(help));
    }
    let (index, slope) = extent.steepest;
    if slope > limits.max_slope_um_per_mm {
        problems.push(
            at_limit("max_slope_um_per_mm", format!("{} would change by {slope:.3} µm/mm between {} and {} mm, the limit is {} µm/mm", table.term, place(index), place(index + 1), limits.max_slope_um_per_mm))
                .help("check the unit and the measurement there; else raise `max_slope_um_per_mm` in [limits]"),
        );
    }
}
