//! The points of a table: equally spaced, one of them on the reference point.
//!
//! ```text
//!          start                reference              end
//!   ─────────┼────────┼────────┼────────●────────┼────────┼──────
//!   index   first    …        −1        0        1       last
//!            └ at or beyond the end of the travel ┘
//! ```
//! Spacing is a whole number of the smallest digit the control writes, so a grid position is
//! never rounded a second time.

use crate::control::controller::ControlUnit;
use crate::inputs::job::{AxisSettings, Job, MachineAxis};
use crate::quantity::{Axis, Millimetres, Nodes, power_of_ten};
use crate::text::{Problem, Problems};
use crate::write::refusals;

/// Smallest difference of two spacings when the number of points is given (contract §2.3).
const SPACING_STEP_MM: f64 = 0.001;
/// A table may end short of the travel by this much (rounding of binary fractions), mm: a millionth
/// of a millimetre, less than every control writes.
const SHORT_MM: f64 = 1e-6;
/// A stated end of a table may miss its grid point by this much (rounding of the spacing), mm.
const END_OFF_GRID_MM: f64 = 0.001;
/// Part of a spacing by which a place may miss a grid point and still be on it (floating point).
const ON_GRID: f64 = 1e-6;

/// A table may pass the measured range by this much without being refused or named (rounding of
/// inch positions), mm.
pub const EDGE_MM: f64 = 0.01;

/// The last digit of a length in the control's files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LengthDigit {
    /// Unit of the control.
    pub unit: ControlUnit,
    /// Decimals of that unit.
    pub decimals: u32,
}

impl LengthDigit {
    /// One last digit, mm.
    pub(crate) fn digit_mm(self) -> f64 {
        self.unit.in_mm() / self.per_unit()
    }

    /// Last digits in one unit: 10^decimals.
    pub(crate) fn per_unit(self) -> f64 {
        power_of_ten(self.decimals)
    }
}

/// Equally spaced points anchored on the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Machine coordinate of index 0.
    pub reference: Millimetres,
    /// Spacing in last digits of the control's length.
    pub spacing_digits: i64,
    /// What a last digit is.
    pub digit: LengthDigit,
    /// Index of the first point, ≤ 0.
    pub first: i64,
    /// Index of the last point, ≥ 0.
    pub last: i64,
}

impl Grid {
    /// Distance of two points.
    pub fn spacing(&self) -> Millimetres {
        Millimetres::new(written_mm(self.spacing_digits, self.digit))
    }

    /// Machine coordinate of a point.
    pub fn position(&self, index: i64) -> Millimetres {
        Millimetres::new(self.reference.mm() + as_number(index) * self.spacing().mm())
    }

    /// Coordinate of a point in the control's unit, from whole last digits.
    pub(crate) fn written(&self, index: i64) -> f64 {
        let reference = (self.reference.mm() / self.digit.digit_mm()).round();
        (reference + as_number(index * self.spacing_digits)) / self.digit.per_unit() + 0.0
    }

    /// Distance of two points in the control's unit.
    pub(crate) fn written_spacing(&self) -> f64 {
        as_number(self.spacing_digits) / self.digit.per_unit()
    }

    /// Whether the points, as they are written, lie within the travel.
    pub(crate) fn is_within(&self, machine: MachineAxis) -> bool {
        let mm = |index| self.written(index) * self.digit.unit.in_mm();
        mm(self.first) >= machine.low.mm() - SHORT_MM
            && mm(self.last) <= machine.high.mm() + SHORT_MM
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        usize::try_from(self.last - self.first + 1).unwrap_or(0)
    }

    /// Which of the points is the reference.
    pub(crate) fn reference_node(&self) -> usize {
        usize::try_from(-self.first).unwrap_or(0)
    }

    /// First and last machine coordinate.
    pub fn range(&self) -> (Millimetres, Millimetres) {
        (self.position(self.first), self.position(self.last))
    }

    /// The same points as a list of nodes for fitting.
    pub fn nodes(&self) -> Nodes {
        Nodes {
            first: self.position(self.first),
            step: self.spacing(),
            count: self.count(),
            reference_node: self.reference_node(),
        }
    }
}

/// What a grid has to cover.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    below: f64,
    above: f64,
}

impl Span {
    fn of(machine: MachineAxis) -> Span {
        Span {
            below: (machine.reference - machine.low).mm().max(0.0),
            above: (machine.high - machine.reference).mm().max(0.0),
        }
    }

