//! A Fanuc read-out: its pitch, straightness and backlash parameters, and what it says of the machine against the job.

use crate::control::claims::Assumption;
use crate::control::control_state::{AxisState, ControlState};
use crate::control::controller::{ControlUnit, FanucFacts, NumberRange, StraightnessForm};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::inputs::job::{Job, MachineAxis};
use crate::judge::active::ReadOutReader;
use crate::judge::findings::InControl;
use crate::quantity::{Axis, PerAxis, power_of_ten, rounded};
use crate::read::fanuc::{merge, read_out};
use crate::text::Problems;
use crate::write::plan::Plan;
use std::collections::BTreeSet;

/// Functions whose parameters at 0 do nothing (docs/fanuc.md §2.1, §2.4).
const IDLE_AT_ZERO: [(u32, u32); 5] =
    [(3666, 3671), (3676, 3677), (5861, 5874), (10800, 10814), (14985, 14988)];

/// Reads the files of a control.
pub(super) fn read(reading: &mut ReadOutReader<'_>, facts: &FanucFacts) -> Result<(), Problems> {
    let unit = reading.job.compensation.control_unit;
    let files = reading.texts.iter().map(|(name, text)| read_out(name, text, facts, unit));
    let mut memories = Vec::new();
    for ((name, _), read) in reading.texts.iter().zip(Problems::all(files)?) {
        memories.push(read.memory);
        for parameter in read.spindles {
            // Whose points it means is not known.
            let wrong = "a spindle with a pitch compensation of its own (Cs axis) would take points of these tables: compare its point numbers on the control";
            let none = Assumption::of_job(&parameter, "it takes no point of the job's axes", wrong);
            reading.take(none, InControl::Spindle { parameter });
        }
        if read.passed_over > 0 {
            let (file, count, what) = (name.to_string(), read.passed_over, "other parameters");
            reading.tell(InControl::PassedOver { file, count, what });
        }
    }
    let mut memory = merge(memories)?;
    take_as_found(reading, &mut memory);
    let held = Tables::Fanuc(memory.clone());
    let unit = unit_of(&memory);
    for finding in found(reading.job, &reading.names, &memory, facts) {
        reading.tell(finding);
    }
    let mut sorted = ReadOutMemory { reading, facts, memory };
    sorted.take_sets();
    sorted.tell_second_tables();
    sorted.take_other_axes();
    let backlash = sorted.reading.backlash(|axis, name| sorted.backlash(axis, name));
    sorted.reading.active.held_backlash = backlash;
    sorted.tell_cutting_feed();
    sorted.tell_points_of_nobody();
    sorted.take_what_is_no_table();
    sorted.reading.found(Tables::Fanuc(sorted.memory), held);
    sorted.reading.check_unit(unit);
    Ok(())
}

/// 3605 that no file holds, as the job states it: as found, so of what was active.
fn take_as_found(reading: &ReadOutReader<'_>, memory: &mut FanucMemory) {
    for (axis, name) in reading.named().filter(|_| !reading.judges()) {
        let settings = reading.job.compensation.axes[axis].as_ref();
        let key = ParameterKey { number: 3605, axis: name.parse().ok() };
        if let Some(bits) = settings.and_then(|s| s.parameter_3605) {
            memory.parameters.entry(key).or_insert(ParameterValue::Bits(bits));
        }
    }
}

struct ReadOutMemory<'a, 'b> {
    reading: &'a mut ReadOutReader<'b>,
    facts: &'a FanucFacts,
    memory: FanucMemory,
}

impl ReadOutMemory<'_, '_> {
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
                self.take_set_of_others(index + 1, [moving, shifted], [magnification, start]);
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
    fn take_set_of_others(&mut self, set: u32, [moving, shifted]: [u32; 2], own: [u32; 2]) {
        let [magnification, start] = own.map(|number| self.memory.count(number, None));
        self.reading.active.others.sets.push(set);
        let what = format!("straightness set {set} (axis {shifted} while axis {moving} moves)");
        let of_moving = |number| self.memory.count(number, Some(moving));
        if let (StraightnessForm::PerPoint, Some(first), Some(own), Some(last)) =
            (self.facts.straightness_form.value, start, of_moving(3621), of_moving(3622))
        {
            let last = first.saturating_add(last.saturating_sub(own));
            self.reading.active.others.points.push(NumberRange { first, last });
        }
        let follows = self.reading.judges() && self.is_own(shifted) && magnification != Some(0);
        let (moving, axes) = (moving.to_string(), "axes");
        self.reading.tell(match follows {
            true => InControl::Follows { what, moving },
            false => InControl::OfOthers { what, axes },
        });
    }

