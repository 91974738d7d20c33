//! A measuring run, move by move, in whole last digits of the control, and the mirror that it needs.

use crate::control::controller::program::ProgramFacts;
use crate::control::controller::{ControlUnit, Profile, builtin};
use crate::inputs::job::{Job, ProgramRequest, RunType};
use crate::quantity::{Axis, Diagonal, Figure, LaserPath, Pass, PathKind, PerAxis, Squared, unit};
use crate::text::{Finding, Problem, joined};
use crate::write::control_text::with_point;
use crate::write::grid::{LengthDigit, as_number, whole};
use crate::write::refusals;

/// A length as a number of the control's last digits.
pub type Digits = i64;

/// How far a length may be from whole digits to be one: what binary numbers add, not a length.
const WHOLE: f64 = 1e-4;

impl LengthDigit {
    /// One last digit for people.
    pub(super) fn words(self) -> String {
        let digit = 1.0 / self.per_unit();
        let digit = format!("{digit:.*} {}", self.decimals as usize, self.unit.word());
        match self.unit {
            ControlUnit::Millimetre => digit,
            ControlUnit::Inch => format!("{digit} ({} mm)", Figure(self.mm(1)).trimmed(6)),
        }
    }

    /// A length in mm.
    pub fn mm(self, digits: Digits) -> f64 {
        // Division last: 1500 digits of 0.001 mm are 1.5 mm exactly.
        as_number(digits) * self.unit.in_mm() / self.per_unit()
    }

    /// A length that is a whole number of digits.
    pub fn digits(self, mm: f64) -> Option<Digits> {
        let exact = mm / self.digit_mm();
        ((exact - exact.round()).abs() < WHOLE).then(|| self.nearest(mm))
    }

    /// The nearest whole number of digits.
    pub fn nearest(self, mm: f64) -> Digits {
        whole((mm / self.digit_mm()).round())
    }

    /// The largest whole number of digits that is not longer.
    pub(crate) fn at_most(self, mm: f64) -> Digits {
        whole((mm / self.digit_mm() + WHOLE).floor())
    }

    /// The smallest whole number of digits that is not shorter.
    pub(crate) fn at_least(self, mm: f64) -> Digits {
        whole((mm / self.digit_mm() - WHOLE).ceil())
    }

    /// A length as it stands in a program, in the control's unit; never `-0`.
    pub fn text(self, digits: Digits) -> String {
        with_point(digits, self.decimals as usize)
    }
}

/// One standstill that is read.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedReading {
    /// Number of the run, from 1.
    pub run: u32,
    /// Forward or back.
    pub pass: Pass,
    /// Node along the forward path, or target of a single axis.
    pub node: usize,
    /// Axis of the forward step from node − 1 to node; `None` at node 0 and where all move.
    pub moved: Option<Axis>,
    /// Nominal displacement along the laser from node 0, mm.
    pub nominal_mm: f64,
    /// Machine coordinates.
    pub place: PerAxis<Digits>,
}

/// One thing that the machine does.
#[derive(Clone, Debug, PartialEq)]
pub enum Move {
    /// Waits for cycle start; the text is shown to the operator.
    Stop(String),
    /// A remark in the program.
    Remark(String),
    /// To a place in machine coordinates, at rapid traverse: X and Y together, then Z alone.
    Approach(PerAxis<Digits>),
    /// By an increment, at the feed.
    Feed(PerAxis<Digits>),
    /// Stands still; the reading with this index is taken.
    Dwell(usize),
}

/// The program of one set-up of the laser.
#[derive(Clone, Debug, PartialEq)]
pub struct SetUpProgram {
    /// What it measures.
    pub subject: LaserPath,
    /// Its moves in order.
    pub moves: Vec<Move>,
    /// Its readings in order.
    pub readings: Vec<PlannedReading>,
}

/// A measuring run, complete.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuringRun {
    /// The last digit of a position.
    pub resolution: LengthDigit,
    /// One program for each set-up.
    pub programs: Vec<SetUpProgram>,
    /// What the mirror has to cover; step diagonals only.
    pub mirror: Option<MirrorSize>,
    /// What has to be known beside the files.
    pub notes: Vec<Finding>,
}

/// Most readings of one program: block numbers have four digits on every control.
pub(super) const MOST_READINGS: usize = 9999;

