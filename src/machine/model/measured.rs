//! How a term was measured, and whether its places fit the machine.
//! The nine angular errors: columns `ea_…`, `eb_…`, `ec_…` of the error table, or a table of their own.

use crate::inputs::error_table::{ErrorTable, Kind, Series};
use crate::inputs::job::{Job, MachineAxis};
use crate::machine::findings::{ModelFinding, two_digits};
use crate::quantity::{
    Axis, Deviation, Direction, ErrorCurve, ErrorTerm, Millimetres, PerTerm, Rotation,
};
use crate::text::{Finding, Problem, Problems, counted};

/// How a term was measured.
#[derive(Clone, Debug, PartialEq)]
pub enum TermCurves {
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

impl TermCurves {
    /// One or two curves with their directions, + before −; `None` = there is none.
    pub(super) fn of(
        mut curves: impl Iterator<Item = (Option<Direction>, ErrorCurve)>,
    ) -> Option<TermCurves> {
        let (direction, first) = curves.next()?;
        Some(match (direction, curves.next()) {
            (_, Some((_, minus))) => TermCurves::BothWays { plus: first, minus },
            (Some(direction), None) => TermCurves::OneWay(direction, first),
            (None, None) => TermCurves::Undirected(first),
        })
    }

    /// Its curves with the direction that each is for, + before −.
    pub(crate) fn ways(&self) -> impl Iterator<Item = (Option<Direction>, &ErrorCurve)> {
        let (way, first, second) = match self {
            TermCurves::Undirected(curve) => (None, curve, None),
            TermCurves::OneWay(way, curve) => (Some(*way), curve, None),
            TermCurves::BothWays { plus, minus } => (Some(Direction::Plus), plus, Some(minus)),
        };
        let second = second.map(|minus| (Some(Direction::Minus), minus));
        std::iter::once((way, first)).chain(second)
    }

    /// The curve without regard to direction: of two the mean, over the range that both cover.
    pub fn mean(&self) -> ErrorCurve {
        match self {
            TermCurves::Undirected(curve) | TermCurves::OneWay(_, curve) => curve.clone(),
            TermCurves::BothWays { plus, minus } => {
                plus.mean_with(minus).unwrap_or_else(|| plus.clone())
            }
        }
    }

    /// The curve that holds while the axis moves in `direction`, if that direction was measured.
    pub fn curve(&self, direction: Direction) -> Option<&ErrorCurve> {
        self.ways().find_map(|(way, curve)| way.is_none_or(|way| way == direction).then_some(curve))
    }

    /// The curve that is zero at the reference, and its direction: that of the reference return, else the first.
    pub(crate) fn zeroed(&self, homing: Direction) -> (Option<Direction>, &ErrorCurve) {
        match (self, homing) {
            (TermCurves::BothWays { minus, .. }, Direction::Minus) => (Some(homing), minus),
            (TermCurves::BothWays { plus, .. }, Direction::Plus) => (Some(homing), plus),
            (TermCurves::OneWay(way, curve), _) => (Some(*way), curve),
            (TermCurves::Undirected(curve), _) => (None, curve),
        }
    }

