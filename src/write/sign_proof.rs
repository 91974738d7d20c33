//! Sign proof: tables that are zero but for one small bump, one for each mechanism of a kit.
//!
//! ```text
//!   deviation that the table pretends           peak
//!                                          h ─  ╱╲
//!   ●────────────┬──────────┬─────────────────╱──╲───────────  0
//!   reference    at least one section      from    to
//! ```
//! The control takes the bump for an error of the machine and pulls the axis back by h, if it
//! reads the table as its profile says; if it reads it the other way round, the axis goes h
//! further. Tables, grids and numbers are those of the kit, so nothing else is overwritten.

pub use crate::write::family::{Bump, SignProof};

use crate::control::table::Tables;
use crate::inputs::job::{LEAST_BUMP_UM, MachineAxis};
use crate::quantity::{ErrorTerm, Millimetres};
use crate::text::Finding;
use crate::write::family::{Compiled, ProofOf, family, whole_below};
use crate::write::findings::TableFinding;
use crate::write::grid::Grid;
use crate::write::task::{Plan, PlannedTable, Task};

/// The proofs of a kit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignProofs {
    /// One for each mechanism that has a place for it.
    pub proofs: Vec<SignProof>,
    /// Mechanisms that have none.
    pub missing: Vec<Finding>,
}

/// The sign proofs of a kit; a mechanism without a place for a bump is named.
pub fn sign_proofs(task: Task<'_>, plan: &Plan, compiled: &Compiled) -> SignProofs {
    let mut found = SignProofs::default();
    let family = family(task.profile);
    for of in task.profile.family.proofs {
        let mechanism = of.mechanism;
        let is_own = |t: &&PlannedTable| family.belongs(mechanism, t);
        let planned: Vec<&PlannedTable> = plan.tables.iter().filter(is_own).collect();
        if planned.is_empty() {
            continue;
        }
        let limits = family.section_limits(mechanism).into_iter();
        let mut bumps = limits.filter_map(|limit| highest(task, compiled, &planned, limit));
        let proof = bumps.next().and_then(|(term, bump)| {
            let tables = family.proof_tables(&ProofOf {
                task,
                plan,
                kit: &compiled.tables,
                mechanism,
                term,
                bump: &bump,
            })?;
            Some(SignProof { of, term, bump, tables })
        });
        match proof {
            Some(proof) => found.proofs.push(proof),
            None => found.missing.push(
                TableFinding::NoSignProof {
                    mechanism: of.name,
                    least_um: LEAST_BUMP_UM,
                    slope_um_per_mm: task.job.limits.max_slope_um_per_mm,
                }
                .into(),
            ),
        }
    }
    let tables = found.proofs.iter_mut().map(|proof| &mut proof.tables);
    let mut tables: Vec<&mut Tables> = tables.collect();
    family.zero_the_rest(&compiled.tables, &mut tables);
    found
}

/// The highest bump of all tables of a mechanism, then the narrowest, then the first in the
/// contract's order of terms.
fn highest(
    task: Task<'_>,
    compiled: &Compiled,
    planned: &[&PlannedTable],
    section_limit: Option<i64>,
) -> Option<(ErrorTerm, Bump)> {
    let better = |a: &Bump, b: &Bump| {
        let (high, higher) = (a.height().um(), b.height().um());
        higher > high || (higher >= high && b.rise < a.rise)
    };
    let bumps = planned.iter().filter_map(|t| {
        let placed = compiled.placements.iter().find(|p| p.term == t.term)?;
        Some((t.term, bump(task, t, placed.count_um, section_limit)?))
    });
    bumps.reduce(|a, b| if better(&a.1, &b.1) { b } else { a })
}

/// Largest height of a bump, µm: `limits` of the job, and what the control does not cut off.
fn most_um(task: Task<'_>, planned: &PlannedTable) -> f64 {
    let limits = task.job.limits;
    let wanted = limits.max_bump_um.min(limits.max_correction_um);
    wanted.min(family(task.profile).cut_off_um(task, planned))
}

/// The highest legal bump of a table, the narrowest of that height, nearest to the middle of the
/// travel; `None` below [`LEAST_BUMP_UM`].
fn bump(
    task: Task<'_>,
    planned: &PlannedTable,
    count_um: f64,
    section_limit: Option<i64>,
) -> Option<Bump> {
    if family(task.profile).proves_by_slope() {
        return slope(task, planned, count_um);
    }
    let (grid, machine) = (planned.grid, task.job.machine.axes[planned.term.along]?);
    let most = whole_below(most_um(task, planned) / count_um);
    let slope_um = task.job.limits.max_slope_um_per_mm * grid.spacing().mm();
    let by_slope = whole_below(slope_um / count_um);
    let in_section = section_limit.map_or(by_slope, |limit| limit.min(by_slope));
    let stretches = stretches(machine, &grid);
    let widest = stretches.iter().map(|(low, high)| (high - low) / 2).max()?;
    if widest < 1 || in_section < 1 || most < 1 {
        return None;
    }
    let rise = ((most + in_section - 1) / in_section).min(widest);
    let counts = most.min(rise * in_section);
    let peak = nearest_to_the_middle(machine, &grid, &stretches, rise)?;
    let bump = Bump { grid, peak, rise, counts, count_um, is_slope: false };
    (bump.height().um() >= LEAST_BUMP_UM).then_some(bump)
}

/// The highest legal slope to the end of the travel that lies farther from the reference; `None` below
/// [`LEAST_BUMP_UM`].
fn slope(task: Task<'_>, planned: &PlannedTable, count_um: f64) -> Option<Bump> {
    let grid = planned.grid;
    let [(low, _), (_, high)] = stretches(task.job.machine.axes[planned.term.along]?, &grid);
    let peak = if -low > high { low } else { high };
    let far = (grid.position(peak) - grid.reference).mm().abs();
    let most_um = most_um(task, planned).min(task.job.limits.max_slope_um_per_mm * far);
    let bump = Bump {
        grid,
        peak,
        rise: peak.abs(),
        counts: whole_below(most_um / count_um),
        count_um,
        is_slope: true,
    };
    (bump.rise > 0 && bump.height().um() >= LEAST_BUMP_UM).then_some(bump)
}

/// Nodes on both sides of the reference that a bump may use: inside table and travel, at least
/// one section away from the reference.
fn stretches(machine: MachineAxis, grid: &Grid) -> [(i64, i64); 2] {
    let spacing = grid.spacing().mm();
    let nodes = |place: Millimetres| (place.mm() - grid.reference.mm()) / spacing;
    let low = -whole_below(-nodes(machine.low));
    let high = whole_below(nodes(machine.high));
    [(low.max(grid.first), -1), (1, high.min(grid.last))]
}

fn nearest_to_the_middle(
    machine: MachineAxis,
    grid: &Grid,
    stretches: &[(i64, i64)],
    rise: i64,
) -> Option<i64> {
    let middle = f64::midpoint(machine.low.mm(), machine.high.mm());
    let wanted = ((middle - grid.reference.mm()) / grid.spacing().mm()).round();
    let peaks = stretches.iter().filter_map(|(low, high)| {
        let (low, high) = (low + rise, high - rise);
        (low <= high).then(|| whole_below(wanted).clamp(low, high))
    });
    let distance = |peak: &i64| (grid.position(*peak).mm() - middle).abs();
    peaks.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}
