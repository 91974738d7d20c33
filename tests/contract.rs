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
use nonius::curve::Interpolation;
use nonius::emulate::{Emulator, Response};
use nonius::forecast::TermForecast;
use nonius::kit::{Inputs, Kit};
use nonius::table::Tables;
use nonius::table::fanuc::{FanucMemory, ParameterValue};
use support::machine::{Errors, Machine, Term, machine};
use support::{DUST_UM, Lines, um_at};

/// Machines for each profile.
const MACHINES: usize = 72;
/// Positions of a dense look along an axis: straight lines bend at known places, cubics peak.
const DENSE: [usize; 2] = [240, 2000];
/// Beside a jump, mm: near enough that no curve moves by more than [`NEAR_UM`].
const BESIDE_MM: f64 = 1e-7;
/// What a curve moves within [`BESIDE_MM`], µm.
const NEAR_UM: f64 = 1e-5;

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
    format!("{}", integer(memory, number, axis))
        .parse()
        .unwrap()
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

/// Whether each direction has a table of its own. Where the policy asks for it and the control
/// could hold it, anything else has to be said.
fn two_tables(case: &Case<'_>, term: &Term) -> bool {
    let mut own = case.kit.plan.tables.iter().filter(|t| t.term == term.term);
    let directed = own.any(|t| t.direction.is_some());
    let asked = case.machine.policy == Some("two-tables") && term.both_ways();
    if asked && !directed && term.takes_directions(case.profile) {
        let said = format!("{}: the mean of both directions is used", term.term);
        assert!(case.kit.plan.notes.iter().any(|n| n.starts_with(&said)));
    }
    directed
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

/// Where the deviation of a term or its correction bends, and where the correction jumps.
fn bends_and_jumps(case: &Case<'_>, term: &Term, held: &Held) -> (Vec<f64>, Vec<f64>) {
    let mut bends = term.knots();
    bends.extend(&held.mm);
    let mut jumps = Vec::new();
    if matches!(case.profile.dialect, Dialect::Fanuc(_)) {
        jumps.extend(held.mm.windows(2).map(|p| (p[0] + p[1]) / 2.0));
        let unit = case.machine.axis(term.term.of).unit_um.unwrap();
        for (pair, um) in held.mm.windows(2).zip(held.um.windows(2)) {
            let pulses = ((um[1] - um[0]) / unit).abs().round();
            let mut pulse = 0.5;
            while pulse < pulses {
                jumps.push(pair[0] + (pair[1] - pair[0]) * pulse / pulses);
                pulse += 1.0;
            }
        }
    }
    (bends, jumps)
}

fn places(case: &Case<'_>, term: &Term, held: &Held, from: f64, to: f64) -> Vec<f64> {
    let dense = DENSE[usize::from(case.machine.kind != Interpolation::Linear)];
    let (mut places, jumps) = bends_and_jumps(case, term, held);
    places.extend(jumps.iter().flat_map(|x| [x - BESIDE_MM, x + BESIDE_MM]));
    places.extend((0..=dense).map(|i| from + (to - from) * i as f64 / dense as f64));
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
        assert!(
            (placement.count_um - count).abs() < 1e-12,
            "{}: count {} ≠ {count}",
            name(),
            placement.count_um
        );
        let half = placement.fit_residual_um.unwrap_or(count / 2.0);
        let target = |x: f64| term.target(machine, two_tables(case, term), direction, x);
        let (first, last) = (planned.grid.range().0.mm(), planned.grid.range().1.mm());
        let on_grid = |x: f64| x >= first - 1e-3 && x <= last + 1e-3;

        // Nodes lie on the grid anchored on the reference.
        let step = held.step();
        let half_digit = half_position_digit(case);
        let mut anchored = Vec::new();
        for x in &held.mm {
            let index = ((x - axis.reference) / step).round();
            let exact = axis.reference + index * step;
            assert!(
                (x - exact).abs() <= half_digit + 1e-9,
                "{}: node {x} is not at {exact}",
                name()
            );
            anchored.push(exact);
        }
        // They cover the travel, but for the rounding of the written spacing.
        let digit = match &case.profile.dialect {
            Dialect::Fanuc(_) if machine.inch => 1e-4 * 25.4,
            Dialect::Fanuc(_) => 1e-3,
            _ => 2.0 * half_digit,
        };
        let short = digit * held.mm.len() as f64 / 2.0 + 1e-6 * step;
        assert!(first <= axis.low + short && last >= axis.high - short);
        // Every point of the planned grid is a node of the control.
        let held_count = held.mm.iter().filter(|x| on_grid(**x)).count();
        assert_eq!(
            held_count,
            planned.grid.count(),
            "{}: nodes {:?}",
            name(),
            held.mm
        );

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
                let left = wanted + um + reversal_in_constant(case, term, &response, &held);
                assert!(
                    left.abs() <= half + DUST_UM + place_um,
                    "{}: at {x}: wanted {wanted}, held {um}, left {left}, bound {half}",
                    name()
                );
            }
        }

        // Between the points.
        let constant = um_at(&response, held.mm[0]) - held.um[0];
        let parameter = has_parameter(case, term);
        let (low, high) = (axis.low, axis.high);
        let table = Lines {
            mm: anchored.clone(),
            um: wanted.clone(),
        };
        let mut worst_grid = 0.0_f64;
        for x in places(case, term, &held, low, high) {
            let line = if x < first {
                table.at(first)
            } else if x > last {
                table.at(last)
            } else {
                table.at(x)
            };
            let own = (target(x) - line).abs();
            worst_grid = worst_grid.max(own);
            let jump = jump_um(case, term, &held, x);
            let tables_only = um_at(&response, x) - if parameter { constant } else { 0.0 };
            let left = target(x) + tables_only;
            let bound = half + own + jump + place_um + DUST_UM;
            assert!(
                left.abs() <= bound,
                "{}: at {x}: deviation {}, correction {tables_only}, left {left}, bound {bound} = {half} + {own} + {jump}",
                name(),
                target(x)
            );
        }
        let printed = placement.grid_residual_um;
        assert!(
            printed >= worst_grid - DUST_UM - place_um,
            "{}: grid residual {printed}, seen {worst_grid}",
            name()
        );
        let near = if machine.kind == Interpolation::Linear {
            DUST_UM + place_um
        } else {
            0.02 * printed + 0.01
        };
        assert!(
            printed <= worst_grid + near,
            "{}: grid residual {printed}, seen {worst_grid}",
            name()
        );

        // Zero at the reference; the other direction carries the reversal.
        let node = held.node_at(axis.reference);
        let at_reference = um_at(&response, axis.reference);
        if direction == term.homing || !(placed.len() > 1 || parameter) {
            assert!(
                held.um[node].to_bits() << 1 == 0 && constant.abs() < DUST_UM,
                "{}: {} at the reference",
                name(),
                held.um[node]
            );
            assert!(
                at_reference.abs() <= place_um + DUST_UM,
                "{}: {at_reference} at the reference",
                name()
            );
        } else if placed.len() > 1 {
            let reversal = target(axis.reference);
            assert!(
                (at_reference + reversal).abs() <= half + place_um + DUST_UM,
                "{}: {at_reference} at the reference, deviation there {reversal}",
                name()
            );
        }
        if parameter {
            let sign = if term.homing == Direction::Plus {
                1.0
            } else {
                -1.0
            };
            let expected = if direction == term.homing {
                0.0
            } else {
                sign * term.reversal()
            };
            let digit = parameter_digit_um(case, term);
            assert!(
                (constant - expected).abs() <= digit / 2.0 + 1e-6,
                "{}: constant {constant}, expected {expected}",
                name()
            );
        }
    }
}

