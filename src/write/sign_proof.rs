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

mod bump;
mod fanuc;
mod siemens;

use self::bump::whole_below;
pub use self::bump::{Bump, SignProof};

use crate::control::controller::{Dialect, Mechanism, StraightnessForm};
use crate::control::table::Tables;
use crate::inputs::job::LEAST_BUMP_UM;
use crate::quantity::axis::{Axis, ErrorTerm};
use crate::quantity::units::Millimetres;
use crate::write::compensation::Compiled;
use crate::write::compensation::siemens::is_lec;
use crate::write::grid::Grid;
use crate::write::plan::{Plan, PlannedTable, Task};

/// The proofs of a kit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignProofs {
    /// One for each mechanism that has a place for it.
    pub proofs: Vec<SignProof>,
    /// Why the others have none, one sentence each.
    pub missing: Vec<String>,
}

/// The sign proofs of a kit; a mechanism without a place for a bump is named.
pub fn sign_proofs(task: Task<'_>, plan: &Plan, compiled: &Compiled) -> SignProofs {
    let mut found = SignProofs::default();
    for mechanism in mechanisms(task) {
        let is_own = |t: &&PlannedTable| belongs(task, mechanism, t);
        let planned: Vec<&PlannedTable> = plan.tables.iter().filter(is_own).collect();
        if planned.is_empty() {
            continue;
        }
        let limits = section_limits(task, mechanism);
        let best = limits
            .into_iter()
            .find_map(|limit| highest(task, compiled, &planned, limit));
        let proof = best.and_then(|(term, bump)| {
            let tables = tables(task, plan, compiled, mechanism, term, &bump)?;
            Some(SignProof {
                mechanism,
                term,
                bump,
                tables,
            })
        });
        match proof {
            Some(proof) => found.proofs.push(proof),
            None => found.missing.push(no_place(task, mechanism)),
        }
    }
    if let Tables::Fanuc(memory) = &compiled.tables {
        fanuc::zero_the_rest(memory, &mut found.proofs);
    }
    found
}

fn mechanisms(task: Task<'_>) -> [Mechanism; 2] {
    match &task.profile.dialect {
        Dialect::Siemens(_) => [Mechanism::EncComp, Mechanism::Cec],
        Dialect::Fanuc(facts) => match facts.straightness_form.value {
            StraightnessForm::FourPoint => [Mechanism::Pitch, Mechanism::FourPoint],
            StraightnessForm::PerPoint => [Mechanism::Pitch, Mechanism::PerPoint],
        },
        Dialect::Generic(_) => [Mechanism::Nothing; 2],
    }
}

fn belongs(task: Task<'_>, mechanism: Mechanism, planned: &PlannedTable) -> bool {
    match (&task.profile.dialect, mechanism) {
        (Dialect::Siemens(_), Mechanism::EncComp) => is_lec(planned),
        (Dialect::Siemens(_), Mechanism::Cec) => !is_lec(planned),
        (Dialect::Fanuc(_), Mechanism::Pitch) => planned.term.is_positioning(),
        (Dialect::Fanuc(_), _) => planned.term.is_cross(),
        _ => false,
    }
}

/// Largest changes in one section that are tried in turn, counts; `None` = the slope alone limits.
///
/// A straightness set of four points has no increments, but the control refuses a slope that is too
/// large (alarm PW5046, from memory; the limit is not known). So its bump rises like one of pitch
/// points, and steeper only where the table has no room for that.
fn section_limits(task: Task<'_>, mechanism: Mechanism) -> Vec<Option<i64>> {
    let Dialect::Fanuc(facts) = &task.profile.dialect else {
        return vec![None];
    };
    let increment = Some(i64::from(facts.increment_max.value));
    match mechanism {
        Mechanism::FourPoint => vec![increment, None],
        _ => vec![increment],
    }
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
    match &task.profile.dialect {
        Dialect::Siemens(facts) if !is_lec(planned) => wanted.min(facts.cec_max_sum_um.value),
        _ => wanted,
    }
}

