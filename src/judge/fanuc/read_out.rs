//! Pitch, straightness and backlash parameters of a Fanuc read-out.

use super::machine;
use crate::control::claims::Assumption;
use crate::control::controller::{FanucFacts, NumberRange, StraightnessForm};
use crate::control::table::Tables;
use crate::control::table::fanuc::FanucMemory;
use crate::judge::active::{Found, Held, NamedBacklash, ReadOutReader};
use crate::judge::findings::InControl;
use crate::quantity::{Axis, PerAxis};
use crate::read::fanuc::{merge, read_out};
use crate::text::Problems;

/// Functions whose parameters at 0 do nothing (docs/fanuc.md §2.1, §2.4).
const IDLE_AT_ZERO: [(u32, u32); 5] =
    [(3666, 3671), (3676, 3677), (5861, 5874), (10800, 10814), (14985, 14988)];

/// Reads the files of a control.
pub(super) fn read(reading: &mut ReadOutReader<'_>, facts: &FanucFacts) -> Result<Found, Problems> {
    let unit = reading.job.compensation.control_unit;
    let files = reading.texts.iter().map(|(name, text)| read_out(name, text, facts, unit));
    let mut memories = Vec::new();
    for ((name, _), read) in reading.texts.iter().zip(Problems::all(files)?) {
        memories.push(read.memory);
        for parameter in read.spindles {
            reading.take(of_spindle(&parameter), InControl::Spindle { parameter });
        }
        if read.passed_over > 0 {
            let (file, count, what) = (name.to_string(), read.passed_over, "other parameters");
            reading.tell(InControl::PassedOver { file, count, what });
        }
    }
    let memory = merge(memories)?;
    let held = Held::plain(Tables::Fanuc(memory.clone()));
    let unit = machine::unit(&memory);
    for finding in machine::found(reading.job, &reading.names, &memory, facts) {
        reading.tell(finding);
    }
    let mut sorted = Sorted { reading, facts, memory };
    sorted.take_sets();
    sorted.take_other_axes();
    let backlash = PerAxis::from_fn(|axis| sorted.backlash(axis));
    sorted.tell_points_of_nobody();
    sorted.take_what_is_no_table();
    Ok(Found { tables: Tables::Fanuc(sorted.memory), held, backlash, unit })
}

/// Whose points a parameter of a spindle means is not known.
fn of_spindle(parameter: &String) -> Assumption {
    Assumption::of_job(
        parameter,
        "it takes no point of the job's axes",
        "a spindle with a pitch compensation of its own (Cs axis) would take points of these tables: compare its point numbers on the control",
    )
}

struct Sorted<'a, 'b> {
    reading: &'a mut ReadOutReader<'b>,
    facts: &'a FanucFacts,
    memory: FanucMemory,
}

impl Sorted<'_, '_> {
    fn is_own(&self, axis: u32) -> bool {
        self.reading.has(&axis.to_string())
    }

    fn remove(&mut self, numbers: &[u32]) {
        self.memory.parameters.retain(|key, _| !numbers.contains(&key.number));
    }

    /// Straightness sets that are not in use, or belong to other axes.
    fn take_sets(&mut self) {
        for index in 0..self.facts.straightness_sets.value {
            let axis = |first: u32| self.memory.count(first + index, None).unwrap_or(0);
            let (moving, shifted) = (axis(5711), axis(5721));
            // A set without its corrected axis is not complete, which the emulation tells.
            if moving != 0 && self.is_own(moving) && (shifted == 0 || self.is_own(shifted)) {
                continue;
            }
            let magnification = self.facts.straightness_magnification_parameter.value + index;
            let start = self.facts.straightness_start_parameter.value + index;
            if moving != 0 {
                let is_idle = self.memory.count(magnification, None) == Some(0);
                let first = self.memory.count(start, None);
                self.take_set_of_others(index + 1, [moving, shifted], is_idle, first);
            }
            let mut numbers = vec![5711 + index, 5721 + index, magnification, start];
            if self.facts.straightness_form.value == StraightnessForm::FourPoint {
                let knots = 10 * index..10 * index + 4;
                numbers.extend(knots.flat_map(|knot| [5731 + knot, 5761 + knot]));
            }
            self.remove(&numbers);
        }
    }

    /// A set in use of which an axis is none of the job, and its points where it has some.
    fn take_set_of_others(
        &mut self,
        set: u32,
        [moving, shifted]: [u32; 2],
        is_idle: bool,
        start: Option<u32>,
    ) {
        self.reading.others.sets.push(set);
        let what = format!("straightness set {set} (axis {shifted} while axis {moving} moves)");
        let of_moving = |number| self.memory.count(number, Some(moving));
        if let (StraightnessForm::PerPoint, Some(first), Some(own), Some(last)) =
            (self.facts.straightness_form.value, start, of_moving(3621), of_moving(3622))
        {
            let last = first.saturating_add(last.saturating_sub(own));
            self.reading.others.points.push(NumberRange { first, last });
        }
        let follows = self.reading.judges() && self.is_own(shifted) && !is_idle;
        let (moving, axes) = (moving.to_string(), "axes");
        self.reading.tell(match follows {
            true => InControl::Follows { what, moving },
            false => InControl::OfOthers { what, axes },
        });
    }