/// Whether the backlash parameter carries the reversal of this term.
fn has_parameter(case: &Case<'_>, term: &Term) -> bool {
    case.machine.policy == Some("curve-and-parameter")
        && term.both_ways()
        && term.term.is_positioning()
}

/// Where the reversal of two tables stands in a constant (Fanuc 3627), it belongs to the table.
fn reversal_in_constant(case: &Case<'_>, term: &Term, response: &Response, held: &Held) -> f64 {
    if has_parameter(case, term) {
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
        && (term.term.is_positioning()
            || facts.straightness_form.value == StraightnessForm::FourPoint);
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
                None => Held {
                    mm: vec![from, to],
                    um: vec![0.0, 0.0],
                },
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
    for (what, said, seen) in [
        ("before", forecast.before_um, before),
        ("after", forecast.after_um, after),
    ] {
        let near = if linear {
            NEAR_UM
        } else {
            0.02 * before + 0.01
        };
        assert!(
            said >= seen - DUST_UM,
            "{}: {what} {said} µm, but {seen} µm was seen",
            name()
        );
        assert!(
            said <= seen + near,
            "{}: {what} {said} µm, but only {seen} µm was seen",
            name()
        );
    }
    assert_eq!(
        forecast.compensated,
        is_compensated(case, term.term),
        "{}",
        name()
    );
}

/// (c) With the sign turned the residual doubles.
fn turned_sign_doubles(
    case: &Case<'_>,
    term: &Term,
    turned: &dyn Emulator,
    output: &str,
    base: &str,
) -> usize {
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
            assert!(
                generic || (a + b).abs() < DUST_UM,
                "the sign of the profile acts on every node"
            );
        }
        let reference = case.machine.axis(term.term.along).reference;
        let zero = term.target(case.machine, two_tables(case, term), direction, reference);
        let planned = case
            .kit
            .plan
            .tables
            .iter()
            .find(|t| t.term == term.term && t.direction.is_none_or(|d| d == direction))
            .unwrap();
        let (first, last) = (
            planned.grid.range().0.mm() - 1e-3,
            planned.grid.range().1.mm() + 1e-3,
        );
        let (mut deviation, mut left) = (0.0_f64, 0.0_f64);
        for (x, um) in right.mm.iter().zip(&right.um) {
            if *x < first || *x > last {
                continue;
            }
            let own = term.target(case.machine, two_tables(case, term), direction, *x) - zero;
            let at_reference = right.um[right.node_at(reference)];
            deviation = deviation.max(own.abs());
            left = left.max((own - (um - at_reference)).abs());
        }
        // The table of a fit may leave the curve, a four-point line does.
        let slack = count.max(placement.fit_residual_um.unwrap_or(0.0))
            + if case.machine.fit == "sample" {
                0.0
            } else {
                placement.grid_residual_um
            };
        if deviation > 12.0 * slack && deviation > 0.1 {
            seen += 1;
            assert!(
                left >= 1.9 * deviation,
                "{}{direction}: deviation {deviation}, with the sign turned {left}",
                term.term
            );
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
                let um = um_at(
                    &response,
                    axis.low + (axis.high - axis.low) * f64::from(i) / 20.0,
                );
                assert!(
                    um.to_bits() << 1 == 0,
                    "{} {term}: {um} µm",
                    case.profile.id
                );
            }
        }
    }
}

