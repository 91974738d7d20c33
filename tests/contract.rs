//! The contract: whatever machine is measured, the bytes that a control loads cancel its errors.
//!
//! ```text
//!   machine of the test ─→ job and error table (text) ─→ kit (bytes) ─→ emulated control
//!         └──────────────── deviation ──────── + ──────── correction ────────┘  ≤ bound
//! ```
//! Deviations are evaluated by the test itself: straight lines with code of its own, cubics
//! through the public curve; zero, mean of both directions and reversal are computed here once
//! more. So a change of sign in the program cannot cancel itself.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test may stop at what it did not expect"
)]

mod support;

use nonius::axis::{Axis, Direction, ErrorTerm};
use nonius::controller::{Dialect, NumberRange, Profile, StraightnessForm, TableSign, builtin};
use nonius::curve::{ErrorCurve, Interpolation};
use nonius::emulate::{Emulator, Response};
use nonius::forecast::TermForecast;
use nonius::kit::{Inputs, Kit};
use nonius::table::Tables;
use nonius::table::fanuc::{FanucMemory, ParameterValue};
use nonius::units::{Deviation, Millimetres};
use std::fmt::Write;
use support::{DUST_UM, Lines, Random, um_at};

/// Machines for each profile.
const MACHINES: usize = 72;
/// Positions of a dense look along an axis.
const DENSE: usize = 240;
/// Beside a jump, mm: near enough that no curve moves by more than [`NEAR_UM`].
const BESIDE_MM: f64 = 1e-7;
/// What a curve moves within [`BESIDE_MM`], µm.
const NEAR_UM: f64 = 1e-5;

// ---------------------------------------------------------------------------------------------
// The machine of the test

#[derive(Clone, Debug)]
enum Shape {
    Lines(Lines),
    Cubic(Lines, ErrorCurve),
}

/// Deviation of one term in one direction as measured, µm over mm, plus a squareness.
#[derive(Clone, Debug)]
struct Errors {
    shape: Shape,
    slope_um_per_m: f64,
}

impl Errors {
    fn new(mm: Vec<f64>, um: Vec<f64>, kind: Interpolation) -> Errors {
        let lines = Lines { mm, um };
        let shape = if kind == Interpolation::Linear {
            Shape::Lines(lines)
        } else {
            let positions: Vec<_> = lines.mm.iter().copied().map(Millimetres::new).collect();
            let values: Vec<_> = lines.um.iter().copied().map(Deviation::from_um).collect();
            let curve = ErrorCurve::through(&positions, &values, kind);
            Shape::Cubic(lines, curve)
        };
        Errors {
            shape,
            slope_um_per_m: 0.0,
        }
    }

    fn points(&self) -> &Lines {
        match &self.shape {
            Shape::Lines(lines) | Shape::Cubic(lines, _) => lines,
        }
    }

    fn range(&self) -> (f64, f64) {
        let mm = &self.points().mm;
        (mm[0], mm[mm.len() - 1])
    }

    fn at(&self, x: f64) -> f64 {
        let (low, high) = self.range();
        let base = match &self.shape {
            Shape::Lines(lines) => lines.at(x),
            Shape::Cubic(_, curve) => curve.at(Millimetres::new(x)).um(),
        };
        base + self.slope_um_per_m / 1000.0 * x.clamp(low, high)
    }
}

/// One measured term.
#[derive(Clone, Debug)]
struct Term {
    term: ErrorTerm,
    directed: bool,
    plus: Option<Errors>,
    minus: Option<Errors>,
    reference: f64,
    homing: Direction,
}

impl Term {
    fn errors(&self, direction: Direction) -> Option<&Errors> {
        match direction {
            Direction::Plus => self.plus.as_ref(),
            Direction::Minus => self.minus.as_ref(),
        }
    }

    fn both_ways(&self) -> bool {
        self.directed && self.plus.is_some() && self.minus.is_some()
    }

    /// As measured: what is subtracted so that the reference direction is zero at the reference.
    fn zero(&self) -> f64 {
        let own = self.errors(self.homing);
        let curve = own.or(self.plus.as_ref()).or(self.minus.as_ref());
        curve.unwrap().at(self.reference)
    }

    /// Deviation relative to the reference.
    fn deviation(&self, direction: Direction, x: f64) -> f64 {
        self.errors(direction).unwrap().at(x) - self.zero()
    }

    fn mean(&self, x: f64) -> f64 {
        let (plus, minus) = (self.plus.as_ref().unwrap(), self.minus.as_ref().unwrap());
        let low = plus.range().0.max(minus.range().0);
        let high = plus.range().1.min(minus.range().1);
        let x = x.clamp(low, high);
        (plus.at(x) + minus.at(x)) / 2.0
    }

    /// Mean of (moving + minus moving −) over the common range: Simpson's rule between all
    /// points, which is exact for cubics.
    fn reversal(&self) -> f64 {
        let (plus, minus) = (self.plus.as_ref().unwrap(), self.minus.as_ref().unwrap());
        let low = plus.range().0.max(minus.range().0);
        let high = plus.range().1.min(minus.range().1);
        let mut places: Vec<f64> = [&plus.points().mm[..], &minus.points().mm[..]].concat();
        places.retain(|x| *x >= low && *x <= high);
        places.sort_by(f64::total_cmp);
        let difference = |x: f64| plus.at(x) - minus.at(x);
        let area: f64 = places
            .windows(2)
            .map(|p| {
                let middle = (p[0] + p[1]) / 2.0;
                (p[1] - p[0]) / 6.0
                    * (difference(p[0]) + 4.0 * difference(middle) + difference(p[1]))
            })
            .sum();
        area / (high - low)
    }

    /// What the table that acts in `direction` has to cancel.
    fn target(&self, machine: &Machine, profile: &Profile, direction: Direction, x: f64) -> f64 {
        if !self.both_ways() {
            let measured = if self.errors(direction).is_some() {
                direction
            } else {
                direction.opposite()
            };
            return self.deviation(measured, x);
        }
        let from_reference = |direction: Direction| {
            self.errors(direction).unwrap().at(x)
                - self.errors(direction).unwrap().at(self.reference)
        };
        match machine.policy.unwrap() {
            "forward-only" => from_reference(Direction::Plus),
            "curve-and-parameter" => from_reference(self.homing),
            "two-tables" if self.takes_directions(profile) => self.deviation(direction, x),
            _ => self.mean(x) - self.mean(self.reference),
        }
    }