    /// Indices that cover the span with a spacing, but for [`SHORT_MM`].
    fn indices(self, spacing_mm: f64) -> (i64, i64) {
        (-steps(self.below, spacing_mm), steps(self.above, spacing_mm))
    }

    fn count(self, spacing_mm: f64) -> i64 {
        let (first, last) = self.indices(spacing_mm);
        last - first + 1
    }
}

fn steps(length_mm: f64, spacing_mm: f64) -> i64 {
    whole(((length_mm - SHORT_MM) / spacing_mm).ceil().max(0.0))
}

/// A grid of the spacing that the job asks for.
pub(crate) fn with_spacing(
    job: &Job,
    axis: Axis,
    machine: MachineAxis,
    settings: &AxisSettings,
    digit: LengthDigit,
    spacing_mm: f64,
) -> Result<Grid, Problems> {
    let at =
        |key: &str, wrong| job.source.at(&format!("compensation.axes.{}.{key}", axis.key()), wrong);
    if spacing_mm < digit.digit_mm() {
        let (last, unit) = (digit.digit_mm() / digit.unit.in_mm(), digit.unit.word());
        return Err(at("spacing_mm", refusals::below_digit(spacing_mm, last, unit)).into());
    }
    let mut problems = Problems::none();
    let spacing_digits = digits_of(spacing_mm, digit);
    let spacing_mm = written_mm(spacing_digits, digit);
    let (first, last) = Span::of(machine).indices(spacing_mm);
    let mut stated = |key: &str, stated_mm: Option<f64>| {
        problems.take(on_grid(machine, spacing_mm, stated_mm?).map_err(|wrong| at(key, wrong)))
    };
    let first = stated("start_mm", settings.start_mm).unwrap_or(first);
    let last = stated("end_mm", settings.end_mm).unwrap_or(last);
    if first > 0 || last < 0 {
        let key = if first > 0 { "start_mm" } else { "end_mm" };
        problems.push(at(key, refusals::without_reference(axis, machine.reference.mm())));
    }
    if first == last && problems.is_empty() {
        problems.push(at("spacing_mm", refusals::single_point(axis)));
    }
    problems.or_ok(Grid { reference: machine.reference, spacing_digits, digit, first, last })
}

/// A spacing in last digits of the control, rounded up: the table then never ends before the
/// travel because of the rounding.
fn digits_of(spacing_mm: f64, digit: LengthDigit) -> i64 {
    let digits = spacing_mm / digit.digit_mm();
    let near = digits.round();
    if (digits - near).abs() <= ON_GRID { whole(near) } else { whole(digits.ceil()) }
}

fn written_mm(spacing_digits: i64, digit: LengthDigit) -> f64 {
    as_number(spacing_digits) * digit.digit_mm()
}

/// A number that was rounded, far below 2^52; NaN and infinity saturate.
#[allow(clippy::cast_possible_truncation, reason = "the number was rounded and is far below 2^52")]
pub(crate) fn whole(rounded: f64) -> i64 {
    rounded as i64
}

/// A count as a number, far below 2^52.
pub(crate) fn as_number(count: i64) -> f64 {
    count as f64
}

fn on_grid(machine: MachineAxis, spacing_mm: f64, place_mm: f64) -> Result<i64, Problem> {
    let reference_mm = machine.reference.mm();
    let index = (place_mm - reference_mm) / spacing_mm;
    if (index - index.round()).abs() * spacing_mm <= END_OFF_GRID_MM {
        return Ok(whole(index.round()));
    }
    let [below, above] = [index.floor(), index.ceil()].map(|at| reference_mm + at * spacing_mm);
    Err(refusals::off_grid(place_mm, spacing_mm, reference_mm, below, above))
}