/// (g) Every axis of a gantry gets what the first one gets.
fn gantry_is_equal(case: &Case<'_>, term: ErrorTerm) {
    let pairs = case.machine.pairs(term);
    let axis = case.machine.axis(term.along);
    for direction in Direction::BOTH {
        let of =
            |(base, output): (&str, &str)| support::response(case.control, base, output, direction);
        for pair in &pairs[1..] {
            let (first, other) = (of(pairs[0]), of(*pair));
            for i in 0..=50 {
                let x = axis.low + (axis.high - axis.low) * f64::from(i) / 50.0;
                let difference = um_at(&first, x) - um_at(&other, x);
                assert!(
                    difference.abs() < 1e-12,
                    "{} {term}: {pair:?} differs by {difference}",
                    case.profile.id
                );
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
    let axes: Vec<u32> = memory
        .parameters
        .keys()
        .filter(|k| k.number == 3620)
        .map(|k| k.axis.unwrap())
        .collect();
    let count = |axis: u32| whole(memory, 3622, Some(axis)) - whole(memory, 3621, Some(axis)) + 1;
    for axis in &axes {
        let [reference, first, last] = [3620, 3621, 3622].map(|n| whole(memory, n, Some(*axis)));
        assert!(
            first <= reference && reference < last,
            "{first} {reference} {last}"
        );
        let run = NumberRange { first, last };
        assert!(
            facts
                .pitch_points
                .value
                .iter()
                .any(|b| b.contains(first) && b.contains(last)),
            "{run:?}"
        );
        runs.push((format!("axis {axis}"), run));
        if memory.parameter(3626, Some(*axis)).is_some() {
            let first = whole(memory, 3626, Some(*axis));
            let last = first + count(*axis) - 1;
            assert!(
                facts
                    .minus_points
                    .value
                    .iter()
                    .any(|b| b.contains(first) && b.contains(last))
            );
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
            assert!(
                facts
                    .straightness_points
                    .value
                    .iter()
                    .any(|b| b.contains(first) && b.contains(last))
            );
            runs.push((format!("set {set}"), NumberRange { first, last }));
        }
    }
    for (index, (name, run)) in runs.iter().enumerate() {
        for (other, run_of_other) in &runs[index + 1..] {
            assert!(
                !run.overlaps(*run_of_other),
                "{name} and {other} share points"
            );
        }
        for [first, last] in &case.machine.reserved {
            let reserved = NumberRange {
                first: *first,
                last: *last,
            };
            assert!(!run.overlaps(reserved), "{name} uses reserved points");
        }
    }
    for (point, value) in &memory.points {
        assert!((-7..=7).contains(value), "point {point} is {value}");
        assert!(
            runs.iter().any(|(_, run)| run.contains(*point)),
            "point {point} belongs to nobody"
        );
    }
    let owned: u32 = runs.iter().map(|(_, run)| run.last - run.first + 1).sum();
    assert_eq!(
        memory.points.len(),
        owned as usize,
        "every point is written"
    );
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
        let ranges = terms.flat_map(|t| {
            Direction::BOTH
                .into_iter()
                .filter_map(|d| t.errors(d).map(Errors::range))
        });
        ranges.fold((f64::NEG_INFINITY, f64::INFINITY), |(l, h), (low, high)| {
            (l.max(low), h.min(high))
        })
    };
    let ends = Axis::ALL.map(corner);
    let length = ends
        .iter()
        .map(|(l, h)| (h - l) * (h - l))
        .sum::<f64>()
        .sqrt();
    let place = |axis: Axis| Axis::ALL.iter().position(|a| *a == axis).unwrap();
    for diagonal in &case.kit.forecast.diagonals {
        let signs: Vec<f64> = diagonal
            .name
            .chars()
            .map(|c| if c == 'P' { 1.0 } else { -1.0 })
            .collect();
        let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for reverse in [false, true] {
            // Of every term: cosine, its place, and the response in the direction of the walk.
            let walk: Vec<OnWalk<'_>> = machine
                .terms
                .iter()
                .filter_map(|term| {
                    let (of, along) = (place(term.term.of), place(term.term.along));
                    let direction = if (signs[along] > 0.0) == reverse {
                        Direction::Minus
                    } else {
                        Direction::Plus
                    };
                    term.errors(direction)?;
                    let (base, output) = machine.pairs(term.term)[0];
                    let cosine = signs[of] * (ends[of].1 - ends[of].0) / length;
                    Some((
                        term,
                        direction,
                        along,
                        cosine,
                        support::response(case.control, base, output, direction),
                    ))
                })
                .collect();
            for t in steps_of_walk(case, &walk, &ends, &signs) {
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
            let near = if machine.kind == Interpolation::Linear {
                1e-3
            } else {
                0.05 * said + 0.02 // the top of a cubic lies between two steps
            };
            assert!(*said <= seen + near, "{name}");
        }
    }
}

/// One term on a walk along a diagonal: its direction, moving axis, cosine, and what it gets.
type OnWalk<'a> = (&'a Term, Direction, usize, f64, Response);

/// Beside every bend and jump and between them; never exactly where axes jump together, for
/// which of them is first there is rounding.
fn steps_of_walk(
    case: &Case<'_>,
    walk: &[OnWalk<'_>],
    ends: &[(f64, f64); 3],
    signs: &[f64],
) -> Vec<f64> {
    let mut breaks = vec![0.0, 1.0];
    for (term, _, along, _, response) in walk {
        let (low, high) = ends[*along];
        let (bends, jumps) = match response.tables().first() {
            Some(_) => bends_and_jumps(case, term, &Held::of(response)),
            None => (term.knots(), Vec::new()),
        };
        for x in bends.iter().chain(&jumps) {
            let travelled = (x - low) / (high - low);
            breaks.push(if signs[*along] > 0.0 {
                travelled
            } else {
                1.0 - travelled
            });
        }
    }
    breaks.retain(|t| (0.0..=1.0).contains(t));
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-8);
    breaks
        .windows(2)
        .flat_map(|pair| [1e-9, 0.25, 0.5, 0.75].map(|part| (pair, part)))
        .flat_map(|(pair, part)| match part {
            0.0..0.1 => vec![pair[0] + part, pair[1] - part],
            _ => vec![pair[0] + part * (pair[1] - pair[0])],
        })
        .collect()
}

/// Shows the machine whose kit did not hold.
struct Shown<'a>(&'a Machine, &'a Profile);

impl Drop for Shown<'_> {
    #[allow(
        clippy::print_stderr,
        reason = "a failure has to be seen with its inputs"
    )]
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("{}\n{}\n{}", self.1.id, self.0.job, self.0.csv);
        }
    }
}