    fn takes_directions(&self, profile: &Profile) -> bool {
        !matches!(profile.dialect, Dialect::Fanuc(_)) || self.term.is_positioning()
    }

    /// Every place where a measured curve bends.
    fn knots(&self) -> Vec<f64> {
        let both = [&self.plus, &self.minus];
        both.into_iter()
            .flatten()
            .flat_map(|errors| errors.points().mm.clone())
            .collect()
    }
}

#[derive(Clone, Debug)]
struct MachineAxis {
    low: f64,
    high: f64,
    reference: f64,
    names: Vec<String>,
    unit_um: Option<f64>,
    interpolated: bool,
}

/// A generated machine, its job and its error table.
struct Machine {
    axes: Vec<MachineAxis>,
    terms: Vec<Term>,
    policy: Option<&'static str>,
    fit: &'static str,
    kind: Interpolation,
    inch: bool,
    reserved: Vec<[u32; 2]>,
    job: String,
    csv: String,
    features: Vec<&'static str>,
}

impl Machine {
    fn axis(&self, axis: Axis) -> &MachineAxis {
        &self.axes[Axis::ALL.iter().position(|a| *a == axis).unwrap()]
    }

    fn pairs(&self, term: ErrorTerm) -> Vec<(&str, &str)> {
        let base = &self.axis(term.along).names[0];
        let outputs = &self.axis(term.of).names;
        let pair = |output| (if term.is_positioning() { output } else { base }, output);
        outputs.iter().map(|o| pair(o)).map(|(b, o)| (b.as_str(), o.as_str())).collect()
    }
}

const POLICIES: [&str; 4] = ["mean", "two-tables", "forward-only", "curve-and-parameter"];

/// The machine number `seed` for a profile.
fn machine(profile: &Profile, seed: usize) -> Machine {
    let mut random = Random::new(seed as u64 * 1000 + profile.id.len() as u64);
    let fanuc = matches!(profile.dialect, Dialect::Fanuc(_));
    let siemens = matches!(profile.dialect, Dialect::Siemens(_));
    let mut features = Vec::new();
    // Cycled, so that every value meets the others; the rest is drawn.
    let directions = seed % 7; // 0, 1: undirected · 2 … 5: both, one policy each · 6: one way
    let policy = (2..=5).contains(&directions).then(|| POLICIES[directions - 2]);
    let kind = [
        Interpolation::Linear,
        Interpolation::Linear,
        Interpolation::Pchip,
        Interpolation::NaturalSpline,
    ][(seed / 7) % 4];
    let fit = ["sample", "sample", "least-squares", "minimax"][(seed / 3) % 4];
    let inch = seed % 5 == 3;
    let steep = seed % 6 == 1;
    let nine = !random.once_in(3);
    features.push(policy.unwrap_or(if directions == 6 { "one way" } else { "undirected" }));
    features.push(fit);
    features.push(match kind {
        Interpolation::Linear => "linear",
        Interpolation::Pchip => "pchip",
        Interpolation::NaturalSpline => "natural-spline",
    });
    features.extend(inch.then_some("inch"));
    features.extend(steep.then_some("steep"));
    features.push(if nine { "nine terms" } else { "fewer terms" });

    let unit_um = random.of(&[1.0, 0.1, 2.5]);
    let stated_unit = (fanuc || (!siemens && random.once_in(3))).then_some(unit_um);
    let gantry = random.once_in(4);
    features.extend(gantry.then_some("gantry"));
    let measured: Vec<ErrorTerm> = ErrorTerm::ALL
        .into_iter()
        .filter(|_| nine || !random.once_in(2))
        .collect();
    let measured = if measured.is_empty() {
        vec![ErrorTerm::ALL[random.below(9)]]
    } else {
        measured
    };

    let mut axes = Vec::new();
    let mut terms = Vec::new();
    let mut csv = String::from("axis,direction,position_mm,ex_um,ey_um,ez_um\n");
    let mut machine_text = String::new();
    let mut axes_text = String::new();
    let mut slopes = Vec::new();
    for (index, axis) in Axis::ALL.into_iter().enumerate() {
        let length = random.of(&[100.0, 240.0, 500.0, 720.0, 900.0, 1234.567]);
        let low = random.of(&[0.0, -length, -length / 4.0, 17.5]);
        let high = low + length;
        let (from, to) = if random.once_in(3) {
            (low + 0.11 * length, high - 0.08 * length)
        } else {
            (low, high)
        };
        let reference = match random.below(6) {
            0 => low,
            1 => high,
            2 => low + 0.05 * length, // off the measured range, where that is shorter
            3 => low + 0.5 * length,
            _ => random.between(low, high),
        };
        let rounded = |x: f64| (x * 1000.0).round() / 1000.0;
        let (from, to, reference) = (rounded(from), rounded(to), rounded(reference));
        features.push(if reference < from || reference > to {
            "reference not measured"
        } else if reference <= low || reference >= high {
            "reference at an end"
        } else {
            "reference inside"
        });
        let homing = if random.once_in(2) { Direction::Minus } else { Direction::Plus };
        let homing_stated = homing == Direction::Minus || random.once_in(2);
        writeln!(
            machine_text,
            "[machine.axes.{}]\ntravel_mm = [{low:?}, {high:?}]\nreference_mm = {reference:?}",
            axis.key()
        )
        .unwrap();
        if homing_stated {
            writeln!(machine_text, "reference_direction = \"{homing}\"").unwrap();
        }

        let default_name = &profile.axis_names.value[index];
        let names = if gantry && index == 0 {
            let second = if fanuc { "4" } else if siemens { "AX4" } else { "x2" };
            vec![default_name.clone(), second.to_string()]
        } else {
            vec![default_name.clone()]
        };

        let along: Vec<ErrorTerm> = measured.iter().copied().filter(|t| t.along == axis).collect();
        let step_limit = if along.is_empty() {
            1.0
        } else {
            add_terms(
                &mut random, &along, directions, kind, steep, unit_um, (from, to), reference,
                homing, length, &mut terms, &mut csv,
            )
        };
        writeln!(axes_text, "[compensation.axes.{}]", axis.key()).unwrap();
        let interpolated = fanuc && random.once_in(3);
        features.extend(interpolated.then_some("interpolated"));
        grid_text(&mut random, &mut axes_text, length, step_limit, fit, &mut features);
        if let Some(unit) = stated_unit {
            writeln!(axes_text, "detection_unit_um = {unit:?}").unwrap();
        }
        if names.len() > 1 {
            writeln!(axes_text, "ids = {names:?}").unwrap();
        }
        if fanuc {
            if interpolated {
                writeln!(axes_text, "interpolated = true").unwrap();
            }
            if random.once_in(4) {
                features.push("first_point");
                writeln!(axes_text, "first_point = {}", 150 + 150 * index).unwrap();
            }
            if random.once_in(4) {
                features.push("parameter_3605");
                writeln!(axes_text, "parameter_3605 = \"10000000\"").unwrap();
            }
        }
        if siemens && random.once_in(4) {
            writeln!(axes_text, "measuring_system = 2").unwrap();
        }
        axes.push(MachineAxis {
            low,
            high,
            reference,
            names,
            unit_um: stated_unit,
            interpolated,
        });
    }

    // Squareness of slopes that the measurement does not contain.
    if random.once_in(4) {
        for (key, name) in [("xy", "EXY"), ("xz", "EXZ"), ("yz", "EYZ")] {
            let term = ErrorTerm::from_name(name).unwrap();
            let own = terms.iter_mut().find(|t: &&mut Term| t.term == term);
            if let Some(own) = own.filter(|_| !random.once_in(3)) {
                let slope = random.between(-30.0, 30.0);
                for errors in [&mut own.plus, &mut own.minus].into_iter().flatten() {
                    errors.slope_um_per_m = slope;
                }
                slopes.push(format!("{key} = {slope:?}"));
            }
        }
    }
    let squareness = if slopes.is_empty() {
        String::new()
    } else {
        features.push("squareness");
        format!("[measurement.squareness_um_per_m]\n{}\n", slopes.join("\n"))
    };

    let reserved: Vec<[u32; 2]> = match random.below(4) {
        _ if !fanuc => Vec::new(),
        0 => vec![[0, 20], [600, 640], [6000, 6010], [3000, 3100]],
        1 => vec![[6120, 6140]],
        _ => Vec::new(),
    };
    features.extend((!reserved.is_empty()).then_some("reserved_points"));
    let mut control = format!("controller = \"{}\"\nfit = \"{fit}\"\n", profile.id);
    writeln!(control, "curve = \"{}\"", match kind {
        Interpolation::Linear => "linear",
        Interpolation::Pchip => "pchip",
        Interpolation::NaturalSpline => "natural-spline",
    })
    .unwrap();
    if inch {
        control.push_str("control_unit = \"inch\"\n");
    }
    if let Some(policy) = policy.filter(|_| terms.iter().any(Term::both_ways)) {
        writeln!(control, "backlash = \"{policy}\"").unwrap();
    }
    if siemens && random.once_in(3) {
        features.push("first_table");
        writeln!(control, "first_table = {}", 1 + random.below(3)).unwrap();
    }
    if fanuc && random.once_in(3) {
        features.push("first_set");
        writeln!(control, "first_set = {}", 1 + random.below(2)).unwrap();
    }
    if !reserved.is_empty() {
        writeln!(control, "reserved_points = {reserved:?}").unwrap();
    }
    let listed = random.once_in(4) && terms.len() > 1;
    if listed {
        features.push("listed terms");
        let names: Vec<String> = terms
            .iter()
            .enumerate()
            .filter(|(index, term)| {
                index % 2 == 0 || (matches!(policy, Some("two-tables" | "curve-and-parameter")) && term.both_ways())
            })
            .map(|(_, term)| term.term.to_string())
            .collect();
        writeln!(control, "terms = {names:?}").unwrap();
    }
    let job = format!(
        "schema = 1\n[machine]\nname = \"machine {seed}\"\n{machine_text}\
         [measurement]\nerrors = \"errors.csv\"\nactive_while_measuring = \"none\"\n{squareness}\
         [compensation]\n{control}{axes_text}\
         [limits]\nmax_correction_um = 5000.0\nmax_slope_um_per_mm = 50.0\n"
    );
    Machine {
        axes,
        terms,
        policy,
        fit,
        kind,
        inch,
        reserved,
        job,
        csv,
        features,
    }
}

