//! Following the moves of a program: extremes, samples, and what lies outside.

use super::cloud::{Cloud, MOST_VECTORS};
use super::extremes::{Channel, Range, squares, through, turning_points};
use super::map::PathMap;
use crate::inputs::job::Job;
use crate::quantity::{Axis, Figure};
use crate::volume::space::diameter::longest;
use crate::volume::space::pair::{dot, minus};
use crate::volume::volume_model::VolumeModel;
use part_program::{Move, Place, Plane, Refused, Shape};
use serde::{Serialize, Serializer};

/// Samples of one move: a kilometre in steps of a micrometre.
const MOST_STEPS: f64 = 2e9;
/// A move that ends so near to the travel keeps it (rounding of inch programs), mm.
const TRAVEL_TOLERANCE_MM: f64 = 1e-4;

/// How a path is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileLimits {
    /// How far chords may leave an arc, mm.
    pub chord_mm: f64,
    /// Largest distance of two samples, mm.
    pub sample_mm: f64,
    /// Whether rapid moves count.
    pub rapid: bool,
    /// Length of the tool (or the optics) that was measured with, mm.
    pub measured_tool_mm: f64,
    /// The range of each axis that was measured; `None` = the axis was not measured.
    pub measured: [Option<(f64, f64)>; 3],
    /// The travel of each axis with its reference points, if it is known.
    pub travel: [Option<(f64, f64)>; 3],
    /// Whether places outside the measured range are refused.
    pub refuse_outside: bool,
}

/// How the path of a job is followed.
pub fn limits(job: &Job, volume: &VolumeModel) -> ProfileLimits {
    let path = &job.path;
    let travel = |axis: Axis| {
        let machine = job.machine.axes[axis]?;
        let second = path.setup.second_reference.map(|place| place[axis as usize]);
        let references = [machine.reference.mm(), second.unwrap_or(machine.reference.mm())];
        let wider = |(low, high): (f64, f64), at: f64| (low.min(at), high.max(at));
        Some(references.into_iter().fold((machine.low.mm(), machine.high.mm()), wider))
    };
    ProfileLimits {
        chord_mm: path.chord_mm,
        sample_mm: path.sample_mm,
        rapid: path.rapid,
        measured_tool_mm: path.measured_tool_mm.unwrap_or(0.0),
        measured: Axis::ALL.map(|axis| volume.is_measured(axis).then(|| volume.range(axis))),
        travel: Axis::ALL.map(travel),
        refuse_outside: path.refuse_outside,
    }
}

/// A sample of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Length of the path up to here, mm (followed moves only).
    pub s_mm: f64,
    /// Machine coordinates, mm.
    pub place: Place,
    /// Error vector, µm.
    pub error_um: [f64; 3],
    /// What the tool is longer than the one measured with, mm.
    pub longer_mm: f64,
    /// Line of the program.
    pub line: usize,
    /// Whether the place lies outside the measured range, so that end values are held.
    pub is_held: bool,
    /// Along the path, unit vector.
    pub ahead: [f64; 3],
    /// Across it to the left in the plane, unit vector; `None` where the path runs along the third
    /// axis.
    pub left: Option<[f64; 3]>,
    /// Number of the hole whose bottom this is.
    pub hole: Option<u64>,
}

/// Where a path leaves the measured range of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside {
    /// Number of the axis.
    pub axis: usize,
    /// Lowest and highest position of the path, mm.
    pub reached_mm: (f64, f64),
    /// The measured range, mm.
    pub measured_mm: (f64, f64),
    /// First line of the program that does.
    pub line: usize,
}

/// What was found along a path.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Length of the moves that were followed, mm.
    pub length_mm: f64,
    /// Numbers of moves.
    pub moves: Moves,
    /// Range of each channel, in the order of [`Channel::ALL`].
    #[serde(rename = "extremes", serialize_with = "by_name")]
    ranges: [Range; 6],
    /// Largest difference of two error vectors of the samples, µm.
    pub profile_accuracy_um: f64,
    /// What it is at most, µm: more where there are too many samples to keep all that count.
    pub profile_accuracy_at_most_um: f64,
    /// Number of samples.
    pub samples: u64,
    /// Where the path leaves the measured range.
    #[serde(skip)]
    pub outside: Vec<Outside>,
    /// Whether a tool length was used.
    #[serde(skip)]
    pub with_tool: bool,
}

/// Numbers of moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Moves {
    /// Straight ones that were followed.
    pub straight: u64,
    /// Arcs that were followed.
    pub arcs: u64,
    /// Rapid ones that were left out.
    pub rapid_left_out: u64,
}

