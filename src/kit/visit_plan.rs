//! A visit before it is made: what a run of step diagonals and variants of it determine, how well, in what
//! time, and the cheapest of them that reaches the acceptance.
//!
//! ```text
//!   [program] or [measurement.step_diagonal] ─→ run ─→ variants ─┬→ motion ─→ minutes, mirror
//!                                                                └→ readings of 0 ─→ separation ─→ U
//!   acceptance ←─ 95 % of the largest of all errors, drawn together ←── by readings and lines ←─┘
//! ```
//! U comes from the separation itself, the acceptance is judged as `generate` judges it, for a machine
//! without errors and tables that leave nothing: what a variant misses here, no tables reach.
//! The described visit stands beside its variants, with what the figures rest on.

mod design;
mod variant;
mod what_decides;

use self::design::NOISE_UM;
pub use self::design::{Design, SetUpTimes};
pub(crate) use self::variant::listed;
pub use self::variant::{Share, Variant, Visit};
pub(crate) use self::what_decides::OpenFigures;
pub use self::what_decides::{Act, Remeasurement, WhatDecides};
use crate::judge::findings::joined;
use crate::judge::forecast::shares;
use crate::quantity::{Axis, PerAxis};
use crate::text::{Finding, Problems, findings};

/// More runs are no variant: a day has no more.
const MOST_RUNS: u32 = 6;
/// Probability from which on a second measurement is counted on.
const LIKELY: f64 = 0.8;