/// How the points of an axis are chosen.
fn grid_text(
    random: &mut Random,
    text: &mut String,
    length: f64,
    residual_um: f64,
    fit: &str,
    features: &mut Vec<&'static str>,
) {
    let parts = random.of(&[4.0, 9.0, 15.0, 30.0, 60.0]);
    match random.below(6) {
        0 => {
            features.push("points");
            writeln!(text, "points = {}", 3 + random.below(50)).unwrap();
        }
        1 if fit != "minimax" => {
            features.push("max_residual_um");
            writeln!(text, "max_residual_um = {residual_um:.3}").unwrap();
        }
        2 | 3 => {
            features.push("dividing spacing");
            writeln!(text, "spacing_mm = {:?}", length / parts).unwrap();
        }
        _ => {
            features.push("other spacing");
            let spacing = ((length / parts * 1.0417) * 1000.0).round() / 1000.0;
            writeln!(text, "spacing_mm = {spacing:?}").unwrap();
        }
    }
}

/// Measured terms of one moving axis with their rows; gives a residual that a grid can keep.
#[allow(
    clippy::too_many_arguments,
    reason = "one step of the generator, split for its length"
)]
fn add_terms(
    random: &mut Random,
    along: &[ErrorTerm],
    directions: usize,
    kind: Interpolation,
    steep: bool,
    unit_um: f64,
    (from, to): (f64, f64),
    reference: f64,
    homing: Direction,
    length: f64,
    terms: &mut Vec<Term>,
    csv: &mut String,
) -> f64 {
    let count = 4 + random.below(12);
    let targets = |random: &mut Random, from: f64, to: f64| -> Vec<f64> {
        let step = (to - from) / (count - 1) as f64;
        let even = random.once_in(2);
        (0..count)
            .map(|i| match i {
                0 => from,
                _ if i == count - 1 => to,
                _ if even => ((from + step * i as f64) * 1000.0).round() / 1000.0,
                _ => {
                    let shift = random.between(-0.3, 0.3);
                    ((from + step * (i as f64 + shift)) * 1000.0).round() / 1000.0
                }
            })
            .collect()
    };
    let places: Vec<(Option<Direction>, Vec<f64>)> = match directions {
        0 | 1 => vec![(None, targets(random, from, to))],
        6 => {
            let direction = random.of(&Direction::BOTH);
            vec![(Some(direction), targets(random, from, to))]
        }
        _ => {
            let plus = targets(random, from, to);
            let minus = if random.once_in(3) {
                let shorter = ((to - 0.04 * length) * 1000.0).round() / 1000.0;
                targets(random, from, shorter)
            } else {
                plus.clone()
            };
            vec![(Some(Direction::Plus), plus), (Some(Direction::Minus), minus)]
        }
    };
    let mut largest = 0.0_f64;
    let mut columns: Vec<Vec<Option<Vec<f64>>>> = vec![vec![None; 3]; places.len()];
    for term in along {
        let size = random.of(&[0.0, 2.0, 12.0, 12.0, 45.0]);
        let offset = random.between(-3.0, 3.0);
        let tilt = if steep && random.once_in(2) {
            if unit_um < 0.5 { 0.08 } else { 0.25 }
        } else {
            0.0
        };
        let waves = 1.0 + random.below(3) as f64;
        let reversal = if size > 0.0 { random.between(-8.0, 4.0) } else { 0.0 };
        let mut curves: Vec<Errors> = Vec::new();
        let of = Axis::ALL.iter().position(|a| *a == term.of).unwrap();
        for (index, (direction, mm)) in places.iter().enumerate() {
            let um: Vec<f64> = mm
                .iter()
                .map(|x| {
                    let part = (x - from) / (to - from);
                    let wave = (part * waves * std::f64::consts::TAU).sin() * size / 2.0;
                    let noise = random.between(-0.04, 0.04) * size;
                    let lost = if *direction == Some(Direction::Minus) { -reversal } else { 0.0 };
                    if size > 0.0 || tilt > 0.0 {
                        offset + wave + noise + tilt * (x - from) + lost
                    } else {
                        0.0
                    }
                })
                .collect();
            largest = um.iter().fold(largest, |most, um| most.max(um.abs()));
            columns[index][of] = Some(um.clone());
            curves.push(Errors::new(mm.clone(), um, kind));
        }
        let (plus, minus) = match (&places[0].0, curves.len()) {
            (None, _) => (Some(curves[0].clone()), Some(curves[0].clone())),
            (Some(Direction::Plus), 1) => (Some(curves[0].clone()), None),
            (Some(Direction::Minus), 1) => (None, Some(curves[0].clone())),
            _ => (Some(curves[0].clone()), Some(curves[1].clone())),
        };
        terms.push(Term {
            term: *term,
            directed: places[0].0.is_some(),
            plus,
            minus,
            reference,
            homing,
        });
    }
    for ((direction, mm), columns) in places.iter().zip(&columns) {
        let sign = direction.map_or("", Direction::symbol);
        for (row, x) in mm.iter().enumerate() {
            let cells: Vec<String> = columns
                .iter()
                .map(|c| c.as_ref().map_or(String::new(), |um| format!("{:?}", um[row])))
                .collect();
            writeln!(csv, "{},{sign},{x:?},{}", along[0].along.key(), cells.join(",")).unwrap();
        }
    }
    (0.12 * largest).max(0.05)
}