    /// Parameters of axes that the job does not have; their points are theirs.
    fn take_other_axes(&mut self) {
        let axes = self.memory.parameters.keys().filter_map(|key| key.axis);
        let mut axes: Vec<u32> = axes.filter(|axis| !self.is_own(*axis)).collect();
        axes.sort_unstable();
        axes.dedup();
        for axis in axes {
            let points = self.points_of(axis);
            self.tell_shared_points(axis, &points);
            if let Some(NumberRange { first, last }) = points.first() {
                let what =
                    format!("the pitch compensation of axis {axis} (points {first} to {last})");
                let axes = "an axis";
                self.reading.tell(InControl::OfOthers { what, axes });
            }
            self.reading.others.points.extend(points);
            self.memory.parameters.retain(|key, _| key.axis != Some(axis));
        }
    }

    /// The points of an axis in use: its table, and that for travel in − where 3605#0 does not
    /// switch it off.
    fn points_of(&self, axis: u32) -> Vec<NumberRange> {
        let number = |parameter| self.memory.count(parameter, Some(axis));
        let (Some(1..), Some(first), Some(last)) = (number(3623), number(3621), number(3622))
        else {
            return Vec::new();
        };
        let mut points = vec![NumberRange { first, last }];
        let is_off = self.memory.bits(3605, Some(axis)).is_some_and(|bits| bits & 1 == 0);
        if let Some(minus) = number(3626).filter(|minus| *minus != 0 && !is_off) {
            let last = minus.saturating_add(last.saturating_sub(first));
            points.push(NumberRange { first: minus, last });
        }
        points
    }

    /// Points of an axis of the job that an axis of others takes too. The slave of a gantry may
    /// take all of its master's; another axis is corrected by errors that are not its own. New
    /// tables at places of others are refused elsewhere.
    fn tell_shared_points(&mut self, other: u32, points: &[NumberRange]) {
        if !self.reading.judges() {
            return;
        }
        let names = Axis::ALL.map(|axis| self.reading.names[axis].clone()).concat();
        let own: Vec<u32> = names.iter().filter_map(|name| name.parse().ok()).collect();
        for axis in own {
            let is_same = |number: u32| {
                let of = |axis| self.memory.parameter(number, Some(axis));
                of(axis) == of(other)
            };
            let is_slave = (3620..=3624).all(is_same);
            let overlaps = |own: &NumberRange| points.iter().any(|other| other.overlaps(*own));
            if self.points_of(axis).iter().any(overlaps) {
                self.reading.tell(match is_slave {
                    true => InControl::Slave { other, axis },
                    false => InControl::SharedPoints { other, axis },
                });
            }
        }
    }

    /// 1851 of each axis of the control, µm.
    fn backlash(&mut self, axis: Axis) -> NamedBacklash {
        let settings = self.reading.job.compensation.axes[axis].as_ref();
        let Some(unit_um) = settings.and_then(|s| s.detection_unit_um) else {
            return NamedBacklash::new();
        };
        let mut held = NamedBacklash::new();
        for axis in self.reading.names[axis].clone() {
            let of = |number| self.memory.amount(number, axis.parse().ok());
            let (cutting, rapid) = (of(1851), of(1852));
            held.push((axis.clone(), cutting.map(|counts| counts * unit_um)));
            if let (Some(cutting), Some(rapid), false) = (cutting, rapid, self.reading.judges())
                && (cutting - rapid).abs() > 0.0
            {
                self.reading.tell(InControl::CuttingFeed { axis, cutting, rapid });
            }
        }
        held
    }

    /// Points without the parameters that say which axis they belong to.
    fn tell_points_of_nobody(&mut self) {
        let mut keys = self.memory.parameters.keys();
        let has_owner = keys.any(|key| (3620..=3624).contains(&key.number));
        if has_owner || !self.reading.others.points.is_empty() || self.memory.points.is_empty() {
            return;
        }
        let points = self.memory.points.len();
        self.reading.tell(InControl::PointsOfNobody { points });
    }

    /// What was judged, and what does nothing.
    fn take_what_is_no_table(&mut self) {
        self.remove(&[1001, 1013, 1020, 1240, 1320, 1321, 1820, 1851, 1852]);
        self.memory.parameters.retain(|key, value| {
            let idle = IDLE_AT_ZERO.iter().any(|(a, b)| (*a..=*b).contains(&key.number));
            !(idle && value.is_zero())
        });
    }
}