/// The run of the job, variants of it, and the cheapest.
#[derive(Clone, Debug)]
pub struct VisitPlan<'a> {
    /// The visit as the job describes it.
    pub design: &'a Design<'a>,
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
pub fn plan<'a>(design: &'a Design<'a>) -> Result<VisitPlan<'a>, Problems> {
    let described = &design.described;
    let mut visits = vec![design.visit(described.clone())?];
    let worst = visits[0].worst.zip(visits[0].at_most_um);
    let parts = worst.map_or_else(Vec::new, |(term, um)| {
        shares(um, visits[0].expected.parts(design.job, term, None))
    });
    let additions = design.additions(&visits[0], &parts);
    let one_way = described.run_as(|run| run.bidirectional = false);
    let ways = vec![one_way, described.turning()];
    let runs = [1, 3, MOST_RUNS].map(|runs| described.in_runs(runs)).to_vec();
    for other in [additions.clone(), ways, runs, design.in_other_steps(described)].concat() {
        if visits.iter().all(|visit| visit.variant != other) {
            visits.push(design.visit(other)?);
        }
    }
    let asked = design.job.acceptance;
    let likely = |visit: &Visit| visit.reaches(asked) && design.chance(visit) >= Some(LIKELY);
    let variants = combinations(design, &additions);
    let forecast = design.cheapest(&variants, |visit| visit.reaches(asked));
    let second = asked.max_deviation_um.and(forecast.as_ref()).and_then(|first| {
        if likely(first) { Some(first.clone()) } else { design.cheapest(&variants, likely) }
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
    Ok(VisitPlan { design, decides: visits[0].most(parts), visits, forecast, second })
}

/// All changes together but for the runs. A return pass is not given up: without it the reversal is mixed into the
/// curves, and U does not say so.
fn combinations(design: &Design<'_>, additions: &[Variant]) -> Vec<Variant> {
    let all = together(&design.described, additions).into_iter();
    let ways = all.flat_map(|one| [one.turning(), one]);
    ways.flat_map(|one| [design.in_other_steps(&one), vec![one]].concat()).collect()
}

/// What can be measured in addition, alone and together.
fn together(described: &Variant, additions: &[Variant]) -> Vec<Variant> {
    additions.iter().fold(vec![described.clone()], |all, one| {
        let both = all.iter().map(|other| other.and(one));
        let new: Vec<Variant> = both.filter(|both| !all.contains(both)).collect();
        [all, new].concat()
    })
}

findings! {
    /// What a plan rests on.
    Assumed {
        Noise { um: f64 } => Label, "noise of a reading {um} µm (noise_um)";
        NoiseNotStated { um: f64 } => Note, "noise of a reading {um} µm is assumed: state `noise_um` (instrument, air and machine together; the scatter of five readings at one place), because it decides how many runs are needed";
        NotCounted { words: String } => Label, "{words}";
        LinearAxes { runs: u32, u_um_per_m: PerAxis<f64>, named: Vec<Axis> } => Label, "linear axis: same laser, {runs} runs both ways, u_um_per_m = {:.2}, {:.2}, {:.2} (X, Y, Z; state it){}", u_um_per_m.x, u_um_per_m.y, u_um_per_m.z, match named.as_slice() {
            [] => String::new(),
            named => format!("; {} named by the job, no time", Axis::letters(named)),
        };
        Time { feed_mm_per_min: f64, dwell_s: f64, diagonal_min: f64, linear_min: f64 } => Label, "time: {feed_mm_per_min} mm/min, standstill {dwell_s} s, set-up {diagonal_min} min a diagonal, {linear_min} min a linear axis; no warm-up";
        Optics { circle_mm: f64 } => Label, "optics: flat mirror of {circle_mm:.1} mm and the diameter of the beam; retroreflector for linear axes";
        AtMost => Label, "at most: the largest of all errors in the forecast, with 95 %, before what the points of the tables leave, and the reversal with one curve for both directions";
        Second => Label, "second passes: share of 400 simulated second measurements, made like the first; the tables then leave the errors of the first and nothing else, and the machine stays as it is; measured angles are taken as known";
        NoU { terms: String } => Note, "U is not known for {terms}: with `setup = \"assume-perfect\"` state `tilt_arcsec`, or solve for the set-up; a beam needs `u_um_per_m`";
        OneDirection => Note, "one direction only: the reversal of every axis is mixed into the curves, and U does not hold it";
    }
}

impl Design<'_> {
    /// The one that takes the least time of all with which something is reached. Tables that need another grid
    /// count only where no others do.
    fn cheapest(&self, variants: &[Variant], is_reached: impl Fn(&Visit) -> bool) -> Option<Visit> {
        let timed = variants.iter().map(|one| (self.minutes(&one.in_runs(1)), one));
        let mut timed: Vec<(f64, &Variant)> = timed.collect();
        timed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: [Option<Visit>; 2] = [None, None];
        for (least, variant) in timed {
            let best = &mut best[usize::from(self.other_grid(variant).is_some())];
            let is_quicker = |minutes: f64| best.as_ref().is_none_or(|best| minutes < best.minutes);
            if is_quicker(least) {
                let visit = self.in_fewest_runs(variant, &is_reached);
                *best = visit.filter(|visit| is_quicker(visit.minutes)).or(best.take());
            }
        }
        let [own_grid, other_grid] = best;
        own_grid.or(other_grid)
    }

    /// With the fewest runs that reach something; what some do not, no fewer do.
    fn in_fewest_runs(
        &self,
        variant: &Variant,
        is_reached: impl Fn(&Visit) -> bool,
    ) -> Option<Visit> {
        let reached = |runs| self.visit(variant.in_runs(runs)).ok().filter(&is_reached);
        let most = reached(MOST_RUNS)?;
        let fewer: Vec<u32> = (self.fewest_runs()..MOST_RUNS).collect();
        let fewest = fewer.partition_point(|runs| reached(*runs).is_none());
        Some(fewer.get(fewest).and_then(|runs| reached(*runs)).unwrap_or(most))
    }

    /// What the figures rest on: what is known of the laser, what U leaves out, then the visit.
    pub(crate) fn assumed(&self, described: &Visit) -> Vec<Finding> {
        let run = &described.variant.run;
        let noise = self.instrument.stated.noise_um.map(|um| Assumed::Noise { um });
        let silent = described.expected.silence.sentences().into_iter();
        let silent = silent.map(|words| Assumed::NotCounted { words });
        let linear = Assumed::LinearAxes {
            runs: run.along(Axis::X).runs,
            u_um_per_m: self.u_um_per_m(described),
            named: self.axes_named(),
        };
        let SetUpTimes { diagonal_min, linear_min } = self.times;
        let (feed_mm_per_min, dwell_s) = (run.feed_mm_per_min, run.dwell_s);
        let time = Assumed::Time { feed_mm_per_min, dwell_s, diagonal_min, linear_min };
        let optics = described.mirror.map(|mirror| Assumed::Optics { circle_mm: mirror.circle_mm });
        let all = noise.into_iter().chain(silent).chain([linear, time]).chain(optics);
        all.chain([Assumed::AtMost, Assumed::Second]).map(Finding::from).collect()
    }

    /// What is asked for where the noise is not stated.
    pub(crate) fn noise_asked(&self) -> Option<Finding> {
        let is_stated = self.instrument.stated.noise_um.is_some();
        (!is_stated).then(|| Assumed::NoiseNotStated { um: NOISE_UM }.into())
    }

    /// Standard uncertainty of the slope of each axis: as the job states it, else as the laser gives it.
    pub(crate) fn u_um_per_m(&self, described: &Visit) -> PerAxis<f64> {
        PerAxis::from_fn(|axis| {
            let line = described.lines.iter();
            let mut line = line.filter(|line| line.direction[axis] > 0.999);
            let own = line.find_map(|line| line.u_um_per_m);
            own.unwrap_or_else(|| self.of_line(axis, &described.variant))
        })
    }
}

impl Visit {
    /// What this visit leaves open or mixed up, the gravest first.
    pub(crate) fn shortcomings(&self) -> Vec<Finding> {
        let ranges = self.ranges.iter().filter(|range| !range.is_known());
        let ranges = ranges.map(|range| Assumed::NotCounted { words: range.missing() }.into());
        let missing = self.expected.missing();
        let no_u = joined(self.open.iter().filter(|term| !missing.contains(term)));
        let no_u = (!no_u.is_empty()).then(|| Assumed::NoU { terms: no_u }.into());
        let open = self.expected.undetermined.iter().cloned();
        let one_way = !self.variant.run.bidirectional;
        let one_way = one_way.then(|| Assumed::OneDirection.into());
        ranges.chain(no_u).chain(open).chain(one_way).collect()
    }
}