/// What a machine had to show: compensated terms, tables large enough to turn, and features that
/// only the kit tells.
struct Seen {
    compensated: usize,
    doubled: usize,
    features: Vec<&'static str>,
}

fn features_of(case: &Case<'_>) -> Vec<&'static str> {
    let tables = &case.kit.plan.tables;
    let unit = |term: ErrorTerm| case.machine.axis(term.of).unit_um;
    let mut placements = case.kit.compiled.placements.iter();
    let is = |there: bool, name: &'static str| there.then_some(name);
    [
        is(
            tables.iter().any(|t| t.direction.is_some()),
            "tables for one direction",
        ),
        is(!case.kit.plan.omitted.is_empty(), "terms without a table"),
        is(
            case.kit.plan.backlash_um.iter().any(|(_, b)| b.is_some()),
            "backlash parameter",
        ),
        is(
            placements.any(|p| p.count_um > 1.5 * unit(p.term).unwrap_or(1e9)),
            "magnified",
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn check(profile: &Profile, machine: &Machine) -> Seen {
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
            assert!(
                kit.plan.omitted.iter().any(|o| o.term == term.term),
                "{} is listed",
                term.term
            );
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
    Seen {
        compensated,
        doubled,
        features: features_of(&case),
    }
}

fn contract_of(id: &str) {
    let profile = builtin::profile(id).unwrap();
    let (mut compensated, mut doubled) = (0, 0);
    let mut features = std::collections::BTreeMap::new();
    for seed in 0..MACHINES {
        let machine = machine(&profile, seed);
        let seen = check(&profile, &machine);
        for feature in machine.features.iter().chain(&seen.features) {
            *features.entry(*feature).or_insert(0) += 1;
        }
        compensated += seen.compensated;
        doubled += seen.doubled;
    }
    // The test must have had something to say.
    assert!(compensated > 2 * MACHINES, "{id}: only {compensated} terms");
    assert!(
        doubled > MACHINES,
        "{id}: only {doubled} tables were large enough to turn"
    );
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
    let tested = [
        "siemens-840d-sl",
        "siemens-828d",
        "fanuc-30i",
        "fanuc-0i-f",
        "fanuc-16i",
        "generic",
    ];
    assert_eq!(builtin::ids(), tested);
}
