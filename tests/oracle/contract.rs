//! The contract: whatever machine is measured, the bytes that a control loads cancel its errors.
//!
//! ```text
//!   machine of the test ─→ job and error table (text) ─→ kit (bytes) ─→ emulated control
//!         └──────────────── deviation ──────── + ──────── correction ────────┘  ≤ bound
//! ```
//! Deviations, zero, mean and reversal are the test's own (tests/support/machine.rs), so a change of sign
//! in the program cannot cancel itself.
mod case;
mod fanuc_numbers;
mod forecast;
mod one_way;
mod stages;

use crate::support::machine::{Machine, machine};
use crate::support::{self, control, in_parallel, loaded, short_or, um_at, with_signs_turned};
use case::Case;
use fanuc_numbers::numbers_are_legal;
use forecast::{diagonals_hold, forecast_holds};
use nonius::control::controller::{Dialect, Profile, builtin};
use nonius::control::table::Tables;
use nonius::quantity::{Direction, ErrorTerm};
use one_way::cancels;
use std::collections::BTreeMap;

/// The machines for each profile: 72 where `NONIUS_SIMULATIONS` is set, else every fourth, one of each four.
fn seeds() -> Vec<usize> {
    let all = short_or(false, true);
    (0..72).filter(|seed| all || seed % 4 == seed / 4 % 4).collect()
}

/// (f) A term without a table gets exactly nothing.
fn has_no_effect(case: &Case<'_>, term: ErrorTerm) {
    for (base, output) in case.machine.pairs(term) {
        for direction in Direction::BOTH {
            let response = support::response(case.control, base, output, direction);
            for x in case.machine.axis(term.along).parts(20) {
                let um = um_at(&response, x);
                assert!(um.to_bits() << 1 == 0, "{} {term}: {um} µm", case.profile.id);
            }
        }
    }
}

/// (g) Every axis of a gantry gets what the first one gets.
fn gantry_is_equal(case: &Case<'_>, term: ErrorTerm) {
    let pairs = case.machine.pairs(term);
    for direction in Direction::BOTH {
        let of = |(base, output)| support::response(case.control, base, output, direction);
        for pair in &pairs[1..] {
            let (first, other) = (of(pairs[0]), of(*pair));
            for x in case.machine.axis(term.along).parts(50) {
                let difference = um_at(&first, x) - um_at(&other, x);
                let id = &case.profile.id;
                assert!(difference.abs() < 1e-12, "{id} {term}: {pair:?}: {difference}");
            }
        }
    }
}

struct Shown<'a>(&'a Machine, &'a Profile);

impl Drop for Shown<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("{}\n{}\n{}", self.1.id, self.0.job, self.0.csv);
        }
    }
}

/// What machines had to show: compensated terms, tables large enough to turn, and how often each feature.
#[derive(Default)]
struct Seen {
    compensated: usize,
    doubled: usize,
    features: BTreeMap<&'static str, usize>,
}

fn features_of(case: &Case<'_>) -> impl Iterator<Item = &'static str> {
    let tables = &case.kit.plan.tables;
    let unit = |term: ErrorTerm| case.machine.axis(term.of).unit_um;
    let mut placements = case.kit.compiled.placements.iter();
    let all = [
        (tables.iter().any(|t| t.direction.is_some()), "tables for one direction"),
        (!case.kit.plan.omitted.is_empty(), "terms without a table"),
        (case.kit.plan.backlash_um.iter().any(|(_, b)| b.is_some()), "backlash parameter"),
        (placements.any(|p| p.count_um > 1.5 * unit(p.term).unwrap_or(1e9)), "magnified"),
    ];
    all.into_iter().filter_map(|(there, name)| there.then_some(name))
}

fn check(profile: &Profile, machine: &Machine, seen: &mut Seen) {
    let _shown = Shown(machine, profile);
    let (inputs, kit) = support::generate(&machine.job, &machine.csv);
    let (tables, control) = (loaded(profile, &kit), control(profile, &kit));
    let turned = support::control(&with_signs_turned(profile), &kit);
    let case = Case { machine, profile, kit: &kit, control: control.as_ref(), tables: &tables };
    assert_eq!(inputs.model.measured().count(), machine.terms.len());
    for term in &machine.terms {
        if case.is_compensated(term.term) {
            seen.compensated += 1;
            for pair in machine.pairs(term.term) {
                seen.doubled += cancels(&case, term, pair, turned.as_ref());
            }
            gantry_is_equal(&case, term.term);
        } else {
            let is_listed = kit.plan.omitted.iter().any(|o| o.term == term.term);
            assert!(is_listed, "{} is not listed", term.term);
            has_no_effect(&case, term.term);
        }
        let forecast = kit.forecast.terms.iter().find(|f| f.term == term.term);
        forecast_holds(&case, term, forecast.unwrap());
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
    for feature in machine.features.iter().copied().chain(features_of(&case)) {
        *seen.features.entry(feature).or_insert(0) += 1;
    }
}

fn contract_of(id: &str) {
    let profile = builtin::profile(id).unwrap();
    let (seeds, mut seen) = (seeds(), Seen::default());
    for seed in &seeds {
        check(&profile, &machine(&profile, *seed), &mut seen);
    }
    // The test must have had something to say; few machines seldom show what is rare.
    let (Seen { compensated, doubled, features }, machines) = (seen, seeds.len());
    let (enough, often) = if machines == 72 { (machines / 2, 3) } else { (machines / 3, 1) };
    assert!(compensated > 2 * machines, "{id}: only {compensated} terms");
    // Few where a count is 1 µm and no table follows another axis; the larger a count, the fewer are turned by more.
    let count_um = match &profile.dialect {
        Dialect::Declared(facts) => support::count_um(facts, Some(1.0)).max(1.0),
        _ => 1.0,
    };
    let is_enough = doubled as f64 * count_um > enough as f64;
    assert!(is_enough, "{id}: only {doubled} tables were large enough to turn");
    let rare = features.iter().find(|(_, times)| **times < often);
    assert!(rare.is_none() && features.len() >= 24, "{id}: {features:?}");
}

/// All but that of lines alone: tests/it/skew.rs.
#[test]
fn every_profile_keeps_the_contract() {
    in_parallel(support::positioning_ids(), contract_of);
}
