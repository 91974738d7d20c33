//! The described visit beside its variants, and the cheapest that will do.

use super::design::Design;
use super::variant::{Share, Variant, Visit};
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
    /// What makes most of U as described.
    pub decides: Vec<Share>,
}

/// Compares the described run with its variants.
pub fn plan(design: &Design<'_>) -> Result<VisitPlan, Problems> {
    let described = &design.described;
    let mut visits = vec![design.visit(described.clone())?];
    let worst = visits[0].forecast.worst();
    let parts = worst.map_or_else(Vec::new, |worst| visits[0].parts(design.job, &worst, None));
    let additions = design.additions(&visits[0], &parts);
    let runs = [1, 3, MOST_RUNS].map(|runs| described.in_runs(runs)).to_vec();
    let ways = vec![described.one_way(), described.turning()];
    for other in [additions.clone(), ways, runs, design.in_other_steps(described)].concat() {
        if visits.iter().all(|visit| visit.variant != other) {
            visits.push(design.visit(other)?);
        }
    }
    let asked = design.acceptance();
    let likely = |visit: &Visit| visit.reaches(asked) && design.chance(visit) >= Some(LIKELY);
    let variants = combinations(design, &additions);
    let forecast = cheapest(design, &variants, |visit| visit.reaches(asked));
    let second = asked.max_deviation_um.and(forecast.as_ref()).and_then(|first| {
        if likely(first) { Some(first.clone()) } else { cheapest(design, &variants, likely) }
    });
    let [forecast, second] = [forecast, second].map(|found| {
        let new = found?;
        let known = visits.iter().position(|visit| visit.variant == new.variant);
        Some(known.unwrap_or_else(|| {
            visits.push(new);
            visits.len() - 1
        }))
    });
    // Where the forecast is reached and the second measurement is not sure, fewer steps say more.
    let fewer = forecast
        .map_or_else(Vec::new, |index: usize| design.in_other_steps(&visits[index].variant));
    for other in fewer.into_iter().filter(|one| one.run.volume.steps < described.run.volume.steps) {
        if visits.iter().all(|visit| visit.variant != other) {
            visits.push(design.visit(other)?);
        }
    }
    visits.iter_mut().for_each(|visit| visit.chance = design.chance(visit));
    Ok(VisitPlan { decides: visits[0].largest(parts), visits, forecast, second })
}

/// All changes together but for the runs. A return pass is not given up: without it the reversal is mixed into the
/// curves, and U does not say so.
fn combinations(design: &Design<'_>, additions: &[Variant]) -> Vec<Variant> {
    let all = together(&design.described, additions).into_iter();
    let ways = all.flat_map(|one| [one.turning(), one]);
    ways.flat_map(|one| [design.in_other_steps(&one), vec![one]].concat()).collect()
}

/// What can be measured in addition, alone and together.
pub(super) fn together(described: &Variant, additions: &[Variant]) -> Vec<Variant> {
    additions.iter().fold(vec![described.clone()], |all, one| {
        let both = all.iter().map(|other| other.and(one));
        let new: Vec<Variant> = both.filter(|both| !all.contains(both)).collect();
        [all, new].concat()
    })
}

/// The one that takes the least time of all with which something is reached. Tables that need another grid
/// count only where no others do.
pub(super) fn cheapest(
    design: &Design<'_>,
    variants: &[Variant],
    is_reached: impl Fn(&Visit) -> bool,
) -> Option<Visit> {
    let timed = variants.iter().map(|one| (design.minutes(&one.in_runs(1)), one));
    let mut timed: Vec<(f64, &Variant)> = timed.collect();
    timed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: [Option<Visit>; 2] = [None, None];
    for (least, variant) in timed {
        let best = &mut best[usize::from(design.other_grid(variant).is_some())];
        let is_quicker = |minutes: f64| best.as_ref().is_none_or(|best| minutes < best.minutes);
        if is_quicker(least) {
            let visit = fewest_runs(design, variant, &is_reached);
            *best = visit.filter(|visit| is_quicker(visit.minutes)).or(best.take());
        }
    }
    let [own_grid, other_grid] = best;
    own_grid.or(other_grid)
}

/// With the fewest runs that reach something; what the most do not, no fewer do.
pub(super) fn fewest_runs(
    design: &Design<'_>,
    variant: &Variant,
    is_reached: impl Fn(&Visit) -> bool,
) -> Option<Visit> {
    let reached = |runs| design.visit(variant.in_runs(runs)).ok().filter(&is_reached);
    let most = reached(MOST_RUNS)?;
    Some((design.fewest_runs()..MOST_RUNS).find_map(reached).unwrap_or(most))
}
