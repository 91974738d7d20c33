//! The box, the margins and the targets of a run in whole digits of the control, and the way over the nodes of
//! one set-up, in both directions.

use crate::inputs::job::{ProgramRequest, RunType, TargetGrid, WayBack};
use crate::quantity::{Axis, Diagonal, Figure, LaserPath, Pass, PathKind, PerAxis};
use crate::text::Problems;
use crate::write::grid::{LengthDigit, whole};
use crate::write::program::{Digits, Move, PlannedReading, RunTask, SetUpProgram};
use crate::write::refusals;

/// The nodes of a set-up along the forward path.
struct Route {
    subject: LaserPath,
    nodes: Vec<PerAxis<Digits>>,
    moved: Vec<Option<Axis>>,
    nominal_mm: Vec<f64>,
    /// +1, −1 or 0: direction of each axis on the forward path.
    ahead: PerAxis<Digits>,
}

/// The programs of a run, one for each set-up of the laser.
pub(super) fn programs(request: &ProgramRequest, scale: &Scale) -> Vec<SetUpProgram> {
    let routes: Vec<Route> = match request.what.path() {
        Some(kind) => Diagonal::ALL
            .into_iter()
            .map(|diagonal| along_diagonal(request, scale, diagonal, kind))
            .collect(),
        None => request.axes.iter().map(|axis| along_axis(request, scale, *axis)).collect(),
    };
    let program = |route| {
        let here = PerAxis::default();
        Walk { request, scale, route, here, moves: Vec::new(), readings: Vec::new() }.whole()
    };
    routes.iter().map(program).collect()
}

fn along_diagonal(
    request: &ProgramRequest,
    scale: &Scale,
    diagonal: Diagonal,
    kind: PathKind,
) -> Route {
    let volume = &request.volume;
    let node = |node: usize| {
        PerAxis::from_fn(|axis| {
            let from_low = volume.end_at(diagonal, kind, node, axis);
            scale.start[axis] + Digits::try_from(from_low).unwrap_or(0) * scale.step[axis]
        })
    };
    let moved = |node: usize| {
        let alone = kind == PathKind::Step && node > 0;
        alone.then(|| volume.moved(node))
    };
    let nodes = 0..=volume.last_node(kind);
    Route {
        subject: LaserPath::Diagonal(diagonal),
        nodes: nodes.clone().map(node).collect(),
        moved: nodes.clone().map(moved).collect(),
        nominal_mm: nodes.map(|node| volume.nominal_mm(diagonal, kind, node)).collect(),
        ahead: PerAxis::from_fn(|axis| whole(diagonal.sign(axis))),
    }
}

fn along_axis(request: &ProgramRequest, scale: &Scale, axis: Axis) -> Route {
    let targets = targets(request, scale, axis);
    let first = targets.first().copied().unwrap_or(0);
    let place = |target: &Digits| {
        PerAxis::from_fn(|other| if other == axis { *target } else { scale.rest[other] })
    };
    let moved = |node: usize| (node > 0).then_some(axis);
    Route {
        subject: LaserPath::Axis(axis),
        nodes: targets.iter().map(place).collect(),
        moved: (0..targets.len()).map(moved).collect(),
        nominal_mm: targets.iter().map(|target| scale.resolution.mm(target - first)).collect(),
        ahead: PerAxis::from_fn(|other| Digits::from(other == axis)),
    }
}

/// Writes the moves of a route down, keeping the place.
struct Walk<'a> {
    request: &'a ProgramRequest,
    scale: &'a Scale,
    route: &'a Route,
    here: PerAxis<Digits>,
    moves: Vec<Move>,
    readings: Vec<PlannedReading>,
}