// ---------------------------------------------------------------------------------------------
// What is asked of every kit

/// A kit under test, with the control that loaded its bytes.
struct Case<'a> {
    machine: &'a Machine,
    profile: &'a Profile,
    inputs: &'a Inputs,
    kit: &'a Kit,
    control: &'a dyn Emulator,
    tables: &'a Tables,
}

/// One table as the control holds it: nodes with the corrections there.
struct Held {
    mm: Vec<f64>,
    um: Vec<f64>,
}

impl Held {
    fn of(response: &Response) -> Held {
        assert_eq!(response.tables().len(), 1, "one table acts");
        let nodes: Vec<_> = response.tables()[0].nodes().collect();
        Held {
            mm: nodes.iter().map(|(x, _)| x.mm()).collect(),
            um: nodes.iter().map(|(_, c)| c.um()).collect(),
        }
    }

    fn step(&self) -> f64 {
        (self.mm[self.mm.len() - 1] - self.mm[0]) / (self.mm.len() - 1) as f64
    }

    fn node_at(&self, x: f64) -> usize {
        let node = (0..self.mm.len())
            .min_by(|a, b| (self.mm[*a] - x).abs().total_cmp(&(self.mm[*b] - x).abs()));
        node.unwrap()
    }

    /// Largest change in the section (or the two sections) at `x`.
    fn increment_at(&self, x: f64) -> f64 {
        let place = (x - self.mm[0]) / self.step();
        (1..self.mm.len())
            .filter(|node| {
                let node = *node as f64;
                place > node - 1.0 - 1e-6 && place < node + 1e-6
            })
            .map(|node| (self.um[node] - self.um[node - 1]).abs())
            .fold(0.0, f64::max)
    }
}

/// Size of a count in the control's file, from the bytes where they tell, µm.
fn count_um(case: &Case<'_>, term: ErrorTerm, output: &str) -> f64 {
    match (&case.profile.dialect, case.tables) {
        (Dialect::Siemens(_), _) if case.machine.inch => 0.0254, // sixth decimal of an inch
        (Dialect::Siemens(_), _) => 0.001,                       // sixth decimal of a millimetre
        (Dialect::Fanuc(facts), Tables::Fanuc(memory)) => {
            let unit = case.machine.axis(term.of).unit_um.unwrap();
            let output: u32 = output.parse().unwrap();
            if term.is_positioning() {
                unit * integer(memory, 3623, Some(output))
            } else if facts.straightness_form.value == StraightnessForm::FourPoint {
                unit
            } else {
                let set = set_of(case, memory, term, output);
                unit * integer(memory, 13381 + set, None)
            }
        }
        _ => case.machine.axis(term.of).unit_um.unwrap_or(0.0),
    }
}

fn integer(memory: &FanucMemory, number: u32, axis: Option<u32>) -> f64 {
    match memory.parameter(number, axis) {
        Some(ParameterValue::Integer(value)) => value as f64,
        other => panic!("parameter {number} of {axis:?} is {other:?}"),
    }
}

fn whole(memory: &FanucMemory, number: u32, axis: Option<u32>) -> u32 {
    format!("{}", integer(memory, number, axis)).parse().unwrap()
}