/// A run to be planned and written: what is asked for, and what the control understands.
#[derive(Clone, Copy, Debug)]
pub struct RunTask<'a> {
    /// The job.
    pub job: &'a Job,
    /// Its `[program]`.
    pub request: &'a ProgramRequest,
    /// The control.
    pub profile: &'a Profile,
    /// Its part programs.
    pub facts: &'a ProgramFacts,
}

impl<'a> RunTask<'a> {
    /// Refused where the job asks for no run, or where the control has no language for it.
    pub fn of(job: &'a Job, profile: &'a Profile) -> Result<RunTask<'a>, Problem> {
        Ok(RunTask {
            job,
            profile,
            facts: profile.program.as_ref().ok_or_else(|| no_language(job, profile))?,
            request: job.program.as_ref().ok_or_else(|| no_section(job))?,
        })
    }

    /// The last digit of a position.
    pub fn resolution(&self) -> LengthDigit {
        let unit = self.job.compensation.control_unit;
        LengthDigit { unit, decimals: self.facts.decimals(unit) }
    }
}

fn no_section(job: &Job) -> Problem {
    job.source.at("program", refusals::no_run())
}

fn no_language(job: &Job, profile: &Profile) -> Problem {
    let known = builtin::ids()
        .into_iter()
        .filter(|id| builtin::profile(id).is_ok_and(|profile| profile.program.is_some()));
    job.source.at("compensation.controller", refusals::no_language(&profile.id, joined(known)))
}

impl MeasuringRun {
    /// Time of all programs without operator and approach, s: path / feed and standstills.
    pub(crate) fn duration_s(&self, request: &ProgramRequest) -> f64 {
        let moves = self.programs.iter().flat_map(|program| &program.moves);
        let seconds = moves.map(|step| match step {
            Move::Feed(by) => {
                let squares = by.iter().map(|(_, d)| self.resolution.mm(*d).squared());
                60.0 * squares.sum::<f64>().sqrt() / request.feed_mm_per_min
            }
            Move::Dwell(_) => request.dwell_s,
            _ => 0.0,
        });
        seconds.sum()
    }

    /// Smallest and largest commanded coordinate of an axis, mm.
    pub(crate) fn reach_mm(&self, axis: Axis) -> Option<(f64, f64)> {
        let mut reach: Option<(Digits, Digits)> = None;
        for place in self.programs.iter().flat_map(SetUpProgram::places) {
            let (low, high) = reach.unwrap_or((place[axis], place[axis]));
            reach = Some((low.min(place[axis]), high.max(place[axis])));
        }
        reach.map(|(low, high)| (self.resolution.mm(low), self.resolution.mm(high)))
    }
}

impl SetUpProgram {
    /// Every commanded place, machine coordinates.
    pub fn places(&self) -> Vec<PerAxis<Digits>> {
        let mut here = PerAxis::from_fn(|_| 0);
        let mut places = Vec::new();
        for step in &self.moves {
            match step {
                Move::Approach(place) => here = *place,
                Move::Feed(by) => here = PerAxis::from_fn(|axis| here[axis] + by[axis]),
                _ => continue,
            }
            places.push(here);
        }
        places
    }
}

// What the flat mirror of a step diagonal has to cover.
//
// The mirror stands across the diagonal and is carried along; a step of one axis carries it
// sideways as well, so the beam meets it at another spot. In the mirror's plane the spots of a cell are
// ```text
//        · after the 2nd move          s(node) = d − (d·u)u,  d = node − start, u = the beam
//       ╱ ╲
//      ╱   ╲                           after the 1st move of axis k it is
//     ·─────· after the 1st            step_k · √(1 − (V_k/R)²)
//   cell ends
// ```
// Preload and overrun lie beside the cell ends by p − (p·u)u.

/// Size of the mirror that a step diagonal needs, without the diameter of the beam; the same for
/// all four diagonals, because their spots are mirror images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorSize {
    /// Farthest spot from that of the cell ends inside a cell: after the first and the second move, mm.
    pub excursion_mm: [f64; 2],
    /// Farthest spot from that of the cell ends, with preload and overrun, mm.
    pub farthest_mm: f64,
    /// Diameter of the smallest circle around all spots, mm.
    pub circle_mm: f64,
}

type Spot = [f64; 2];

