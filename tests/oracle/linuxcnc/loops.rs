//! Known errors → kit → the control started with exactly its files → through the volume along axes and diagonals, both
//! ways → every servo cycle against our emulator, the simulated machine against our forecast.

use super::control::{CYCLE_S, Cycle, Joint, LETTERS, Setup, run};
use super::machine::{Machine, stands};
use crate::support::{UNCORRECTED, control, generate, response, text_of, um_at};
use nonius::control::controller::Role;
use nonius::kit::Kit;
use nonius::quantity::Direction;
use nonius::read::emulate::{Emulator, Response};
use std::fmt::Display;

/// What the emulator may differ from the control, µm; the rounding of what is printed comes on top.
const EMULATOR_UM: f64 = 1e-3;
/// What the forecast may differ from the machine, µm, likewise: it leaves out that the errors change over the way of the
/// correction itself, by 0.2 µm/mm times 0.01 mm for each axis.
const FORECAST_UM: f64 = 5e-3;
/// Quick, so that the test is: a reversal of less than half of it × cycle² (2.5 µm) could be left out (docs/linuxcnc.md §2).
pub(crate) const ACCELERATION_MM: f64 = 5000.0;

pub(crate) struct Case {
    pub(crate) machine: Machine,
    pub(crate) controller: &'static str,
    pub(crate) points: usize,
    /// Places of the first diagonal where the machine stands.
    pub(crate) stops: usize,
    pub(crate) unit: &'static str,
}

#[derive(Default)]
pub(crate) struct Seen {
    /// Servo cycles in which a joint moved, all joints together.
    pub(crate) cycles: usize,
    /// Largest difference between what the control adds and the emulator, µm.
    pub(crate) emulator_um: f64,
    /// Largest difference between what is left on the machine and the forecast of a term or diagonal, µm.
    pub(crate) forecast_um: f64,
    /// Largest error of a compensated term before and after, µm.
    pub(crate) before_um: f64,
    pub(crate) after_um: f64,
}

impl Case {
    fn unit_mm(&self) -> f64 {
        if self.unit == "inch" { 25.4 } else { 1.0 }
    }

    pub(crate) fn close(&self) -> Seen {
        let (inputs, kit) = generate(&self.job(), &self.error_table());
        let cycles = self.driven(&kit);
        let control = control(&inputs.profile, &kit);
        let emulator_um =
            (0..3).map(|joint| off_emulator(&cycles, joint, control.as_ref())).fold(0.0, f64::max);
        let moving = cycles.iter().flatten().filter(|joint| joint.speed != 0.0);
        let mut seen = Seen { cycles: moving.count(), emulator_um, ..Seen::default() };
        assert!(stands(&cycles).len() >= 2 * self.stops - 1, "{}", self.machine.name);
        self.against_forecast(&kit, &cycles, &mut seen);
        let (name, forecast_um) = (self.machine.name, seen.forecast_um);
        // Rounding of one printed position, µm.
        let printed_um = 0.5e-6 * self.unit_mm() * 1000.0;
        assert!(emulator_um <= EMULATOR_UM + 4.0 * printed_um, "{name}: {emulator_um} µm");
        assert!(forecast_um <= FORECAST_UM + 8.0 * printed_um, "{name}: {forecast_um} µm");
        seen
    }

    /// The errors at the points of the tables and so often between them that straight lines are as good as the curves.
    pub(crate) fn error_table(&self) -> String {
        let sections = self.points - 1;
        let steps = 480_usize.div_ceil(sections).max(2);
        self.machine.error_table(sections * steps + 1)
    }

    pub(crate) fn job(&self) -> String {
        let own = "terms = [\"EXX\", \"EYY\", \"EZZ\"]\n";
        let control = format!(
            "controller = \"{}\"\ncontrol_unit = \"{}\"\nbacklash = \"two-tables\"\n{}",
            self.controller,
            self.unit,
            if self.controller == "linuxcnc-hal" { "" } else { own },
        );
        let sections = (self.points - 1) as f64;
        let spacing = self.machine.travel.map(|[low, high]| (high - low) / sections);
        let measured = format!("errors = \"errors.csv\"\n{UNCORRECTED}");
        let job = self.machine.job(&measured, &control, spacing);
        job + "[acceptance]\nmax_deviation_um = 10.0\n"
    }

    /// Every servo cycle of the control with exactly the files of the kit, in mm.
    fn driven(&self, kit: &Kit) -> Vec<Cycle> {
        let unit_mm = self.unit_mm();
        let tables = kit.files.iter().filter(|file| file.role == Role::Table);
        let seen = run(&Setup {
            unit: self.unit,
            travel: self.machine.travel.map(|ends| ends.map(|end| end / unit_mm)),
            acceleration_mm: ACCELERATION_MM,
            joints: sections(text_of(kit, "joints.ini")),
            files: tables.map(|file| (file.path.clone(), file.bytes.clone())).collect(),
            programs: vec![path(&self.machine, self.stops, unit_mm)],
            ..Setup::default()
        });
        // Which it says of every curve above the 64th (docs/linuxcnc.md §3).
        let in_order = |line: &str| line.contains("assigned personality=16");
        assert!(seen.messages.lines().all(in_order), "{}", seen.messages);
        let in_mm = |cycle: &Cycle| cycle.map(|joint| joint.times(unit_mm));
        seen.cycles[0].iter().map(in_mm).collect()
    }

