//! Points and straightness amounts of the kit, zero but for the bump.
//!
//! The parameters of the kit (3620 to 3624, magnifications, sets) stay as they are: the bump is in
//! counts of these magnifications.

use crate::control::controller::{FanucFacts, Mechanism, TableSign};
use crate::control::table::Tables;
use crate::control::table::fanuc::{FanucMemory, ParameterKey, ParameterValue};
use crate::quantity::units::Deviation;
use crate::write::compiled::Bump;
use crate::write::family::ProofOf;
use crate::write::grid::{as_number, whole};
use crate::write::task::axis_pairs;

/// What the file of a mechanism writes.
pub(super) fn memory(
    proof: &ProofOf<'_>,
    facts: &FanucFacts,
    kit: &FanucMemory,
) -> Option<FanucMemory> {
    let pairs: Vec<(u32, u32)> = axis_pairs(&proof.plan.names, proof.term)
        .iter()
        .map(|(base, output)| Some((base.parse().ok()?, output.parse().ok()?)))
        .collect::<Option<_>>()?;
    let mut out = FanucMemory::default();
    if proof.mechanism == Mechanism::Pitch {
        for (axis, run) in runs(kit) {
            let has_bump = pairs.iter().any(|(_, output)| *output == axis);
            let bump = has_bump.then_some(proof.bump);
            for first in std::iter::once(run.first).chain(run.second) {
                increments(run, first, facts.pitch_sign.value, bump, &mut out);
            }
        }
        return Some(out);
    }
    for set in sets(kit, facts) {
        let has_bump = pairs.contains(&(set.moving, set.output));
        let bump = has_bump.then_some(proof.bump);
        let sign = facts.straightness_sign.value;
        let run = run(kit, set.moving)?;
        if proof.mechanism == Mechanism::PerPoint {
            let start = facts.straightness_start_parameter.value + set.index;
            increments(run, held(kit, start, None)?, sign, bump, &mut out);
        } else {
            four_points(kit, &set, run, sign, bump, &mut out)?;
        }
    }
    Some(out)
}

/// Points of the kit that no proof writes would keep what the control holds: the first file that
/// holds points writes zeros there.
pub(super) fn zero_the_rest(kit: &FanucMemory, proofs: &mut [&mut Tables]) {
    let mut proofs: Vec<&mut FanucMemory> = proofs
        .iter_mut()
        .filter_map(|tables| match tables {
            Tables::Fanuc(memory) => Some(memory),
            _ => None,
        })
        .collect();
    let is_missing = |point: &&u32| !proofs.iter().any(|p| p.points.contains_key(*point));
    let rest: Vec<u32> = kit.points.keys().filter(is_missing).copied().collect();
    if let Some(memory) = proofs.iter_mut().find(|p| !p.points.is_empty()) {
        let zeros = rest.into_iter().map(|point| (point, 0));
        memory.points.extend(zeros);
    }
}

/// Pitch points of one controlled axis.
#[derive(Clone, Copy)]
struct Run {
    reference: u32,
    first: u32,
    count: u32,
    second: Option<u32>,
}

fn held(kit: &FanucMemory, number: u32, axis: Option<u32>) -> Option<u32> {
    match kit.parameter(number, axis)? {
        ParameterValue::Integer(value) => u32::try_from(value).ok(),
        _ => None,
    }
}

fn run(kit: &FanucMemory, axis: u32) -> Option<Run> {
    let first = held(kit, 3621, Some(axis))?;
    Some(Run {
        reference: held(kit, 3620, Some(axis))?,
        first,
        count: held(kit, 3622, Some(axis))?.checked_sub(first)? + 1,
        second: held(kit, 3626, Some(axis)),
    })
}

fn runs(kit: &FanucMemory) -> impl Iterator<Item = (u32, Run)> {
    let keys = kit.parameters.keys().filter(|key| key.number == 3620);
    keys.filter_map(|key| Some((key.axis?, run(kit, key.axis?)?)))
}

/// Increments of a bump (`None` = zeros), one for each section of the run; point N0 ends at the
/// reference. Both directions of travel have the same.
fn increments(run: Run, first: u32, sign: TableSign, bump: Option<&Bump>, out: &mut FanucMemory) {
    for offset in 0..run.count {
        let node = i64::from(run.first) + i64::from(offset) - i64::from(run.reference);
        let total = |node: i64| bump.map_or(0, |bump| in_table(sign, bump.counts_at(node)));
        let increment = total(node) - total(node - 1);
        let increment = i32::try_from(increment).unwrap_or(0);
        out.points.insert(first + offset, increment);
    }
}

/// Counts of a deviation in the sense of the table.
fn in_table(sign: TableSign, counts: i64) -> i64 {
    whole(sign.table_um(Deviation::from_um(as_number(counts))).round())
}

/// A straightness set of the kit; `index` counts from 0.
struct Set {
    index: u32,
    moving: u32,
    output: u32,
}

fn sets(kit: &FanucMemory, facts: &FanucFacts) -> Vec<Set> {
    (0..facts.straightness_sets.value)
        .filter_map(|index| {
            Some(Set {
                index,
                moving: held(kit, 5711 + index, None)?,
                output: held(kit, 5721 + index, None)?,
            })
        })
        .collect()
}

/// The points of a set without the bump stay, with amounts 0. A set with it has the reference as
/// its fourth point.
fn four_points(
    kit: &FanucMemory,
    set: &Set,
    run: Run,
    sign: TableSign,
    bump: Option<&Bump>,
    out: &mut FanucMemory,
) -> Option<()> {
    for knot in 0..4 {
        let number = 10 * set.index + knot;
        let (point, amount) = match bump {
            None => (held(kit, 5731 + number, None)?, 0),
            Some(bump) => {
                let nodes = bump_nodes(bump);
                let node = nodes[usize::try_from(knot).ok()?];
                let point = u32::try_from(i64::from(run.reference) + node).ok()?;
                (point, in_table(sign, bump.counts_at(node)))
            }
        };
        let mut write = |number, value| {
            let key = ParameterKey { number, axis: None };
            out.parameters.insert(key, ParameterValue::Integer(value));
        };
        write(5731 + number, i64::from(point));
        write(5761 + number, amount);
    }
    Some(())
}

/// Beginning, peak and end of the bump, and the reference, ascending.
fn bump_nodes(bump: &Bump) -> [i64; 4] {
    let mut nodes = [0, bump.peak - bump.rise, bump.peak, bump.peak + bump.rise];
    nodes.sort_unstable();
    nodes
}