impl Walk<'_> {
    fn whole(mut self) -> SetUpProgram {
        let before = self.beside(0, -self.scale.preload);
        self.moves.push(Move::Approach(before));
        self.here = before;
        self.to(self.route.nodes[0]);
        if self.request.alignment_pass {
            self.align(before);
        }
        let name = self.route.subject;
        self.moves.push(Move::Stop(format!("{name} NODE 0: ZERO THE LASER, CYCLE START")));
        for run in 1..=self.request.runs {
            self.run(run);
        }
        SetUpProgram { subject: self.route.subject, moves: self.moves, readings: self.readings }
    }

    /// To the far end and back, straight, with a halt at both ends; again through the preload.
    fn align(&mut self, before: PerAxis<Digits>) {
        let name = self.route.subject;
        let halt = |end: &str| Move::Stop(format!("{name} {end} END: ALIGN, CYCLE START"));
        self.moves.push(halt("NEAR"));
        self.to(self.route.nodes[self.route.nodes.len() - 1]);
        self.moves.push(halt("FAR"));
        self.to(before);
        self.to(self.route.nodes[0]);
    }

    /// One run, from node 0 in its forward direction to the place where the next one begins.
    fn run(&mut self, run: u32) {
        let name = self.route.subject;
        let last = self.route.nodes.len() - 1;
        self.moves.push(Move::Remark(format!("{name} RUN {run} FORWARD")));
        self.read(run, Pass::Forward, 0);
        for node in 1..=last {
            self.to(self.route.nodes[node]);
            self.read(run, Pass::Forward, node);
        }
        if self.request.bidirectional {
            self.moves.push(Move::Remark(format!("{name} RUN {run} REVERSE")));
            if self.scale.overrun > 0 {
                // So that every axis arrives in its reverse direction.
                self.to(self.beside(last, self.scale.overrun));
                self.to(self.route.nodes[last]);
            }
            self.read(run, Pass::Reverse, last);
            for node in (0..last).rev() {
                self.to(self.route.nodes[node]);
                self.read(run, Pass::Reverse, node);
            }
        } else {
            self.moves.push(Move::Remark("BACK, NO READINGS".to_string()));
            if self.request.way_back == WayBack::Retrace {
                for node in (0..last).rev() {
                    self.to(self.route.nodes[node]);
                }
            }
        }
        if run < self.request.runs || !self.request.bidirectional {
            self.to(self.beside(0, -self.scale.preload));
            self.to(self.route.nodes[0]);
        }
    }

    /// The place beside a node, on every axis that is measured by this much ahead.
    fn beside(&self, node: usize, ahead: Digits) -> PerAxis<Digits> {
        let route = self.route;
        PerAxis::from_fn(|axis| route.nodes[node][axis] + ahead * route.ahead[axis])
    }

    fn to(&mut self, place: PerAxis<Digits>) {
        self.moves.push(Move::Feed(PerAxis::from_fn(|axis| place[axis] - self.here[axis])));
        self.here = place;
    }

    fn read(&mut self, run: u32, pass: Pass, node: usize) {
        self.moves.push(Move::Dwell(self.readings.len()));
        self.readings.push(PlannedReading {
            run,
            pass,
            node,
            moved: self.route.moved[node],
            nominal_mm: self.route.nominal_mm[node],
            place: self.route.nodes[node],
        });
    }
}

/// Number of readings of one program; known before any of them is made.
pub(super) fn readings_of(request: &ProgramRequest) -> usize {
    let nodes = match request.what {
        RunType::StepDiagonal => request.volume.last_node(PathKind::Step) + 1,
        RunType::StraightDiagonal | RunType::SingleAxis => request.volume.steps + 1,
    };
    let passes = if request.bidirectional { 2 } else { 1 };
    nodes * passes * usize::try_from(request.runs).unwrap_or(1)
}

/// A run's lengths in digits.
pub(super) struct Scale {
    pub(super) resolution: LengthDigit,
    pub(super) start: PerAxis<Digits>,
    pub(super) step: PerAxis<Digits>,
    pub(super) rest: PerAxis<Digits>,
    pub(super) preload: Digits,
    pub(super) overrun: Digits,
}

