//! Points and straightness amounts of the kit, zero but for the bump.
//!
//! The parameters of the kit (3620 to 3624, magnifications, sets) stay as they are: the bump is in
//! counts of these magnifications.

use crate::control::controller::{FanucFacts, Mechanism, TableSign};
use crate::control::table::Tables;
use crate::control::table::fanuc::FanucMemory;
use crate::quantity::Deviation;
use crate::text::Problems;
use crate::write::compiled::Bump;
use crate::write::family::ProofOf;
use crate::write::fanuc::numbers::{Run, runs};
use crate::write::fanuc::tables::{Totals, points};
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
    let (runs, _) = runs(proof.task, proof.plan, facts, &mut Problems::none());
    let mut out = FanucMemory::default();
    if proof.mechanism == Mechanism::Pitch {
        for run in &runs {
            let has_bump = pairs.iter().any(|(_, output)| *output == run.id);
            let totals = has_bump.then(|| totals(proof.bump, facts.pitch_sign.value));
            for first in std::iter::once(run.first).chain(run.minus_first) {
                points(&mut out, first, run, totals.as_ref());
            }
        }
        return Some(out);
    }
    for index in 0..facts.straightness_sets.value {
        let axis = |first: u32| kit.count(first + index, None);
        let (Some(moving), Some(output)) = (axis(5711), axis(5721)) else { continue };
        let bump = pairs.contains(&(moving, output)).then_some(proof.bump);
        let sign = facts.straightness_sign.value;
        let run = runs.iter().find(|run| run.id == moving)?;
        if proof.mechanism == Mechanism::PerPoint {
            let first = axis(facts.straightness_start_parameter.value)?;
            points(&mut out, first, run, bump.map(|bump| totals(bump, sign)).as_ref());
        } else {
            four_points(kit, index, run, bump.map(|bump| (bump, sign)), &mut out)?;
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

/// What a bump is in increments; both directions of travel have the same.
fn totals(bump: &Bump, sign: TableSign) -> Totals {
    let nodes = bump.grid.first..=bump.grid.last;
    let counts = nodes.map(|node| in_table(sign, bump.counts_at(node))).collect();
    Totals { grid: bump.grid, counts }
}

/// Counts of a deviation in the sense of the table.
fn in_table(sign: TableSign, counts: i64) -> i64 {
    whole(sign.table_um(Deviation::from_um(as_number(counts))).round())
}

/// The points of a set without the bump stay, with amounts 0. A set with it has the reference as
/// its fourth point.
fn four_points(
    kit: &FanucMemory,
    set: u32,
    run: &Run,
    bump: Option<(&Bump, TableSign)>,
    out: &mut FanucMemory,
) -> Option<()> {
    for knot in 0..4 {
        let number = 10 * set + knot;
        let (point, amount) = match bump {
            None => (kit.count(5731 + number, None)?, 0),
            Some((bump, sign)) => {
                let node = bump_nodes(bump)[usize::try_from(knot).ok()?];
                (run.point(node), in_table(sign, bump.counts_at(node)))
            }
        };
        out.set(5731 + number, None, point);
        out.set(5761 + number, None, amount);
    }
    Some(())
}

/// Beginning, peak and end of the bump, and the reference, ascending.
fn bump_nodes(bump: &Bump) -> [i64; 4] {
    let mut nodes = [0, bump.peak - bump.rise, bump.peak, bump.peak + bump.rise];
    nodes.sort_unstable();
    nodes
}