    fn against_forecast(&self, kit: &Kit, cycles: &[Cycle], seen: &mut Seen) {
        let machine = &self.machine;
        for of in kit.forecast.terms.iter().filter(|of| of.compensated) {
            let [output, base] = joints(&of.term.to_string());
            let [before, after] = match output == base {
                true => left_of_own_term(machine, cycles, base),
                false => left_of_cross_term(machine, cycles, base, output),
            };
            seen.before_um = seen.before_um.max(before);
            seen.after_um = seen.after_um.max(after);
            seen.is_forecast(&of.term, after, of.change.after_um);
        }
        for of in &kit.forecast.diagonals {
            let left = left_along_diagonal(machine, cycles, of.diagonal.name());
            seen.is_forecast(&of.diagonal, left, of.change.after_um);
        }
    }
}

impl Seen {
    fn is_forecast(&mut self, what: &dyn Display, left: f64, forecast: f64) {
        println!("{what} {left:.4} µm, forecast {forecast:.4}");
        self.forecast_um = self.forecast_um.max((left - forecast).abs());
    }
}

/// The moved and the moving joint of a term: `EYX` is 1, 0.
pub(crate) fn joints(term: &str) -> [usize; 2] {
    let joint = |letter: char| LETTERS.iter().position(|own| own.starts_with(letter));
    let letters: Vec<char> = term.chars().collect();
    [joint(letters[1]).unwrap(), joint(letters[2]).unwrap()]
}

pub(crate) fn sections(fragment: &str) -> [String; 3] {
    let section = |joint: usize| -> String {
        let head = format!("[JOINT_{joint}]");
        let from = fragment.lines().skip_while(|line| line.trim() != head).skip(1);
        let own = from.take_while(|line| !line.starts_with('['));
        own.map(|line| format!("{line}\n")).collect()
    };
    [0, 1, 2].map(section)
}

/// All axes together up and down in steps; then the other diagonals without a stop, and each axis by itself.
pub(crate) fn path(machine: &Machine, places: usize, unit_mm: f64) -> String {
    let words = |place: [f64; 3]| -> String {
        let word = |axis: usize| format!(" {}{:.8}", LETTERS[axis], place[axis] / unit_mm);
        [0, 1, 2].map(word).concat()
    };
    let at = |part: [f64; 3]| {
        words([0, 1, 2].map(|axis| {
            let [low, high] = machine.travel[axis];
            low + part[axis] * (high - low)
        }))
    };
    let g20 = if unit_mm > 1.0 { "G20" } else { "G21" };
    let mut program = format!("{g20} G90 G17 G61 G94\nF{}\n", 30000.0 / unit_mm);
    let up = (0..places).map(|n| n as f64 / (places - 1) as f64);
    let down = up.clone().rev().skip(1);
    program += &format!("G0{}\n", at([0.02; 3]));
    program += &format!("G0{}\n", at([0.0; 3]));
    for part in up.chain(down) {
        program += &format!("G1{}\nG4 P0.2\n", at([part; 3]));
    }
    for [x, y, z] in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        let (from, to) = (at([x, y, z]), at([1.0 - x, 1.0 - y, 1.0 - z]));
        program += &format!("G0{from}\nG1{to}\nG1{from}\n");
    }
    for axis in 0..3 {
        let alone = |at: f64| words([0, 1, 2].map(|own| if own == axis { at } else { 0.0 }));
        let [low, high] = machine.travel[axis].map(alone);
        program += &format!("G0{}\nG0{low}\nG1{high}\nG1{low}\n", alone(0.0));
    }
    program + "M2\n"
}

/// The largest difference, µm, of the table of a joint from the emulator while it moves, and of what all the others
/// add to it from theirs at any time. What is added is what the table says but for the ramp after a reversal, which is short
/// and leaves at most half of acceleration × cycle² (docs/linuxcnc.md §2).
fn off_emulator(cycles: &[Cycle], joint: usize, control: &dyn Emulator) -> f64 {
    let of = |base: usize, way| response(control, &base.to_string(), &joint.to_string(), way);
    let own = [Direction::Plus, Direction::Minus].map(|way| of(joint, way));
    let others = (0..3).filter(|base| *base != joint);
    let others: Vec<(usize, Response)> =
        others.map(|base| (base, of(base, Direction::Plus))).collect();
    let step_um = 0.5 * ACCELERATION_MM * CYCLE_S * CYCLE_S * 1000.0;
    let (mut largest, mut ramp) = (0.0_f64, 0);
    for cycle in cycles {
        let now = cycle[joint];
        ramp = if now.ramp_um() > step_um + 0.1 { ramp + 1 } else { 0 };
        assert!(ramp < 100, "a ramp does not end at {now:?}");
        if now.speed != 0.0 {
            let way = &own[usize::from(now.speed < 0.0)];
            largest = largest.max((now.table * 1000.0 - um_at(way, now.command)).abs());
        }
        let sum: f64 = others.iter().map(|(base, of)| um_at(of, cycle[*base].command)).sum();
        largest = largest.max((now.by_others_um() - sum).abs());
    }
    largest
}