    /// Whether the two directions were measured apart.
    pub(crate) fn has_both_ways(&self) -> bool {
        matches!(self, TermCurves::BothWays { .. })
    }
}

/// Lowest and highest position.
pub(crate) type Range = (Millimetres, Millimetres);

/// What two ranges have in common; the first where there is no second.
pub(crate) fn within((from, to): Range, other: Option<Range>) -> Range {
    let (low, high) = other.unwrap_or((from, to));
    (if low > from { low } else { from }, if high < to { high } else { to })
}

pub(super) fn measured_range(series: &[Series]) -> Option<Range> {
    let ends = |s: &Series| Some((*s.positions.first()?, *s.positions.last()?));
    series.iter().filter_map(ends).reduce(|a, b| within(a, Some(b)))
}

/// Problems: places outside the travel, directions that do not overlap, angles that were not measured where they are
/// to be zero.
pub(super) fn check_places(job: &Job, table: &ErrorTable, problems: &mut Problems) {
    Axis::ALL.into_iter().for_each(|axis| check_axis(job, table, axis, problems));
    check_zeros(job, table, problems);
}

fn check_axis(job: &Job, table: &ErrorTable, axis: Axis, problems: &mut Problems) {
    let series = table.series(axis);
    let Some(last) = series.last() else { return };
    let Some(machine) = job.machine.axes[axis] else {
        let words =
            format!("axis {axis} was measured, but [machine.axes.{}] is missing", axis.key());
        let problem = job.problem_at("machine.axes", words);
        problems.push(problem.help("add travel_mm and reference_mm of this axis"));
        return;
    };
    let at_row = |problem: Problem, series: &Series, row| {
        table.place(series, row).into_iter().fold(problem, Problem::at)
    };
    for series in series {
        let rows = outside(series, machine);
        let Some(first) = rows.first() else { continue };
        let position = series.positions[*first].mm();
        let more = match rows.len() - 1 {
            0 => String::new(),
            more => format!(", and {}", counted(more, "more row")),
        };
        let (low, high) = (machine.low.mm(), machine.high.mm());
        let words = format!(
            "position {position} mm of axis {axis} lies outside its travel {low} … {high} mm{more}"
        );
        let help = "positions are machine coordinates in the unit of their column; correct them or `travel_mm`";
        problems.push(at_row(Problem::new(words).help(help), series, *first));
    }
    if measured_range(series).is_some_and(|(low, high)| low >= high) {
        let words = format!(
            "the two directions of axis {axis} were measured at places that do not overlap"
        );
        let problem = Problem::new(words).help("measure both directions over the same range");
        problems.push(at_row(problem, last, 0));
    }
}

/// Targets may miss the stated travel by this much (rounding of inch positions).
const TRAVEL_TOLERANCE_MM: f64 = 0.01;

/// The rows outside the travel.
fn outside(series: &Series, machine: MachineAxis) -> Vec<usize> {
    let [low, high] = [machine.low, machine.high].map(Millimetres::mm);
    let travel = low - TRAVEL_TOLERANCE_MM..=high + TRAVEL_TOLERANCE_MM;
    let rows = 0..series.positions.len();
    rows.filter(|row| !travel.contains(&series.positions[*row].mm())).collect()
}

/// Errors that stay below this in every term are more often a unit error, µm; a laser resolves
/// a tenth of it at best.
pub(super) const UNLIKELY_SMALL_UM: f64 = 0.1;
/// How many times larger than those the largest of the other axes is where the unit of one axis is wrong.
const UNLIKELY_TIMES: f64 = 100.0;
/// Fewer values than these may be small by chance.
pub(super) const FEWEST_POSITIONS: usize = 4;

/// Refuses terms in µm that stay below a tenth while others of their kind (positioning, cross terms) are hundred
/// times larger: mm under `_um`. A smaller `noise_um` confirms them; a predicted or separated table has no such slip.
pub(super) fn refuse_unlikely(
    job: &Job,
    table: &ErrorTable,
    sizes: &[(ErrorTerm, f64)],
    problems: &mut Problems,
) {
    let written = table.remarks.frame.is_none() && table.remarks.simulated().next().is_none();
    let noise_um = job.measurement.uncertainty.noise_um.unwrap_or(f64::INFINITY);
    for (term, um) in sizes.iter().filter(|_| written) {
        let sisters = sizes.iter().filter(|(of, _)| of.is_positioning() == term.is_positioning());
        let largest = sisters.max_by(|a, b| a.1.total_cmp(&b.1));
        let small = *um > 0.0 && *um < UNLIKELY_SMALL_UM.min(noise_um);
        let heading = table.heading(*term).filter(|heading| small && heading.to_um <= 1.0);
        let (Some(heading), Some((sister, large))) = (heading, largest) else { continue };
        if *large >= UNLIKELY_TIMES * um {
            let (name, axis, um) = (&heading.name, term.along, two_digits(*um));
            let words = format!(
                "{term} reaches {um} µm only, and {sister} {large:.3} µm: are the values of `{name}` in the rows of {axis} mm?"
            );
            let help = format!(
                "write them in µm; if they are right, state the `noise_um` of a reading, which then lies below {um}"
            );
            problems.push(Problem::new(words).at(heading.place.clone()).help(help));
        }
    }
}

/// The measured rotations of a table, µrad in place of µm.
pub(super) fn rotations(job: &Job, table: &ErrorTable) -> PerTerm<Option<TermCurves>> {
    // Rotations stand in the places of the terms.
    PerTerm::from_fn(|ErrorTerm { of: about, along }| {
        let curves = table.series(along).iter().filter_map(|series| {
            let angles = series.values.get(&Kind::Angle(about))?;
            let angles: Vec<Deviation> = angles.iter().copied().map(Deviation::from_um).collect();
            let curve = ErrorCurve::through(&series.positions, &angles, job.compensation.curve);
            let zero_at = job.measurement.levers.angles_zero[along];
            let curve = zero_at.map_or(curve.clone(), |place| curve.rezeroed_at(place));
            Some((series.direction, curve))
        });
        TermCurves::of(curves)
    })
}

/// Places where angles are to be zero and were not measured: nothing is known of them there.
pub(in crate::machine) fn check_zeros(job: &Job, table: &ErrorTable, problems: &mut Problems) {
    for (axis, place) in job.measurement.levers.angles_zero.iter() {
        let Some(place) = *place else { continue };
        let series = table.series(axis).iter().filter(|s| has_angles(s));
        let ends = series.filter_map(|s| s.positions.first().zip(s.positions.last()));
        let outside = ends.into_iter().find(|(low, high)| place < **low || place > **high);
        if let Some((low, high)) = outside {
            let [place, low, high] = [place, *low, *high].map(Millimetres::mm);
            let key = format!("measurement.angles_zero_mm.{}", axis.key());
            let words = format!(
                "the angles of {axis} are to be zero at {place} mm, but they were measured from {low} to {high} mm only"
            );
            let help = "give a place where they were measured (`angles_zero_mm`; without it `offsets_mm`): nothing is extrapolated";
            problems.push(job.problem_at(&key, words).help(help));
        }
    }
}

/// Both tables' rotations as one.
pub(super) fn added(
    job: &Job,
    table: &ErrorTable,
    known: &PerTerm<Option<TermCurves>>,
) -> Result<PerTerm<Option<TermCurves>>, Problems> {
    let mut problems = Problems::none();
    check_places(job, table, &mut problems);
    no_angles(table).into_iter().for_each(|problem| problems.push(problem));
    let mut all = rotations(job, table);
    for rotation in Rotation::all() {
        let Some(own) = &known[rotation] else { continue };
        if all[rotation].replace(own.clone()).is_some() {
            let words = format!("{rotation} stands in the error table and in `angles`");
            let problem = Problem::new(words).at(table.header.clone());
            problems.push(problem.help("give each angular error in one table"));
        }
    }
    problems.or_ok(all)
}

/// Whether rows hold an angle.
pub(in crate::machine) fn has_angles(series: &Series) -> bool {
    series.values.keys().any(|kind| matches!(kind, Kind::Angle(_)))
}

/// The problem of a table without any.
pub(in crate::machine) fn no_angles(table: &ErrorTable) -> Option<Problem> {
    let name = &table.source.name;
    let words = format!("`{name}` holds no angles, expected columns such as `ea_urad`");
    let help = "name a table with ea, eb or ec, or remove `angles`";
    (!holds(table, has_angles)).then(|| Problem::new(words).at(table.header.clone()).help(help))
}

/// What a kit has to say of measured angles.
pub(super) fn not_compensated(table: &ErrorTable) -> Option<Finding> {
    holds(table, has_angles).then(|| ModelFinding::AnglesNotCompensated.into())
}

/// What a table of `angles` holds that nobody reads.
pub(super) fn deviations_beside(table: &ErrorTable) -> Option<Finding> {
    let is_deviation = |kind: &Kind| matches!(kind, Kind::Deviation(_));
    let has_deviations = |s: &Series| s.values.keys().any(is_deviation);
    let file = || ModelFinding::DeviationsBeside { file: table.source.name.clone() };
    holds(table, has_deviations).then(|| file().into())
}

fn holds(table: &ErrorTable, what: impl Fn(&Series) -> bool) -> bool {
    Axis::ALL.into_iter().flat_map(|axis| table.series(axis)).any(what)
}