/// Channels by their names, without marks; a channel without a value is `null`.
fn by_name<S: Serializer>(ranges: &[Range; 6], to: S) -> Result<S::Ok, S::Error> {
    let ranges = ranges.iter().map(|range| Some(range).filter(|range| range.is_found()));
    let names = Channel::ALL.map(|channel| channel.word().trim_matches('|'));
    to.collect_map(names.into_iter().zip(ranges))
}

/// Follows moves on one machine.
pub struct Profile<'m> {
    map: &'m PathMap,
    limits: ProfileLimits,
    cell: [usize; 3],
    cuts: Vec<f64>,
    cloud: Cloud,
    found: Summary,
}

/// A straight stretch of a move.
#[derive(Clone, Copy)]
struct Stretch {
    from: Place,
    to: Place,
    begins: bool,
    /// What all of its samples have in common.
    common: Sample,
}

impl<'m> Profile<'m> {
    /// Nothing followed yet.
    pub fn new(map: &'m PathMap, limits: ProfileLimits) -> Profile<'m> {
        Profile {
            map,
            limits,
            cell: [0; 3],
            cuts: Vec::new(),
            cloud: Cloud::holding(MOST_VECTORS),
            found: Summary::default(),
        }
    }

    /// Follows a move; every sample is given to `sample`.
    pub fn follow(&mut self, step: &Move, sample: &mut impl FnMut(&Sample)) -> Result<(), Refused> {
        if step.rapid && !self.limits.rapid {
            self.found.moves.rapid_left_out += 1;
            return self.check_travel(step.to);
        }
        let longer = step.tool_mm.map_or(0.0, |mm| mm - self.limits.measured_tool_mm);
        self.found.with_tool |= step.tool_mm.is_some();
        let Move { from, to, line, hole, .. } = *step;
        let common = Sample { line, hole, longer_mm: longer, ..Sample::default() };
        let mut stretch = Stretch { from, to, begins: true, common };
        let chords = match step.shape {
            Shape::Line => {
                self.found.moves.straight += 1;
                1
            }
            Shape::Arc(arc) => {
                self.found.moves.arcs += 1;
                let radius = arc.radius[0].max(arc.radius[1]);
                chords(arc.sweep_rad, radius, self.limits.chord_mm)
            }
        };
        for chord in 1..=chords {
            stretch.to = step.at(f64::from(chord) / f64::from(chords));
            stretch.begins = chord == 1;
            self.stretch(stretch, step.plane, sample)?;
            stretch.from = stretch.to;
        }
        Ok(())
    }

    /// A straight stretch: split at nodes, each part a polynomial.
    fn stretch(
        &mut self,
        mut stretch: Stretch,
        plane: Plane,
        sample: &mut impl FnMut(&Sample),
    ) -> Result<(), Refused> {
        self.check_travel(stretch.to)?;
        self.check_measured(&stretch)?;
        let way = minus(&stretch.to, &stretch.from);
        let length = dot(&way, &way).sqrt();
        if length <= 0.0 {
            return Ok(());
        }
        stretch.common.ahead = way.map(|part| part / length);
        stretch.common.left = normal(plane, stretch.common.ahead);
        self.cut(&stretch);
        if stretch.begins {
            self.cell = self.map.cell(stretch.from, self.cell);
            let error = self.map.error_in(self.cell, stretch.from, stretch.common.longer_mm);
            self.take(&stretch, stretch.from, error);
            self.sample(&stretch, (stretch.from, error, None), 0.0, sample);
        }
        let cuts = std::mem::take(&mut self.cuts);
        let mut done = 0.0;
        for cut in &cuts {
            self.part(&stretch, (done, *cut), length, sample);
            done = *cut;
        }
        self.cuts = cuts;
        self.found.length_mm += length;
        Ok(())
    }

    /// Where the stretch meets nodes, as parts of it, with its end.
    fn cut(&mut self, stretch: &Stretch) {
        self.cuts.clear();
        for axis in 0..3 {
            let (from, to) = (stretch.from[axis], stretch.to[axis]);
            let (low, high) = if from < to { (from, to) } else { (to, from) };
            let piece = self.map.piece(axis, low, self.cell[axis]);
            if piece == self.map.piece(axis, high, piece) {
                continue;
            }
            let inside = self.map.nodes(axis)[piece..].iter().take_while(|node| **node < high);
            self.cuts.extend(inside.map(|node| (node - from) / (to - from)));
        }
        self.cuts.retain(|part| *part > 0.0 && *part < 1.0);
        self.cuts.sort_by(f64::total_cmp);
        self.cuts.dedup_by(|next, kept| *next <= *kept);
        self.cuts.push(1.0);
    }

    /// A part inside one cell.
    #[inline]
    fn part(
        &mut self,
        stretch: &Stretch,
        (from, to): (f64, f64),
        length: f64,
        sample: &mut impl FnMut(&Sample),
    ) {
        let at = |part: f64| -> Place {
            if part >= 1.0 {
                stretch.to
            } else {
                std::array::from_fn(|k| stretch.from[k] + (stretch.to[k] - stretch.from[k]) * part)
            }
        };
        self.cell = self.map.cell(at(f64::midpoint(from, to)), self.cell);
        self.turns(stretch, &at, (from, to));
        let steps = steps((to - from) * length, self.limits.sample_mm);
        let (map, cell, longer) = (self.map, self.cell, stretch.common.longer_mm);
        for step in 1..steps {
            let part = from + (to - from) * f64::from(step) / f64::from(steps);
            let place = at(part);
            let error = map.error_in(cell, place, longer);
            if !self.map.is_linear() {
                self.take(stretch, place, error);
            } // else the ends and the turning points hold the extremes
            self.sample(stretch, (place, error, None), part * length, sample);
        }
        let place = at(to);
        let error = map.error_in(cell, place, longer);
        self.take(stretch, place, error);
        let hole = stretch.common.hole.filter(|_| to >= 1.0);
        self.sample(stretch, (place, error, hole), to * length, sample);
    }

    /// The extremes inside a part.
    #[inline]
    fn turns(&mut self, stretch: &Stretch, at: &impl Fn(f64) -> Place, (from, to): (f64, f64)) {
        let error = |part: f64| {
            let place = at(from + (to - from) * part);
            channels(stretch, self.map.error_in(self.cell, place, stretch.common.longer_mm))
        };
        if self.map.is_linear() {
            let values = [error(0.0), error(0.5), error(1.0)];
            if self.may_pass(&values) {
                self.take_turns(stretch, at, (from, to), &values);
            }
        } else {
            let values = [0.0, 0.25, 0.5, 0.75, 1.0].map(error);
            self.take_turns(stretch, at, (from, to), &values);
        }
    }

    /// Whether a parabola can leave the ranges: it lies inside its three Bézier points.
    #[inline]
    fn may_pass(&self, values: &[[f64; 5]; 3]) -> bool {
        let inner: [f64; 5] =
            std::array::from_fn(|k| 2.0 * values[1][k] - f64::midpoint(values[0][k], values[2][k]));
        let square = |v: &[f64; 5]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let length = self.found.ranges[5];
        let points = [&values[0], &inner, &values[2]];
        // A vector is at least as long as its part along the one in the middle.
        let middle = &values[1];
        let along = |v: &[f64; 5]| v[0] * middle[0] + v[1] * middle[1] + v[2] * middle[2];
        let least = length.min.um * square(middle).sqrt();
        (0..5).any(|k| self.found.ranges[k].is_passed_by(inner[k]))
            || points.iter().any(|v| square(v).sqrt() > length.max.um)
            || length.min.um > 0.0 && points.iter().any(|v| along(v) < least)
    }

    fn take_turns(
        &mut self,
        stretch: &Stretch,
        at: &impl Fn(f64) -> Place,
        (from, to): (f64, f64),
        values: &[[f64; 5]],
    ) {
        let polynomial = |k: usize| {
            let list: Vec<f64> = values.iter().map(|value| value[k]).collect();
            through(&list)
        };
        let five: Vec<Vec<f64>> = (0..5).map(polynomial).collect();
        let mut turns: Vec<f64> = five.iter().flat_map(|p| turning_points(p)).collect();
        turns.extend(turning_points(&squares(&five[..3])));
        for turn in turns {
            let place = at(from + (to - from) * turn);
            let error = self.map.error_in(self.cell, place, stretch.common.longer_mm);
            self.take(stretch, place, error);
        }
    }

    #[inline]
    fn take(&mut self, stretch: &Stretch, place: Place, error: [f64; 3]) {
        let values = channels(stretch, error);
        let count = if stretch.common.left.is_some() { 5 } else { 4 };
        for (range, value) in self.found.ranges.iter_mut().zip(&values[..count]) {
            range.take(*value, place, stretch.common.line);
        }
        self.found.ranges[5].take(dot(&error, &error).sqrt(), place, stretch.common.line);
    }

    #[inline]
    fn sample(
        &mut self,
        stretch: &Stretch,
        (place, error, hole): (Place, [f64; 3], Option<u64>),
        done: f64,
        sample: &mut impl FnMut(&Sample),
    ) {
        self.cloud.take(error);
        self.found.samples += 1;
        sample(&Sample {
            s_mm: self.found.length_mm + done,
            place,
            error_um: error,
            is_held: self.is_held(place),
            hole,
            ..stretch.common
        });
    }

    fn is_held(&self, place: Place) -> bool {
        (0..3).any(|axis| missed(self.limits.measured[axis], place[axis], 0.0).is_some())
    }

    fn check_travel(&self, place: Place) -> Result<(), Refused> {
        for (axis, at) in place.into_iter().enumerate() {
            if let Some((low, high)) = missed(self.limits.travel[axis], at, TRAVEL_TOLERANCE_MM) {
                return Err(Refused::new(format!(
                        "the move leads to {} = {:.3} mm in machine coordinates, outside the travel with its reference points, {low} … {high} mm",
                        Axis::ALL[axis],
                        Figure(at)
                    )).help("check the zero of the coordinate system ([[path.offset]]), the tool length and `travel_mm`"));
            }
        }
        Ok(())
    }

    fn check_measured(&mut self, stretch: &Stretch) -> Result<(), Refused> {
        for axis in 0..3 {
            for at in [stretch.from[axis], stretch.to[axis]] {
                let range = missed(self.limits.measured[axis], at, 0.0);
                let Some((low, high)) = range else { continue };
                if self.limits.refuse_outside {
                    return Err(Refused::new(format!(
                            "the path is at {} = {:.3} mm, outside the measured range {low} … {high} mm",
                            Axis::ALL[axis],
                            Figure(at)
                        )).help("measure there, or write `outside = \"hold\"` in [path]"));
                }
                self.note_outside((axis, at), (low, high), stretch.common.line);
            }
        }
        Ok(())
    }

    #[cold]
    fn note_outside(&mut self, (axis, at): (usize, f64), measured_mm: (f64, f64), line: usize) {
        let outside = &mut self.found.outside;
        match outside.iter_mut().find(|outside| outside.axis == axis) {
            Some(Outside { reached_mm, .. }) => {
                *reached_mm = (reached_mm.0.min(at), reached_mm.1.max(at));
            }
            None => outside.push(Outside { axis, reached_mm: (at, at), measured_mm, line }),
        }
    }

    /// What was found.
    pub fn summary(self) -> Summary {
        let (vectors, room_um) = self.cloud.ends();
        let mut found = self.found;
        found.outside.sort_by_key(|outside| outside.axis);
        found.profile_accuracy_um = longest(&vectors).map_or(0.0, |longest| longest.um());
        found.profile_accuracy_at_most_um = found.profile_accuracy_um + room_um;
        found
    }
}

/// The range, where a place lies beyond it by more than so much.
#[inline]
fn missed(range: Option<(f64, f64)>, at: f64, by: f64) -> Option<(f64, f64)> {
    range.filter(|(low, high)| at < low - by || at > high + by)
}

impl Summary {
    /// Range of a channel; `None` where nothing was followed.
    pub fn range(&self, channel: Channel) -> Option<&Range> {
        Some(&self.ranges[channel as usize]).filter(|range| range.is_found())
    }
}

/// X, Y, Z, tangent, normal (0 where there is none).
#[inline]
fn channels(stretch: &Stretch, e: [f64; 3]) -> [f64; 5] {
    let Sample { ahead, left, .. } = stretch.common;
    [e[0], e[1], e[2], dot(&ahead, &e), dot(&left.unwrap_or_default(), &e)]
}

/// To the left of the path in the plane; `None` where the path runs along the third axis.
#[inline]
fn normal(plane: Plane, tangent: [f64; 3]) -> Option<[f64; 3]> {
    let [first, second, _] = plane.axes();
    let size = tangent[first].hypot(tangent[second]);
    if size < 1e-9 {
        return None;
    }
    let mut normal = [0.0; 3];
    normal[first] = -tangent[second] / size;
    normal[second] = tangent[first] / size;
    Some(normal)
}

/// Equal steps of a length that are not longer than `longest`.
#[allow(clippy::cast_possible_truncation, reason = "the number is bounded before it is used")]
fn steps(length: f64, longest: f64) -> u32 {
    (length / longest).ceil().clamp(1.0, MOST_STEPS) as u32
}

/// Chords of an arc whose middles lie within a tolerance of it.
fn chords(sweep: f64, radius: f64, tolerance: f64) -> u32 {
    let widest = 2.0 * (1.0 - (tolerance / radius).min(1.0)).acos();
    steps(sweep.abs(), widest.clamp(1e-6, 0.5))
}
