//! Pitch, straightness and backlash parameters of a Fanuc read-out.

use super::{Held, Others, axis_of};
use crate::control::claims::Assumption;
use crate::control::controller::{FanucFacts, LengthUnit, NumberRange, StraightnessForm};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterValue};
use crate::inputs::job::Job;
use crate::judge::active::found::{Contrary, Found, NamedBacklash, ReadOutFor, beside_words};
use crate::quantity::axis::{Axis, PerAxis};
use crate::quantity::units::power_of_ten;
use crate::read::control_data::{self, Text};
use crate::read::fanuc::{merge, read_out};
use crate::text::problem::Problems;

type Names = PerAxis<Vec<String>>;

/// Functions whose parameters at 0 do nothing (docs/fanuc.md §1.1, §2).
const IDLE_AT_ZERO: [(u32, u32); 5] = [
    (3666, 3671),
    (3676, 3677),
    (5861, 5874),
    (10800, 10814),
    (14985, 14988),
];

/// Reads the files of a control.
pub(super) fn read(
    job: &Job,
    names: &Names,
    facts: &FanucFacts,
    texts: &[Text<'_>],
    purpose: ReadOutFor,
) -> Result<Found, Problems> {
    let mut problems = Problems::none();
    let mut memories = Vec::new();
    let mut notes = Vec::new();
    let mut assumptions = Vec::new();
    for (name, text) in texts {
        let (kept, passed_over) = control_data::fanuc(text, facts);
        let unit = job.compensation.control_unit;
        if let Some(read) = problems.take(read_out(name, &kept, facts, unit)) {
            memories.push(read.memory);
            match purpose {
                ReadOutFor::OldTables => assumptions.extend(read.spindles.iter().map(of_spindle)),
                ReadOutFor::Judging => notes.extend(read.spindles.iter().map(|parameter| {
                    format!("{parameter}: a spindle corrects no axis of the job, passed over")
                })),
            }
        }
        if passed_over > 0 {
            notes.push(format!(
                "`{name}`: {passed_over} other parameters were passed over"
            ));
        }
    }
    let memory = merge(problems.or_ok(memories)?)?;
    let held = Held::plain(Tables::Fanuc(memory.clone()));
    let mut sorted = Sorted {
        job,
        names,
        facts,
        memory,
        purpose,
        notes,
        others: Others::default(),
        contrary: Vec::new(),
        beside: Vec::new(),
    };
    sorted.take_sets();
    sorted.take_other_axes();
    let backlash = PerAxis::from_fn(|axis| sorted.backlash(axis));
    sorted.check_references();
    sorted.tell_points_of_nobody();
    sorted.take_what_is_no_table();
    Ok(Found {
        tables: Tables::Fanuc(sorted.memory),
        held,
        backlash,
        others: sorted.others,
        assumptions,
        notes: sorted.notes,
        unit: None,
        contrary: sorted.contrary,
        beside: sorted.beside,
    })
}

/// 3605#1 of an axis as files of the control hold it; `None` where none does, or the axes of a
/// gantry differ.
pub(super) fn interpolated(memory: &FanucMemory, names: &[String]) -> Option<bool> {
    let mut all = names
        .iter()
        .map(|name| match memory.parameter(3605, name.parse().ok()) {
            Some(ParameterValue::Bits(bits)) => Some(bits & 0b10 != 0),
            _ => None,
        });
    let first = all.next()??;
    all.all(|other| other == Some(first)).then_some(first)
}

/// Whose points a parameter of a spindle means is not known.
fn of_spindle(parameter: &String) -> Assumption {
    Assumption::of_job(
        parameter,
        "it takes no point of the job's axes",
        "a spindle with a pitch compensation of its own (Cs axis) would take points of these tables: compare its point numbers on the control",
    )
}

struct Sorted<'a> {
    job: &'a Job,
    names: &'a Names,
    facts: &'a FanucFacts,
    memory: FanucMemory,
    purpose: ReadOutFor,
    notes: Vec<String>,
    others: Others,
    contrary: Vec<Contrary>,
    beside: Vec<String>,
}