/// The highest legal bump of a table, the narrowest of that height, nearest to the middle of the
/// travel; `None` below [`LEAST_BUMP_UM`].
fn bump(
    task: Task<'_>,
    planned: &PlannedTable,
    count_um: f64,
    section_limit: Option<i64>,
) -> Option<Bump> {
    let grid = planned.grid;
    let most = whole_below(most_um(task, planned) / count_um);
    let slope_um = task.job.limits.max_slope_um_per_mm * grid.spacing().mm();
    let by_slope = whole_below(slope_um / count_um);
    let in_section = section_limit.map_or(by_slope, |limit| limit.min(by_slope));
    let stretches = stretches(task, planned.term.along, &grid)?;
    let widest = stretches.iter().map(|(low, high)| (high - low) / 2).max()?;
    if widest < 1 || in_section < 1 || most < 1 {
        return None;
    }
    let rise = ((most + in_section - 1) / in_section).min(widest);
    let counts = most.min(rise * in_section);
    let peak = nearest_to_the_middle(task, planned.term.along, &grid, &stretches, rise)?;
    let bump = Bump {
        grid,
        peak,
        rise,
        counts,
        count_um,
    };
    (bump.height().um() >= LEAST_BUMP_UM).then_some(bump)
}

/// Nodes on both sides of the reference that a bump may use: inside table and travel, at least
/// one section away from the reference.
fn stretches(task: Task<'_>, axis: Axis, grid: &Grid) -> Option<[(i64, i64); 2]> {
    let machine = task.job.machine.axes[axis]?;
    let spacing = grid.spacing().mm();
    let nodes = |place: Millimetres| (place.mm() - grid.reference.mm()) / spacing;
    let low = -whole_below(-nodes(machine.low));
    let high = whole_below(nodes(machine.high));
    Some([(low.max(grid.first), -1), (1, high.min(grid.last))])
}

fn nearest_to_the_middle(
    task: Task<'_>,
    axis: Axis,
    grid: &Grid,
    stretches: &[(i64, i64)],
    rise: i64,
) -> Option<i64> {
    let machine = task.job.machine.axes[axis]?;
    let middle = f64::midpoint(machine.low.mm(), machine.high.mm());
    let wanted = ((middle - grid.reference.mm()) / grid.spacing().mm()).round();
    let peaks = stretches.iter().filter_map(|(low, high)| {
        let (low, high) = (low + rise, high - rise);
        (low <= high).then(|| whole_below(wanted).clamp(low, high))
    });
    let distance = |peak: &i64| (grid.position(*peak).mm() - middle).abs();
    peaks.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

fn no_place(task: Task<'_>, mechanism: Mechanism) -> String {
    let limits = task.job.limits;
    format!(
        "no sign proof of {}: no axis has a stretch, at least one section away from its reference and inside its travel, on which a bump rises to {LEAST_BUMP_UM} µm with at most {} µm/mm; measure after loading instead, one axis first",
        name(mechanism),
        limits.max_slope_um_per_mm
    )
}

/// The mechanism in words.
pub fn name(mechanism: Mechanism) -> &'static str {
    match mechanism {
        Mechanism::EncComp => "ENC_COMP (LEC)",
        Mechanism::Cec => "CEC",
        Mechanism::Pitch => "pitch error compensation",
        _ => "straightness compensation",
    }
}

/// The fact of a profile that states the sign of a mechanism.
pub(crate) fn sign_fact(mechanism: Mechanism) -> &'static str {
    match mechanism {
        Mechanism::EncComp => "lec_sign",
        Mechanism::Cec => "cec_sign",
        Mechanism::Pitch => "pitch_sign",
        _ => "straightness_sign",
    }
}

fn tables(
    task: Task<'_>,
    plan: &Plan,
    compiled: &Compiled,
    mechanism: Mechanism,
    term: ErrorTerm,
    bump: &Bump,
) -> Option<Tables> {
    match (&compiled.tables, &task.profile.dialect) {
        (Tables::Siemens(kit), Dialect::Siemens(facts)) => {
            let own = (term, bump);
            let tables = siemens::tables(task, plan, facts, kit, mechanism, own);
            Some(Tables::Siemens(tables))
        }
        (Tables::Fanuc(kit), Dialect::Fanuc(facts)) => {
            fanuc::memory(plan, facts, kit, mechanism, (term, bump)).map(Tables::Fanuc)
        }
        _ => None,
    }
}