/// Index from 0 of the straightness set of a term and an output.
fn set_of(case: &Case<'_>, memory: &FanucMemory, term: ErrorTerm, output: u32) -> u32 {
    let moving: u32 = case.machine.axis(term.along).names[0].parse().unwrap();
    let is = |number, axis: u32| {
        memory.parameter(number, None) == Some(ParameterValue::Integer(i64::from(axis)))
    };
    (0..6)
        .find(|set| is(5711 + set, moving) && is(5721 + set, output))
        .unwrap_or_else(|| panic!("no set for {term} on {output}"))
}

fn is_compensated(case: &Case<'_>, term: ErrorTerm) -> bool {
    case.kit.plan.tables.iter().any(|table| table.term == term)
}

/// Half the last digit of positions in the control's files, mm.
fn half_position_digit(case: &Case<'_>) -> f64 {
    match case.profile.dialect {
        Dialect::Siemens(_) if case.machine.inch => 0.5e-6 * 25.4,
        Dialect::Siemens(_) | Dialect::Generic(_) => 0.5e-6,
        Dialect::Fanuc(_) => 0.0,
    }
}

/// Steepest slope that the generator makes, µm/mm.
const STEEPEST_UM_PER_MM: f64 = 20.0;

fn places(case: &Case<'_>, term: &Term, held: &Held, from: f64, to: f64) -> Vec<f64> {
    let mut places: Vec<f64> = (0..=DENSE)
        .map(|i| from + (to - from) * i as f64 / DENSE as f64)
        .chain(term.knots())
        .chain(held.mm.iter().copied())
        .collect();
    let mut jumps: Vec<f64> = held.mm.windows(2).map(|p| (p[0] + p[1]) / 2.0).collect();
    let fanuc = matches!(case.profile.dialect, Dialect::Fanuc(_));
    if let Some(unit) = case.machine.axis(term.term.of).unit_um.filter(|_| fanuc) {
        for (pair, um) in held.mm.windows(2).zip(held.um.windows(2)) {
            let pulses = ((um[1] - um[0]) / unit).abs().round();
            let mut pulse = 0.5;
            while pulse < pulses {
                jumps.push(pair[0] + (pair[1] - pair[0]) * pulse / pulses);
                pulse += 1.0;
            }
        }
    }
    if fanuc {
        places.extend(jumps.iter().flat_map(|x| [x - BESIDE_MM, x + BESIDE_MM]));
    }
    places.retain(|x| *x >= from && *x <= to);
    places
}

/// (a), (b), (d), (e): node by node and in between, in both directions.
fn cancels(case: &Case<'_>, term: &Term, base: &str, output: &str) {
    let machine = case.machine;
    let axis = machine.axis(term.term.along);
    let placed: Vec<_> = case
        .kit
        .compiled
        .placements
        .iter()
        .filter(|p| p.term == term.term)
        .collect();
    let count = count_um(case, term.term, output);
    for direction in Direction::BOTH {
        let response = support::response(case.control, base, output, direction);
        let held = Held::of(&response);
        let planned = case
            .kit
            .plan
            .tables
            .iter()
            .find(|t| t.term == term.term && t.direction.is_none_or(|d| d == direction))
            .unwrap();
        let placement = placed
            .iter()
            .find(|p| p.direction.is_none_or(|d| d == direction))
            .unwrap();
        let name = || format!("{}{direction} on {output}", term.term);
        assert!((placement.count_um - count).abs() < 1e-12, "{}: count {} ≠ {count}", name(), placement.count_um);
        let half = placement.fit_residual_um.unwrap_or(count / 2.0);
        let target = |x: f64| term.target(machine, case.profile, direction, x);
        let (first, last) = (planned.grid.range().0.mm(), planned.grid.range().1.mm());
        let on_grid = |x: f64| x >= first - 1e-3 && x <= last + 1e-3;

        // Nodes lie on the grid anchored on the reference.
        let step = held.step();
        let half_digit = half_position_digit(case);
        let mut anchored = Vec::new();
        for x in &held.mm {
            let index = ((x - axis.reference) / step).round();
            let exact = axis.reference + index * step;
            assert!((x - exact).abs() <= half_digit + 1e-9, "{}: node {x} is not at {exact}", name());
            anchored.push(exact);
        }
        // Every point of the planned grid is a node of the control.
        let held_count = held.mm.iter().filter(|x| on_grid(**x)).count();
        assert_eq!(held_count, planned.grid.count(), "{}: nodes {:?}", name(), held.mm);

        let place_um = half_digit * STEEPEST_UM_PER_MM;
        // The table as the fit made it; `sample` is the curve itself, by the test's own figures.
        let wanted: Vec<f64> = anchored
            .iter()
            .map(|x| {
                if machine.fit == "sample" {
                    target(*x)
                } else {
                    let index = (0..planned.values.len()).min_by(|a, b| {
                        let off = |node: usize| (first + node as f64 * step - x).abs();
                        off(*a).total_cmp(&off(*b))
                    });
                    planned.values[index.unwrap()].um()
                }
            })
            .collect();
        for ((x, wanted), um) in held.mm.iter().zip(&wanted).zip(&held.um) {
            if on_grid(*x) {
                // Table and constant: what the tables themselves do at a point.
                let left = wanted + um + reversal_in_constant(case, term, direction, &response, &held);
                assert!(left.abs() <= half + DUST_UM + place_um, "{}: at {x}: wanted {wanted}, held {um}, left {left}, bound {half}", name());
            }
        }

        // Between the points.
        let constant = um_at(&response, held.mm[0]) - held.um[0];
        let parameter = parameter_um(case, term, direction);
        let (low, high) = (axis.low, axis.high);
        let table = Lines { mm: anchored.clone(), um: wanted.clone() };
        let off_grid_um: f64 = 0.0;
        let mut worst_grid = 0.0_f64;
        for x in places(case, term, &held, low, high) {
            let line = if x < first { table.at(first) } else if x > last { table.at(last) } else { table.at(x) };
            let own = (target(x) - line).abs();
            worst_grid = worst_grid.max(own);
            let jump = jump_um(case, term, &held, x);
            let tables_only = um_at(&response, x) - if parameter { constant } else { 0.0 };
            let left = target(x) + tables_only;
            let bound = half + own + jump + off_grid_um + place_um + DUST_UM;
            assert!(left.abs() <= bound, "{}: at {x}: deviation {}, correction {tables_only}, left {left}, bound {bound} = {half} + {own} + {jump}", name(), target(x));
        }
        let printed = placement.grid_residual_um;
        assert!(printed >= worst_grid - DUST_UM - place_um, "{}: grid residual {printed}, seen {worst_grid}", name());
        let near = if machine.kind == Interpolation::Linear { DUST_UM + place_um } else { 0.02 * printed + 0.01 };
        assert!(printed <= worst_grid + near, "{}: grid residual {printed}, seen {worst_grid}", name());

        // Zero at the reference; the other direction carries the reversal.
        let node = held.node_at(axis.reference);
        let at_reference = um_at(&response, axis.reference);
        if direction == term.homing || !(placed.len() > 1 || parameter) {
            assert!(held.um[node].to_bits() << 1 == 0 && constant.abs() < DUST_UM, "{}: {} at the reference", name(), held.um[node]);
            assert!(at_reference.abs() <= place_um + DUST_UM, "{}: {at_reference} at the reference", name());
        } else if placed.len() > 1 {
            let reversal = target(axis.reference);
            assert!((at_reference + reversal).abs() <= half + place_um + DUST_UM, "{}: {at_reference} at the reference, deviation there {reversal}", name());
        }
        if parameter {
            let sign = if term.homing == Direction::Plus { 1.0 } else { -1.0 };
            let expected = if direction == term.homing { 0.0 } else { sign * term.reversal() };
            let digit = parameter_digit_um(case, term);
            assert!((constant - expected).abs() <= digit / 2.0 + 1e-6, "{}: constant {constant}, expected {expected}", name());
        }
    }
}

