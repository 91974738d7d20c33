//! The described visit beside its variants, and the cheapest that will do.

use super::design::Design;
use super::variant::{Variant, Visit};
use crate::quantity::axis::Axis;
use crate::text::problem::Problems;

/// The run of the job, variants of it, and the cheapest.
#[derive(Clone, Debug)]
pub struct VisitPlan {
    /// As described, then one change each; the best last where it is none of these.
    pub visits: Vec<Visit>,
    /// The one that takes the least time of all that reach the acceptance; where none does, that with the
    /// smallest U of all that determine the wanted errors; `None` = none does.
    pub best: Option<usize>,
}

/// Compares the described run with its variants.
pub fn plan(design: &Design<'_>) -> Result<VisitPlan, Problems> {
    let described = design.described();
    let mut visits = vec![design.visit(described.clone())?];
    for count in 1..=design.axes_open().len() {
        visits.extend(best_lines(design, described, count)?);
    }
    let directions = [described.one_way(), described.turning()].into_iter();
    let changes = directions.chain(runs(described));
    for other in changes.chain(design.finer(described)) {
        if other != *described {
            visits.push(design.visit(other)?);
        }
    }
    let best = best(design, &mut visits)?;
    Ok(VisitPlan { visits, best })
}

/// One run for the least time, three for the noise.
fn runs(described: &Variant) -> impl Iterator<Item = Variant> + use<> {
    [1, 3].map(|runs| described.in_runs(runs)).into_iter()
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
        let rank = |visit: &Visit| (visit.open.len(), together_um(visit));
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

/// U of all values together; the largest where it is not known.
fn together_um(visit: &Visit) -> f64 {
    visit.together_um().unwrap_or(f64::MAX)
}

/// Goes through all combinations by their time until one reaches the acceptance.
fn best(design: &Design<'_>, visits: &mut Vec<Visit>) -> Result<Option<usize>, Problems> {
    let mut all: Vec<(f64, Variant)> = combinations(design)
        .into_iter()
        .map(|variant| (design.minutes(&variant), variant))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut closest: Option<Visit> = None;
    for (_, variant) in all {
        let known = visits.iter().find(|visit| visit.variant == variant);
        let visit = match known {
            Some(visit) => visit.clone(),
            None => design.visit(variant)?,
        };
        if visit.reaches(design.acceptance()) {
            return Ok(Some(place(visits, visit)));
        }
        let is_closer = |than: &Visit| together_um(&visit) < together_um(than);
        if visit.open.is_empty() && closest.as_ref().is_none_or(is_closer) {
            closest = Some(visit);
        }
    }
    Ok(closest.map(|visit| place(visits, visit)))
}

/// Where a visit stands among the others; a new one is put at their end.
fn place(visits: &mut Vec<Visit>, new: Visit) -> usize {
    let known = visits.iter().position(|visit| visit.variant == new.variant);
    known.unwrap_or_else(|| {
        visits.push(new);
        visits.len() - 1
    })
}

/// All changes together. A return pass is not given up: without it the reversal is mixed into the curves, and
/// U does not say so.
fn combinations(design: &Design<'_>) -> Vec<Variant> {
    let described = design.described();
    let lines = subsets(&design.axes_open()).into_iter();
    let lines = lines.map(|axes| described.with(&axes));
    let ways = lines.flat_map(|one| [one.turning(), one]);
    let repeated = ways.flat_map(|one| runs(&one).chain([one]));
    let all = repeated.flat_map(|one| [design.finer(&one), Some(one)]);
    all.flatten().fold(Vec::new(), |mut different, one| {
        if !different.contains(&one) {
            different.push(one);
        }
        different
    })
}