/// A grid of a number of points: the smallest spacing (rounded up to 0.001 mm) with which that
/// many points anchored on the reference cover the travel. Where fewer points would do with this
/// spacing, the table goes on beyond the upper end of the travel.
pub(crate) fn with_points(
    machine: MachineAxis,
    digit: LengthDigit,
    points: u32,
) -> Result<Grid, Problem> {
    let span = Span::of(machine);
    let wanted = i64::from(points);
    let fits = |step: i64| span.count(spacing_of(step)) <= wanted;
    let longest = whole(((span.below + span.above) / SPACING_STEP_MM).ceil().max(1.0));
    if !fits(longest) {
        return Err(refusals::two_points(points, machine.reference.mm()));
    }
    let (mut too_short, mut enough) = (0, longest);
    while enough - too_short > 1 {
        let middle = i64::midpoint(too_short, enough);
        if fits(middle) {
            enough = middle;
        } else {
            too_short = middle;
        }
    }
    let spacing_digits = digits_of(spacing_of(enough), digit);
    let (first, last) = span.indices(written_mm(spacing_digits, digit));
    Ok(Grid {
        reference: machine.reference,
        spacing_digits,
        digit,
        first,
        last: last + (wanted - (last - first + 1)).max(0),
    })
}

/// The largest spacing, not above another one, with points on the reference and on both ends of the travel.
pub(crate) fn ending_with_travel(
    machine: MachineAxis,
    digit: LengthDigit,
    most_mm: f64,
) -> Option<f64> {
    let digits = |mm: f64| {
        let digits = mm / digit.digit_mm();
        let is_whole = (digits - digits.round()).abs() <= ON_GRID;
        (is_whole && digits >= 0.0).then(|| whole(digits.round()))
    };
    digits(machine.reference.mm().abs())?;
    let below = digits((machine.reference - machine.low).mm())?;
    let above = digits((machine.high - machine.reference).mm())?;
    let common = common_divisor(below, above);
    let most = digits_of(most_mm, digit).max(1);
    let mut parts = (common + most - 1) / most..=common;
    let parts = parts.find(|parts| common % parts == 0)?;
    Some(written_mm(common / parts, digit))
}

fn common_divisor(a: i64, b: i64) -> i64 {
    match b {
        0 => a,
        _ => common_divisor(b, a % b),
    }
}

fn spacing_of(step: i64) -> f64 {
    as_number(step) * SPACING_STEP_MM
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(low: f64, high: f64, reference: f64) -> MachineAxis {
        MachineAxis::of([low, high, reference])
    }

    const MICRON: LengthDigit = LengthDigit { unit: ControlUnit::Millimetre, decimals: 3 };

    #[test]
    fn thirty_one_points_on_900_mm_are_30_mm_apart() {
        let grid = with_points(axis(0.0, 900.0, 0.0), MICRON, 31).expect("31 points fit");
        assert_eq!((grid.spacing_digits, grid.first, grid.last), (30_000, 0, 30));
    }

    #[test]
    fn a_reference_inside_the_travel_is_a_point() {
        let grid = with_points(axis(0.0, 900.0, 100.0), MICRON, 10).expect("10 points fit");
        // 100 mm below: 1 step; 800 mm above: 8 steps of 100 mm.
        assert_eq!((grid.spacing_digits, grid.first, grid.last), (100_000, -1, 8));
    }

    #[test]
    fn as_many_points_as_asked_for_even_where_fewer_would_do() {
        let grid = with_points(axis(-10.0, 10.0, 0.0), MICRON, 4).expect("4 points fit");
        assert_eq!((grid.spacing_digits, grid.first, grid.last), (10_000, -1, 2));
    }

    #[test]
    fn two_points_cannot_hold_a_reference_inside() {
        assert!(with_points(axis(-10.0, 10.0, 0.0), MICRON, 2).is_err());
    }

    #[test]
    fn a_spacing_that_ends_with_the_travel() {
        for (low, high, reference, most, fits) in [
            (0.0, 900.0, 0.0, 128.572, Some(112.5)),
            (-200.0, 300.0, 0.0, 33.334, Some(25.0)),
            (0.0, 400.0, 0.0, 500.0, Some(400.0)),
            (0.0, 399.9995, 0.0, 100.0, None),
            (0.0004, 400.0004, 0.0004, 100.0, None),
            (0.0, 400.0, -10.0, 100.0, None),
        ] {
            let machine = axis(low, high, reference);
            let own = ending_with_travel(machine, MICRON, most);
            assert_eq!(own, fits, "{low} to {high}");
        }
    }

    #[test]
    fn seven_does_not_divide_900() {
        let grid = with_points(axis(0.0, 900.0, 0.0), MICRON, 8).expect("8 points fit");
        assert_eq!(grid.spacing_digits, 128_572, "900 / 7 = 128.571…, rounded up");
    }
}