pub(super) fn needed(request: &ProgramRequest) -> Option<MirrorSize> {
    if request.what != RunType::StepDiagonal {
        return None;
    }
    let volume = &request.volume;
    let start = volume.inside_mm(Diagonal::Ppp, PathKind::Step, 0);
    let from_start =
        |node: usize| volume.inside_mm(Diagonal::Ppp, PathKind::Step, node).minus(start);
    let beyond = |mm: f64| PerAxis { x: mm, y: mm, z: mm }; // PPP goes ahead on every axis
    let plane = across(volume.laser(Diagonal::Ppp));
    let places = [
        from_start(0),
        from_start(1),
        from_start(2),
        beyond(-request.preload.mm()),
        beyond(overrun_mm(request)),
    ];
    let spots = places.map(|place| plane.map(|across| across.dot(place)));
    let distances = spots.map(|spot| distance(spot, spots[0]));
    Some(MirrorSize {
        excursion_mm: [distances[1], distances[2]],
        farthest_mm: distances.into_iter().fold(0.0, f64::max),
        circle_mm: smallest_circle_mm(&spots),
    })
}

/// How far past the end point: only a run in both directions goes there.
pub(super) fn overrun_mm(request: &ProgramRequest) -> f64 {
    if request.bidirectional { request.overrun.mm() } else { 0.0 }
}

/// Two directions across the beam.
fn across(beam: PerAxis<f64>) -> [PerAxis<f64>; 2] {
    // Any direction that is not the beam's; that of its smallest component is safest.
    let by_size = |a: &Axis, b: &Axis| beam[*a].abs().total_cmp(&beam[*b].abs());
    let smallest = Axis::ALL.into_iter().min_by(by_size).unwrap_or(Axis::X);
    let first = beam.cross(unit(smallest));
    let length = first.length();
    let first = PerAxis::from_fn(|axis| first[axis] / length);
    [first, beam.cross(first)]
}

fn distance(a: Spot, b: Spot) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The smallest circle around a few spots is that of two of them or of three of them.
fn smallest_circle_mm(spots: &[Spot]) -> f64 {
    let mut circles = Vec::new();
    for (i, a) in spots.iter().enumerate() {
        for (j, b) in spots.iter().enumerate().take(i) {
            circles.push(([(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0], distance(*a, *b) / 2.0));
            circles.extend(spots.iter().take(j).filter_map(|c| around(*a, *b, *c)));
        }
    }
    let holds_all = |(centre, radius): &(Spot, f64)| {
        let slack = 1e-9 * (1.0 + radius);
        spots.iter().all(|spot| distance(*spot, *centre) <= radius + slack)
    };
    let radii = circles.into_iter().filter(holds_all).map(|(_, radius)| radius);
    2.0 * radii.reduce(f64::min).unwrap_or(0.0)
}

/// The circle through three spots, if they are not in line.
fn around(a: Spot, b: Spot, c: Spot) -> Option<(Spot, f64)> {
    let (b, c) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let twice = 2.0 * (b[0] * c[1] - b[1] * c[0]);
    let (bb, cc) = (b[0].squared() + b[1].squared(), c[0].squared() + c[1].squared());
    if twice.abs() <= 1e-12 * (bb + cc) {
        return None;
    }
    let centre = [(c[1] * bb - b[1] * cc) / twice, (b[0] * cc - c[0] * bb) / twice];
    let radius = centre[0].hypot(centre[1]);
    Some(([centre[0] + a[0], centre[1] + a[1]], radius))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MICRON: LengthDigit = LengthDigit { unit: ControlUnit::Millimetre, decimals: 3 };

    #[test]
    fn a_length_is_written_with_all_its_digits() {
        assert_eq!(MICRON.text(-1), "-0.001");
        assert_eq!(MICRON.text(0), "0.000");
        assert_eq!(MICRON.text(900_000), "900.000");
        let ten_thousandth = LengthDigit { unit: ControlUnit::Inch, decimals: 4 };
        assert_eq!(ten_thousandth.digits(25.4), Some(10_000));
        assert_eq!(ten_thousandth.text(10_000), "1.0000");
    }

    #[test]
    fn a_length_between_two_digits_is_none() {
        assert_eq!(MICRON.digits(0.0005), None);
        assert_eq!(MICRON.digits(29.99), Some(29_990));
        assert_eq!((MICRON.at_most(1.0), MICRON.at_least(1.0)), (1000, 1000));
        assert_eq!((MICRON.at_most(1.0009), MICRON.at_least(1.0001)), (1000, 1001));
    }
}
