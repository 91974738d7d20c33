//! A control with fewer tables than terms: which terms get one.
//!
//! The tables go to the set of terms that leaves the smallest largest error in the volume.
//! For every set that the control can hold and that cannot be enlarged, the error vector left at
//! a point is the sum of what the three axes leave,
//!
//! ```text
//!   e(x, y, z) = v_X(x) + v_Y(y) + v_Z(z),   v_A = Σ terms along A of (deviation − target, or deviation)
//! ```
//! and its largest length over all measured positions and directions decides. On straight curve
//! pieces a length is largest at the ends of the pieces, so with linear curves the search over
//! the measured positions is exact; with cubic ones it is exact at the measured positions.
//! Angular errors are not part of it; grid and rounding are not either, they are far smaller than
//! a term without a table.

use crate::axis::{Axis, Direction, ErrorTerm, PerAxis};
use crate::model::ErrorModel;
use crate::target::{Omission, TermTargets};
use crate::units::Millimetres;

type Vector = [f64; 3];

/// What one term costs of a limited resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// Which error.
    pub term: ErrorTerm,
    /// Tables (or straightness sets) that it takes.
    pub tables: u32,
}

/// The outcome of a choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Terms that get no table.
    pub omitted: Vec<Omission>,
    /// Largest error vector in the measured volume that the chosen set leaves, µm.
    pub left_um: f64,
}

/// The best set of terms within a budget; `None` if all of them fit.
pub fn choose(
    model: &ErrorModel,
    targets: &[TermTargets],
    costs: &[Cost],
    budget: u32,
    resource: &str,
) -> Option<Choice> {
    let total: u32 = costs.iter().map(|cost| cost.tables).sum();
    if total <= budget {
        return None;
    }
    let parts = Parts::of(model, targets);
    let mut best: Option<(f64, u32)> = None;
    for set in 0..(1_u32 << costs.len()) {
        if is_maximal(costs, set, budget) {
            let left = parts.largest(costs, set);
            // A hair's breadth of a difference is no reason to prefer a set of fewer terms.
            let better = best.is_none_or(|(least, chosen)| {
                left < least - TIE_UM
                    || (left < least + TIE_UM && set.count_ones() > chosen.count_ones())
            });
            if better {
                best = Some((left, set));
            }
        }
    }
    let (left_um, set) = best?;
    Some(Choice {
        omitted: omissions(&parts, costs, set, budget, total, left_um, resource),
        left_um,
    })
}

/// Two largest errors closer than this are equal, µm.
const TIE_UM: f64 = 1e-9;

fn cost_of(costs: &[Cost], set: u32) -> u32 {
    costs
        .iter()
        .enumerate()
        .filter(|(index, _)| set >> index & 1 == 1)
        .map(|(_, cost)| cost.tables)
        .sum()
}

fn is_maximal(costs: &[Cost], set: u32, budget: u32) -> bool {
    let used = cost_of(costs, set);
    let free = budget.checked_sub(used);
    free.is_some_and(|free| {
        costs
            .iter()
            .enumerate()
            .all(|(index, cost)| set >> index & 1 == 1 || cost.tables > free)
    })
}

fn omissions(
    parts: &Parts,
    costs: &[Cost],
    set: u32,
    budget: u32,
    total: u32,
    left_um: f64,
    resource: &str,
) -> Vec<Omission> {
    let mut omitted = Vec::new();
    for (index, cost) in costs.iter().enumerate() {
        if set >> index & 1 == 0 {
            let with = parts.largest(costs, set | 1 << index);
            omitted.push(Omission {
                term: cost.term,
                reason: format!(
                    "the control has {budget} {resource} for {total}; the chosen terms leave at most {left_um:.1} µm in the volume ({with:.1} µm with {} as well)",
                    cost.term
                ),
            });
        }
    }
    omitted
}

/// What one axis contributes at one of its positions in one direction, with and without tables.
struct State {
    /// For each term along the axis: deviation as measured, and what its table would leave.
    terms: Vec<(ErrorTerm, f64, f64)>,
}

struct Parts {
    states: PerAxis<Vec<State>>,
}

impl Parts {
    fn of(model: &ErrorModel, targets: &[TermTargets]) -> Parts {
        Parts {
            states: PerAxis::from_fn(|axis| states_of(model, targets, axis)),
        }
    }

    /// Largest error vector if the terms of `set` (bits over `costs`) have tables, and all terms
    /// that cost nothing.
    fn largest(&self, costs: &[Cost], set: u32) -> f64 {
        let has_table = |term: ErrorTerm| {
            costs
                .iter()
                .position(|cost| cost.term == term)
                .is_none_or(|index| set >> index & 1 == 1)
        };
        let vectors = PerAxis::from_fn(|axis| vectors_of(&self.states[axis], &has_table));
        largest_sum(&vectors)
    }
}

fn states_of(model: &ErrorModel, targets: &[TermTargets], axis: Axis) -> Vec<State> {
    let mut states = Vec::new();
    for direction in Direction::BOTH {
        for position in positions_of(model, axis, direction) {
            let terms = ErrorTerm::ALL
                .into_iter()
                .filter(|term| term.along == axis)
                .filter_map(|term| {
                    let deviation = model.terms[term]
                        .as_ref()?
                        .measured
                        .curve(direction)?
                        .at(position)
                        .um();
                    let target = targets
                        .iter()
                        .find(|t| t.term == term)
                        .and_then(|t| t.curve(direction))
                        .map_or(0.0, |curve| curve.at(position).um());
                    Some((term, deviation, deviation - target))
                })
                .collect();
            states.push(State { terms });
        }
        if !model
            .measured()
            .any(|(term, m)| term.along == axis && m.measured.has_both_ways())
        {
            break; // one direction tells all
        }
    }
    states
}

fn positions_of(model: &ErrorModel, axis: Axis, direction: Direction) -> Vec<Millimetres> {
    let mut positions: Vec<Millimetres> = model
        .measured()
        .filter(|(term, _)| term.along == axis)
        .filter_map(|(_, measured)| measured.measured.curve(direction))
        .flat_map(|curve| curve.knots().iter().copied())
        .collect();
    positions.sort_by(|a, b| a.mm().total_cmp(&b.mm()));
    positions.dedup();
    positions
}

fn vectors_of(states: &[State], has_table: &impl Fn(ErrorTerm) -> bool) -> Vec<Vector> {
    let mut vectors: Vec<Vector> = states
        .iter()
        .map(|state| {
            let mut vector = [0.0; 3];
            for (term, deviation, left) in &state.terms {
                vector[match term.of {
                    Axis::X => 0,
                    Axis::Y => 1,
                    Axis::Z => 2,
                }] += if has_table(*term) { *left } else { *deviation };
            }
            vector
        })
        .collect();
    if vectors.iter().all(|v| length(*v) < TIE_UM) {
        vectors.truncate(1);
    }
    if vectors.is_empty() {
        vectors.push([0.0; 3]);
    }
    vectors
}

fn length(v: Vector) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

fn sum(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Largest |a + b + c| over three sets of vectors. A partial sum that cannot beat the best even
/// with the longest partner is passed over.
fn largest_sum(sets: &PerAxis<Vec<Vector>>) -> f64 {
    let longest = sets.z.iter().map(|v| length(*v)).fold(0.0, f64::max);
    let mut best = 0.0_f64;
    for a in &sets.x {
        for b in &sets.y {
            let partial = sum(*a, *b);
            if length(partial) + longest <= best {
                continue;
            }
            for c in &sets.z {
                best = best.max(length(sum(partial, *c)));
            }
        }
    }
    best
}