/// Whether the backlash parameter carries the reversal of this term.
fn parameter_um(case: &Case<'_>, term: &Term, _: Direction) -> bool {
    case.machine.policy == Some("curve-and-parameter") && term.both_ways() && term.term.is_positioning()
}

/// Where the reversal of two tables stands in a constant (Fanuc 3627), it belongs to the table.
fn reversal_in_constant(
    case: &Case<'_>,
    term: &Term,
    direction: Direction,
    response: &Response,
    held: &Held,
) -> f64 {
    if parameter_um(case, term, direction) {
        0.0
    } else {
        um_at(response, held.mm[0]) - held.um[0]
    }
}

/// Last digit of the backlash parameter, µm.
fn parameter_digit_um(case: &Case<'_>, term: &Term) -> f64 {
    match case.profile.dialect {
        Dialect::Siemens(_) if case.machine.inch => 0.254,
        Dialect::Siemens(_) | Dialect::Generic(_) => 0.1,
        Dialect::Fanuc(_) => case.machine.axis(term.term.of).unit_um.unwrap(),
    }
}

/// Largest distance of what a control puts out from the straight line between its nodes.
fn jump_um(case: &Case<'_>, term: &Term, held: &Held, x: f64) -> f64 {
    let Dialect::Fanuc(facts) = &case.profile.dialect else {
        return 0.0;
    };
    let increment = held.increment_at(x);
    let machine = case.machine;
    let pulses = machine.axis(term.term.along).interpolated
        && (term.term.is_positioning() || facts.straightness_form.value == StraightnessForm::FourPoint);
    if pulses {
        let unit = machine.axis(term.term.of).unit_um.unwrap();
        (unit / 2.0).min(increment / 2.0)
    } else {
        increment / 2.0
    }
}

/// (b) The forecast is the largest of what a dense look finds, and not much more.
fn forecast_holds(case: &Case<'_>, term: &Term, forecast: &TermForecast) {
    let machine = case.machine;
    let (mut before, mut after) = (0.0_f64, 0.0_f64);
    for direction in Direction::BOTH {
        let Some(errors) = term.errors(direction) else {
            continue;
        };
        let (from, to) = errors.range();
        for (base, output) in machine.pairs(term.term) {
            let response = support::response(case.control, base, output, direction);
            let held = match response.tables().first() {
                Some(_) => Held::of(&response),
                None => Held { mm: vec![from, to], um: vec![0.0, 0.0] },
            };
            for x in places(case, term, &held, from, to) {
                let deviation = term.deviation(direction, x);
                before = before.max(deviation.abs());
                after = after.max((deviation + um_at(&response, x)).abs());
            }
        }
    }
    let name = || term.term.to_string();
    let linear = machine.kind == Interpolation::Linear;
    for (what, said, seen) in [("before", forecast.before_um, before), ("after", forecast.after_um, after)] {
        let near = if linear { NEAR_UM } else { 0.02 * before + 0.01 };
        assert!(said >= seen - DUST_UM, "{}: {what} {said} µm, but {seen} µm was seen", name());
        assert!(said <= seen + near, "{}: {what} {said} µm, but only {seen} µm was seen", name());
    }
    assert_eq!(forecast.compensated, is_compensated(case, term.term), "{}", name());
}

/// (c) With the sign turned the residual doubles.
fn turned_sign_doubles(case: &Case<'_>, term: &Term, turned: &dyn Emulator, output: &str, base: &str) -> usize {
    let count = count_um(case, term.term, output);
    let mut seen = 0;
    for direction in Direction::BOTH {
        let placed = case.kit.compiled.placements.iter();
        let placement = placed
            .filter(|p| p.term == term.term)
            .find(|p| p.direction.is_none_or(|d| d == direction))
            .unwrap();
        let right = support::response(case.control, base, output, direction);
        let wrong = support::response(turned, base, output, direction);
        let (right, wrong) = (Held::of(&right), Held::of(&wrong));
        for (a, b) in right.um.iter().zip(&wrong.um) {
            let generic = matches!(case.profile.dialect, Dialect::Generic(_));
            assert!(generic || (a + b).abs() < DUST_UM, "the sign of the profile acts on every node");
        }
        let reference = case.machine.axis(term.term.along).reference;
        let zero = term.target(case.machine, case.profile, direction, reference);
        let planned = case.kit.plan.tables.iter().find(|t| t.term == term.term && t.direction.is_none_or(|d| d == direction)).unwrap();
        let (first, last) = (planned.grid.range().0.mm() - 1e-3, planned.grid.range().1.mm() + 1e-3);
        let (mut deviation, mut left) = (0.0_f64, 0.0_f64);
        for (x, um) in right.mm.iter().zip(&right.um) {
            if *x < first || *x > last {
                continue;
            }
            let own = term.target(case.machine, case.profile, direction, *x) - zero;
            let at_reference = right.um[right.node_at(reference)];
            deviation = deviation.max(own.abs());
            left = left.max((own - (um - at_reference)).abs());
        }
        // The table of a fit may leave the curve, a four-point line does.
        let slack = count.max(placement.fit_residual_um.unwrap_or(0.0)) + if case.machine.fit == "sample" { 0.0 } else { placement.grid_residual_um };
        if deviation > 12.0 * slack && deviation > 0.1 {
            seen += 1;
            assert!(left >= 1.9 * deviation, "{}{direction}: deviation {deviation}, with the sign turned {left}", term.term);
        }
    }
    seen
}