    /// Values for travel in − where no file holds 3605, whose bit 0 decides whether they act. Points that only such a
    /// table can have are some where no file holds 3626.
    fn tell_second_tables(&mut self) {
        let FanucMemory { parameters, points } = &self.memory;
        let is_in = |blocks: &[NumberRange], point| blocks.iter().any(|own| own.contains(point));
        let (minus, plus) = (&self.facts.minus_points.value, &self.facts.pitch_points.value);
        let mut alone = points.iter().filter(|(at, _)| is_in(minus, **at) && !is_in(plus, **at));
        let has_points =
            alone.any(|(_, um)| *um != 0) && parameters.keys().all(|key| key.number != 3626);
        let is_open = |name: &&String| {
            let held = |number| self.memory.parameter(number, name.parse().ok());
            let acts = |number| held(number).is_some_and(|value| !value.is_zero());
            let has_values = has_points || acts(3626) || acts(3627);
            held(3605).is_none() && acts(3623) && has_values
        };
        let names = self.reading.named().map(|(_, name)| name);
        let axes: Vec<String> = names.filter(is_open).cloned().collect();
        if !axes.is_empty() {
            self.reading.tell(InControl::SecondTables { axes });
        }
    }

    /// Parameters of axes that the job does not have; their points are theirs.
    fn take_other_axes(&mut self) {
        let axes = self.memory.parameters.keys().filter_map(|key| key.axis);
        let mut axes: BTreeSet<u32> = axes.collect();
        axes.retain(|axis| !self.is_own(*axis));
        for axis in axes {
            let points = self.points_of(axis);
            self.tell_shared_points(axis, &points);
            if let Some(NumberRange { first, last }) = points.first() {
                let what =
                    format!("the pitch compensation of axis {axis} (points {first} to {last})");
                self.reading.tell(InControl::OfOthers { what, axes: "an axis" });
            }
            self.reading.active.others.points.extend(points);
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
        let own = self.reading.named().filter_map(|(_, name)| name.parse().ok());
        for axis in own.collect::<Vec<u32>>() {
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

    /// 1851 of an axis of the control, µm.
    fn backlash(&self, axis: Axis, name: &str) -> Option<f64> {
        let unit_um = self.reading.job.compensation.axes[axis].as_ref()?.detection_unit_um?;
        Some(self.memory.amount(1851, name.parse().ok())? * unit_um)
    }

    /// Old backlash of which rapid traverse had another.
    fn tell_cutting_feed(&mut self) {
        if self.reading.judges() {
            return;
        }
        for (axis, _) in self.reading.active.held_backlash.clone() {
            let of = |number| self.memory.amount(number, axis.parse().ok());
            if let (Some(cutting), Some(rapid)) = (of(1851), of(1852))
                && (cutting - rapid).abs() > 0.0
            {
                self.reading.tell(InControl::CuttingFeed { axis, cutting, rapid });
            }
        }
    }

    /// Points without the parameters that say which axis they belong to.
    fn tell_points_of_nobody(&mut self) {
        let mut keys = self.memory.parameters.keys();
        let has_owner = keys.any(|key| (3620..=3624).contains(&key.number))
            || !self.reading.active.others.points.is_empty();
        let points = self.memory.points.len();
        if !has_owner && points > 0 {
            self.reading.tell(InControl::PointsOfNobody { points });
        }
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

// What a Fanuc read-out says of the machine, against the job: unit, names, references, detection units and
// travel of its axes, and how the control plays its points. What is compared of the tables themselves stands in [`super::read_out`].

/// 1001#0 INM: whether the machine counts in inches.
fn unit_of(memory: &FanucMemory) -> Option<ControlUnit> {
    let is_inch = memory.bits(1001, None)? & 1 == 1;
    Some(if is_inch { ControlUnit::Inch } else { ControlUnit::Millimetre })
}

/// What contradicts the job, axis by axis.
fn found(
    job: &Job,
    names: &PerAxis<Vec<String>>,
    memory: &FanucMemory,
    facts: &FanucFacts,
) -> Vec<InControl> {
    let own = job.compensation.control_unit;
    let is_same_unit = unit_of(memory).is_none_or(|unit| unit == own);
    let mut found = Vec::new();
    for (axis, names) in names.iter() {
        for (index, name) in names.iter().enumerate() {
            let on = OnControl { memory, name, unit: own, facts };
            found.extend(on.other_name(axis, index == 0));
            if !is_same_unit {
                continue;
            }
            if let Some(machine) = &job.machine.axes[axis] {
                found.extend(on.reference(machine.reference.mm()));
                found.extend(on.travel(machine));
            }
            let stated = job.compensation.axes[axis].as_ref().and_then(|s| s.detection_unit_um);
            found.extend(stated.and_then(|um| on.detection_unit(um)));
        }
    }
    found
}

/// A controlled axis of the read-out.
struct OnControl<'a> {
    memory: &'a FanucMemory,
    name: &'a str,
    unit: ControlUnit,
    facts: &'a FanucFacts,
}

impl OnControl<'_> {
    /// Its number.
    fn number(&self) -> Option<u32> {
        self.name.parse().ok()
    }

    /// The last digit of a length, in the unit of the control.
    fn digit(&self) -> f64 {
        1.0 / power_of_ten(self.facts.interval_decimals(self.unit))
    }

    /// A length in the unit of the control; a whole number counts its last digits, as 3624 does on the same
    /// control.
    fn length(&self, parameter: u32) -> Option<f64> {
        let digits = self.memory.whole(parameter, self.number());
        let digits = digits.map(|digits| digits as f64 * self.digit());
        digits.or_else(|| self.memory.amount(parameter, self.number()))
    }

    /// 1020, the code of a letter. A slave of a gantry may have any but that of another linear axis.
    fn other_name(&self, own: Axis, is_first: bool) -> Option<InControl> {
        let code = self.memory.count(1020, self.number())?;
        let letter = char::from_u32(code)?;
        let others = if is_first { "XYZABC" } else { "XYZ" };
        let is_other = others.contains(letter) && letter != own.letter();
        is_other.then_some(InControl::OtherName { axis: self.name.to_string(), code, letter, own })
    }

    /// 1240, within half a digit of the control.
    fn reference(&self, own_mm: f64) -> Option<InControl> {
        let position = self.length(1240)?;
        let off_mm = (position * self.unit.in_mm() - own_mm).abs();
        let is_off = off_mm > 0.5 * self.digit() * self.unit.in_mm() * 1.001;
        let (axis, unit) = (self.name.to_string(), self.unit.word());
        is_off.then_some(InControl::Reference { axis, position, unit, own_mm })
    }

    /// 1820 and 1013: the least command increment divided by CMR (both from memory).
    fn detection_unit(&self, own_um: f64) -> Option<InControl> {
        let cmr = self.memory.count(1820, self.number())?;
        let system = self.memory.bits(1013, self.number())?;
        let (system, of_is_b) = match system & 0b1111 {
            0 => ("IS-B", 1.0),
            1 => ("IS-A", 10.0),
            2 => ("IS-C", 0.1),
            4 => ("IS-D", 0.01),
            8 => ("IS-E", 0.001),
            _ => return None,
        };
        let per_unit = match cmr {
            1..=96 => f64::from(cmr) / 2.0,
            101..=127 => 1.0 / f64::from(cmr - 100),
            _ => return None,
        };
        let um = rounded(self.unit.least_increment_um() * of_is_b / per_unit, 6);
        let axis = self.name.to_string();
        let is_other = (um - own_um).abs() > 0.01 * um;
        is_other.then_some(InControl::DetectionUnit { axis, cmr, system, um, own_um })
    }

    /// 1321 and 1320, the stored stroke limits; where − is not below +, there are none (from memory). They may
    /// stand a little beside the travel that was stated; a tenth of it that no limit lets through is another
    /// machine, or other coordinates.
    fn travel(&self, own: &MachineAxis) -> Option<InControl> {
        const SAME_MM: f64 = 1.0;
        let limit = |parameter| Some(self.length(parameter)? * self.unit.in_mm());
        let (low, high) = (limit(1321)?, limit(1320)?);
        let (from, to) = (own.low.mm(), own.high.mm());
        let beyond = (low - from).max(0.0) + (to - high).max(0.0);
        let differs = (low - from).abs().max((high - to).abs()) > SAME_MM;
        let axis = self.name.to_string();
        if low >= high || !differs {
            return None;
        }
        let (held_mm, own_mm) = ([low, high], [from, to]);
        Some(match beyond > 0.1 * (to - from) {
            true => InControl::TravelBeyond { axis, held_mm, own_mm },
            false => InControl::OtherTravel { axis, held_mm, own_mm },
        })
    }
}

// What a read-out holds around the points: how the control plays them, its second backlash parameter.

/// How a Fanuc control plays its points, and its second backlash parameter.
pub(super) fn around(
    plan: &Plan,
    state: &ControlState,
    wanted: &FanucMemory,
    held: &FanucMemory,
) -> Vec<InControl> {
    let mut found = Vec::new();
    for axis in &state.axes {
        if wanted.parameter(3623, axis.name.parse().ok()).is_some() {
            found.extend(switches(axis, wanted, held));
        }
        found.extend(rapid(plan, axis, held));
    }
    found
}

/// 3605 bits 0 and 1 of an axis with a pitch table.
fn switches(axis: &AxisState, wanted: &FanucMemory, held: &FanucMemory) -> Vec<InControl> {
    let number = axis.name.parse().ok();
    let of_state = u8::from(axis.bidirectional) | (u8::from(axis.interpolated) << 1);
    let asked = wanted.bits(3605, number).unwrap_or(of_state) & 0b11;
    let Some(found) = held.bits(3605, number) else { return Vec::new() };
    let meanings = ["a table for each direction", "lines between the points, not steps"];
    let other = meanings.into_iter().enumerate().map(|(bit, meaning)| {
        let (is, asked) = ((found >> bit) & 1, (asked >> bit) & 1);
        let axis = axis.name.clone();
        (is != asked).then_some(InControl::OtherSwitch { bit, axis, is, asked, meaning })
    });
    other.flatten().collect()
}

/// 1852 beside 1851 where the job sets the backlash parameter. Which of the two acts in rapid
/// traverse depends on a bit (1800#4, from memory) that is not read.
fn rapid(plan: &Plan, axis: &AxisState, held: &FanucMemory) -> Option<InControl> {
    let sets = |own: &Axis| plan.names[*own].contains(&axis.name) && plan.sets_backlash(*own);
    if !Axis::ALL.iter().any(sets) {
        return None;
    }
    let number = axis.name.parse().ok();
    let of = |parameter| Some(held.amount(parameter, number)?.to_string());
    let (axis, cutting) = (axis.name.clone(), of(1851));
    match of(1852) {
        None => cutting.map(|_| InControl::NoRapid { axis }),
        Some(rapid) => (cutting.as_ref() != Some(&rapid)).then(|| InControl::RapidDiffers {
            axis,
            rapid,
            cutting: cutting.unwrap_or("in no file".to_string()),
        }),
    }
}

/// Preconditions on parameters that no file holds, for the axes with a pitch table.
pub(super) fn absent(axes: &[AxisState], wanted: &FanucMemory, held: &FanucMemory) -> Vec<String> {
    let mut absent = Vec::new();
    if held.parameters.keys().all(|key| key.number != 3602) {
        absent.push("3602".to_string());
    }
    for axis in axes {
        let number = axis.name.parse().ok();
        let own = wanted.parameter(3623, number).is_some();
        let lacks = |parameter: &u32| own && held.parameter(*parameter, number).is_none();
        let lacking = [1006, 1240, 3605].into_iter().filter(lacks);
        absent.extend(lacking.map(|parameter| format!("{parameter} of axis {}", axis.name)));
    }
    absent
}
