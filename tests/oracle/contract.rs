//! The contract: whatever machine is measured, the bytes that a control loads cancel its errors.
//!
//! ```text
//!   machine of the test ─→ job and error table (text) ─→ kit (bytes) ─→ emulated control
//!         └──────────────── deviation ──────── + ──────── correction ────────┘  ≤ bound
//! ```
//! Deviations are evaluated by the test itself: straight lines with code of its own, cubics
//! through the public curve; zero, mean of both directions and reversal are computed here once
//! more. So a change of sign in the program cannot cancel itself.
mod case;
mod fanuc_numbers;
mod forecast;
mod one_way;
mod places;
mod turned_sign;

use crate::support;
use crate::support::machine::{Machine, machine};
use crate::support::um_at;
use case::{Case, is_compensated};
use fanuc_numbers::numbers_are_legal;
use forecast::{diagonals_hold, forecast_holds};
use nonius::control::controller::{Profile, builtin};
use nonius::control::table::Tables;
use nonius::quantity::axis::{Direction, ErrorTerm};
use one_way::cancels;
use turned_sign::turned_sign_doubles;

/// Machines for each profile.
const MACHINES: usize = 72;

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
        is(tables.iter().any(|t| t.direction.is_some()), "tables for one direction"),
        is(!case.kit.plan.omitted.is_empty(), "terms without a table"),
        is(case.kit.plan.backlash_um.iter().any(|(_, b)| b.is_some()), "backlash parameter"),
        is(placements.any(|p| p.count_um > 1.5 * unit(p.term).unwrap_or(1e9)), "magnified"),
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
    let turned = support::control(&support::with_signs_turned(profile), &kit);
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
    Seen { compensated, doubled, features: features_of(&case) }
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
        doubled > MACHINES / 2, // few where a count is 1 µm and no table follows another axis
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
fn linuxcnc() {
    contract_of("linuxcnc");
}

#[test]
fn linuxcnc_hal() {
    contract_of("linuxcnc-hal");
}

#[test]
fn weihong() {
    contract_of("weihong");
}

#[test]
fn isg_volcomp() {
    contract_of("isg-volcomp");
}

#[test]
fn aerotech() {
    contract_of("aerotech");
}

#[test]
fn isg_axis() {
    contract_of("isg-axis");
}

#[test]
fn fagor_8055() {
    contract_of("fagor-8055");
}

#[test]
fn fagor_8065() {
    contract_of("fagor-8065");
}

#[test]
fn heidenhain_com() {
    contract_of("heidenhain-com");
}

#[test]
fn gsk() {
    contract_of("gsk");
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
        "linuxcnc",
        "linuxcnc-hal",
        "weihong",
        "isg-volcomp",
        "aerotech",
        "isg-axis",
        "fagor-8055",
        "fagor-8065",
        "heidenhain-com",
        "gsk",
        "klipper-skew", // lines alone: tests/it/skew.rs
        "generic",
    ];
    assert_eq!(builtin::ids(), tested);
}