impl Sorted<'_> {
    fn number(&self, parameter: u32, axis: Option<u32>) -> Option<u32> {
        match self.memory.parameter(parameter, axis)? {
            ParameterValue::Integer(value) => u32::try_from(value).ok(),
            _ => None,
        }
    }

    fn is_own(&self, axis: u32) -> bool {
        axis_of(self.names, &axis.to_string()).is_some()
    }

    fn remove(&mut self, numbers: &[u32]) {
        self.memory
            .parameters
            .retain(|key, _| !numbers.contains(&key.number));
    }

    /// Straightness sets that are not in use, or belong to other axes.
    fn take_sets(&mut self) {
        for index in 0..self.facts.straightness_sets.value {
            let moving = self.number(5711 + index, None).unwrap_or(0);
            let shifted = self.number(5721 + index, None).unwrap_or(0);
            // A set without its corrected axis is not complete, which the emulation tells.
            if moving != 0 && self.is_own(moving) && (shifted == 0 || self.is_own(shifted)) {
                continue;
            }
            if moving != 0 {
                self.take_set_of_others(index + 1, moving, shifted);
                self.reserve_set(index, moving);
            }
            let four_points =
                (0..4).flat_map(|knot| [5731, 5761].map(|first| first + 10 * index + knot));
            let mut numbers = vec![
                5711 + index,
                5721 + index,
                self.facts.straightness_magnification_parameter.value + index,
                self.facts.straightness_start_parameter.value + index,
            ];
            if self.facts.straightness_form.value == StraightnessForm::FourPoint {
                numbers.extend(four_points);
            }
            self.remove(&numbers);
        }
    }

    /// A set in use of which an axis is none of the job.
    fn take_set_of_others(&mut self, set: u32, moving: u32, shifted: u32) {
        self.others.sets.push(set);
        let name = format!("straightness set {set} (axis {shifted} while axis {moving} moves)");
        let magnification = self.facts.straightness_magnification_parameter.value + set - 1;
        let is_idle = self.number(magnification, None) == Some(0);
        if self.purpose == ReadOutFor::Judging && self.is_own(shifted) && !is_idle {
            self.beside.push(beside_words(&name, &moving.to_string()));
        } else {
            let left = self.purpose.leaves();
            self.notes.push(format!(
                "{name} belongs to axes that the job does not have: {left}"
            ));
        }
    }

    /// The points of a per-point set of other axes.
    fn reserve_set(&mut self, index: u32, moving: u32) {
        let start = self.number(self.facts.straightness_start_parameter.value + index, None);
        let first = self.number(3621, Some(moving));
        let last = self.number(3622, Some(moving));
        if let (StraightnessForm::PerPoint, Some(start), Some(first), Some(last)) =
            (self.facts.straightness_form.value, start, first, last)
        {
            let last = start.saturating_add(last.saturating_sub(first));
            self.others.points.push(NumberRange { first: start, last });
        }
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
                let left = self.purpose.leaves();
                self.notes.push(format!("the pitch compensation of axis {axis} (points {first} to {last}) belongs to an axis that the job does not have: {left}"));
            }
            self.others.points.extend(points);
            self.memory
                .parameters
                .retain(|key, _| key.axis != Some(axis));
        }
    }

    /// The points of an axis in use: its table, and that for travel in − where 3605#0 does not
    /// switch it off.
    fn points_of(&self, axis: u32) -> Vec<NumberRange> {
        let number = |parameter| self.number(parameter, Some(axis));
        let (Some(1..), Some(first), Some(last)) = (number(3623), number(3621), number(3622))
        else {
            return Vec::new();
        };
        let mut points = vec![NumberRange { first, last }];
        let bits = self.memory.parameter(3605, Some(axis));
        let is_off = matches!(bits, Some(ParameterValue::Bits(bits)) if bits & 1 == 0);
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
        if self.purpose == ReadOutFor::OldTables {
            return;
        }
        let names = Axis::ALL.into_iter().flat_map(|axis| &self.names[axis]);
        let own: Vec<u32> = names.filter_map(|name| name.parse().ok()).collect();
        for axis in own {
            let is_same = |number: &u32| {
                let of = |axis| self.memory.parameter(*number, Some(axis));
                of(axis) == of(other)
            };
            let is_slave = [3620, 3621, 3622, 3623, 3624].iter().all(is_same);
            let overlaps = |own: &NumberRange| points.iter().any(|other| other.overlaps(*own));
            if !self.points_of(axis).iter().any(overlaps) {
                continue;
            }
            if is_slave {
                self.notes.push(format!("axis {other}, which the job does not have, takes the points of axis {axis}, as the slave of a gantry does"));
            } else {
                self.beside.push(format!("axis {other}, which the job does not have, takes points of axis {axis} in another way than it: it is corrected by errors that are not its own"));
            }
        }
    }

    /// 1851 of each axis of the control, µm.
    fn backlash(&mut self, axis: Axis) -> NamedBacklash {
        let settings = self.job.compensation.axes[axis].as_ref();
        let Some(unit_um) = settings.and_then(|s| s.detection_unit_um) else {
            return NamedBacklash::new();
        };
        let mut held = NamedBacklash::new();
        for name in &self.names[axis] {
            let of = |number| self.any_number(number, name);
            let (cutting, rapid) = (of(1851), of(1852));
            if let (ReadOutFor::OldTables, Some(cutting), Some(rapid)) =
                (self.purpose, cutting, rapid)
                && (cutting - rapid).abs() > 0.0
            {
                self.notes.push(format!("axis {name}: 1851 is {cutting} and 1852 is {rapid}; 1851 (cutting feed) is taken"));
            }
            held.push((name.clone(), cutting.map(|counts| counts * unit_um)));
        }
        held
    }

    /// A parameter of an axis, with or without a decimal point.
    #[allow(clippy::cast_precision_loss, reason = "parameters are far below 2^52")]
    fn any_number(&self, parameter: u32, axis: &str) -> Option<f64> {
        match self.memory.parameter(parameter, axis.parse().ok())? {
            ParameterValue::Integer(whole) => Some(whole as f64),
            ParameterValue::Real(real) => Some(real),
            ParameterValue::Bits(_) => None,
        }
    }

    /// Points without the parameters that say which axis they belong to.
    fn tell_points_of_nobody(&mut self) {
        let mut keys = self.memory.parameters.keys();
        let has_owner = keys.any(|key| (3620..=3624).contains(&key.number));
        if has_owner || !self.others.points.is_empty() || self.memory.points.is_empty() {
            return;
        }
        let words = format!(
            "the files hold {} points and no parameter 3620 to 3624, so which axes they correct is not known",
            self.memory.points.len()
        );
        match self.purpose {
            ReadOutFor::Judging => self.beside.push(words),
            ReadOutFor::OldTables => self.contrary.push(Contrary::new(
                words,
                "read out the parameters too (`CNC-PARA.TXT`) and name both files together",
            )),
        }
    }

    /// 1240 against the job.
    fn check_references(&mut self) {
        for axis in Axis::ALL {
            let Some(machine) = self.job.machine.axes[axis] else {
                continue;
            };
            for name in self.names[axis].clone() {
                self.check_reference(&name, machine.reference.mm());
            }
        }
    }

    /// 1240 of an axis, within half a digit of the control. A whole number counts these digits, as
    /// 3624 does on the same control.
    fn check_reference(&mut self, name: &str, reference_mm: f64) {
        let unit = self.job.compensation.control_unit;
        let decimals = match unit {
            LengthUnit::Millimetre => self.facts.interval_decimals_mm.value,
            LengthUnit::Inch => self.facts.interval_decimals_inch.value,
        };
        let per_unit = power_of_ten(decimals);
        let number = name.parse().ok();
        let (Some(held), Some(value)) = (
            self.memory.parameter(1240, number),
            self.any_number(1240, name),
        ) else {
            return;
        };
        let position = match held {
            ParameterValue::Integer(_) => value / per_unit,
            _ => value,
        };
        let half_a_digit_mm = 0.5 * unit.in_mm() / per_unit;
        if (position * unit.in_mm() - reference_mm).abs() > half_a_digit_mm * 1.001 {
            self.contrary.push(Contrary::new(
                format!(
                    "1240 of axis {name} is {position} {}, the job has the reference at {reference_mm} mm",
                    unit.word()
                ),
                "correct `reference_mm`; tables of another reference cannot be added",
            ));
        }
    }

    /// What was judged, and what does nothing.
    fn take_what_is_no_table(&mut self) {
        self.remove(&[1240, 1851, 1852]);
        self.memory.parameters.retain(|key, value| {
            let idle = IDLE_AT_ZERO
                .iter()
                .any(|(a, b)| (*a..=*b).contains(&key.number));
            let zero = match value {
                ParameterValue::Integer(number) => *number == 0,
                ParameterValue::Real(number) => number.abs() <= 0.0,
                ParameterValue::Bits(bits) => *bits == 0,
            };
            !(idle && zero)
        });
    }
}