/// The largest positioning error without and with the table of a joint, µm: where all stand, and where it moves after its
/// ramps.
fn left_of_own_term(machine: &Machine, cycles: &[Cycle], joint: usize) -> [f64; 2] {
    let error = |drive: f64, upwards: bool, added: f64| {
        let error = machine.error_um(joint, joint, drive, upwards);
        [error, error + added * 1000.0]
    };
    let stands = stands(cycles);
    let standing =
        stands.iter().map(|at| error(at.drive[joint], at.upwards[joint], at.added[joint]));
    let own = cycles.iter().map(|cycle| cycle[joint]);
    let moving = own.filter(|now| now.speed != 0.0 && !now.is_ramped());
    let moving = moving.map(|now| error(now.drive, now.speed > 0.0, now.added));
    standing.chain(moving).fold([0.0; 2], largest)
}

/// The largest error across without and with the curves, µm, while a joint moves and the others are at the reference point.
fn left_of_cross_term(machine: &Machine, cycles: &[Cycle], base: usize, output: usize) -> [f64; 2] {
    let is_alone = |cycle: &&Cycle| {
        let others = (0..3).filter(|joint| *joint != base);
        let at_reference =
            |joint: usize| cycle[joint].speed == 0.0 && cycle[joint].command.abs() < 1e-6;
        cycle[base].speed != 0.0 && others.into_iter().all(at_reference)
    };
    let error = |cycle: &Cycle| {
        let now = cycle[base];
        let error = machine.error_um(base, output, now.drive, now.speed > 0.0);
        [error, error + cycle[output].by_others_um()]
    };
    let alone = cycles.iter().filter(is_alone);
    alone.map(error).fold([0.0; 2], largest)
}

fn largest(largest: [f64; 2], of: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|which| f64::max(largest[which], of[which].abs()))
}

/// Largest less smallest error of the machine's point along a diagonal, both ways, µm, once the ramps at its ends are over.
fn left_along_diagonal(machine: &Machine, cycles: &[Cycle], name: &str) -> f64 {
    let size = machine.travel.map(|[low, high]| high - low);
    let length = size.iter().map(|side| side * side).sum::<f64>().sqrt();
    let sign = |letter| if letter == 'P' { 1.0 } else { -1.0 };
    let signs: Vec<f64> = name.chars().map(sign).collect();
    let is_on = |cycle: &&Cycle| {
        let way = cycle[0].speed.signum() * signs[0];
        let part = |joint: usize| {
            let from_low = (cycle[joint].command - machine.travel[joint][0]) / size[joint];
            if signs[joint] > 0.0 { from_low } else { 1.0 - from_low }
        };
        let moves = |joint: usize| {
            cycle[joint].speed * signs[joint] * way > 0.0 && !cycle[joint].is_ramped()
        };
        (0..3).all(|joint| moves(joint) && (part(joint) - part(0)).abs() < 1e-6)
    };
    let along = |cycle: &Cycle| -> f64 {
        let errors =
            machine.errors_um(cycle.map(|joint| joint.drive), cycle.map(|joint| joint.speed > 0.0));
        let axis = |joint: usize| {
            let added = (cycle[joint].drive - cycle[joint].command) * 1000.0;
            signs[joint] * size[joint] / length * (errors[joint] + added)
        };
        (0..3).map(axis).sum()
    };
    let on_it = cycles.iter().filter(is_on).map(along);
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = on_it.fold(none, |[low, high], um| [low.min(um), high.max(um)]);
    high - low
}

impl Joint {
    fn times(self, factor: f64) -> Joint {
        let Joint { command, drive, speed, offset, table, added } = self;
        let [command, drive, speed] = [command, drive, speed].map(|figure| figure * factor);
        let [offset, table, added] = [offset, table, added].map(|figure| figure * factor);
        Joint { command, drive, speed, offset, table, added }
    }

    /// What is added to the joint besides its own table, µm, of a joint in mm.
    fn by_others_um(self) -> f64 {
        (self.drive - self.command - self.added) * 1000.0
    }

    fn is_ramped(self) -> bool {
        self.ramp_um() > 0.000_1
    }

    fn ramp_um(self) -> f64 {
        (self.added - self.table).abs() * 1000.0
    }
}