impl Scale {
    /// Every length as the nearest whole number of digits; preload and overrun as the next larger one. They
    /// and the places of rest are no nodes: nothing is measured against them.
    pub(super) fn nearest(request: &ProgramRequest, resolution: LengthDigit) -> Scale {
        let volume = &request.volume;
        Scale {
            resolution,
            start: PerAxis::from_fn(|axis| resolution.nearest(volume.start[axis].mm())),
            step: PerAxis::from_fn(|axis| resolution.nearest(volume.step_mm(axis))),
            rest: PerAxis::from_fn(|axis| resolution.nearest(request.rest_of(axis).mm())),
            preload: resolution.at_least(request.preload.mm()),
            overrun: resolution.at_least(request.overrun.mm()),
        }
    }
}

/// Lengths that are no whole number of digits: the control would round them, and the readings would hold the
/// rounding as a deviation of the machine.
pub(super) fn refuse_between_digits(task: RunTask<'_>, problems: &mut Problems) {
    let (request, resolution) = (task.request, task.resolution());
    let path = request.size_path.replace("size_mm", "start_mm");
    for axis in Axis::ALL.into_iter().filter(|axis| moving(request).contains(axis)) {
        let mm = request.volume.start[axis].mm();
        if resolution.digits(mm).is_none() {
            let [start, nearest] =
                [mm, resolution.mm(resolution.nearest(mm))].map(|mm| Figure(mm).trimmed(6));
            let wrong = refusals::start_between(axis, start, resolution.words(), nearest);
            problems.push(task.job.source.at(&format!("{path}.{}", axis.key()), wrong));
        }
    }
    for axis in Axis::ALL {
        refuse_step(task, axis, problems);
    }
}

fn refuse_step(task: RunTask<'_>, axis: Axis, problems: &mut Problems) {
    let (request, resolution) = (task.request, task.resolution());
    let (size, steps) = (request.volume.size[axis].mm(), request.volume.steps);
    let step = request.volume.step_mm(axis);
    let unused = request.what == RunType::SingleAxis
        && (!request.axes.contains(&axis) || request.targets != TargetGrid::Equal);
    if unused || resolution.digits(step).is_some_and(|whole| whole > 0) {
        return;
    }
    let below = resolution.at_most(step).max(1);
    let mm = |digits| Figure(resolution.mm(digits)).trimmed(6);
    let nearest = mm(below * i64::try_from(steps).unwrap_or(1));
    let (size, digit, below) = (Figure(size).trimmed(6), resolution.words(), mm(below));
    let wrong = refusals::step_between(size, axis, steps, step, digit, nearest, below);
    let key = format!("{}.{}", request.size_path, axis.key());
    problems.push(task.job.source.at(&key, wrong));
}

/// Golden section: its multiples fill an interval evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Targets of one axis, ascending. Offset targets: Pi = start + i·p + r_i with
/// r_i = a·(2·frac(g·(i + 1)) − 1), g = 0.618…, a = the largest shift; the first is shifted inwards by
/// |r_0|, the last by |r_n|, so all lie in the box. The shifts are the same in every version.
fn targets(request: &ProgramRequest, scale: &Scale, axis: Axis) -> Vec<Digits> {
    let volume = &request.volume;
    let last = volume.steps;
    let TargetGrid::Offset { shift } = request.targets else {
        let counts = 0..=i64::try_from(last).unwrap_or(0);
        return counts.map(|count| scale.start[axis] + count * scale.step[axis]).collect();
    };
    let largest = shift.map_or(volume.step_mm(axis) / 4.0, |shift| shift.mm());
    let of_index = |index: usize| {
        let turns = GOLDEN * (index + 1) as f64;
        let shift = largest * (2.0 * turns.fract() - 1.0);
        let shift = match index {
            0 => shift.abs(),
            index if index == last => -shift.abs(),
            _ => shift,
        };
        let place = volume.start[axis].mm() + volume.along_mm(axis, index) + shift;
        scale.resolution.nearest(place)
    };
    (0..=last).map(of_index).collect()
}

/// The axes that move while readings are taken.
pub(super) fn moving(request: &ProgramRequest) -> Vec<Axis> {
    match request.what {
        RunType::SingleAxis => request.axes.clone(),
        RunType::StepDiagonal | RunType::StraightDiagonal => Axis::ALL.to_vec(),
    }
}