/// The profile with every sign the other way round, for emulation only.
fn with_signs_turned(profile: &Profile) -> Profile {
    let turn = |sign: &mut TableSign| {
        *sign = match sign {
            TableSign::AsError => TableSign::AsCorrection,
            TableSign::AsCorrection => TableSign::AsError,
        }
    };
    let mut turned = profile.clone();
    match &mut turned.dialect {
        Dialect::Siemens(facts) => {
            turn(&mut facts.lec_sign.value);
            turn(&mut facts.cec_sign.value);
        }
        Dialect::Fanuc(facts) => {
            turn(&mut facts.pitch_sign.value);
            turn(&mut facts.straightness_sign.value);
        }
        Dialect::Generic(_) => {}
    }
    turned
}

/// (f) A term without a table gets exactly nothing.
fn has_no_effect(case: &Case<'_>, term: ErrorTerm) {
    let axis = case.machine.axis(term.along);
    for (base, output) in case.machine.pairs(term) {
        for direction in Direction::BOTH {
            let response = support::response(case.control, base, output, direction);
            for i in 0..=20 {
                let um = um_at(&response, axis.low + (axis.high - axis.low) * f64::from(i) / 20.0);
                assert!(um.to_bits() << 1 == 0, "{} {term}: {um} µm", case.profile.id);
            }
        }
    }
}

/// (g) Every axis of a gantry gets what the first one gets.
fn gantry_is_equal(case: &Case<'_>, term: ErrorTerm) {
    let pairs = case.machine.pairs(term);
    let axis = case.machine.axis(term.along);
    for direction in Direction::BOTH {
        let of = |(base, output): (&str, &str)| support::response(case.control, base, output, direction);
        for pair in &pairs[1..] {
            let (first, other) = (of(pairs[0]), of(*pair));
            for i in 0..=50 {
                let x = axis.low + (axis.high - axis.low) * f64::from(i) / 50.0;
                let difference = um_at(&first, x) - um_at(&other, x);
                assert!(difference.abs() < 1e-12, "{} {term}: {pair:?} differs by {difference}", case.profile.id);
            }
        }
    }
}

/// (h) Numbers of points: in order, apart, none reserved, none left over; increments legal.
fn numbers_are_legal(case: &Case<'_>, memory: &FanucMemory) {
    let Dialect::Fanuc(facts) = &case.profile.dialect else {
        panic!("a memory of another control");
    };
    let mut runs: Vec<(String, NumberRange)> = Vec::new();
    let axes: Vec<u32> = memory.parameters.keys().filter(|k| k.number == 3620).map(|k| k.axis.unwrap()).collect();
    let count = |axis: u32| whole(memory, 3622, Some(axis)) - whole(memory, 3621, Some(axis)) + 1;
    for axis in &axes {
        let [reference, first, last] = [3620, 3621, 3622].map(|n| whole(memory, n, Some(*axis)));
        assert!(first <= reference && reference < last, "{first} {reference} {last}");
        let run = NumberRange { first, last };
        assert!(facts.pitch_points.value.iter().any(|b| b.contains(first) && b.contains(last)), "{run:?}");
        runs.push((format!("axis {axis}"), run));
        if memory.parameter(3626, Some(*axis)).is_some() {
            let first = whole(memory, 3626, Some(*axis));
            let last = first + count(*axis) - 1;
            assert!(facts.minus_points.value.iter().any(|b| b.contains(first) && b.contains(last)));
            runs.push((format!("axis {axis}, -"), NumberRange { first, last }));
        }
    }
    for set in 0..6 {
        let Some(ParameterValue::Integer(moving)) = memory.parameter(5711 + set, None) else {
            continue;
        };
        if facts.straightness_form.value == StraightnessForm::PerPoint {
            let first = whole(memory, 13391 + set, None);
            let last = first + count(u32::try_from(moving).unwrap()) - 1;
            assert!(facts.straightness_points.value.iter().any(|b| b.contains(first) && b.contains(last)));
            runs.push((format!("set {set}"), NumberRange { first, last }));
        }
    }
    for (index, (name, run)) in runs.iter().enumerate() {
        for (other, run_of_other) in &runs[index + 1..] {
            assert!(!run.overlaps(*run_of_other), "{name} and {other} share points");
        }
        for [first, last] in &case.machine.reserved {
            let reserved = NumberRange { first: *first, last: *last };
            assert!(!run.overlaps(reserved), "{name} uses reserved points");
        }
    }
    for (point, value) in &memory.points {
        assert!((-7..=7).contains(value), "point {point} is {value}");
        assert!(runs.iter().any(|(_, run)| run.contains(*point)), "point {point} belongs to nobody");
    }
    let owned: u32 = runs.iter().map(|(_, run)| run.last - run.first + 1).sum();
    assert_eq!(memory.points.len(), owned as usize, "every point is written");
}

