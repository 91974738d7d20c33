//! The described visit beside its variants, and the cheapest that will do.

use super::design::Design;
use super::variant::{Variant, Visit};
use crate::quantity::axis::{Axis, Rotation};
use crate::text::problem::Problems;

/// More runs are no variant: a day has no more.
pub(super) const MOST_RUNS: u32 = 6;
/// Probability from which on a second measurement is counted on.
const LIKELY: f64 = 0.8;

/// The run of the job, variants of it, and the cheapest.
#[derive(Clone, Debug)]
pub struct VisitPlan {
    /// As described, then one change each; then what is proposed and is none of these.
    pub visits: Vec<Visit>,
    /// The one that takes the least time of all whose forecast reaches the acceptance; `None` = none does.
    pub forecast: Option<usize>,
    /// Likewise of those whose second measurement passes with a probability of 80 %, too.
    pub second: Option<usize>,
}

/// Compares the described run with its variants.
pub fn plan(design: &Design<'_>) -> Result<VisitPlan, Problems> {
    let described = design.described();
    let mut visits = vec![design.visit(described.clone())?];
    for count in 1..=design.axes_open().len() {
        visits.extend(best_lines(design, described, count)?);
    }
    let angles = design.angles_by_size(&visits[0]);
    let measured = of_angles(&angles).into_iter().map(|angles| described.with_angles(&angles));
    let directions = [described.one_way(), described.turning()].into_iter();
    let runs = [1, 3, MOST_RUNS].map(|runs| described.in_runs(runs));
    for other in measured.chain(directions).chain(runs).chain(design.in_other_steps(described)) {
        if other != *described {
            visits.push(design.visit(other)?);
        }
    }
    for visit in &mut visits {
        visit.chance = design.chance(visit);
    }
    let variants = combinations(design, &angles);
    let asked = design.acceptance();
    let forecast = cheapest(design, &variants, |visit| visit.reaches(asked))?;
    let likely = |visit: &Visit| {
        visit.reaches(asked) && design.chance(visit).is_none_or(|chance| chance >= LIKELY)
    };
    let second = cheapest(design, &variants, likely)?.filter(|_| !asked.asks_nothing());
    let [forecast, second] = [forecast, second].map(|found| found.map(|visit| place(design, &mut visits, visit)));
    Ok(VisitPlan { visits, forecast, second })
}

/// With so many more linear axes: those that leave the least open, with the smallest U.
fn best_lines(
    design: &Design<'_>,
    described: &Variant,
    count: usize,
) -> Result<Option<Visit>, Problems> {
    let mut best: Option<Visit> = None;
    for axes in subsets(&design.axes_open()) {
        if axes.len() != count {
            continue;
        }
        let visit = design.visit(described.with(&axes))?;
        let rank = |visit: &Visit| (visit.open.len(), visit.at_most_um().unwrap_or(f64::MAX));
        if best.as_ref().is_none_or(|best| rank(&visit) < rank(best)) {
            best = Some(visit);
        }
    }
    Ok(best)
}

fn subsets(axes: &[Axis]) -> Vec<Vec<Axis>> {
    let mut all = vec![Vec::new()];
    for axis in axes {
        let with: Vec<Vec<Axis>> = all.iter().map(|one| [one, &[*axis][..]].concat()).collect();
        all.extend(with);
    }
    all
}

/// The largest alone, and all.
fn of_angles(by_size: &[Rotation]) -> Vec<Vec<Rotation>> {
    let mut each = vec![by_size.iter().take(1).copied().collect(), by_size.to_vec()];
    each.dedup();
    each.retain(|angles| !angles.is_empty());
    each
}

/// The one that takes the least time of all with which something is reached. Tables that need another grid
/// count only where no others do.
pub(super) fn cheapest(
    design: &Design<'_>,
    variants: &[Variant],
    is_reached: impl Fn(&Visit) -> bool,
) -> Result<Option<Visit>, Problems> {
    for other_grid in [false, true] {
        let mut best: Option<Visit> = None;
        for variant in variants.iter().filter(|one| design.other_grid(one).is_some() == other_grid) {
            let is_quicker = |minutes: f64| best.as_ref().is_none_or(|best| minutes < best.minutes);
            // What the most runs do not reach, no fewer do.
            if !is_quicker(design.minutes(&variant.in_runs(1)))
                || !is_reached(&design.visit(variant.in_runs(MOST_RUNS))?)
            {
                continue;
            }
            let mut runs = (1..=MOST_RUNS).map(|runs| variant.in_runs(runs));
            let visit = runs.find_map(|one| design.visit(one).ok().filter(&is_reached));
            best = visit.filter(|visit| is_quicker(visit.minutes)).or(best);
        }
        if best.is_some() {
            return Ok(best);
        }
    }
    Ok(None)
}

/// Where a visit stands among the others; a new one is put at their end.
fn place(design: &Design<'_>, visits: &mut Vec<Visit>, new: Visit) -> usize {
    let known = visits.iter().position(|visit| visit.variant == new.variant);
    known.unwrap_or_else(|| {
        visits.push(Visit { chance: design.chance(&new), ..new });
        visits.len() - 1
    })
}

/// All changes together but for the runs, by their time. A return pass is not given up: without it the reversal
/// is mixed into the curves, and U does not say so.
pub(super) fn combinations(design: &Design<'_>, angles: &[Rotation]) -> Vec<Variant> {
    let described = design.described();
    let lines = subsets(&design.axes_open()).into_iter();
    let lines = lines.map(|axes| described.with(&axes));
    let with_angles = |one: Variant| {
        let measured = of_angles(angles).into_iter().map(|angles| one.with_angles(&angles));
        measured.chain([one.clone()]).collect::<Vec<_>>()
    };
    let ways = lines.flat_map(with_angles).flat_map(|one| [one.turning(), one]);
    let all = ways.flat_map(|one| [design.in_other_steps(&one), vec![one]].concat());
    let mut all = all.fold(Vec::new(), |mut different, one| {
        if !different.contains(&one) {
            different.push(one);
        }
        different
    });
    let minutes = |one: &Variant| design.minutes(&one.in_runs(1));
    all.sort_by(|a, b| minutes(a).total_cmp(&minutes(b)));
    all
}