/// Body diagonals of the forecast against walks of the test's own.
fn diagonals_hold(case: &Case<'_>) {
    let machine = case.machine;
    if machine.terms.len() < 9 {
        assert!(case.kit.forecast.diagonals.is_empty());
        return;
    }
    let corner = |axis: Axis| {
        let terms = machine.terms.iter().filter(|t| t.term.along == axis);
        let ranges = terms.flat_map(|t| Direction::BOTH.into_iter().filter_map(|d| t.errors(d).map(Errors::range)));
        ranges.fold((f64::NEG_INFINITY, f64::INFINITY), |(l, h), (low, high)| (l.max(low), h.min(high)))
    };
    let ends = Axis::ALL.map(corner);
    let length = ends.iter().map(|(l, h)| (h - l) * (h - l)).sum::<f64>().sqrt();
    let place = |axis: Axis| Axis::ALL.iter().position(|a| *a == axis).unwrap();
    for diagonal in &case.kit.forecast.diagonals {
        let signs: Vec<f64> = diagonal.name.chars().map(|c| if c == 'P' { 1.0 } else { -1.0 }).collect();
        let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for reverse in [false, true] {
            // Of every term: cosine, its place, and the response in the direction of the walk.
            let walk: Vec<_> = machine
                .terms
                .iter()
                .filter_map(|term| {
                    let (of, along) = (place(term.term.of), place(term.term.along));
                    let direction = if (signs[along] > 0.0) == reverse { Direction::Minus } else { Direction::Plus };
                    term.errors(direction)?;
                    let (base, output) = machine.pairs(term.term)[0];
                    let cosine = signs[of] * (ends[of].1 - ends[of].0) / length;
                    Some((term, direction, along, cosine, support::response(case.control, base, output, direction)))
                })
                .collect();
            for i in 0..=400 {
                let t = f64::from(i) / 400.0;
                let mut sums = [0.0; 2];
                for (term, direction, along, cosine, response) in &walk {
                    let travelled = if signs[*along] > 0.0 { t } else { 1.0 - t };
                    let x = ends[*along].0 + travelled * (ends[*along].1 - ends[*along].0);
                    let deviation = term.deviation(*direction, x);
                    sums[0] += cosine * deviation;
                    sums[1] += cosine * (deviation + um_at(response, x));
                }
                for (extent, sum) in extent.iter_mut().zip(sums) {
                    *extent = [extent[0].min(sum), extent[1].max(sum)];
                }
            }
        }
        let seen = extent.map(|[low, high]| high - low);
        let said = [diagonal.before_um, diagonal.after_um];
        for (said, seen) in said.iter().zip(seen) {
            let name = format!("{}: said {said}, seen {seen}", diagonal.name);
            assert!(*said >= seen - DUST_UM, "{name}");
            // A walk of 400 steps misses a narrow peak: a bend, or a jump of steep output.
            assert!(*said <= seen + 0.1 * said + 0.05 + largest_jump(case), "{name}");
        }
    }
}

fn largest_jump(case: &Case<'_>) -> f64 {
    let mut largest = 0.0_f64;
    if !matches!(case.profile.dialect, Dialect::Fanuc(_)) {
        return largest;
    }
    for term in case.machine.terms.iter().filter(|t| is_compensated(case, t.term)) {
        let (base, output) = case.machine.pairs(term.term)[0];
        let held = Held::of(&support::response(case.control, base, output, Direction::Plus));
        largest = held.um.windows(2).map(|p| (p[1] - p[0]).abs()).fold(largest, f64::max);
    }
    3.0 * largest
}

/// Shows the machine whose kit did not hold.
struct Shown<'a>(&'a Machine, &'a Profile);

impl Drop for Shown<'_> {
    #[allow(clippy::print_stderr, reason = "a failure has to be seen with its inputs")]
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("{}\n{}\n{}", self.1.id, self.0.job, self.0.csv);
        }
    }
}

fn check(profile: &Profile, machine: &Machine) -> (usize, usize) {
    let _shown = Shown(machine, profile);
    let (inputs, kit) = support::generate(&machine.job, &machine.csv);
    let tables = support::loaded(profile, &kit);
    let control = support::control(profile, &kit);
    let turned = support::control(&with_signs_turned(profile), &kit);
    let case = Case {
        machine,
        profile,
        inputs: &inputs,
        kit: &kit,
        control: control.as_ref(),
        tables: &tables,
    };
    assert_eq!(case.inputs.model.measured().count(), machine.terms.len());
    let (mut doubled, mut compensated) = (0, 0);
    for term in &machine.terms {
        let forecasts = kit.forecast.terms.iter();
        let forecast = forecasts.clone().find(|f| f.term == term.term).unwrap();
        if is_compensated(&case, term.term) {
            compensated += 1;
            for (base, output) in machine.pairs(term.term) {
                cancels(&case, term, base, output);
                doubled += turned_sign_doubles(&case, term, turned.as_ref(), output, base);
            }
            gantry_is_equal(&case, term.term);
        } else {
            assert!(kit.plan.omitted.iter().any(|o| o.term == term.term), "{} is listed", term.term);
            has_no_effect(&case, term.term);
        }
        forecast_holds(&case, term, forecast);
    }
    for term in ErrorTerm::ALL {
        if !machine.terms.iter().any(|t| t.term == term) {
            has_no_effect(&case, term);
        }
    }
    if let Tables::Fanuc(memory) = &tables {
        numbers_are_legal(&case, memory);
    }
    diagonals_hold(&case);
    (compensated, doubled)
}

fn contract_of(id: &str) {
    let profile = builtin::profile(id).unwrap();
    let (mut compensated, mut doubled) = (0, 0);
    let mut features = std::collections::BTreeMap::new();
    for seed in 0..MACHINES {
        let machine = machine(&profile, seed);
        for feature in &machine.features {
            *features.entry(*feature).or_insert(0) += 1;
        }
        let (terms, turned) = check(&profile, &machine);
        compensated += terms;
        doubled += turned;
    }
    // The test must have had something to say.
    assert!(compensated > 2 * MACHINES, "{id}: only {compensated} terms");
    assert!(doubled > MACHINES, "{id}: only {doubled} tables were large enough to turn");
    let rare = features.iter().find(|(_, times)| **times < 3);
    assert!(rare.is_none() && features.len() >= 24, "{id}: {features:?}");
}

#[test]
fn siemens_840d_sl() {
    contract_of("siemens-840d-sl");
}

#[test]
fn siemens_828d() {
    contract_of("siemens-828d");
}

#[test]
fn fanuc_30i() {
    contract_of("fanuc-30i");
}

#[test]
fn fanuc_0i_f() {
    contract_of("fanuc-0i-f");
}

#[test]
fn fanuc_16i() {
    contract_of("fanuc-16i");
}

#[test]
fn generic() {
    contract_of("generic");
}

#[test]
fn no_profile_is_left_out() {
    let tested = ["siemens-840d-sl", "siemens-828d", "fanuc-30i", "fanuc-0i-f", "fanuc-16i", "generic"];
    assert_eq!(builtin::ids(), tested);
}
